// How the threads of the host share the fronts of all depths in one parallel region, which has no barrier.
//
// The work of a region is a row of lists (the depths), each to be finished before the next begins. Every
// thread is a worker, and all workers go through the lists in the same order:
//
//   list k   +--------------------------+-----------------------------------------+
//            | shared items (few, large)| single items (many, groups of small ones) |
//            +--------------------------+-----------------------------------------+
//              first taken                last taken, where there is nothing to help with
//
// Who takes a shared item owns it: it does the item's steps one after another, and publishes the loop of each
// step (for_each_tile). The owner takes tiles of its own loop; workers without an item take tiles of any loop
// that they find; the owner goes on when its last tile is done. So a thread that the system holds up
// delays what it has taken and nothing else, and one worker alone would finish everything: nothing here
// counts on workers running at the same time. Who does what differs from run to run; what is done does not.
//
// Whoever waits spins for some microseconds and then yields its processor at every look. Nothing is allocated
// and no lock is held in a region.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "kernels/runtime/dispatch.hpp"

namespace mfs {

/// Lets time pass for somebody who waits: longer from call to call.
class Backoff {
 public:
  void wait();

 private:
  int looks_ = 0;
};

/// The loop that one worker shares with the others. `ticket_` holds the number of this loop in its upper half
/// and how many of its tiles are not taken in the lower one, so that a tile is taken by one exchange, and
/// only of the loop that was looked at.
class alignas(64) PublishedLoop {
 public:
  /// Calls body(i) for i = 0 ... count-1, begun in this order, and returns when all are done.
  template <class Body>
  void run(Vertex count, const Body& body) {
    // Nobody reads these as long as no tile is there to be taken: see take_tile.
    body_.store(&body, std::memory_order_relaxed);
    call_.store([](const void* it, Vertex tile) { (*static_cast<const Body*>(it))(tile); },
                std::memory_order_relaxed);
    count_.store(count, std::memory_order_relaxed);
    left_.store(count, std::memory_order_relaxed);
    const std::uint64_t number = (ticket_.load(std::memory_order_relaxed) >> 32) + 1;
    ticket_.store(number << 32 | static_cast<std::uint32_t>(count), std::memory_order_release);
    while (take_tile()) {
    }
    Backoff backoff;
    while (left_.load(std::memory_order_acquire) > 0) backoff.wait();
  }

  /// Does one tile; false where none is left to take.
  bool take_tile();

 private:
  using Call = void (*)(const void*, Vertex);
  std::atomic<std::uint64_t> ticket_{0};
  std::atomic<const void*> body_{nullptr};
  std::atomic<Call> call_{nullptr};
  std::atomic<Vertex> count_{0};
  alignas(64) std::atomic<Vertex> left_{0};  // tiles that are not done
};

/// How many items a list has: [0, shared) and [shared, shared + single).
struct WorkList {
  Vertex shared, single;
};

/// Of lists that wait for nothing but those before them.
struct AtOnce {
  bool operator()(std::size_t) const { return true; }
};
/// Where nobody is told.
struct Unheard {
  void operator()(std::size_t) const {}
};

/// What an item does its loops with.
class Worker {
 public:
  explicit Worker(PublishedLoop& loop) : loop_(&loop) {}
  template <class Body>
  void for_each_tile(Vertex count, const Body& body) const {
    if (count == 1) {
      body(0);
    } else if (count > 1) {
      loop_->run(count, body);
    }
  }

 private:
  PublishedLoop* loop_;
};

class Workers {
 public:
  /// Room for regions of up to `lists` lists. Throws std::bad_alloc.
  Workers(int threads, std::size_t lists) : loops_(static_cast<std::size_t>(threads)), lists_(lists) {}
  int count() const { return static_cast<int>(loops_.size()); }

  /// Calls item(worker, list, i) for each item of size_of(list), list = 0 ... lists-1, and done(list) in
  /// one worker some time after all items of the list are done. Items throw nothing. Each worker calls
  /// may_begin(list) before it looks at a list, which may wait for anything but another worker's items, and
  /// leaves all to the others where that is false.
  template <class Exec, class SizeOf, class Item, class Done, class MayBegin = AtOnce>
  void run(const Exec& exec, const char* label, std::size_t lists, const SizeOf& size_of, const Item& item,
           const Done& done, const MayBegin& may_begin = {}) {
    begin(lists, size_of);
    for_each_index(exec, label, static_cast<Offset>(loops_.size()), [&, this](Offset worker) {
      work(static_cast<std::size_t>(worker), lists, size_of, item, done, may_begin);
    });
  }

  /// The two halves of run: begin by one thread, then work(w, ...) for each worker w, in any threads.
  template <class SizeOf>
  void begin(std::size_t lists, const SizeOf& size_of) {
    for (std::size_t k = 0; k < lists; ++k) {
      const WorkList size = size_of(k);
      lists_[k].shared.store(0, std::memory_order_relaxed);
      lists_[k].single.store(0, std::memory_order_relaxed);
      lists_[k].left.store(size.shared + size.single, std::memory_order_relaxed);
    }
  }
  template <class SizeOf, class Item, class Done, class MayBegin = AtOnce>
  void work(std::size_t me, std::size_t lists, const SizeOf& size_of, const Item& item, const Done& done,
            const MayBegin& may_begin = {}) {
    for (std::size_t k = 0; k < lists; ++k) {
      if (!may_begin(k)) return;
      work_on(me, k, size_of(k), item);
      if (me == 0) done(k);
    }
  }

 private:
  struct alignas(64) ListState {
    std::atomic<Vertex> shared{0}, single{0};  // items taken
    alignas(64) std::atomic<Vertex> left{0};   // items that are not done
  };

  // What the items of a list wrote is seen by all who have left it: they read `left` as zero.
  template <class Item>
  void work_on(std::size_t me, std::size_t list, const WorkList& size, const Item& item) {
    ListState& state = lists_[list];
    Backoff backoff;
    while (state.left.load(std::memory_order_acquire) > 0) {
      Vertex i = 0;
      if (take(state.shared, size.shared, i)) {
        item(Worker(loops_[me]), list, i);
      } else if (help(me)) {
        backoff = Backoff();
        continue;
      } else if (take(state.single, size.single, i)) {
        item(Worker(loops_[me]), list, size.shared + i);
      } else {
        backoff.wait();
        continue;
      }
      state.left.fetch_sub(1, std::memory_order_acq_rel);
      backoff = Backoff();
    }
  }

  static bool take(std::atomic<Vertex>& taken, Vertex count, Vertex& item) {
    if (taken.load(std::memory_order_relaxed) >= count) return false;
    item = taken.fetch_add(1, std::memory_order_relaxed);
    return item < count;
  }
  bool help(std::size_t me);

  std::vector<PublishedLoop> loops_;  // by worker
  std::vector<ListState> lists_;
};

}  // namespace mfs
