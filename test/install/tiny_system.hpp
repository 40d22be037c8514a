// A small system solved by MFS, for programs that look at what else is in the process.
#pragma once

#include <memory>
#include <mfs/mfs.hpp>

/// A factored tridiagonal matrix that can be solved again and again.
class TinySystem {
 public:
  TinySystem();
  /// Refactors and solves; true if the solution is right.
  bool solve();

 private:
  static constexpr int n = 1000;
  std::vector<int> row_offsets_, columns_;
  std::vector<double> values_;
  mfs::CsrView<double> matrix_;
  mfs::Solver solver_;
};
