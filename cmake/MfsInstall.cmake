# cmake --install: libmfs, its headers, the programs, the adapter, and what find_package(mfs) and pkg-config read. Each
# belongs to a component, of which MfsPackages makes a package of Debian.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/mfs)

install(TARGETS mfs mfs_fortran EXPORT mfs-targets LIBRARY COMPONENT library NAMELINK_COMPONENT development)
if(MFS_BLAS STREQUAL "pypi")
  install(FILES "${MFS_PYPI_BLAS}" DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
  set_target_properties(mfs PROPERTIES INSTALL_RPATH "$ORIGIN")
endif()
install(EXPORT mfs-targets NAMESPACE mfs:: DESTINATION ${package_dir} COMPONENT development)
install(DIRECTORY ordering/include/mfs solver/include/mfs bindings/c/include/mfs
  bindings/eigen/include/mfs DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
  FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h")
install(FILES bindings/sundials/include/sunlinsol_mfs.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT development)
install(FILES bindings/c/fortran/mfs.f90 DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/mfs COMPONENT development)

file(RELATIVE_PATH prefix_from_bin "/${CMAKE_INSTALL_BINDIR}" "/${CMAKE_INSTALL_LIBDIR}")
set(mfs_program_component tools)
set(mfs_dae_component dae)
foreach(program mfs_program mfs_dae)
  if(TARGET ${program})
    if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")  # where the linker looks by itself
      set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/${prefix_from_bin}")
    endif()
    install(TARGETS ${program} RUNTIME COMPONENT ${${program}_component})
  endif()
endforeach()
# Manual pages, made of what --help says; nothing needs them.
find_program(MFS_PYTHON3 python3 PATHS /usr/bin NO_DEFAULT_PATH)
find_program(MFS_PYTHON3 python3)
mark_as_advanced(MFS_PYTHON3)
if(MFS_PYTHON3 AND NOT CMAKE_CROSSCOMPILING)
  add_custom_target(mfs_manuals)
  foreach(program mfs_program mfs_dae)
    if(TARGET ${program})
      get_target_property(name ${program} OUTPUT_NAME)
      set(manual ${PROJECT_BINARY_DIR}/documents/${name}.1.gz)
      add_custom_command(OUTPUT ${manual} DEPENDS ${program} ${PROJECT_SOURCE_DIR}/cmake/man_page
        COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/documents
        COMMAND ${MFS_PYTHON3} ${PROJECT_SOURCE_DIR}/cmake/man_page $<TARGET_FILE:${program}> ${manual})
      add_custom_target(mfs_manual_${name} DEPENDS ${manual})
      add_dependencies(mfs_manuals mfs_manual_${name})
      install(FILES ${manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${${program}_component} OPTIONAL)
    endif()
  endforeach()
endif()
if(TARGET mfs_dae)
  install(PROGRAMS dae/output/plot_results dae/output/plot_modes DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/mfs
    COMPONENT dae)
endif()

if(TARGET mfs_amesos2)
  install(TARGETS mfs_amesos2 EXPORT mfs-amesos2-targets ARCHIVE COMPONENT amesos2)
  install(EXPORT mfs-amesos2-targets NAMESPACE mfs:: DESTINATION ${package_dir} COMPONENT amesos2)
  install(DIRECTORY amesos2_mfs/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT amesos2
    FILES_MATCHING PATTERN "*.hpp")
  install(FILES amesos2_mfs/cmake/FindMfsTrilinos.cmake DESTINATION ${package_dir} COMPONENT amesos2)
endif()

set(mfs_pc_plugins "")
foreach(plugin IN LISTS mfs_petsc_targets)
  install(TARGETS ${plugin} EXPORT mfs-petsc-targets LIBRARY COMPONENT petsc)
  string(APPEND mfs_pc_plugins "${plugin}=\${libdir}/lib${plugin}.so\n")
endforeach()
if(mfs_petsc_targets)
  install(EXPORT mfs-petsc-targets NAMESPACE mfs:: DESTINATION ${package_dir} COMPONENT petsc)
  install(FILES bindings/petsc/include/mfs_petsc.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT petsc)
endif()

configure_package_config_file(cmake/mfs-config.cmake.in mfs-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(mfs-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mfs-config.cmake ${PROJECT_BINARY_DIR}/mfs-config-version.cmake
  DESTINATION ${package_dir} COMPONENT development)

file(RELATIVE_PATH prefix_from_pc "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" prefix_from_pc "${prefix_from_pc}")
configure_file(cmake/mfs.pc.in mfs.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/mfs.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
