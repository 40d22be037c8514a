# cmake/kokkos/edit_source on the lines of Kokkos 3.4.01 that it is for: each is edited as it has to be, and a source
# that lacks any of them stays as it is.
set(files
  core/src/impl/Kokkos_MemoryPool.cpp
  bin/nvcc_wrapper
  cmake/KokkosCore_config.h.in
  cmake/kokkos_arch.cmake
  core/src/Cuda/Kokkos_CudaSpace.cpp
  core/src/Cuda/Kokkos_Cuda_Half.hpp)

set(before_core/src/impl/Kokkos_MemoryPool.cpp [[
#include <impl/Kokkos_Error.hpp>

#include <ostream>
#include <sstream>
]])
set(after_core/src/impl/Kokkos_MemoryPool.cpp [[
#include <impl/Kokkos_Error.hpp>

#include <cstdint>
#include <ostream>
#include <sstream>
]])

set(before_bin/nvcc_wrapper [[
default_arch="sm_35"
#default_arch="sm_50"
]])
set(after_bin/nvcc_wrapper [[
default_arch="sm_90"
#default_arch="sm_50"
]])

set(before_cmake/KokkosCore_config.h.in [[
#cmakedefine KOKKOS_ARCH_AMPERE80
#cmakedefine KOKKOS_ARCH_AMPERE86
#cmakedefine KOKKOS_ARCH_AMD_ZEN
]])
set(after_cmake/KokkosCore_config.h.in [[
#cmakedefine KOKKOS_ARCH_AMPERE80
#cmakedefine KOKKOS_ARCH_AMPERE86
#cmakedefine KOKKOS_ARCH_HOPPER90
#cmakedefine KOKKOS_ARCH_AMD_ZEN
]])

set(before_cmake/kokkos_arch.cmake [[
KOKKOS_ARCH_OPTION(AMPERE80        GPU  "NVIDIA Ampere generation CC 8.0")
KOKKOS_ARCH_OPTION(AMPERE86        GPU  "NVIDIA Ampere generation CC 8.6")
CHECK_CUDA_ARCH(AMPERE80  sm_80)
CHECK_CUDA_ARCH(AMPERE86  sm_86)
  IF (KOKKOS_ARCH_AMPERE80 OR KOKKOS_ARCH_AMPERE86)
]])
set(after_cmake/kokkos_arch.cmake [[
KOKKOS_ARCH_OPTION(AMPERE80        GPU  "NVIDIA Ampere generation CC 8.0")
KOKKOS_ARCH_OPTION(AMPERE86        GPU  "NVIDIA Ampere generation CC 8.6")
KOKKOS_ARCH_OPTION(HOPPER90        GPU  "NVIDIA Hopper generation CC 9.0")
CHECK_CUDA_ARCH(AMPERE80  sm_80)
CHECK_CUDA_ARCH(AMPERE86  sm_86)
CHECK_CUDA_ARCH(HOPPER90  sm_90)
  IF (KOKKOS_ARCH_AMPERE80 OR KOKKOS_ARCH_AMPERE86 OR KOKKOS_ARCH_HOPPER90)
]])

set(before_core/src/Cuda/Kokkos_CudaSpace.cpp [[
    CUDA_SAFE_CALL(cudaMemPrefetchAsync(ptr, bytes, space.cuda_device(),
                                        space.cuda_stream()));
]])
set(after_core/src/Cuda/Kokkos_CudaSpace.cpp [[
    CUDA_SAFE_CALL(cudaMemPrefetchAsync(ptr, bytes, cudaMemLocation{cudaMemLocationTypeDevice, space.cuda_device()}, 0,
                                        space.cuda_stream()));
]])

set(before_core/src/Cuda/Kokkos_Cuda_Half.hpp "")
set(after_core/src/Cuda/Kokkos_Cuda_Half.hpp "")
foreach(function float short_rz ushort_rz int_rz uint_rz ll_rz ull_rz)
  string(APPEND before_core/src/Cuda/Kokkos_Cuda_Half.hpp "  return __half2${function}(val);\n")
  string(APPEND after_core/src/Cuda/Kokkos_Cuda_Half.hpp "  return __half2${function}(half_t::impl_type(val));\n")
endforeach()
string(APPEND before_core/src/Cuda/Kokkos_Cuda_Half.hpp "  return __half2double(val);\n")
string(APPEND after_core/src/Cuda/Kokkos_Cuda_Half.hpp
  "  return static_cast<T>(__half2float(half_t::impl_type(val)));\n")

function(write_source)
  foreach(file IN LISTS files)
    file(WRITE ${WORK}/${file} "${before_${file}}")
  endforeach()
endfunction()

function(expect state)
  foreach(file IN LISTS files)
    file(READ ${WORK}/${file} text)
    if(NOT text STREQUAL "${${state}_${file}}")
      message(FATAL_ERROR "${file} should be as ${state} the edits:\n${${state}_${file}}\nbut is:\n${text}")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK})
write_source()
execute_process(COMMAND ${SCRIPT} ${WORK} COMMAND_ERROR_IS_FATAL ANY)
expect(after)

# A source that was edited, or differs from 3.4.01 in one of those lines, whichever it is.
execute_process(COMMAND ${SCRIPT} ${WORK} RESULT_VARIABLE again ERROR_QUIET)
if(again EQUAL 0)
  message(FATAL_ERROR "a source that was edited is edited again")
endif()
expect(after)
foreach(other IN LISTS files)
  set(kept "${before_${other}}")
  set(before_${other} "another version\n")
  write_source()
  execute_process(COMMAND ${SCRIPT} ${WORK} RESULT_VARIABLE refused ERROR_VARIABLE error)
  if(refused EQUAL 0 OR NOT error MATCHES "edit_source: ${other} has")
    message(FATAL_ERROR "another ${other}: exit status ${refused}, ${error}")
  endif()
  expect(before)
  set(before_${other} "${kept}")
endforeach()
