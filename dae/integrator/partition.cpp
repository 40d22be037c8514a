#include "dae/integrator/partition.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "dae/integrator/sparse_lu.hpp"
#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {
namespace {

/// It is not looked at while no entry of the constraints has changed more, in parts of the constraint's
/// largest: each pivot was at least half of what it was chosen from.
constexpr double kUnchanged = 0.25;
/// A choice has degraded when dependent coordinates move this many times more than they did at first.
constexpr double kDegraded = 4.0;

/// Phi_q with columns in the coordinates' scales and rows of largest entry 1.
std::vector<double> scaled(const Pattern& pattern, const std::vector<double>& values,
                           const std::vector<double>& scale, int threads) {
  std::vector<double> result(values.size());
  const auto scale_row = [&](std::size_t row) {
    double most = 0.0;
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
      most = std::max(most, std::abs(result[k] = values[k] * scale[pattern.column[k]]));
    if (most > 0.0)
      for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k) result[k] /= most;
  };
  parallel_for(static_cast<std::size_t>(pattern.rows), threads, scale_row, pattern.entries());
  return result;
}

/// +1 or -1, always the same for one pair of numbers (a step of splitmix64).
double random_sign(std::uint64_t sample, std::uint64_t index) {
  std::uint64_t z = (index + 1) * 0x9e3779b97f4a7c15ULL + sample;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return (z >> 63) != 0 ? 1.0 : -1.0;
}

}  // namespace

class Partition::Impl {
 public:
  Impl(const Pattern& pattern, const std::vector<double>& values, std::vector<double> scale, int threads)
      : pattern_(pattern), scale_(std::move(scale)), threads_(threads), independent_(scale_.size(), 1) {
    if (pattern.rows == 0) return;
    looked_at_ = scaled(pattern_, values, scale_, threads_);
    for (const int row : find_pivots(pattern.columns, pattern.row_start, pattern.column, looked_at_).row)
      independent_[row] = 0;
    make_dependent_block();
    first_growth_ = std::max(growth(PivotOrder::chosen), 1.0);
  }

  const std::vector<char>& independent() const { return independent_; }
  bool degraded(const std::vector<double>& values) {
    if (pattern_.rows == 0) return false;
    std::vector<double> entries = scaled(pattern_, values, scale_, threads_);
    const auto unchanged = [](double a, double b) { return std::abs(a - b) <= kUnchanged; };
    if (std::equal(entries.begin(), entries.end(), looked_at_.begin(), unchanged)) return false;
    looked_at_ = std::move(entries);
    const double most = kDegraded * first_growth_;
    // Pivots that were chosen for other values are at hand sooner, and may show more growth than there is.
    return growth(PivotOrder::kept) > most && growth(PivotOrder::chosen) > most;
  }

 private:
  // Phi_d^T in compressed columns is Phi_d by rows.
  void make_dependent_block() {
    std::vector<int> number(independent_.size(), -1);
    int count = 0;
    for (std::size_t i = 0; i < independent_.size(); ++i)
      if (independent_[i] == 0) number[i] = count++;
    std::vector<int> starts{0}, index;
    for (int row = 0; row < pattern_.rows; ++row) {
      for (int k = pattern_.row_start[row]; k < pattern_.row_start[row + 1]; ++k)
        if (number[pattern_.column[k]] >= 0) {
          index.push_back(number[pattern_.column[k]]);
          entry_.push_back(k);
        }
      starts.push_back(static_cast<int>(index.size()));
    }
    dependent_ = std::make_unique<BlockLu>(std::move(starts), std::move(index));
  }

  /// Of the entries that are looked at.
  double growth(PivotOrder order) {
    std::vector<double> block(entry_.size());
    for (std::size_t k = 0; k < block.size(); ++k) block[k] = looked_at_[entry_[k]];
    if (!dependent_->factor(std::move(block), order)) return std::numeric_limits<double>::infinity();
    double most = 0.0;
    for (std::uint64_t sample = 0; sample < 2; ++sample) {
      std::vector<double> moved(static_cast<std::size_t>(pattern_.rows), 0.0);
      const auto move_by_signs = [&](std::size_t row) {
        for (int k = pattern_.row_start[row]; k < pattern_.row_start[row + 1]; ++k) {
          const int i = pattern_.column[k];
          if (independent_[i] != 0)
            moved[row] += looked_at_[k] * random_sign(sample, static_cast<std::uint64_t>(i));
        }
      };
      parallel_for(moved.size(), threads_, move_by_signs, looked_at_.size());
      for (const double x : dependent_->solve_transpose(std::move(moved))) most = std::max(most, std::abs(x));
    }
    return most;
  }

  const Pattern& pattern_;
  std::vector<double> scale_;
  int threads_;
  std::vector<char> independent_;
  std::vector<int> entry_;  ///< of Phi_q, for each entry of the dependent block
  std::unique_ptr<BlockLu> dependent_;
  double first_growth_ = 1.0;
  std::vector<double> looked_at_;  ///< scaled
};

Partition::Partition(const Pattern& position_q, const std::vector<double>& values, std::vector<double> scale,
                     int threads)
    : impl_(std::make_unique<Impl>(position_q, values, std::move(scale), threads)) {}
Partition::~Partition() = default;
Partition::Partition(Partition&&) noexcept = default;
Partition& Partition::operator=(Partition&&) noexcept = default;

const std::vector<char>& Partition::independent() const {
  return impl_->independent();
}
bool Partition::degraded(const std::vector<double>& values) {
  return impl_->degraded(values);
}

}  // namespace mfs::dae
