# What MFS stands on. scripts/setup brings everything that is named here; what it builds itself lies under
# MFS_THIRD_PARTY, outside the source tree. Any of it is overridden by CMAKE_PREFIX_PATH or <name>_ROOT.
if(DEFINED ENV{MFS_THIRD_PARTY})
  set(mfs_third_party "$ENV{MFS_THIRD_PARTY}")
elseif(DEFINED ENV{XDG_CACHE_HOME})
  set(mfs_third_party "$ENV{XDG_CACHE_HOME}/mfs")
else()
  set(mfs_third_party "$ENV{HOME}/.cache/mfs")
endif()
set(MFS_THIRD_PARTY "${mfs_third_party}" CACHE PATH "Where scripts/setup put Kokkos and the sources of METIS")

find_package(Threads REQUIRED)
find_package(OpenMP REQUIRED)

# BLAS and LAPACK (mfs_blas): OpenBLAS unless told otherwise (BLA_VENDOR=Intel10_64lp takes oneMKL).
set(MFS_BLAS system CACHE STRING "system: what find_package(BLAS) finds; pypi: what scripts/setup --blas pypi has brought")
set_property(CACHE MFS_BLAS PROPERTY STRINGS system pypi)
add_library(mfs_blas INTERFACE)
if(MFS_BLAS STREQUAL "pypi")
  # A later OpenBLAS, which knows later processors. All its names begin with scipy_, so it disturbs no other BLAS.
  find_library(MFS_PYPI_BLAS scipy_openblas PATHS "${MFS_THIRD_PARTY}/openblas/lib" NO_DEFAULT_PATH)
  if(NOT MFS_PYPI_BLAS)
    message(FATAL_ERROR "MFS_BLAS=pypi: no libscipy_openblas in ${MFS_THIRD_PARTY}/openblas/lib; scripts/setup --blas pypi brings it")
  endif()
  mark_as_advanced(MFS_PYPI_BLAS)
  target_link_libraries(mfs_blas INTERFACE "${MFS_PYPI_BLAS}")
  target_compile_definitions(mfs_blas INTERFACE MFS_BLAS_PREFIX=scipy_)
elseif(MFS_BLAS STREQUAL "system")
  if(NOT DEFINED BLA_VENDOR)
    set(BLA_VENDOR OpenBLAS)
  endif()
  find_package(BLAS REQUIRED)
  find_package(LAPACK REQUIRED)
  target_link_libraries(mfs_blas INTERFACE LAPACK::LAPACK BLAS::BLAS)
else()
  message(FATAL_ERROR "MFS_BLAS is system or pypi, not ${MFS_BLAS}")
endif()

# CAMD of SuiteSparse: a plain library without a CMake package in Debian 12.
find_path(MFS_CAMD_INCLUDE camd.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(MFS_CAMD_LIBRARY camd REQUIRED)
mark_as_advanced(MFS_CAMD_INCLUDE MFS_CAMD_LIBRARY)
add_library(mfs_camd UNKNOWN IMPORTED GLOBAL)
set_target_properties(mfs_camd PROPERTIES IMPORTED_LOCATION "${MFS_CAMD_LIBRARY}")
target_include_directories(mfs_camd SYSTEM INTERFACE "${MFS_CAMD_INCLUDE}")

# Headers alone: what is linked to libmfs needs no Eigen for it.
find_package(Eigen3 CONFIG REQUIRED GLOBAL)  # a version here would refuse Eigen 5
if(Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "Eigen ${Eigen3_VERSION} in ${Eigen3_DIR}: MFS needs 3.4 or later")
endif()

add_subdirectory(cmake/kokkos)    # target mfs_kokkos
add_subdirectory(ordering/metis)   # target mfs_metis

# Trilinos, for the adapter: its packages are looked for in amesos2_mfs; here only whether they are there.
set(MFS_TRILINOS_FOUND OFF)
if(MFS_TRILINOS)
  find_path(MFS_AMESOS2_INCLUDE Amesos2.hpp HINTS ${Trilinos_DIR}/../../.. ${Trilinos_ROOT}
    PATH_SUFFIXES include include/trilinos trilinos)
  mark_as_advanced(MFS_AMESOS2_INCLUDE)
  if(MFS_AMESOS2_INCLUDE)
    set(MFS_TRILINOS_FOUND ON)
  else()
    message(STATUS "Trilinos (Amesos2) not found: mfs::amesos2 is left out")
  endif()
endif()
