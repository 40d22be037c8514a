# cmake --install: libmfs, its headers, the programs, the adapter, and what find_package(mfs) and pkg-config read.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/mfs)

install(TARGETS mfs mfs_fortran EXPORT mfs-targets)
install(EXPORT mfs-targets NAMESPACE mfs:: DESTINATION ${package_dir})
install(DIRECTORY ordering/include/mfs solver/include/mfs bindings/c/include/mfs
  bindings/eigen/include/mfs DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h")
install(FILES bindings/sundials/include/sunlinsol_mfs.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES bindings/c/fortran/mfs.f90 DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/mfs)

file(RELATIVE_PATH prefix_from_bin "/${CMAKE_INSTALL_BINDIR}" "/${CMAKE_INSTALL_LIBDIR}")
foreach(program mfs_program mfs_dae)
  if(TARGET ${program})
    set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/${prefix_from_bin}")
    install(TARGETS ${program})
  endif()
endforeach()
if(TARGET mfs_dae)
  install(PROGRAMS dae/output/plot_results dae/output/plot_modes DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/mfs)
endif()

if(TARGET mfs_amesos2)
  install(TARGETS mfs_amesos2 EXPORT mfs-amesos2-targets)
  install(EXPORT mfs-amesos2-targets NAMESPACE mfs:: DESTINATION ${package_dir})
  install(DIRECTORY amesos2_mfs/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
  install(FILES amesos2_mfs/cmake/FindMfsTrilinos.cmake DESTINATION ${package_dir})
endif()

set(mfs_pc_plugins "")
foreach(plugin IN LISTS mfs_petsc_targets)
  install(TARGETS ${plugin} EXPORT mfs-petsc-targets)
  string(APPEND mfs_pc_plugins "${plugin}=\${libdir}/lib${plugin}.so\n")
endforeach()
if(mfs_petsc_targets)
  install(EXPORT mfs-petsc-targets NAMESPACE mfs:: DESTINATION ${package_dir})
  install(FILES bindings/petsc/include/mfs_petsc.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endif()

configure_package_config_file(cmake/mfs-config.cmake.in mfs-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(mfs-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mfs-config.cmake ${PROJECT_BINARY_DIR}/mfs-config-version.cmake
  DESTINATION ${package_dir})

file(RELATIVE_PATH prefix_from_pc "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" prefix_from_pc "${prefix_from_pc}")
configure_file(cmake/mfs.pc.in mfs.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/mfs.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
