// The solve of a plan whose blocks come one after the other (plan/block_triangle.hpp).
#pragma once

#include "kernels/stages/stages.hpp"
#include "plan/block_schedule.hpp"

namespace mfs {

/// numbers[k] = coupling k, scaled as the entries of fronts are.
template <class Exec, class Scalar, class Value>
void take_couplings(const Exec& exec, const FrontStore<Scalar, Value>& store, const BlockTriangle& triangle,
                    Scalar* numbers) {
  const Offset* const slots = triangle.slot.data();
  const Offset* const begin = triangle.by_row.begin.data();
  for_each_index(exec, "mfs::couplings", store.n, [=](Offset position) {
    for (Offset k = begin[position]; k < begin[position + 1]; ++k)
      numbers[k] = store.scaled_slot(slots[k], store.row_of[position]);
  });
}

/// One solve with A, or with A^T.
template <class Scalar, class Value>
class BlockSubstitution {
 public:
  BlockSubstitution(const FrontStore<Scalar, Value>& store, const BlockTriangle& triangle,
                    const Scalar* couplings, const SolveVectors<Scalar>& vectors, bool transposed)
      : store_(store),
        triangle_(triangle),
        lists_(transposed ? triangle.by_column : triangle.by_row),
        numbers_(couplings),
        vectors_(vectors),
        transposed_(transposed) {}

  void forward(const Vertex* fronts, Vertex count) const {
    for_fronts_ahead(store_, fronts, count, false, transposed_,
                     [&](Vertex f) { forward(SequentialSplit(), f); });
  }
  void backward(const Vertex* fronts, Vertex count) const {
    for_fronts_ahead(store_, fronts, count, true, transposed_,
                     [&](Vertex f) { backward(SequentialSplit(), f); });
  }
  template <class Split>
  void forward(const Split& split, Vertex f) const {
    couple(store_.pivot_begin[f], store_.pivot_begin[f + 1]);
    forward_front(split, store_, vectors_, f, transposed_);
  }
  template <class Split>
  void backward(const Split& split, Vertex f) const {
    backward_front(split, store_, vectors_, f, transposed_);
  }

  /// All of these blocks, one after the other.
  void solve(const BlockSchedule::Group& group) const {
    for (Vertex i = group.begin; i < group.end; ++i) {
      const Vertex b = transposed_ ? group.end - 1 - (i - group.begin) : i;
      const Vertex begin = triangle_.block_begin[b], count = triangle_.block_begin[b + 1] - begin;
      forward(triangle_.front.data() + begin, count);
      backward(triangle_.front.data() + begin, count);
    }
  }

 private:
  // Takes from the right-hand sides at these positions what blocks that are solved for make of them.
  void couple(Vertex begin, Vertex end) const {
    const Offset *const first = lists_.begin.data(), *const number = lists_.number.data();
    const Vertex* const others = lists_.others.data();
    for (Vertex p = begin; p < end; ++p) {
      Scalar* const to = vectors_.row(vectors_.v, p);
      for (Offset k = first[p]; k < first[p + 1]; ++k) {
        const Scalar by = numbers_[number[k]];
        const Scalar* const from = vectors_.row(vectors_.v, others[k]);
        for (Vertex j = 0; j < vectors_.width; ++j) to[j] -= by * from[j];
      }
    }
  }

  const FrontStore<Scalar, Value>& store_;
  const BlockTriangle& triangle_;
  const BlockTriangle::Couplings& lists_;
  const Scalar* const numbers_;
  const SolveVectors<Scalar> vectors_;
  const bool transposed_;
};

template <class Exec, class Scalar, class Value>
void solve_blocks(const Exec& exec, Workers& workers, const BlockSchedule& schedule,
                  const BlockSubstitution<Scalar, Value>& blocks, bool transposed) {
  const std::vector<BlockSchedule::List>& lists = schedule.lists[transposed];
  const auto depth_of = [&](std::size_t k) -> const DepthSchedule& {
    return schedule.steps[lists[k].step].depths[lists[k].depth];
  };
  workers.run(
      exec, "mfs::solve", lists.size(),
      [&](std::size_t k) {
        if (lists[k].depth >= 0) return work_list(depth_of(k));
        return WorkList{0, static_cast<Vertex>(schedule.steps[lists[k].step].groups.size())};
      },
      [&](const Worker& worker, std::size_t k, Vertex i) {
        if (lists[k].depth < 0) return blocks.solve(schedule.steps[lists[k].step].groups[i]);
        for_fronts(
            depth_of(k), i,
            [&](Vertex f, int) {
              lists[k].down ? blocks.backward(TiledSplit{worker}, f) : blocks.forward(TiledSplit{worker}, f);
            },
            [&](const Vertex* fronts, Vertex count) {
              lists[k].down ? blocks.backward(fronts, count) : blocks.forward(fronts, count);
            });
      },
      Unheard());
}

}  // namespace mfs
