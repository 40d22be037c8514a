# cpack -G DEB: the packages of Debian, one for each component of MfsInstall. The preset "deb" configures what belongs into
# them, below /usr.
#
#   libmfs0.1          libmfs.so.0.1
#   libmfs-dev         headers for C++, C, Fortran, Eigen and SUNDIALS, CMake and pkg-config files
#   libmfs-amesos2-dev the adapter to Trilinos
#   mfs-tools          the program mfs
#   mfs-dae            the program mfs-dae
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mfs)
set(CPACK_PACKAGE_VENDOR "MFS")
set(CPACK_PACKAGE_CONTACT "MFS maintainers <maintainers@mfs-solver.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
  WORLD_EXECUTE)

set(CPACK_COMPONENTS_ALL library development)
foreach(part amesos2 program dae)
  if(TARGET mfs_${part})
    string(REPLACE program tools component ${part})
    list(APPEND CPACK_COMPONENTS_ALL ${component})
  endif()
endforeach()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 0mfs1)  # older than any that Debian may make of that version
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

# mfs_debian_package(<component> <package> <section> <summary> DEPENDS <packages> LIBRARIES <yes or no> TEXT <lines>...)
function(mfs_debian_package component package section summary)
  cmake_parse_arguments(arg "" "DEPENDS;LIBRARIES" "TEXT" ${ARGN})
  string(TOUPPER ${component} COMPONENT)
  list(JOIN arg_TEXT "\n" text)
  foreach(variable_and_value "PACKAGE_NAME;${package}" "PACKAGE_SECTION;${section}" "PACKAGE_DEPENDS;${arg_DEPENDS}"
      "PACKAGE_SHLIBDEPS;${arg_LIBRARIES}")
    list(POP_FRONT variable_and_value variable)
    set(CPACK_DEBIAN_${COMPONENT}_${variable} "${variable_and_value}" PARENT_SCOPE)
  endforeach()
  set(CPACK_COMPONENT_${COMPONENT}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(documents ${PROJECT_BINARY_DIR}/documents/${package})
  file(MAKE_DIRECTORY ${documents})
  configure_file(${PROJECT_SOURCE_DIR}/LICENSE ${documents}/copyright COPYONLY)
  file(WRITE ${documents}/changelog.Debian
    "mfs (${version}) unstable; urgency=medium\n\n  * As CHANGELOG.md of MFS tells.\n\n"
    " -- ${CPACK_PACKAGE_CONTACT}  Tue, 24 Nov 2026 12:00:00 +0000\n")
  execute_process(COMMAND gzip -9nf ${documents}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${documents}/copyright ${documents}/changelog.Debian.gz DESTINATION share/doc/${package}
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

set(same "(= ${version})")
get_target_property(soversion mfs SOVERSION)
set(what "MFS solves large, sparse, unsymmetric linear systems directly, with a"
  "checked backward error: LU by fronts whose tree is a nested dissection.")
mfs_debian_package(library libmfs${soversion} libs "multifrontal sparse direct solver - library" LIBRARIES ON
  TEXT ${what} "This package has the shared library.")
mfs_debian_package(development libmfs-dev libdevel "multifrontal sparse direct solver - development files"
  DEPENDS "libmfs${soversion} ${same}" LIBRARIES OFF
  TEXT ${what} "This package has the headers for C++, C, Eigen and SUNDIALS, the module of"
  "Fortran, and the files of CMake and pkg-config.")
# Debian's packages of Trilinos do not depend on those whose headers and libraries theirs need.
set(trilinos mpi-default-dev)
foreach(part amesos2 epetra kokkos kokkos-kernels rtop shylu stratimikos teuchos thyra tpetra trilinosss)
  string(APPEND trilinos ", libtrilinos-${part}-dev")
endforeach()
mfs_debian_package(amesos2 libmfs-amesos2-dev libdevel "multifrontal sparse direct solver - solver of Trilinos' Amesos2"
  DEPENDS "libmfs-dev ${same}, ${trilinos}" LIBRARIES OFF
  TEXT ${what} "This package has the adapter that makes it the solver MFS of Amesos2.")
mfs_debian_package(tools mfs-tools math "multifrontal sparse direct solver - program"
  DEPENDS "libmfs${soversion} ${same}" LIBRARIES ON
  TEXT ${what} "This package has the program mfs, which solves systems in Matrix Market"
  "files and files of PETSc.")
mfs_debian_package(dae mfs-dae math "simulation of mechanisms of rigid and flexible bodies"
  DEPENDS "libmfs${soversion} ${same}, python3" LIBRARIES ON
  TEXT "The program mfs-dae integrates mechanisms implicitly, finds their equilibrium"
  "and their small motions. Models are files of JSON.")
set(CPACK_DEBIAN_DAE_PACKAGE_RECOMMENDS python3-matplotlib)
# dpkg-shlibdeps finds the others' libmfs in the build tree, and its package by the lines above.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(control ${PROJECT_BINARY_DIR}/documents/control)
file(WRITE ${control}/shlibs "libmfs ${soversion} libmfs${soversion} ${same}\n")
file(WRITE ${control}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${control}/shlibs ${control}/triggers)
# The trigger calls ldconfig; cpack has added scripts that do, too.
set(CPACK_POST_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/without_scripts.cmake)
# What the package was called before its name was that of the library.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONFLICTS libmfs0)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_REPLACES libmfs0)
include(CPack)
