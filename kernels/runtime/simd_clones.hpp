// Functions marked MFS_SIMD_CLONES are compiled for several x86-64 levels and the right one is taken at load
// time: the library is built for any machine, its few own inner loops still use wide registers. A
// function may have a body for each of these levels instead: MFS_FOR_SIMD_TARGETS is
// MACRO(attribute, S) for each of them, or once where there is but one. MFS_FOR_SIMD_REGISTERS is
// MACRO(attribute, S, bytes) with the bytes of a vector register, too: 32 of 64, 16 of 32, 16 of 16.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__CUDACC__)
#define MFS_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define MFS_FOR_SIMD_TARGETS(MACRO, S)                \
  MACRO(__attribute__((target("arch=x86-64-v4"))), S) \
  MACRO(__attribute__((target("arch=x86-64-v3"))), S) \
  MACRO(__attribute__((target("default"))), S)
#define MFS_FOR_SIMD_REGISTERS(MACRO, S)                  \
  MACRO(__attribute__((target("arch=x86-64-v4"))), S, 64) \
  MACRO(__attribute__((target("arch=x86-64-v3"))), S, 32) \
  MACRO(__attribute__((target("default"))), S, 16)
#else
#define MFS_SIMD_CLONES
#define MFS_FOR_SIMD_TARGETS(MACRO, S) MACRO(, S)
#define MFS_FOR_SIMD_REGISTERS(MACRO, S) MACRO(, S, 16)
#endif
