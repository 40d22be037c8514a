// Copies of states for threads that work beside the computation. Those that nobody holds any more lend their
// memory to later ones, as to touch new memory takes longer than to copy.
#pragma once

#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "dae/integrator/integrator.hpp"

namespace mfs::dae {

class StateCopies {
 public:
  /// Another thread may let it go, also when this object has ended. Throws std::bad_alloc.
  std::shared_ptr<const State> copy_of(const State& state) {
    std::unique_ptr<State> copy = unused_->take();
    *copy = state;
    return {copy.release(), [unused = unused_](State* done) { unused->add(std::unique_ptr<State>(done)); }};
  }

 private:
  class Unused {
   public:
    std::unique_ptr<State> take() {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (states_.empty()) return std::make_unique<State>();
      std::unique_ptr<State> state = std::move(states_.back());
      states_.pop_back();
      return state;
    }
    void add(std::unique_ptr<State> state) noexcept {
      const std::lock_guard<std::mutex> lock(mutex_);
      try {
        states_.push_back(std::move(state));
      } catch (const std::bad_alloc&) {  // its memory is given back instead
      }
    }

   private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<State>> states_;
  };

  std::shared_ptr<Unused> unused_ = std::make_shared<Unused>();
};

}  // namespace mfs::dae
