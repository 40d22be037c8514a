# Installs into a prefix of its own, then builds and runs programs of users who know that prefix only.
set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  list(JOIN ARGV " " line)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${line}\n${output}\nexit status ${result}")
  endif()
  message(STATUS "${line}")
endfunction()

if(SANITIZE)
  set(sanitizer -fsanitize=address,undefined)
endif()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${prefix}/bin/mfs info)

function(build_outside name)
  run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR}/outside -B ${WORK}/${name}
    -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_FLAGS=${sanitizer} ${ARGN})
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
  run(${WORK}/${name}/solve_tiny)
endfunction()
build_outside(plain)
if(AMESOS2)
  build_outside(amesos2 -D WITH_AMESOS2=ON)
  run(${WORK}/amesos2/solve_tiny_amesos2)
endif()

# The same program by pkg-config, from a prefix that was moved after the installation.
set(moved ${WORK}/moved)
file(RENAME ${prefix} ${moved})
find_program(pkg_config pkg-config REQUIRED)
set(ENV{PKG_CONFIG_PATH} ${moved}/${LIBDIR}/pkgconfig)
execute_process(COMMAND ${pkg_config} --cflags --libs mfs OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} -std=c++17 ${sanitizer} ${CMAKE_CURRENT_LIST_DIR}/outside/solve_tiny.cpp -o solve_tiny_pc ${flags}
  -Wl,-rpath,${moved}/${LIBDIR})
run(${WORK}/solve_tiny_pc)
run(${moved}/bin/mfs info)
file(REMOVE_RECURSE ${WORK})
