// What evaluating one element takes: room for its state, its shares and its small dense matrices, which each
// thread has once; and what becomes of an exception thrown while all threads are at work.
#pragma once

#include <omp.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <limits>
#include <vector>

#include "dae/mechanics/colouring.hpp"
#include "dae/mechanics/force_blocks.hpp"

namespace mfs::dae {

constexpr std::array<Block, 4> kConstraintBlocks{Block::position_q, Block::velocity_q, Block::acceleration_q,
                                                 Block::acceleration_v};

/// Keeps the first of the exceptions that elements throw, first in the order of the sum.
class FirstFailure {
 public:
  template <class Work>
  void watch(std::size_t place, Work&& work) {
    try {
      work();
    } catch (...) {
#pragma omp critical(mfs_dae_first_failure)
      if (place < place_) {
        place_ = place;
        exception_ = std::current_exception();
      }
    }
  }
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::size_t place_ = std::numeric_limits<std::size_t>::max();
  std::exception_ptr exception_;
};

/// What is needed to compute one element of groups with at most nq coordinates and nc constraints.
struct Workspace {
  std::vector<double> q, v, a;
  std::vector<double> force, position, velocity, acceleration;
  std::array<std::vector<double>, kBlocks> block;
  Runs runs;

  Workspace(std::size_t nq, std::size_t nc)
      : q(nq), v(nq), a(nq), force(nq), position(nc), velocity(nc), acceleration(nc) {
    for (const Block b : kForceBlocks) block[static_cast<std::size_t>(b)].resize(nq * nq);
    for (const Block b : kConstraintBlocks) block[static_cast<std::size_t>(b)].resize(nc * nq);
    runs.reserve(nq + 1);
  }

  LocalState gather(const StateView& state, const int* coordinates, int nq, int first_constraint) {
    for (int k = 0; k < nq; ++k) {
      q[k] = state.q[coordinates[k]];
      v[k] = state.v[coordinates[k]];
      a[k] = state.a[coordinates[k]];
    }
    return {state.t, q.data(), v.data(), a.data(), state.lambda + first_constraint};
  }
  /// The array of block b, cleared if it is asked for.
  double* array(Block b, std::size_t count, BlockSet asked) {
    double* values = block[static_cast<std::size_t>(b)].data();
    if (asked.has(b)) std::fill_n(values, count, 0.0);
    return values;
  }
};

/// Calls work(element, workspace) by so many threads, each with its workspace, for all elements that have a
/// colour, of the groups that take part, in the order of the colouring.
template <class Work>
void for_each_coloured(const Colouring& colouring, const std::vector<char>& group_takes_part, int threads,
                       std::vector<Workspace>& workspaces, const Work& work) {
  FirstFailure failure;
  const auto& order = colouring.order;
  const auto& start = colouring.colour_start;
#pragma omp parallel num_threads(threads) if (start.size() > 1)
  {
    Workspace& workspace = workspaces[static_cast<std::size_t>(omp_get_thread_num())];
    for (std::size_t colour = 0; colour + 1 < start.size(); ++colour)
#pragma omp for schedule(dynamic, 8)
      for (std::size_t k = start[colour]; k < start[colour + 1]; ++k)
        if (group_takes_part[order[k].group] != 0) failure.watch(k, [&] { work(order[k], workspace); });
  }
  failure.rethrow();
}

}  // namespace mfs::dae
