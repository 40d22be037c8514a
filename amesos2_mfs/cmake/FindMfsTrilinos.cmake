# The packages of Trilinos that the adapter of MFS uses, as imported targets:
#
#   mfs::trilinos               Amesos2, Tpetra, Teuchos, Kokkos and, where Amesos2 has it, Epetra; MPI
#   mfs::trilinos_stratimikos   Stratimikos with Thyra       component Stratimikos
#   mfs::trilinos_nox           NOX with Thyra               component NOX
#   mfs::trilinos_belos         Belos                        component Belos
#   mfs::trilinos_ifpack2       Ifpack2                      component Ifpack2
#   mfs::trilinos_muelu         MueLu with Xpetra            component MueLu
#   mfs::trilinos_frosch        FROSch of ShyLU              component FROSch, which needs all others but NOX
#
# Which Trilinos: that of Trilinos_DIR or Trilinos_ROOT, else the first on CMAKE_PREFIX_PATH or in the system. All
# packages are taken from one installation.
#
# Headers and libraries are looked for one by one, under Debian's names (libtrilinos_amesos2) and Trilinos' own
# (libamesos2): the CMake packages of Trilinos 13 bring their own Kokkos::kokkos into the project, and they fail
# where the -dev package of any library they were built with is missing.
#
# Where Tpetra has CUDA, what uses mfs::trilinos is compiled by nvcc: with MFS_CUDA as MFS itself is, otherwise the
# project's compiler has to be Kokkos' nvcc_wrapper. MfsTrilinos_CUDA tells of it.
include(FindPackageHandleStandardArgs)
include(CMakeFindDependencyMacro)

set(_mfs_prefixes ${Trilinos_ROOT})
if(Trilinos_DIR)
  get_filename_component(_mfs_prefix "${Trilinos_DIR}/../../.." ABSOLUTE)
  list(PREPEND _mfs_prefixes "${_mfs_prefix}")
endif()
find_path(MfsTrilinos_trilinos_INCLUDE Amesos2.hpp HINTS ${_mfs_prefixes}
  PATH_SUFFIXES include include/trilinos trilinos)
find_library(MfsTrilinos_amesos2_LIBRARY NAMES trilinos_amesos2 amesos2 NAMES_PER_DIR
  HINTS ${MfsTrilinos_trilinos_INCLUDE}/../lib ${MfsTrilinos_trilinos_INCLUDE}/../lib64)
# Kokkos has a folder of its own in newer versions of Trilinos.
find_path(MfsTrilinos_kokkos_INCLUDE KokkosCore_config.h
  PATHS ${MfsTrilinos_trilinos_INCLUDE} ${MfsTrilinos_trilinos_INCLUDE}/kokkos ${MfsTrilinos_trilinos_INCLUDE}/../kokkos
  NO_DEFAULT_PATH)
mark_as_advanced(MfsTrilinos_kokkos_INCLUDE)
set(_mfs_library_dir "")
if(MfsTrilinos_amesos2_LIBRARY)
  get_filename_component(_mfs_library_dir "${MfsTrilinos_amesos2_LIBRARY}" DIRECTORY)
endif()

function(_mfs_trilinos_package target header)
  find_path(MfsTrilinos_${target}_INCLUDE ${header} PATHS ${MfsTrilinos_trilinos_INCLUDE} NO_DEFAULT_PATH)
  mark_as_advanced(MfsTrilinos_${target}_INCLUDE)
  set(found ${MfsTrilinos_${target}_INCLUDE})
  set(libraries)
  foreach(name IN LISTS ARGN)
    find_library(MfsTrilinos_${name}_LIBRARY NAMES trilinos_${name} ${name}
      PATHS ${_mfs_library_dir} NO_DEFAULT_PATH)
    mark_as_advanced(MfsTrilinos_${name}_LIBRARY)
    if(NOT MfsTrilinos_${name}_LIBRARY)
      set(found FALSE)
      string(APPEND MfsTrilinos_MISSING " ${name}")
    endif()
    list(APPEND libraries ${MfsTrilinos_${name}_LIBRARY})
  endforeach()
  set(MfsTrilinos_MISSING "${MfsTrilinos_MISSING}" PARENT_SCOPE)
  if(found AND NOT TARGET mfs::${target})
    add_library(mfs::${target} INTERFACE IMPORTED)
    target_include_directories(mfs::${target} INTERFACE ${MfsTrilinos_${target}_INCLUDE})
    target_link_libraries(mfs::${target} INTERFACE ${libraries})
    if(NOT target STREQUAL trilinos)
      target_link_libraries(mfs::${target} INTERFACE mfs::trilinos)
    endif()
  endif()
endfunction()

set(_mfs_static FALSE)
if(MfsTrilinos_amesos2_LIBRARY MATCHES "\\.a$")
  set(_mfs_static TRUE)
endif()
set(_mfs_cuda "")
if(MfsTrilinos_kokkos_INCLUDE)
  file(STRINGS "${MfsTrilinos_kokkos_INCLUDE}/KokkosCore_config.h" _mfs_cuda REGEX "^#define KOKKOS_ENABLE_CUDA$")
endif()
# Shared libraries bring these themselves, but for what a Tpetra without explicit instantiation needs, as those for
# CUDA mostly are. Not every version of Trilinos has all of them.
set(_mfs_indirect)
if(_mfs_static)
  set(_mfs_indirect trilinosss tpetraclassicnodeapi teuchosparser kokkoscontainers)
elseif(_mfs_cuda)
  set(_mfs_indirect trilinosss tpetraclassicnodeapi)
endif()
get_filename_component(_mfs_suffix "${MfsTrilinos_amesos2_LIBRARY}" LAST_EXT)
foreach(name IN LISTS _mfs_indirect)
  if(NOT EXISTS ${_mfs_library_dir}/lib${name}${_mfs_suffix})
    list(REMOVE_ITEM _mfs_indirect ${name})
  endif()
endforeach()
_mfs_trilinos_package(trilinos Amesos2.hpp amesos2 tpetrainout tpetraext tpetra kokkoskernels
  teuchoskokkoscompat teuchoskokkoscomm teuchosremainder teuchosnumerics teuchoscomm teuchosparameterlist
  ${_mfs_indirect} teuchoscore kokkoscore)
if(TARGET mfs::trilinos AND MfsTrilinos_kokkos_INCLUDE)
  set(MfsTrilinos_INCLUDE_DIR ${MfsTrilinos_trilinos_INCLUDE})
  target_include_directories(mfs::trilinos INTERFACE ${MfsTrilinos_kokkos_INCLUDE})
  file(STRINGS ${MfsTrilinos_kokkos_INCLUDE}/KokkosCore_config.h _mfs_standard REGEX "^#define KOKKOS_ENABLE_CXX2[0-9]$")
  if(_mfs_standard MATCHES "2[0-9]$")
    target_compile_features(mfs::trilinos INTERFACE cxx_std_${CMAKE_MATCH_0})
  endif()
  file(STRINGS ${MfsTrilinos_INCLUDE_DIR}/Teuchos_config.h _mfs_mpi REGEX "^#define HAVE_MPI")
  if(_mfs_mpi)
    find_dependency(MPI COMPONENTS CXX)
    target_link_libraries(mfs::trilinos INTERFACE MPI::MPI_CXX)
  endif()
  file(STRINGS ${MfsTrilinos_INCLUDE_DIR}/Amesos2_config.h _mfs_epetra REGEX "^#define HAVE_AMESOS2_EPETRA$")
  if(_mfs_epetra)
    find_library(MfsTrilinos_epetra_LIBRARY NAMES trilinos_epetra epetra PATHS ${_mfs_library_dir} NO_DEFAULT_PATH)
    mark_as_advanced(MfsTrilinos_epetra_LIBRARY)
    target_link_libraries(mfs::trilinos INTERFACE ${MfsTrilinos_epetra_LIBRARY})
    set(MfsTrilinos_EPETRA TRUE)
  endif()
  set(MfsTrilinos_CUDA FALSE CACHE INTERNAL "Whether Trilinos' Kokkos has CUDA")
  if(_mfs_cuda)
    set_property(CACHE MfsTrilinos_CUDA PROPERTY VALUE TRUE)
    if(TARGET mfs_nvcc)
      target_link_libraries(mfs::trilinos INTERFACE mfs_nvcc)
    endif()
    # Programs call these themselves where Tpetra has no explicit instantiation.
    file(STRINGS ${MfsTrilinos_INCLUDE_DIR}/KokkosKernels_config.h _mfs_called
      REGEX "^#define KOKKOSKERNELS_ENABLE_TPL_(CUBLAS|CUSPARSE)$")
    string(REGEX MATCHALL "CUBLAS|CUSPARSE" _mfs_called "${_mfs_called}")
    if(_mfs_called)
      find_dependency(CUDAToolkit)
      list(TRANSFORM _mfs_called TOLOWER)
      list(TRANSFORM _mfs_called PREPEND "CUDA::")
    endif()
    file(STRINGS ${MfsTrilinos_kokkos_INCLUDE}/KokkosCore_config.h _mfs_openmp
      REGEX "^#define KOKKOS_ENABLE_OPENMP$")
    if(_mfs_openmp)
      find_dependency(OpenMP)
      list(APPEND _mfs_called OpenMP::OpenMP_CXX)
    endif()
    target_link_libraries(mfs::trilinos INTERFACE ${_mfs_called})
  endif()
  if(_mfs_static)
    find_dependency(LAPACK)
    target_link_libraries(mfs::trilinos INTERFACE LAPACK::LAPACK BLAS::BLAS ${CMAKE_DL_LIBS})
    if(MfsTrilinos_CUDA)
      find_dependency(CUDAToolkit)
      target_link_libraries(mfs::trilinos INTERFACE CUDA::cudart CUDA::cuda_driver)
    endif()
  endif()
  file(STRINGS ${MfsTrilinos_INCLUDE_DIR}/Trilinos_version.h _mfs_version
    REGEX "^#define TRILINOS_VERSION_STRING")
  string(REGEX REPLACE ".*\"(.*)\".*" "\\1" MfsTrilinos_VERSION "${_mfs_version}")
endif()

if("Stratimikos" IN_LIST MfsTrilinos_FIND_COMPONENTS OR "NOX" IN_LIST MfsTrilinos_FIND_COMPONENTS)
  _mfs_trilinos_package(trilinos_stratimikos Stratimikos_DefaultLinearSolverBuilder.hpp stratimikos
    stratimikosamesos2 thyratpetra thyracore rtop)
endif()
if("NOX" IN_LIST MfsTrilinos_FIND_COMPONENTS AND TARGET mfs::trilinos_stratimikos)
  _mfs_trilinos_package(trilinos_nox NOX_Thyra.H nox)
  if(TARGET mfs::trilinos_nox)
    target_link_libraries(mfs::trilinos_nox INTERFACE mfs::trilinos_stratimikos)
  endif()
endif()
if("Belos" IN_LIST MfsTrilinos_FIND_COMPONENTS)
  _mfs_trilinos_package(trilinos_belos BelosTpetraAdapter.hpp belostpetra belos)
endif()
if("Ifpack2" IN_LIST MfsTrilinos_FIND_COMPONENTS)
  _mfs_trilinos_package(trilinos_ifpack2 Ifpack2_Factory.hpp ifpack2-adapters ifpack2)
endif()
if("MueLu" IN_LIST MfsTrilinos_FIND_COMPONENTS OR "FROSch" IN_LIST MfsTrilinos_FIND_COMPONENTS)
  # Their headers call these libraries as well; not every version of Trilinos has each.
  set(_mfs_below)
  foreach(name muelu-interface xpetra-sup zoltan2 zoltan galeri-xpetra teuchosparser)
    find_library(MfsTrilinos_${name}_LIBRARY NAMES trilinos_${name} ${name} PATHS ${_mfs_library_dir} NO_DEFAULT_PATH)
    mark_as_advanced(MfsTrilinos_${name}_LIBRARY)
    if(MfsTrilinos_${name}_LIBRARY)
      list(APPEND _mfs_below ${name})
    endif()
  endforeach()
  _mfs_trilinos_package(trilinos_muelu MueLu_CreateTpetraPreconditioner.hpp muelu-adapters muelu ${_mfs_below} xpetra)
endif()
if("FROSch" IN_LIST MfsTrilinos_FIND_COMPONENTS AND TARGET mfs::trilinos_muelu AND TARGET mfs::trilinos_stratimikos
   AND TARGET mfs::trilinos_belos AND TARGET mfs::trilinos_ifpack2)
  _mfs_trilinos_package(trilinos_frosch FROSch_TwoLevelPreconditioner_def.hpp shylu_ddfrosch)
  # Zoltan2's headers call Scotch.
  find_path(MfsTrilinos_scotch_INCLUDE ptscotch.h PATH_SUFFIXES scotch)
  find_library(MfsTrilinos_ptscotch_LIBRARY ptscotch)
  find_library(MfsTrilinos_scotch_LIBRARY scotch)
  mark_as_advanced(MfsTrilinos_scotch_INCLUDE MfsTrilinos_ptscotch_LIBRARY MfsTrilinos_scotch_LIBRARY)
  if(TARGET mfs::trilinos_frosch)
    target_link_libraries(mfs::trilinos_frosch INTERFACE mfs::trilinos_muelu mfs::trilinos_stratimikos
      mfs::trilinos_belos mfs::trilinos_ifpack2)
    if(MfsTrilinos_scotch_INCLUDE)
      target_include_directories(mfs::trilinos_frosch INTERFACE ${MfsTrilinos_scotch_INCLUDE})
      target_link_libraries(mfs::trilinos_frosch INTERFACE ${MfsTrilinos_ptscotch_LIBRARY} ${MfsTrilinos_scotch_LIBRARY})
    endif()
  endif()
endif()
foreach(component IN LISTS MfsTrilinos_FIND_COMPONENTS)
  string(TOLOWER ${component} _mfs_lower)
  if(TARGET mfs::trilinos_${_mfs_lower})
    set(MfsTrilinos_${component}_FOUND TRUE)
  endif()
endforeach()

find_package_handle_standard_args(MfsTrilinos REQUIRED_VARS MfsTrilinos_INCLUDE_DIR MfsTrilinos_kokkos_INCLUDE
  VERSION_VAR MfsTrilinos_VERSION HANDLE_COMPONENTS REASON_FAILURE_MESSAGE "missing:${MfsTrilinos_MISSING}")
