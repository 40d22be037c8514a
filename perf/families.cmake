# The benchmark families (target mfs_families), for the program as well as for the benchmarks.
include_guard(GLOBAL)

add_library(mfs_families STATIC ${CMAKE_CURRENT_LIST_DIR}/families.cpp)
target_link_libraries(mfs_families PUBLIC mfs::mfs)
target_include_directories(mfs_families PUBLIC ${PROJECT_SOURCE_DIR})
# The families are defined to the last bit: no fused multiply-add, whatever the machine offers.
target_compile_options(mfs_families PRIVATE -ffp-contract=off)
