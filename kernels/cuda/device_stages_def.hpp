// Definitions of device_stages.hpp, for the files that instantiate it.
#pragma once

#include <algorithm>
#include <cstring>

#include "kernels/cuda/device_layout.hpp"
#include "kernels/cuda/device_limits.hpp"
#include "kernels/cuda/device_stages.hpp"
#include "kernels/cuda/factor/assembly.hpp"
#include "kernels/cuda/factor/block_lu.hpp"
#include "kernels/cuda/factor/products.hpp"
#include "kernels/cuda/factor/reductions.hpp"
#include "kernels/cuda/factor/small_fronts.hpp"
#include "kernels/cuda/factor/strips.hpp"
#include "kernels/cuda/factor/unpivoted_roots.hpp"
#include "kernels/cuda/solve/substitution.hpp"
#include "kernels/cuda/solve/tile_inverses.hpp"
#include "kernels/cuda/solve/tiny_substitution.hpp"

namespace mfs::cuda {

template <class S, class V>
DevicePlan DeviceStages<S, V>::lists_for(const SymbolicPlan& plan, SegmentPlan segments) {
  return make_device_plan(plan, device_limits<S>(least_root_for<S>(plan)), std::move(segments));
}

template <class S, class V>
Offset DeviceStages<S, V>::library_bytes(const DevicePlan& lists) {
  constexpr Offset kBlas = Offset(32) << 20;  // of two handles, which take about 4 MiB (device-memory.md)
  const auto is_product = [](const Launch& part) { return part.kind == Launch::Kind::vendor_gemm; };
  const bool products =
      std::any_of(lists.depths.begin(), lists.depths.end(), [&](const DepthLaunches& depth) {
        return std::any_of(depth.factor.begin(), depth.factor.end(), is_product) ||
               std::any_of(depth.update.begin(), depth.update.end(), is_product);
      });
  Offset bytes = products ? kBlas : 0;
  for (const RootTask& root : lists.roots) {
    const Offset workspace = static_cast<Offset>(root.pivots) * kTile<S> * static_cast<Offset>(sizeof(S));
    bytes = std::max(bytes, (products ? kBlas : 0) + DeviceLapack::kHandleBytes + 2 * workspace);
  }
  return bytes;
}

template <class S, class V>
NumericBytes DeviceStages<S, V>::bytes_for(const SymbolicPlan& plan, const Pattern& pattern,
                                           const DevicePlan& lists) {
  ArenaLayout storage;
  storage.add(plan.storage_entries * static_cast<Offset>(sizeof(S)));
  NumericBytes bytes;
  bytes.factor = plan.factor_entries * static_cast<Offset>(sizeof(S));
  bytes.outside = lists.segments.host_entries * static_cast<Offset>(sizeof(S));
  bytes.contribution = storage.total() - (bytes.factor - bytes.outside);
  bytes.other = Layout(plan, pattern, lists).arena.total() - storage.total();
  return bytes;
}

template <class S, class V>
DeviceStages<S, V>::DeviceStages(const SymbolicPlan& plan, const Pattern& pattern, const Stream& stream)
    : DeviceStages(plan, pattern, stream, lists_for(plan)) {}

template <class S, class V>
DeviceStages<S, V>::DeviceStages(const SymbolicPlan& plan, const Pattern& pattern, const Stream& stream,
                                 Vertex least_root)
    : DeviceStages(plan, pattern, stream, make_device_plan(plan, device_limits<S>(least_root))) {}

template <class S, class V>
DeviceStages<S, V>::DeviceStages(const SymbolicPlan& plan, const Pattern& pattern, const Stream& stream,
                                 DevicePlan lists)
    : plan_(plan),
      stream_(stream),
      lists_(std::move(lists)),
      flops_{count_flops(plan, lists_, false), count_flops(plan, lists_, true)},
      copies_(lists_.segments.empty()
                  ? nullptr
                  : std::make_unique<SegmentCopies>(lists_.segments, static_cast<Offset>(sizeof(S)))),
      early_(copies_ ? std::make_unique<EarlyAssembly>(lists_.segments) : nullptr),
      arena_(Layout(plan, pattern, lists_).arena.total()) {
  open_libraries();
  find_places_on_host();
  const Offset place = upload(pattern);
  if (lists_.block_read.empty()) store_.block_read = store_.fronts.contribution_begin;
  if (lists_.divided.empty()) store_.divided = nullptr;
  store_.fronts.n = plan.n;
  store_.fronts.max_block_size = plan.max_block_size;
  store_.fronts.entry_target = nullptr;
  store_.fronts.entry_row = nullptr;
  store_.fronts.interchange = nullptr;
  store_.fronts.work = nullptr;
  status_ = arena_.at<DeviceStatus>(place);
  store_.fronts.status = &status_->pivots;
  store_.found_strict = &status_->found_strict;
  store_.pivots_needed = &status_->pivots_needed;
  store_.largest = &status_->largest;
  store_.tile = lists_.tile;
  store_.tall = lists_.tall;
  store_.by_panels = false;
  store_.substitutes = false;
  states_.resize(static_cast<std::size_t>(plan_.num_fronts));
  forget_strict_fronts();
  stream_.clear(status_, sizeof(DeviceStatus));
  stream_.synchronize();  // copies that failed are told of here
  lists_.entry_place = {};
  set_kernel_attributes();
}

// Returns what has been used of the arena.
template <class S, class V>
Offset DeviceStages<S, V>::upload(const Pattern& pattern) {
  const Layout layout(plan_, pattern, lists_);
  if (layout.host.total() > 0) host_arena_ = std::make_unique<PinnedArena>(layout.host.total());
  Upload upload(stream_, layout.copied);
  Offset place = 0, host_place = 0;
  Layout::place(plan_, pattern, lists_, store_, [&](auto*& pointer, Offset count, const void* source) {
    using T = std::remove_pointer_t<std::remove_reference_t<decltype(pointer)>>;
    const bool there = Layout::on_host(store_, &pointer, lists_);
    Offset& at = there ? host_place : place;
    pointer = there ? host_arena_->template at<T>(at) : arena_.at<T>(at);
    const Offset bytes = count * static_cast<Offset>(sizeof(T));
    T* const to = pointer;
    if (source && there)
      std::memcpy(const_cast<std::remove_const_t<T>*>(to), source, static_cast<std::size_t>(bytes));
    if (source && !there) upload.to_device(const_cast<std::remove_const_t<T>*>(to), source, bytes);
    at += (bytes + kRegionAlignment - 1) / kRegionAlignment * kRegionAlignment;
  });
  return place;
}

// The device reads page-locked memory of the host as its own: one address means one place. The region comes
// first in the arena.
template <class S, class V>
void DeviceStages<S, V>::find_places_on_host() {
  if (lists_.segments.empty()) return;
  const Offset bytes = static_cast<const char*>(copies_->host()) - arena_.template at<char>(0);
  const Offset host = bytes / static_cast<Offset>(sizeof(S));
  for (Vertex f = 0; f < plan_.num_fronts; ++f) {
    const Offset place = lists_.segments.read_on_host[f];
    if (place >= 0) lists_.block_read[f] = host + place;
    if (!lists_.segments.solved_on_host(f)) continue;
    lists_.solve_lower[f] += host;
    lists_.solve_upper[f] += host;
  }
  for (SolvePart& part : lists_.solve) {
    part.where.lower = lists_.solve_lower[part.front];
    part.where.upper = lists_.solve_upper[part.front];
  }
}

template <class S, class V>
void DeviceStages<S, V>::set_kernel_attributes() {
  small_begin_early_ = begins_early(reinterpret_cast<const void*>(&factor_small_fronts<32, 28, S, V>));
  constexpr int kWide = kTile<S>, kNarrow = kNarrowTile<S>;
  constexpr std::size_t kUnasked = 48 * 1024, kMiddle = small_front_bytes<S>(64);  // what needs no attribute
  set_shared_memory(reinterpret_cast<const void*>(&factor_small_fronts<256, 2, S, V>),
                    small_front_bytes<S>(lists_.small_rows));
  if constexpr (kMiddle > kUnasked)
    set_shared_memory(reinterpret_cast<const void*>(&factor_small_fronts<128, 4, S, V>), kMiddle);
  if (lists_.tile > kNarrow)
    set_shared_memory(reinterpret_cast<const void*>(&factor_diagonal_tiles<kWide, kTileThreads, S, V>),
                      block_lu_bytes<S>(kWide));
  set_shared_memory(reinterpret_cast<const void*>(&factor_diagonal_tiles<kNarrow, kNarrowThreads, S, V>),
                    block_lu_bytes<S>(kNarrow));
  static_assert(tile_entries(kTile<S>) >= kTile<S> * kTile<S>);  // panel_border_bytes
  set_shared_memory(reinterpret_cast<const void*>(&eliminate_panel_borders<S, V>),
                    sizeof(S) * lists_.tile * lists_.tile);
  set_shared_memory(reinterpret_cast<const void*>(&factor_strict_panels<S, V>),
                    strict_panel_bytes<S>(lists_.panel_entries));
  set_shared_memory(reinterpret_cast<const void*>(&take_unpivoted_tiles<S, V>), tile_bytes<S>(lists_.tile));
  for (const Vertex pivots : {kInverted, 2 * kInverted, kTile<S>}) {
    if (pivots > lists_.tile) break;
    with_strip_shape<S>(lists_.strip, pivots, [](auto rows, auto blocks) {
      set_shared_memory(reinterpret_cast<const void*>(&solve_strips<rows(), blocks(), S, V>),
                        strip_bytes<S>(blocks(), rows()));
    });
  }
  set_shared_memory(reinterpret_cast<const void*>(&invert_tiles<S, V>), sizeof(TileInverseWork<S>));
  const auto memory = static_cast<std::size_t>(shared_memory_per_block());
  most_columns_ = substitution_bytes<S, kSolveColumns>() <= memory ? kSolveColumns
                  : substitution_bytes<S, kFewColumns>() <= memory ? kFewColumns
                                                                   : 1;
  short_products_ = NarrowShape::bytes<S>() > memory;
  for (const bool wide : {false, true}) {
    with_product_shape<S>(wide, short_products_, [](auto shape) {
      using Shape = decltype(shape);
      set_shared_memory(reinterpret_cast<const void*>(&subtract_products<Shape, S, V>),
                        Shape::template bytes<S>());
    });
  }
}

// Their working memory would be most of what a small system takes.
template <class S, class V>
void DeviceStages<S, V>::open_libraries() {
  for (const DepthLaunches& depth : lists_.depths) {
    for (const auto* launches : {&depth.factor, &depth.update}) {
      for (const Launch& part : *launches) {
        if (part.kind != Launch::Kind::vendor_gemm) continue;
        if (!blas_) blas_.emplace(stream_);
        if (part.order == Order::concurrent && !blas_ahead_) blas_ahead_.emplace(ahead_.stream());
      }
    }
  }
  for (const RootTask& root : lists_.roots) {
    if (!lapack_) lapack_.emplace(stream_);
    lapack_->reserve(root.pivots, static_cast<const S*>(nullptr), root.ld);
  }
}

template <class S, class V>
void DeviceStages<S, V>::make_ancestors_strict() {
  const Offset bytes = plan_.num_fronts * static_cast<Offset>(sizeof(int));
  stream_.to_host(states_.data(), store_.strict, bytes);
  stream_.synchronize();
  mfs::make_ancestors_strict(plan_, states_);
  stream_.to_device(store_.strict, states_.data(), bytes);
  stream_.synchronize();
}

template <class S, class V>
void DeviceStages<S, V>::launch(const Launch& what, const Stream& stream,
                                const std::optional<DeviceBlas>& blas) {
  const unsigned blocks = static_cast<unsigned>(what.blocks);
  const int count = static_cast<int>(what.tasks.count());
  constexpr int kWide = kTile<S>, kNarrow = kNarrowTile<S>;
  switch (what.kind) {
    case Launch::Kind::diagonal:
      if (what.width <= kNarrow) {
        factor_diagonal_tiles<kNarrow, kNarrowThreads>
            <<<blocks, kNarrowThreads, block_lu_bytes<S>(kNarrow), stream.get()>>>(store_, what.tasks.begin);
      } else {
        factor_diagonal_tiles<kWide, kTileThreads>
            <<<blocks, kTileThreads, block_lu_bytes<S>(kWide), stream.get()>>>(store_, what.tasks.begin);
      }
      break;
    case Launch::Kind::strips:
      if (blocks == 0) break;
      with_strip_shape<S>(lists_.strip, what.width, [&](auto rows, auto wide) {
        solve_strips<rows(), wide()>
            <<<blocks, strip_threads(rows()), strip_bytes<S>(wide(), rows()), stream.get()>>>(
                store_, what.tasks.begin, count);
      });
      break;
    case Launch::Kind::products:
    case Launch::Kind::wide_products:
      with_product_shape<S>(what.kind == Launch::Kind::wide_products, short_products_, [&](auto shape) {
        using Shape = decltype(shape);
        subtract_products<Shape><<<blocks, Shape::threads, Shape::template bytes<S>(), stream.get()>>>(
            store_, what.tasks.begin, count);
      });
      break;
    case Launch::Kind::vendor_gemm: {
      const ProductTask& task = lists_.products[what.tasks.begin];
      S* const storage = store_.fronts.storage;
      blas->template gemm_minus<S>(task.m, task.n, task.k, storage + task.a, task.lda, storage + task.b,
                                   task.ldb, storage + task.c, task.ldc);
      break;
    }
  }
}

// Each size in a stream of its own, beside the larger fronts of the depth: all are too small to fill the
// device.
template <class S, class V>
void DeviceStages<S, V>::launch_small_fronts(const std::vector<SmallLaunch>& launches) {
  if (launches.empty()) return;
  fork_.record(stream_);
  for (std::size_t i = 0; i < launches.size(); ++i) {
    side_[i].wait_for(fork_);
    launch_small(store_, launches[i], side_[i], false);
    joined_[i].record(side_[i]);
  }
}

template <class S, class V>
void DeviceStages<S, V>::join_small_fronts(const std::vector<SmallLaunch>& launches) {
  for (std::size_t i = 0; i < launches.size(); ++i) stream_.wait_for(joined_[i]);
}

template <class S, class V>
void DeviceStages<S, V>::factor(const PivotPolicy& policy, PivotSearch search, const Mark& mark) {
  with_sides([&] { launch_stages(policy, search, mark); });
}

template <class S, class V>
void DeviceStages<S, V>::launch_stages(const PivotPolicy& policy, PivotSearch search, const Mark& mark) {
  const bool strict = search == PivotSearch::strict || search == PivotSearch::strict_by_panels;
  const bool look_ahead = !strict && !mark;
  const bool library_roots = search == PivotSearch::not_in_roots && has_library_roots();
  store_.pivots = pivot_rule<RealOf<S>>(policy, 1);
  store_.substitutes = policy.substitutes();
  store_.by_panels = search == PivotSearch::strict_by_panels;
  settle_strict_fronts<<<vector_blocks(plan_.num_fronts), kVectorThreads, 0, stream_.get()>>>(
      store_.strict, plan_.num_fronts, store_.found_strict);
  stream_.clear(status_, sizeof(DeviceStatus));
  stream_.clear(store_.fronts.shift, plan_.n * static_cast<Offset>(sizeof(S)));
  Vertex step = 0;
  const auto next = [&](Kernel kernel) {
    if (mark) mark(kernel, step);
  };
  next(Kernel::largest);
  with_row_lanes(plan_.n, plan_.nnz, [&](auto lanes) {
    largest_entry_by_rows<lanes()>
        <<<reducing_blocks(static_cast<Offset>(plan_.n) * lanes()), kVectorThreads, 0, stream_.get()>>>(
            store_.fronts, &status_->largest);
  });
  bool after_small = true;  // the stream's last launch is one of small fronts, or of all entries
  for (; step < static_cast<Vertex>(lists_.depths.size()); ++step) {
    const DepthLaunches& depth = lists_.depths[step];
    if (!copies_ && depth.is_one_small_launch()) {
      next(Kernel::small_fronts);
      launch_small(store_, depth.small.front(), stream_, after_small && !mark && small_begin_early_);
      after_small = true;
      continue;
    }
    after_small = false;
    if (look_ahead && early_) assemble_early(step);
    if (copies_) copies_->begin_factor(step, stream_);
    next(Kernel::small_fronts);
    launch_small_fronts(depth.small);
    if (mark) join_small_fronts(depth.small);  // else their time would show as that of what they run beside
    next(Kernel::assemble);
    const bool early = look_ahead && lists_.segments.is_assembled_early(step);
    if (early) {
      early_->join_factors(step, stream_);
    } else {
      assemble(depth, look_ahead);
    }
    if (library_roots && &depth == &lists_.depths.back()) {
      next(Kernel::roots);
      launch_roots();
    } else {
      launch_steps(depth, look_ahead, next);
      if (copies_) follow_divided(lists_.segments.segments[step]);
    }
    next(Kernel::exchange);
    if (depth.exchange.count() > 0) {
      exchange_block_rows<<<static_cast<unsigned>(depth.exchange.count()), kTileThreads,
                            sizeof(S) * lists_.tile * 32, stream_.get()>>>(store_, depth.exchange.begin);
    }
    assembly_.join(stream_);
    if (early) early_->join_contribution(step, stream_);
    next(Kernel::update);
    for (const Launch& part : depth.update) launch(part, stream_, blas_);
    join_small_fronts(depth.small);
    if (copies_) {
      invert(depth.inverses);
      copies_->end_factor(step, stream_, store_.fronts.storage);
    }
  }
  --step;  // all fronts, told as the last step's
  next(Kernel::inverses);
  if (copies_) {
    copies_->end_factorization(stream_);
  } else {
    invert({0, static_cast<Offset>(lists_.wide_tiles.size())});
  }
  if (strict) {
    count_strict_fronts<<<vector_blocks(plan_.num_fronts), kVectorThreads, 0, stream_.get()>>>(
        store_, plan_.num_fronts, &status_->strict_left, &status_->tall_left);
  }
  next(Kernel::end);
  check_launch("factor");
}

// Everything that needs the triangles of these tiles as they were must have been launched before.
template <class S, class V>
void DeviceStages<S, V>::invert(const Range& tiles) {
  if (tiles.count() == 0) return;
  DeviceStore<S, V> at = store_;
  at.wide_tiles += tiles.begin;
  invert_tiles<<<static_cast<unsigned>(tiles.count()), kInverseThreads, sizeof(TileInverseWork<S>),
                 stream_.get()>>>(at);
}

template <class S, class V>
DeviceStore<S, V> DeviceStages<S, V>::store_for_solve() const {
  DeviceStore<S, V> at = store_;
  if (copies_) {
    at.fronts.lower_begin = store_.solve_lower;
    at.fronts.upper_begin = store_.solve_upper;
  }
  return at;
}

template <class S, class V>
template <class Next>
void DeviceStages<S, V>::launch_steps(const DepthLaunches& depth, bool look_ahead, const Next& next) {
  for (const Launch& part : depth.factor) {
    next(part.kind == Launch::Kind::diagonal ? Kernel::diagonal
         : part.kind == Launch::Kind::strips ? Kernel::strips
                                             : Kernel::products);
    if (part.order == Order::join) ahead_.join(stream_);
    if (store_.by_panels && part.tall_pivots > 0) launch_strict_panels(part);
    if (look_ahead && part.order == Order::concurrent) {
      launch(part, ahead_.begin_after(stream_), blas_ahead_);
    } else {
      launch(part, stream_, blas_);
    }
  }
  ahead_.join(stream_);
}

// Columns of the tall strict fronts among these tiles.
template <class S, class V>
void DeviceStages<S, V>::launch_strict_panels(const Launch& tiles) {
  const auto tasks = static_cast<unsigned>(tiles.blocks);
  const auto blocks = static_cast<unsigned>(lists_.tile / kUpdatedColumns +
                                            (tiles.tall_rows + kExchangedColumns - 1) / kExchangedColumns);
  const int width = panel_columns(lists_.panel_entries, tiles.tall_pivots);
  const auto border_blocks = static_cast<unsigned>((tiles.tall_border + kFollowThreads - 1) / kFollowThreads);
  for (int first = 0; first < std::min(tiles.width, tiles.tall_pivots); first += width) {
    if (store_.substitutes && border_blocks > 0) {
      eliminate_panel_borders<<<dim3(tasks, border_blocks), kFollowThreads,
                                panel_border_bytes<S>(first, std::min<int>(width, lists_.tile - first)),
                                stream_.get()>>>(store_, tiles.tasks.begin, first, width);
    }
    factor_strict_panels<<<tasks, kStrictThreads, strict_panel_bytes<S>(lists_.panel_entries),
                           stream_.get()>>>(store_, tiles.tasks.begin, first, width, lists_.panel_entries);
    follow_strict_panels<<<dim3(tasks, blocks), kFollowThreads, 0, stream_.get()>>>(store_, tiles.tasks.begin,
                                                                                    first, width);
  }
}

template <class S, class V>
void DeviceStages<S, V>::follow_divided(const Segment& segment) {
  if (!segment.divided) return;
  const Vertex f = lists_.segments.order[segment.begin];
  follow_exchanges<<<vector_blocks(plan_.pivots(f)), kVectorThreads, 0, stream_.get()>>>(store_, f);
}

template <class S, class V>
void DeviceStages<S, V>::launch_roots() {
  for (const RootTask& root : lists_.roots)
    lapack_->getrf(root.pivots, store_.fronts.storage + root.at, root.ld);
  const Range &below = lists_.below_diagonal, &on = lists_.on_diagonal;
  if (below.count() > 0) {
    check_unpivoted_tiles<<<static_cast<unsigned>(below.count()), kCheckThreads, 0, stream_.get()>>>(
        store_, below.begin);
  }
  take_unpivoted_tiles<<<static_cast<unsigned>(on.count()), kTileThreads, tile_bytes<S>(lists_.tile),
                         stream_.get()>>>(store_, on.begin);
}

// Contribution blocks beside all else, where it may be; later turns write over blocks that P, L and U of the
// depth are made of, too.
template <class S, class V>
void DeviceStages<S, V>::assemble(const DepthLaunches& depth, bool look_ahead) {
  const auto blocks_stream = [&]() -> const Stream& {
    return look_ahead ? assembly_.begin_after(stream_) : stream_;
  };
  const std::vector<Range>& turns = depth.assemble_contribution;
  assemble(turns.front(), blocks_stream());
  assemble(depth.assemble, stream_);
  if (turns.size() == 1) return;
  const Stream& stream = blocks_stream();
  for (std::size_t turn = 1; turn < turns.size(); ++turn) assemble(turns[turn], stream);
}

// So few blocks have enough of the link under way, and leave the device to all else.
template <class S, class V>
void DeviceStages<S, V>::assemble_early(Vertex done) {
  constexpr int kShare = 6;  // of multiprocessors: half and all of them were slower (device-memory.md)
  const auto most = static_cast<unsigned>(std::max(multiprocessors() / kShare, 1));
  early_->begin(
      done, stream_, *copies_,
      [&](Vertex t, const Stream& stream) { assemble(lists_.depths[t].assemble, stream, most); },
      [&](Vertex t, const Stream& stream) {
        for (const Range& turn : lists_.depths[t].assemble_contribution) assemble(turn, stream, most);
      });
}

template <class S, class V>
void DeviceStages<S, V>::assemble(const Range& parts, const Stream& stream, unsigned most_blocks) {
  if (parts.count() == 0) return;
  const unsigned blocks = std::min(static_cast<unsigned>(parts.count()), most_blocks);
  if (lists_.divided.empty()) {
    assemble_fronts<false><<<blocks, kAssembleThreads, 0, stream.get()>>>(store_, parts.begin, parts.end);
  } else {
    assemble_fronts<true><<<blocks, kAssembleThreads, 0, stream.get()>>>(store_, parts.begin, parts.end);
  }
}

// Launches `side` in another stream while `main` runs, where there are both.
template <class S, class V>
template <class Side, class Main>
void DeviceStages<S, V>::launch_side_by_side(bool has_side, bool has_main, const Side& side,
                                             const Main& main) {
  const bool both = has_side && has_main;
  if (both) {
    fork_.record(stream_);
    side_[0].wait_for(fork_);
  }
  if (has_side) side(both ? side_[0] : stream_);
  if (both) joined_[0].record(side_[0]);
  if (has_main) main();
  if (both) stream_.wait_for(joined_[0]);
}

template <class S, class V>
template <int K, bool Transposed, bool Substituted>
void DeviceStages<S, V>::substitute_columns(const Vectors& at) {
  constexpr bool kForward = Transposed && Substituted, kBackward = !Transposed && Substituted;
  constexpr std::size_t kBytes = substitution_bytes<S, K>();
  const auto forward = &substitute_forward<Transposed, kForward, K, S, V>;
  const auto backward = &substitute_backward<Transposed, kBackward, K, S, V>;
  for (const void* kernel : {reinterpret_cast<const void*>(forward), reinterpret_cast<const void*>(backward)})
    set_shared_memory(kernel, kBytes);
  constexpr int kTinyThreads = kTinyFrontsPerBlock * kWarp;
  const auto tiny_blocks = [](const SolveLaunch& launch) {
    return static_cast<unsigned>((launch.tiny.count() + kTinyFrontsPerBlock - 1) / kTinyFrontsPerBlock);
  };
  const DeviceVectors<S> vectors{at.v, at.y, at.border, at.partial};
  const DeviceStore<S, V> store = store_for_solve();
  const auto unset = [&](S* rows, Offset count) {
    stream_.fill(rows, kUnset, count * K * static_cast<Offset>(sizeof(S)));
  };
  if (copies_) copies_->begin_solve(stream_);
  unset(vectors.y, plan_.n);
  Vertex segment = 0;
  for (const SolveLaunch& launch : lists_.forward) {
    if (copies_) copies_->begin_forward(segment, stream_, store.fronts.storage, Transposed);
    const bool waits = launch.tiny.count() == 0;  // for what it leaves itself
    if (waits) unset(vectors.border + launch.border.begin * K, launch.border.count());
    launch_side_by_side(
        launch.tiny.count() > 0, launch.tiles.count() > 0,
        [&](const Stream& stream) {
          substitute_tiny_forward<Transposed, kForward, K>
              <<<tiny_blocks(launch), kTinyThreads, 0, stream.get()>>>(store, vectors, launch.tiny.begin,
                                                                       static_cast<int>(launch.tiny.count()));
        },
        [&] {
          forward<<<static_cast<unsigned>(launch.tiles.count()), kSolveThreads, kBytes, stream_.get()>>>(
              store, vectors, launch.tiles.begin);
        });
    if (copies_) copies_->end_pass(segment++, stream_);
  }
  unset(vectors.v, plan_.n);
  unset(vectors.partial, partial_rows(lists_));
  for (const SolveLaunch& launch : lists_.backward) {
    if (copies_) copies_->begin_backward(--segment, stream_, store.fronts.storage, Transposed);
    launch_side_by_side(
        launch.tiny.count() > 0, launch.tiles.count() > 0,
        [&](const Stream& stream) {
          substitute_tiny_backward<Transposed, kBackward, K>
              <<<tiny_blocks(launch), kTinyThreads, 0, stream.get()>>>(store, vectors, launch.tiny.begin,
                                                                       static_cast<int>(launch.tiny.count()));
        },
        [&] {
          backward<<<static_cast<unsigned>(launch.tiles.count()), kSolveThreads, kBytes, stream_.get()>>>(
              store, vectors, launch.tiles.begin);
        });
    if (copies_) copies_->end_pass(segment, stream_);
  }
  check_launch("solve");
}

template <class S, class V>
void DeviceStages<S, V>::substitute(const Vectors& vectors, Vertex width, bool transposed) {
  with_sides([&] {
    with_width(width, [&](auto k) {
      const auto solve = [&](auto by) {
        transposed ? substitute_columns<k(), true, by()>(vectors)
                   : substitute_columns<k(), false, by()>(vectors);
      };
      store_.substitutes ? solve(std::true_type()) : solve(std::false_type());
    });
  });
}

// Where a call fails, what is in the side streams already must not run on beside whatever comes next.
template <class S, class V>
template <class Work>
void DeviceStages<S, V>::with_sides(const Work& work) {
  try {
    work();
  } catch (...) {
    for (const Stream& side : side_) side.drain();
    assembly_.drain();
    ahead_.drain();
    if (early_) early_->drain();
    if (copies_) copies_->drain();
    throw;
  }
}

}  // namespace mfs::cuda
