// Visibility of what libmfs shows: everything else in the library is hidden, Kokkos included.
#pragma once

#define MFS_API __attribute__((visibility("default")))
#define MFS_HIDDEN __attribute__((visibility("hidden")))
