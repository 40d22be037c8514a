# Flags of every target of MFS. Hidden visibility and -fno-gnu-unique keep the Kokkos inside libmfs apart from
# any other Kokkos of the process. No -march: BLAS picks its kernels at run time, and so do ours.
if(NOT DEFINED CMAKE_CXX_STANDARD)
  set(CMAKE_CXX_STANDARD 17)
endif()
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_C_VISIBILITY_PRESET hidden)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release)
endif()
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
  set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
endif()

add_compile_options(-Wall -Wextra)
if(NOT MFS_CUDA)  # the host side of nvcc's output is not pedantic C++
  add_compile_options(-Wpedantic)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT MFS_CLANG_TIDY)  # clang does not know the flag
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fno-gnu-unique>)
endif()
if(MFS_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  # A null pointer or one that has left its object ends at the address sanitizer, too, and objects whose type is not what
  # a pointer says do so when they are used. Their checks at each access of a member take half of the compiler's time.
  add_compile_options(-fno-sanitize=null,vptr,pointer-overflow)
  add_link_options(-fsanitize=address,undefined)
endif()
if(MFS_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang" OR NOT MFS_SANITIZE)
    message(FATAL_ERROR "MFS_FUZZ needs clang and MFS_SANITIZE: cmake --preset fuzz")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

if(MFS_CLANG_TIDY)
  find_program(MFS_CLANG_TIDY_PROGRAM NAMES clang-tidy-14 clang-tidy REQUIRED)
  set(CMAKE_CXX_CLANG_TIDY ${MFS_CLANG_TIDY_PROGRAM} --quiet --warnings-as-errors=* --extra-arg=-Wno-unknown-warning-option)
endif()
