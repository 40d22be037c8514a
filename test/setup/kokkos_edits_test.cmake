# cmake/kokkos/edit_source on the lines of Kokkos 3.4.01 that it is for: each is edited as it has to be, and a source
# that lacks any of them stays as it is.
set(files
  core/src/impl/Kokkos_MemoryPool.cpp
  bin/nvcc_wrapper
  cmake/kokkos_arch.cmake
  core/src/Cuda/Kokkos_Cuda_Instance.cpp
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
  #Handle -arch argument (if its not set use a default) this is the version with = sign
  -arch=*|-gencode=*)
]])
set(after_bin/nvcc_wrapper [[
default_arch="sm_80"
  -gencode=*)
    arch_set=1
    cuda_args="$cuda_args $1"
    ;;
  #Handle -arch argument (if its not set use a default) this is the version with = sign
  -arch=*|-gencode=*)
]])

set(before_cmake/kokkos_arch.cmake [[
      GLOBAL_APPEND(KOKKOS_CUDA_OPTIONS "${CUDA_ARCH_FLAG}=${FLAG}")
      IF(KOKKOS_ENABLE_CUDA_RELOCATABLE_DEVICE_CODE OR KOKKOS_CXX_COMPILER_ID STREQUAL NVIDIA)
        GLOBAL_APPEND(KOKKOS_LINK_OPTIONS "${CUDA_ARCH_FLAG}=${FLAG}")
      ENDIF()
]])
set(after_cmake/kokkos_arch.cmake [[
      GLOBAL_APPEND(KOKKOS_CUDA_OPTIONS ${MFS_CUDA_CODE})
      IF(KOKKOS_ENABLE_CUDA_RELOCATABLE_DEVICE_CODE OR KOKKOS_CXX_COMPILER_ID STREQUAL NVIDIA)
      ENDIF()
]])

set(before_core/src/Cuda/Kokkos_Cuda_Instance.cpp [[
    if (compiled_major != cudaProp.major || compiled_minor > cudaProp.minor) {
    if (Kokkos::show_warnings() && (compiled_major != cudaProp.major ||
                                    compiled_minor != cudaProp.minor)) {
]])
set(after_core/src/Cuda/Kokkos_Cuda_Instance.cpp [[
    if (10 * compiled_major + compiled_minor > 10 * cudaProp.major + cudaProp.minor) {
    if (false && (compiled_major != cudaProp.major ||
                                    compiled_minor != cudaProp.minor)) {
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
