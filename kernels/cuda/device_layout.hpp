// The arrays of DeviceStages in its arena. For device_stages_def.hpp.
#pragma once

#include <algorithm>
#include <iterator>

#include "kernels/cuda/device_stages.hpp"

namespace mfs::cuda {

/// Where each array lies in the arena, or in that of the host. Visited twice in one order: to add up sizes,
/// and to copy.
template <class S, class V>
struct DeviceStages<S, V>::Layout {
  ArenaLayout arena, host;
  Offset copied = 0;  // bytes, to the device

  Layout(const SymbolicPlan& plan, const Pattern& pattern, const DevicePlan& lists) {
    DeviceStore<S, V> store{};
    place(plan, pattern, lists, store, [&](auto*& pointer, Offset count, const void* source) {
      using T = std::remove_pointer_t<std::remove_reference_t<decltype(pointer)>>;
      const Offset bytes = count * static_cast<Offset>(sizeof(T));
      const bool there = on_host(store, &pointer, lists);
      (there ? host : arena).add(bytes);
      if (source && !there) copied += bytes;
    });
    arena.add(sizeof(DeviceStatus));
  }

  /// Whether this member of the store points to the memory of the host.
  static bool on_host(const DeviceStore<S, V>& store, const void* member, const DevicePlan& lists) {
    const FrontStore<S, V>& at = store.fronts;
    const void* const there[] = {&at.matrix_values, &at.matrix_columns, &at.entry_in_row, &store.entry_place};
    return lists.matrix_on_host && std::find(std::begin(there), std::end(there), member) != std::end(there);
  }

  template <class Place>
  static void place(const SymbolicPlan& plan, const Pattern& pattern, const DevicePlan& lists,
                    DeviceStore<S, V>& store, const Place& put) {
    const auto copy = [&](auto*& pointer, const auto& array) {
      put(pointer, static_cast<Offset>(array.size()), array.data());
    };
    FrontStore<S, V>& at = store.fronts;
    for_each_numeric_array(at, plan, put);
    put(store.strict, plan.num_fronts, nullptr);
    put(store.panel_rows, static_cast<Offset>(lists.tall_tasks) * kMostPanelColumns, nullptr);
    put(store.panel_border, lists.tall_border, nullptr);
    for_each_plan_array(at, plan, pattern, copy);
    copy(store.small_fronts, lists.small_fronts);
    copy(store.tiny_fronts, lists.tiny_fronts);
    copy(store.assemble, lists.assemble);
    copy(store.exchange, lists.exchange);
    copy(store.wide_tiles, lists.wide_tiles);
    copy(store.unpivoted, lists.unpivoted);
    copy(store.solve, lists.solve);
    copy(store.steps, lists.steps);
    copy(store.products, lists.products);
    copy(store.row_begin, lists.row_begin);
    copy(store.source_begin, lists.source_begin);
    copy(store.destination, lists.destination);
    copy(store.child_row_begin, lists.child_row_begin);
    copy(store.child_row, lists.child_row);
    copy(store.entry_place, lists.entry_place);
    copy(store.solve_lower, lists.solve_lower);
    copy(store.solve_upper, lists.solve_upper);
    copy(store.block_read, lists.block_read);
    copy(store.divided, lists.divided);
    put(store.row_place, lists.divided.empty() ? 0 : plan.n, nullptr);
  }
};

}  // namespace mfs::cuda
