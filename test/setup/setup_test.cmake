# scripts/setup on systems that are made up: what dpkg, apt and the compilers answer stands in files of ${WORK}/system.
# Kokkos and METIS seem to be there, so nothing is fetched or built.
set(system ${WORK}/system)

function(write_program name text)
  file(WRITE ${WORK}/bin/${name} "#!/bin/bash\n${text}\n")
  file(CHMOD ${WORK}/bin/${name} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endfunction()

function(make_system)
  file(REMOVE_RECURSE ${WORK})
  file(WRITE ${WORK}/third_party/metis-5.1.0/libmetis/parmetis.c "")
  file(WRITE ${WORK}/third_party/kokkos-3.4.01-openmp/complete "")
  write_program(id "echo 0")
  write_program(dpkg-query "case \"$*\" in
  *Version*) cat ${system}/version-\"\${@: -1}\" 2>/dev/null ;;
  *) sed 's/^/install ok installed /' ${system}/installed ;;
esac")
  write_program(apt-cache "grep -vxFf ${system}/not-offered ${system}/packages || true")
  write_program(apt-get "echo \"$*\" >>${system}/apt-get")
  write_program(c++ "[ $1 = --version ] && echo 'c++ (Debian)' || cat ${system}/gcc")
  write_program(clang++ "[ $1 = --version ] && echo 'clang version' || cat ${system}/clang")
  write_program(cmake "echo \"cmake version $(cat ${system}/cmake)\"")
  file(WRITE ${system}/gcc 14.2.0)
  file(WRITE ${system}/cmake 3.31.6)
  file(WRITE ${system}/version-libfmt-dev 10.1.1+ds1-4)
  file(WRITE ${system}/version-nlohmann-json3-dev 3.12.0.really.3.12.0.really.3.11.3-3)
  file(WRITE ${system}/version-libtrilinos-amesos2-dev 13.2.0-4)
  file(WRITE ${system}/not-offered "")
  # What setup asks for, as it says itself where nothing is there or offered.
  file(WRITE ${system}/installed "")
  file(WRITE ${system}/packages "")
  setup(1)
  string(REGEX MATCH "missing Debian packages: ([^\n]*)" line "${output}")
  string(REPLACE " " "\n" packages "${CMAKE_MATCH_1}")
  file(WRITE ${system}/installed "${packages}\n")
  file(WRITE ${system}/packages "${packages}\n")
  file(REMOVE ${system}/apt-get)
endfunction()

# setup(<exit status> [VAR=value...]): leaves `output`.
function(setup status)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=CXX MFS_THIRD_PARTY=${WORK}/third_party
    PATH=${WORK}/bin:/usr/bin:/bin ${ARGN} ${SCRIPT} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL status)
    message(FATAL_ERROR "exit status ${result}, not ${status}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(remove_package name)
  file(READ ${system}/installed packages)
  string(REPLACE "\n${name}\n" "\n" packages "${packages}")
  file(WRITE ${system}/installed "${packages}")
endfunction()

function(expect text where)
  string(FIND "${where}" "${text}" found)
  if(found EQUAL -1)
    message(FATAL_ERROR "no '${text}' in:\n${where}")
  endif()
endfunction()

# All is there: apt-get is not called.
make_system()
setup(0)
if(NOT output STREQUAL "setup: all is there\n" OR EXISTS ${system}/apt-get)
  message(FATAL_ERROR "not only 'all is there':\n${output}")
endif()

# Only what is missing is installed.
remove_package(libfmt-dev)
remove_package(cmake)
setup(0)
expect("missing Debian packages: cmake libfmt-dev\n" "${output}")
file(STRINGS ${system}/apt-get calls)
list(GET calls 1 install)
if(NOT install MATCHES "^install .* cmake libfmt-dev$")
  message(FATAL_ERROR "apt-get was called with: ${calls}")
endif()

# The system has no libfmt-dev: nothing is installed.
file(WRITE ${system}/not-offered "libfmt-dev\n")
file(REMOVE ${system}/apt-get)
setup(1)
expect("not offered by this system: libfmt-dev\n" "${output}")
expect("Debian 12 or 13 or Ubuntu 24.04" "${output}")
file(STRINGS ${system}/apt-get calls REGEX "install")
if(calls)
  message(FATAL_ERROR "apt-get was called with: ${calls}")
endif()

# Trilinos without Epetra: the rest is installed.
make_system()
remove_package(libtrilinos-epetra-dev)
remove_package(libtrilinos-nox-dev)
file(WRITE ${system}/not-offered "libtrilinos-epetra-dev\n")
setup(0)
expect("not offered by this system: libtrilinos-epetra-dev; without a Trilinos of your own" "${output}")
expect("all is there" "${output}")
file(STRINGS ${system}/apt-get calls REGEX "^install .* libtrilinos-nox-dev$")
if(NOT calls)
  message(FATAL_ERROR "the package that is offered was not installed")
endif()

# Nor is PETSc needed.
make_system()
remove_package(libpetsc-real-dev)
remove_package(libtrilinos-nox-dev)
file(WRITE ${system}/not-offered "libpetsc-real-dev\n")
setup(0)
expect("not offered by this system: libpetsc-real-dev; without a PETSc of your own" "${output}")
expect("all is there" "${output}")

# Nor is hipcc.
make_system()
remove_package(hipcc)
remove_package(gfortran)
remove_package(libtrilinos-nox-dev)
file(WRITE ${system}/not-offered "hipcc\ngfortran\n")
setup(0)
expect("not offered by this system: hipcc; nothing is compiled for HIP" "${output}")
expect("not offered by this system: gfortran; the module of Fortran is not tested" "${output}")
expect("all is there" "${output}")

# Too old: each is named, with the version that is needed.
make_system()
file(WRITE ${system}/gcc 11.4.0)
file(WRITE ${system}/cmake 3.22.1)
file(WRITE ${system}/version-libfmt-dev 8.1.1+ds1-2)
file(WRITE ${system}/version-libtrilinos-amesos2-dev 13.0.1-1)
setup(1)
expect("gcc 11.4.0 is too old, MFS needs 12: install a newer one and name it in CXX and CC" "${output}")
expect("CMake 3.22.1 is too old, MFS needs 3.25" "${output}")
expect("libfmt-dev 8.1.1 is too old, MFS needs 9.1" "${output}")
expect("libtrilinos-amesos2-dev 13.0.1 is too old, MFS needs 13.2" "${output}")
if(output MATCHES "nlohmann|all is there")
  message(FATAL_ERROR "more than that:\n${output}")
endif()

# Another compiler is named, and is the one that counts.
make_system()
file(WRITE ${system}/gcc 11.4.0)
file(WRITE ${system}/clang 16.0.6)
setup(0 CXX=clang++)
file(WRITE ${system}/clang 13.0.1)
setup(1 CXX=clang++)
expect("clang 13.0.1 is too old, MFS needs 14" "${output}")
