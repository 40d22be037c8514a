// Who does a subtree takes a stack for its contribution blocks, and gives it back (plan/subtrees.hpp). There
// are as many as workers, so one is always free.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace mfs {

class StackPool {
 public:
  explicit StackPool(std::size_t count) : taken_(count) {}

  /// A stack as long as this lives.
  class Taken {
   public:
    explicit Taken(StackPool& pool) : pool_(pool), number_(pool.take()) {}
    ~Taken() { pool_.taken_[number_].store(false, std::memory_order_release); }
    Taken(const Taken&) = delete;
    Taken& operator=(const Taken&) = delete;
    std::size_t number() const { return number_; }

   private:
    StackPool& pool_;
    std::size_t number_;
  };

 private:
  std::size_t take() {
    for (std::size_t i = 0;; i = i + 1 < taken_.size() ? i + 1 : 0) {
      if (!taken_[i].load(std::memory_order_relaxed) && !taken_[i].exchange(true, std::memory_order_acquire))
        return i;
    }
  }
  std::vector<std::atomic<bool>> taken_;
};

}  // namespace mfs
