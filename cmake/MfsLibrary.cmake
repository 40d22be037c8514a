# mfs_library_rules(target): libmfs lives beside any other Kokkos in a process.
#   version script, --exclude-libs   nothing but mfs:: is seen from outside
#   -Bsymbolic                       its own references stay inside
#   -z defs                          nothing is left to be found by chance
#   -z nodelete                      OpenMP's threads and Kokkos' atexit handlers outlive dlclose
function(mfs_library_rules target)
  set(map ${PROJECT_SOURCE_DIR}/cmake/mfs.map)
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    LINK_DEPENDS ${map})
  target_link_options(${target} PRIVATE -Wl,--version-script=${map} -Wl,--exclude-libs,ALL -Wl,-Bsymbolic
    -Wl,-z,nodelete)
  if(NOT MFS_SANITIZE)  # the sanitizers' own symbols come with the executable
    target_link_options(${target} PRIVATE -Wl,-z,defs)
  endif()
endfunction()
