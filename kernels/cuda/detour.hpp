// When a factorization takes a way round that other values may not need.
#pragma once

#include <algorithm>

namespace mfs::cuda {

/// A way round that costs time: once it was needed it is taken, but now and then it is tried without, as
/// other values may not need it: at once, and if that is in vain after 2, 4, ... factorizations, at most
/// kMostPatience.
class Detour {
 public:
  bool taken() const { return taken_; }
  /// Around each factorization.
  void begin() {
    again_ = taken_ && ++taken_for_ >= patience_;
    if (again_) taken_ = false;
  }
  void take() { taken_ = true; }
  void end() {
    if (again_ || !taken_) taken_for_ = 0;
    patience_ = !taken_ ? 1 : again_ ? std::min(2 * patience_, kMostPatience) : patience_;
  }

 private:
  static constexpr int kMostPatience = 64;
  bool taken_ = false, again_ = false;
  int taken_for_ = 0, patience_ = 1;
};

}  // namespace mfs::cuda
