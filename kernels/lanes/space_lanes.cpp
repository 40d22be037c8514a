#include "kernels/lanes/space_lanes_def.hpp"

#include <complex>

namespace mfs::lanes {

namespace {
using Exec = Kokkos::DefaultExecutionSpace;

template <class Copy>
void copy_all(const std::vector<SpaceCopy>& copies, void* stream, const Copy& copy) {
  Space<Exec>::start();
  Space<Exec>::Queue queue;
  queue.follow(stream);
  for (const SpaceCopy& one : copies) copy(queue, one);
  queue.wait();
}

}  // namespace

template <class Scalar>
std::unique_ptr<SpaceLanes<Scalar>> make_space_lanes(const LaneProgram& program, const LevelSchedule& levels,
                                                     const LaneRules& rules, Offset nrhs, Offset count,
                                                     Offset most_bytes) {
  Space<Exec>::start();
  return std::make_unique<SpaceLanesIn<Exec, Scalar>>(program, levels, rules, nrhs, count, most_bytes);
}

void copy_to_host(const std::vector<SpaceCopy>& copies, void* stream) {
  copy_all(copies, stream,
           [](auto& queue, const SpaceCopy& copy) { queue.to_host(copy.to, copy.from, copy.bytes); });
}

void copy_to_space(const std::vector<SpaceCopy>& copies, void* stream) {
  copy_all(copies, stream,
           [](auto& queue, const SpaceCopy& copy) { queue.to_space(copy.to, copy.from, copy.bytes); });
}

#define MFS_INSTANTIATE(S)                                                                              \
  template std::unique_ptr<SpaceLanes<S>> make_space_lanes<S>(const LaneProgram&, const LevelSchedule&, \
                                                              const LaneRules&, Offset, Offset, Offset);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::lanes
