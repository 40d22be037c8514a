// Loops over indices on a stream of a device: what kernels/runtime/dispatch.hpp is for Kokkos' spaces.
// Kokkos' maxima, which rely on the threads of a warp, are what tools that look for races warn of.
#pragma once

#include "kernels/cuda/factor/reductions.hpp"
#include "kernels/cuda/runtime/device.hpp"

namespace mfs::cuda {

struct StreamLoops {
  const Stream* stream;
};

template <class Body>
__global__ void __launch_bounds__(kVectorThreads) do_each_index(Offset count, Body body) {
  const Offset i = blockIdx.x * static_cast<Offset>(kVectorThreads) + threadIdx.x;
  if (i < count) body(i);
}
template <class Body>
__global__ void __launch_bounds__(kVectorThreads) find_largest(Offset count, Body body, double* largest) {
  const Offset stride = static_cast<Offset>(gridDim.x) * kVectorThreads;
  double most = 0;
  for (Offset i = blockIdx.x * static_cast<Offset>(kVectorThreads) + threadIdx.x; i < count; i += stride)
    body(i, most);
  raise_to(largest, most);
}

template <class Body>
void for_each_index(const StreamLoops& loops, const char* label, Offset count, const Body& body) {
  if (count == 0) return;
  do_each_index<<<vector_blocks(count), kVectorThreads, 0, loops.stream->get()>>>(count, body);
  check_launch(label);
}
/// Of what is not negative.
template <class Body>
void find_maximum(const StreamLoops& loops, const char* label, Offset count, const Body& body,
                  double* place) {
  loops.stream->clear(place, sizeof(double));
  find_largest<<<reducing_blocks(count), kVectorThreads, 0, loops.stream->get()>>>(count, body, place);
  check_launch(label);
}

}  // namespace mfs::cuda
