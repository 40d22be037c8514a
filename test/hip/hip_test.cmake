# Compiles the portable executor for AMD's gfx908 by hipcc, against the installed headers of Kokkos 3.4.01 with a
# configuration for HIP before theirs. Skipped (test property SKIP_REGULAR_EXPRESSION) without hipcc.
find_program(hipcc NAMES hipcc)
if(NOT hipcc)
  message("skipped: no hipcc")
  return()
endif()
file(STRINGS ${KOKKOS_INCLUDE}/KokkosCore_config.h version REGEX "KOKKOS_VERSION 30401")
if(NOT version OR NOT EXISTS ${KOKKOS_INCLUDE}/Kokkos_HIP.hpp)
  message("skipped: ${KOKKOS_INCLUDE} has no HIP of Kokkos 3.4.01")
  return()
endif()
file(REMOVE_RECURSE ${WORK})
file(WRITE ${WORK}/KokkosCore_config.h "#define KOKKOS_CORE_CONFIG_H
#define KOKKOS_VERSION 30401
#define KOKKOS_ENABLE_SERIAL
#define KOKKOS_ENABLE_HIP
#define KOKKOS_ENABLE_CXX17
#define KOKKOS_ENABLE_COMPLEX_ALIGN
#define KOKKOS_ENABLE_LIBDL
#define KOKKOS_ARCH_HIP
#define KOKKOS_ARCH_VEGA908
")
file(WRITE ${WORK}/KokkosCore_Config_SetupBackend.hpp "#include <setup/Kokkos_Setup_HIP.hpp>\n")
file(WRITE ${WORK}/KokkosCore_Config_FwdBackend.hpp
  "#include <fwd/Kokkos_Fwd_HIP.hpp>\n#include <fwd/Kokkos_Fwd_SERIAL.hpp>\n")
file(WRITE ${WORK}/KokkosCore_Config_DeclareBackend.hpp
  "#include <decl/Kokkos_Declare_HIP.hpp>\n#include <decl/Kokkos_Declare_SERIAL.hpp>\n")
file(WRITE ${WORK}/KokkosCore_Config_PostInclude.hpp "")
execute_process(
  COMMAND ${hipcc} -std=c++17 -O1 --offload-arch=gfx908 -fopenmp -Wno-everything -c
    -I${WORK} -isystem ${KOKKOS_INCLUDE} -I${ROOT} -I${ROOT}/ordering/include
    ${CMAKE_CURRENT_LIST_DIR}/portable_on_hip.cpp -o ${WORK}/portable_on_hip.o
  RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "hipcc: ${text}")
endif()
