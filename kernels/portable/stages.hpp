// All stages of a factorization and of a solve in one execution space: the plan's copy, one arena, and the
// launches, depth by depth. What is launched goes to one queue; nothing here waits for it.
#pragma once

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "kernels/portable/sizes.hpp"
#include "kernels/stages/diagonal.hpp"
#include "kernels/stages/vector_ops.hpp"
#include "plan/device_flops.hpp"
#include "plan/spans.hpp"

namespace mfs::portable {

/// Lists that a DevicePlan has in another form or not at all.
struct OwnLists {
  struct Depth {
    Range follow;                          // columns that follow later exchanges
    Range whole;                           // fronts that are solved with by one team
    Range begin, border;                   // tasks of the others
    std::vector<Range> forward, backward;  // step by step
  };
  std::vector<Depth> depths;
  std::vector<ColumnTask> columns;
  std::vector<Vertex> whole;
  std::vector<SolveTask> solve;
};

inline OwnLists make_own_lists(const SymbolicPlan& plan, const DevicePlan& lists, const Sizes& sizes) {
  OwnLists made;
  const Vertex tile = sizes.limits.tile, solve_tile = sizes.solve_tile;
  const auto range = [](const auto& list, const auto& fill) {
    Range added{static_cast<Offset>(list.size()), 0};
    fill();
    added.end = static_cast<Offset>(list.size());
    return added;
  };
  for (Vertex step = 0; step < plan.num_depths; ++step) {
    OwnLists::Depth depth;
    const Vertex first = plan.depth_begin[step], last = plan.depth_begin[step + 1];
    std::vector<Vertex> tiled;
    depth.follow = range(made.columns, [&] {
      const Range& blocks = lists.depths[static_cast<std::size_t>(step)].exchange;
      for (Offset i = blocks.begin; i < blocks.end; ++i) {
        const FrontPart& block = lists.exchange[static_cast<std::size_t>(i)];
        if (block.begin == block.column + tile) made.columns.push_back({block.front, block.column});
      }
    });
    depth.whole = range(made.whole, [&] {
      for (Vertex f = first; f < last; ++f) (plan.pivots(f) <= sizes.whole ? made.whole : tiled).push_back(f);
    });
    depth.begin = range(made.solve, [&] {
      for (const Vertex f : tiled) {
        for (Vertex k = 0; k < plan.pivots(f); k += solve_tile) made.solve.push_back({f, k});
      }
    });
    depth.border = range(made.solve, [&] {
      for (const Vertex f : tiled) {
        for (Vertex k = 0; k < plan.border_rows(f); k += sizes.most_chunk) made.solve.push_back({f, k});
      }
    });
    Vertex most = 0;
    for (const Vertex f : tiled) most = std::max(most, tiles_of(plan.pivots(f), solve_tile));
    for (Vertex turn = 0; turn + 1 < most; ++turn) {
      depth.forward.push_back(range(made.solve, [&] {
        for (const Vertex f : tiled) {
          for (Vertex k = (turn + 1) * solve_tile; k < plan.pivots(f); k += solve_tile)
            made.solve.push_back({f, k});
        }
      }));
      depth.backward.push_back(range(made.solve, [&] {
        for (const Vertex f : tiled) {
          const Vertex at = tiles_of(plan.pivots(f), solve_tile) - 1 - turn;
          for (Vertex i = 0; i < at; ++i) made.solve.push_back({f, i * solve_tile});
        }
      }));
    }
    made.depths.push_back(std::move(depth));
  }
  return made;
}

/// What is launched for a plan, made without a look at the space.
struct Lists {
  Sizes sizes;
  DevicePlan device;
  OwnLists own;
};

// Those with the most work begin first.
inline void sort_small_fronts(const SymbolicPlan& plan, DevicePlan& lists) {
  for (const DepthLaunches& depth : lists.depths) {
    for (const SmallLaunch& small : depth.small) {
      const auto begin = lists.small_fronts.begin() + small.fronts.begin;
      std::stable_sort(begin, begin + small.fronts.count(),
                       [&](Vertex a, Vertex b) { return plan.front_flops[a] > plan.front_flops[b]; });
    }
  }
}

inline Lists make_lists(const SymbolicPlan& plan, const Sizes& sizes) {
  if (plan.has_turns() && (sizes.limits.small_part > 0 || sizes.limits.small_rows > kAssemblyTurns.rows))
    throw std::logic_error("MFS: fronts of this plan wait for their turn that are assembled at once");
  Lists made{sizes, make_device_plan(plan, sizes.limits), {}};
  made.own = make_own_lists(plan, made.device, sizes);
  sort_small_fronts(plan, made.device);
  return made;
}

/// Of the factorization before and what it found.
struct SettleStrictFronts {
  int* strict;
  const Status* before;
  KOKKOS_FUNCTION void operator()(Offset f) const {
    if (strict[f] != 0) strict[f] = settled_state(strict[f], before->found_strict > 0);
  }
};

/// S: numbers of the factors, V: of the matrix, both as device code calls them.
template <class Exec, class S, class V, class Dense = DenseOf<Exec, S>>
class PortableStages {
 public:
  using Queue = typename Space<Exec>::Queue;
  using Arena = typename Space<Exec>::Arena;

  /// Takes no memory of the space before allocate().
  PortableStages(const SymbolicPlan& plan, const Pattern& pattern, Lists lists)
      : plan_(plan),
        pattern_(pattern),
        sizes_(lists.sizes),
        lists_(std::move(lists.device)),
        own_(std::move(lists.own)),
        flops_(count_flops(plan, lists_, false).done) {}

  /// Bytes that allocate() takes, the library's left out.
  static Offset bytes_for(const SymbolicPlan& plan, const Pattern& pattern, const DevicePlan& lists,
                          const OwnLists& own) {
    ArenaLayout layout;
    Store<S, V> store{};
    ListPointers pointers{};
    place(plan, pattern, lists, own, store, pointers, [&](auto*& pointer, Offset count, const void*) {
      layout.add(count * static_cast<Offset>(sizeof(*pointer)));
    });
    return layout.total();
  }

  /// Throws std::bad_alloc, OutOfMemory, BackendError.
  void allocate() {
    if (Queue::kLibrary && has_large_products()) queue_.open_library();
    arena_ = std::make_unique<Arena>(bytes_for(plan_, pattern_, lists_, own_));
    Offset at = 0;
    place(plan_, pattern_, lists_, own_, store_, on_space_,
          [&](auto*& pointer, Offset count, const void* source) {
            using T = std::remove_pointer_t<std::remove_reference_t<decltype(pointer)>>;
            pointer = arena_->template at<T>(at);
            const Offset bytes = count * static_cast<Offset>(sizeof(T));
            if (source) queue_.to_space(const_cast<std::remove_const_t<T>*>(pointer), source, bytes);
            at += (bytes + kRegionAlignment - 1) / kRegionAlignment * kRegionAlignment;
          });
    store_.fronts.n = plan_.n;
    store_.fronts.max_block_size = plan_.max_block_size;
    store_.fronts.status = nullptr;
    forget_strict_fronts();
    queue_.fill(store_.status, 0, sizeof(Status));
    states_.resize(static_cast<std::size_t>(plan_.num_fronts));
    queue_.wait();
  }

  Queue& queue() const { return queue_; }
  const Store<S, V>& store() const { return store_; }
  const Sizes& sizes() const { return sizes_; }
  Offset bytes() const { return arena_->bytes() + queue_.library_bytes(); }
  Offset border_places() const { return lists_.border_places; }
  /// Operations of a factorization.
  const BlockFlops& flops() const { return flops_; }

  /// No front is strict any more, until a factorization finds that it has to be.
  void forget_strict_fronts() {
    queue_.fill(store_.strict, 0, plan_.num_fronts * static_cast<Offset>(sizeof(int)));
  }
  /// Before a factorization is repeated that found strict fronts. Waits for it.
  void make_ancestors_strict() {
    const Offset bytes = plan_.num_fronts * static_cast<Offset>(sizeof(int));
    queue_.to_host(states_.data(), store_.strict, bytes);
    queue_.wait();
    mfs::make_ancestors_strict(plan_, states_);
    queue_.to_space(store_.strict, states_.data(), bytes);
    queue_.wait();
  }

  /// Launches all stages for what is in the store's matrix_values. The tolerance of pivots is relative to the
  /// largest scaled entry. Calls after_depth(step) when the fronts of a depth have been launched.
  template <class After>
  void factor(const PivotPolicy& policy, const After& after_depth) {
    begin(policy);
    largest_scaled_entry(queue_.exec(), store_.fronts, &store_.status->largest);
    for (Vertex step = 0; step < plan_.num_depths; ++step) {
      factor_depth(step, Stages());
      after_depth(step);
    }
  }
  /// Whether pivots lie in the factors as they are, else their inverses.
  bool has_pivots() const {
    if constexpr (Dense::kSearchesAll) {
      return true;
    } else {
      return dense_.substitutes;
    }
  }
  /// What factor() does before the first depth, but for the largest entry.
  void begin(const PivotPolicy& policy) {
    store_.pivots = pivot_rule<RealOf<S>>(policy, 1);
    if constexpr (!Dense::kSearchesAll) dense_.substitutes = policy.substitutes();
    for_each_index(queue_.exec(), "mfs::strict", plan_.num_fronts,
                   SettleStrictFronts{store_.strict, store_.status});
    queue_.fill(store_.status, 0, sizeof(Status));
    queue_.fill(store_.displacement, 0, plan_.n * static_cast<Offset>(sizeof(Vertex)));
  }
  void factor_depth(Vertex step, const Stages& stages) {
    const DepthLaunches& depth = lists_.depths[static_cast<std::size_t>(step)];
    for (const SmallLaunch& small : depth.small) launch_small(small, stages);
    if (stages.assemble) {
      const std::vector<Range>& turns = depth.assemble_contribution;
      assemble(turns.front());
      assemble(depth.assemble);
      for (std::size_t turn = 1; turn < turns.size(); ++turn) assemble(turns[turn]);
    }
    if (stages.factor) {
      launch_steps(depth.factor);
      follow_moves(own_.depths[static_cast<std::size_t>(step)].follow);
    }
    if (stages.update) {
      for (const Launch& part : depth.update) launch_step(part);
    }
  }

  /// Launches v := A'^-1 v (elimination order, scaled) for the factors, or the transposed.
  void substitute(const Vectors<S>& vectors, bool transposed) {
    for (Vertex step = 0; step < plan_.num_depths; ++step) solve_depth(step, vectors, true, transposed);
    for (Vertex step = plan_.num_depths - 1; step >= 0; --step) solve_depth(step, vectors, false, transposed);
  }
  void solve_depth(Vertex step, const Vectors<S>& vectors, bool forward, bool transposed) {
    const OwnLists::Depth& depth = own_.depths[static_cast<std::size_t>(step)];
    const Offset entry = static_cast<Offset>(sizeof(S)) * vectors.columns,
                 few = Dense::few_entries(vectors.columns) * static_cast<Offset>(sizeof(S)) + kSlack;
    const Offset fit = (scratch_bytes<Exec>() - few) / entry;
    const Vertex chunk =
        std::max(kInvertedBlock, static_cast<Vertex>(std::min<Offset>(sizes_.most_gathered, fit)));
    const Offset bytes = chunk * entry + few;
    const Substitution<S, V, Dense> all{store_.fronts,
                                        on_space_.row_begin,
                                        on_space_.source_begin,
                                        on_space_.destination,
                                        lists_.border_places,
                                        vectors,
                                        {sizes_.solve_tile, sizes_.most_chunk, chunk},
                                        transposed,
                                        dense_};
    const Exec& exec = queue_.exec();
    const TeamShape threads = team(kMostThreads);
    launch(exec, "mfs::whole", depth.whole.count(), team(vectors.columns > 1 ? kMostThreads : 64), bytes,
           SolveWhole<Exec, S, V, Dense>{all, on_space_.whole + depth.whole.begin, forward});
    launch(exec, "mfs::tiles", depth.begin.count(), threads, bytes,
           BeginTiles<Exec, S, V, Dense>{all, on_space_.solve + depth.begin.begin, forward});
    Vertex turn = 0;
    for (const Range& tasks : forward ? depth.forward : depth.backward) {
      launch(exec, "mfs::step", tasks.count(), threads, bytes,
             StepTiles<Exec, S, V, Dense>{all, on_space_.solve + tasks.begin, turn++, forward});
    }
    if (!forward) return;
    launch(exec, "mfs::border", depth.border.count(), threads, bytes,
           LeaveBorders<Exec, S, V, Dense>{all, on_space_.solve + depth.border.begin});
  }

 private:
  static constexpr Offset kSlack = 48;  // of scratch memory, for alignment
  struct ListPointers {
    const Vertex *small_fronts, *source_begin, *destination, *whole;
    const AssemblyPart* assemble;
    const StepTask* steps;
    const ProductTask* products;
    const ColumnTask* columns;
    const SolveTask* solve;
    const Offset* row_begin;
  };

  // Calls put(pointer, count, source) for all arrays of the arena; on the host, arrays of the plan stay where
  // they are.
  template <class Put>
  static void place(const SymbolicPlan& plan, const Pattern& pattern, const DevicePlan& made,
                    const OwnLists& own, Store<S, V>& store, ListPointers& lists, const Put& put) {
    const auto take = [&](auto*& pointer, const auto& array) {
      if constexpr (kOnHost<Exec>) {
        pointer = array.data();
      } else {
        put(pointer, static_cast<Offset>(array.size()), array.data());
      }
    };
    FrontStore<S, V>& at = store.fronts;
    const Offset n = plan.n;
    for_each_numeric_array(at, plan, put);
    put(at.interchange, n, nullptr);
    put(at.work, n, nullptr);
    put(store.strict, plan.num_fronts, nullptr);
    put(store.status, 1, nullptr);
    put(store.displacement, n, nullptr);
    put(store.move_to, 2 * n, nullptr);
    put(store.move_from, 2 * n, nullptr);
    put(store.move_count, n, nullptr);
    for_each_plan_array(at, plan, pattern, take);
    take(store.entry_place, made.entry_place);
    take(lists.small_fronts, made.small_fronts);
    take(lists.assemble, made.assemble);
    take(lists.steps, made.steps);
    take(lists.products, made.products);
    take(lists.row_begin, made.row_begin);
    take(lists.source_begin, made.source_begin);
    take(lists.destination, made.destination);
    take(lists.columns, own.columns);
    take(lists.whole, own.whole);
    take(lists.solve, own.solve);
  }

  bool has_large_products() const {
    for (const DepthLaunches& depth : lists_.depths) {
      for (const auto* launches : {&depth.factor, &depth.update}) {
        for (const Launch& part : *launches) {
          if (part.kind == Launch::Kind::vendor_gemm) return true;
        }
      }
    }
    return false;
  }

  // Entries of scratch memory that a kernel may use all of.
  Offset room() const { return (scratch_bytes<Exec>() - kSlack) / static_cast<Offset>(sizeof(S)); }
  // Own strips leave room for other teams beside them.
  Offset strip_room() const { return Dense::kSearchesAll ? room() : Dense::strip_entries(); }
  static Offset bytes_of(Offset entries) { return entries * static_cast<Offset>(sizeof(S)) + kSlack; }

  TeamShape team(int threads) const { return {kOnHost<Exec> ? sizes_.host_team : threads}; }
  /// The same of threads with lanes: as many in all.
  TeamShape team_of_lanes(int threads) const {
    return {kOnHost<Exec> ? sizes_.host_team : threads / kLanes<Exec>, kLanes<Exec>};
  }

  void launch_small(const SmallLaunch& small, const Stages& stages) {
    const Vertex rows = Dense::kSearchesAll ? 0 : small.rows;
    const Offset entries = small_front_entries(rows);
    const int threads = small.rows <= 16 ? 1 : small.rows <= 32 ? 2 : kSmallThreads;
    launch(queue_.exec(), "mfs::small", small.fronts.count(), team_of_lanes(threads * kLanes<Exec>),
           small_front_bytes<S>(rows),
           SmallFronts<Exec, S, V, Dense>{store_, on_space_.small_fronts + small.fronts.begin, entries,
                                          stages, dense_});
  }
  void assemble(const Range& parts) {
    launch(queue_.exec(), "mfs::assemble", parts.count(), team(kMostThreads),
           kChildrenAtOnce * static_cast<Offset>(sizeof(ChildSpan)) + kSlack,
           AssembleParts<Exec, S, V>{store_, on_space_.assemble + parts.begin});
  }
  // On the host, products that may run beside the next diagonal tiles share a launch with them.
  void launch_steps(const std::vector<Launch>& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const bool beside = Dense::kSearchesAll && parts[i].order == Order::concurrent &&
                          parts[i].kind == Launch::Kind::products && i + 1 < parts.size() &&
                          parts[i + 1].kind == Launch::Kind::diagonal;
      if (beside) {
        const auto tiles = diagonal_kernel(parts[i + 1]);
        const auto products = product_kernel(parts[i]);
        launch(queue_.exec(), "mfs::ahead", parts[i].blocks + parts[i + 1].blocks, {1}, diagonal_scratch(),
               TilesAndProducts<Exec, S, V, Dense>{tiles, products, parts[i + 1].blocks});
        ++i;
      } else {
        launch_step(parts[i]);
      }
    }
  }
  DiagonalTiles<Exec, S, V, Dense> diagonal_kernel(const Launch& part) const {
    return {store_, on_space_.steps + part.tasks.begin, sizes_.limits.tile, dense_};
  }
  Products<Exec, S, Dense> product_kernel(const Launch& part) const {
    return {store_.fronts.storage,
            on_space_.products + part.tasks.begin,
            static_cast<Vertex>(part.tasks.count()),
            sizes_.limits.product_rows,
            sizes_.limits.product_columns,
            dense_};
  }
  Offset diagonal_scratch() const {
    const Vertex tile = sizes_.limits.tile;
    return Dense::kSearchesAll ? 2 * tile * static_cast<Offset>(sizeof(Vertex)) + kSlack
                               : diagonal_bytes<S>(tile);
  }
  void launch_step(const Launch& part) {
    const Exec& exec = queue_.exec();
    const Vertex count = static_cast<Vertex>(part.tasks.count()), tile = sizes_.limits.tile;
    const StepTask* const steps = on_space_.steps + part.tasks.begin;
    switch (part.kind) {
      case Launch::Kind::diagonal:
        launch(exec, "mfs::diagonal", part.blocks, team_of_lanes(kMostThreads), diagonal_scratch(),
               diagonal_kernel(part));
        break;
      case Launch::Kind::strips:
        launch(
            exec, "mfs::strips", part.blocks, team(kMostThreads), bytes_of(strip_room()),
            Strips<Exec, S, V, Dense>{store_, steps, count, tile, sizes_.limits.strip, strip_room(), dense_});
        break;
      case Launch::Kind::products:
      case Launch::Kind::wide_products:
        launch(exec, "mfs::products", part.blocks, team(kMostThreads), bytes_of(Dense::kProductEntries),
               product_kernel(part));
        break;
      case Launch::Kind::vendor_gemm: {
        const ProductTask& task = lists_.products[static_cast<std::size_t>(part.tasks.begin)];
        S* const storage = store_.fronts.storage;
        queue_.gemm_minus(task.m, task.n, task.k, static_cast<const S*>(storage + task.a), task.lda,
                          static_cast<const S*>(storage + task.b), task.ldb, storage + task.c, task.ldc);
        break;
      }
    }
  }
  void follow_moves(const Range& columns) {
    launch(queue_.exec(), "mfs::follow", columns.count(), team(kMostThreads), bytes_of(room()),
           FollowMoves<Exec, S, V, Dense>{store_, on_space_.columns + columns.begin, sizes_.limits.tile,
                                          room()});
  }

  const SymbolicPlan& plan_;
  const Pattern& pattern_;
  Sizes sizes_;
  DevicePlan lists_;
  OwnLists own_;
  BlockFlops flops_;
  mutable Queue queue_;  // that launches and copies go to is no matter of the factors
  std::unique_ptr<Arena> arena_;
  Store<S, V> store_{};
  ListPointers on_space_{};
  std::vector<int> states_;  // of fronts, on their way
  Dense dense_;
};

}  // namespace mfs::portable
