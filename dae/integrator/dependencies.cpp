#include "dae/integrator/dependencies.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <optional>

#include <mfs/error.hpp>

#include "dae/integrator/sparse_lu.hpp"

namespace mfs::dae {
namespace {

/// A pivot of at least this part of its row's largest entry shows that the row is independent.
constexpr double kLargePivot = 1e-3;
/// The least share in a combination, in parts of the largest, of the row that is called redundant.
constexpr double kShare = 1e-2;
/// Shares below this part of the largest are rounding.
constexpr double kNoShare = 1e-12;

double largest(const SparseRow& row) {
  double most = 0.0;
  for (const auto& entry : row) most = std::max(most, std::abs(entry.second));
  return most;
}

double at(const SparseRow& row, int index) {
  const auto found = std::lower_bound(row.begin(), row.end(), index,
                                      [](const auto& entry, int i) { return entry.first < i; });
  return found != row.end() && found->first == index ? found->second : 0.0;
}

void divide(SparseRow& row, double by) {
  for (auto& entry : row) entry.second /= by;
}

/// y + f x without the entry at `zero`, which it makes zero.
SparseRow added(const SparseRow& y, double f, const SparseRow& x, int zero) {
  SparseRow sum;
  sum.reserve(x.size() + y.size());
  auto i = y.begin();
  auto j = x.begin();
  while (i != y.end() || j != x.end()) {
    const bool of_y = j == x.end() || (i != y.end() && i->first <= j->first);
    const bool of_x = i == y.end() || (j != x.end() && j->first <= i->first);
    const int index = of_y ? i->first : j->first;
    double value = 0.0;
    if (of_y) value += (i++)->second;
    if (of_x) value += f * (j++)->second;
    if (index != zero) sum.emplace_back(index, value);
  }
  return sum;
}

void drop_rounding(SparseRow& row) {
  const double bound = kNoShare * largest(row);
  row.erase(std::remove_if(row.begin(), row.end(),
                           [bound](const auto& entry) { return std::abs(entry.second) <= bound; }),
            row.end());
}

/// A sum that touches few places of a long vector.
class Accumulator {
 public:
  explicit Accumulator(int length) : value_(static_cast<std::size_t>(length)), seen_(value_.size(), 0) {}

  void add(int i, double value) {
    if (seen_[i] == 0) touched_.push_back(i);
    seen_[i] = 1;
    value_[i] += value;
  }
  /// The sum; begins anew.
  SparseRow take() {
    std::sort(touched_.begin(), touched_.end());
    SparseRow row;
    for (const int i : touched_) {
      row.emplace_back(i, value_[i]);
      value_[i] = seen_[i] = 0;
    }
    touched_.clear();
    return row;
  }

 private:
  std::vector<double> value_;
  std::vector<char> seen_;
  std::vector<int> touched_;
};

/// Phi_q as step 1 and 2 see it.
struct ScaledRows {
  std::vector<SparseRow> row;    ///< empty: a normalization
  std::vector<SparseRow> along;  ///< of each row: its parts along normalizations, by their row
  std::vector<double> factor;    ///< of each row of Phi_q
};

ScaledRows scale_rows(const Pattern& pattern, const std::vector<double>& values,
                      const std::vector<double>& scale, const std::vector<char>& normalizes) {
  const auto m = static_cast<std::size_t>(pattern.rows);
  ScaledRows rows{std::vector<SparseRow>(m), std::vector<SparseRow>(m), std::vector<double>(m, 1.0)};
  std::vector<int> owner(static_cast<std::size_t>(pattern.columns), -1);  // the normalization of a coordinate
  std::vector<double> unit(owner.size());                                 // and its direction
  const auto for_entries = [&](int row, const auto& visit) {
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
      visit(pattern.column[k], values[k] * scale[pattern.column[k]]);
  };
  for (int r = 0; r < pattern.rows; ++r) {
    double most = 0.0, square = 0.0;
    for_entries(r, [&](int, double x) {
      most = std::max(most, std::abs(x));
      square += x * x;
    });
    if (!std::isfinite(square)) throw InvalidInput("constraints", "their derivatives are not finite", r);
    if (most == 0.0) continue;
    rows.factor[r] = 1.0 / (normalizes[r] != 0 ? std::sqrt(square) : most);
    if (normalizes[r] == 0) continue;
    for_entries(r, [&](int c, double x) {
      owner[c] = r;
      unit[c] = x * rows.factor[r];
    });
  }
  Accumulator sum(pattern.columns), part(pattern.rows);
  for (int r = 0; r < pattern.rows; ++r) {
    if (normalizes[r] != 0) continue;
    for_entries(r, [&](int c, double x) {
      sum.add(c, x * rows.factor[r]);
      if (owner[c] >= 0) part.add(owner[c], x * rows.factor[r] * unit[c]);
    });
    rows.along[r] = part.take();
    for (const auto& [normalization, share] : rows.along[r])
      for_entries(normalization, [&, share = share](int c, double) { sum.add(c, -share * unit[c]); });
    rows.row[r] = sum.take();
  }
  return rows;
}

/// Steps 1 to 3.
class Search {
 public:
  Search(const ScaledRows& rows, const std::vector<char>& normalizes, const std::vector<char>& nonholonomic,
         int columns, double nothing)
      : rows_(rows), nonholonomic_(nonholonomic), columns_(columns), nothing_(nothing), sum_(columns) {
    for (std::size_t r = 0; r < normalizes.size(); ++r)
      if (normalizes[r] == 0) kept_.push_back(static_cast<int>(r));
  }

  /// Combinations of scaled rows that are zero, and the row of each that is redundant.
  std::vector<std::pair<int, SparseRow>> run() {
    leave_out_small_pivots();
    if (left_out_.empty()) return {};
    express_left_out();
    eliminate_rests();
    return name_redundant();
  }

 private:
  /// A combination of rows and what it makes of coordinates.
  struct LeftOut {
    SparseRow combination, rest;
    double most_share = 0.0, most_rest = 0.0;  ///< largest of both
    void measure() {
      most_share = largest(combination);
      most_rest = largest(rest);
    }
    bool is_zero(double nothing) const { return most_rest <= nothing * most_share; }
  };
  /// A combination that is zero.
  struct Zero {
    SparseRow combination;
    double most = 0.0;  ///< largest share
    int last = -1;      ///< row with a share worth mentioning
  };
  void measure(Zero& zero) const {
    zero.most = largest(zero.combination);
    zero.last = -1;
    for (const auto& [r, share] : zero.combination)
      if (std::abs(share) > kShare * zero.most && (zero.last < 0 || comes_before(zero.last, r)))
        zero.last = r;
  }
  void add_zero(SparseRow combination) { measure(zero_.emplace_back(Zero{std::move(combination)})); }
  /// In the order in which constraints are read.
  bool comes_before(int a, int b) const {
    const auto late = [this](int r) { return !nonholonomic_.empty() && nonholonomic_[r] != 0; };
    return late(a) == late(b) ? a < b : late(b);
  }

  void leave_out_small_pivots() {
    while (!kept_.empty()) {
      std::vector<int> starts{0};
      RawVector<int> index;
      std::vector<double> values;
      for (const int row : kept_) {
        for (const auto& [c, x] : rows_.row[row]) {
          index.push_back(c);
          values.push_back(x);
        }
        starts.push_back(static_cast<int>(index.size()));
      }
      const Pivots pivots = find_pivots(columns_, starts, index, values);
      std::vector<char> good(kept_.size(), 0);  // more rows than columns: the rest has no pivot
      dependent_.assign(static_cast<std::size_t>(columns_), -1);
      int count = 0;
      for (std::size_t k = 0; k < pivots.value.size(); ++k) {
        good[pivots.column[k]] = std::abs(pivots.value[k]) >= std::max(kLargePivot, nothing_) ? 1 : 0;
        if (good[pivots.column[k]] != 0) dependent_[pivots.row[k]] = count++;
      }
      std::vector<int> left;
      for (std::size_t k = 0; k < kept_.size(); ++k) (good[k] != 0 ? left : left_out_).push_back(kept_[k]);
      if (left.size() == kept_.size()) break;
      kept_ = std::move(left);
    }
    std::sort(left_out_.begin(), left_out_.end());
  }

  /// Combinations in which the coordinates of pivots are zero, and what is left in the others.
  void express_left_out() {
    std::vector<int> starts{0}, index;
    std::vector<double> values;
    for (const int row : kept_) {
      for (const auto& [c, x] : rows_.row[row])
        if (dependent_[c] >= 0) {
          index.push_back(dependent_[c]);
          values.push_back(x);
        }
      starts.push_back(static_cast<int>(index.size()));
    }
    std::optional<BlockLu> lu;  // not of nothing
    if (!kept_.empty()) lu.emplace(std::move(starts), std::move(index));
    if (lu) lu->factor(std::move(values), PivotOrder::chosen);
    for (const int row : left_out_) {
      std::vector<double> right(kept_.size(), 0.0);
      for (const auto& [c, x] : rows_.row[row])
        if (dependent_[c] >= 0) right[dependent_[c]] = x;
      LeftOut& out = out_.emplace_back();
      out.combination.emplace_back(row, 1.0);
      if (lu) {
        const std::vector<double> shares = lu->solve(std::move(right));
        for (std::size_t k = 0; k < kept_.size(); ++k)
          if (shares[k] != 0.0) out.combination.emplace_back(kept_[k], -shares[k]);
      }
      std::sort(out.combination.begin(), out.combination.end());
      drop_rounding(out.combination);
      for (const auto& [r, share] : out.combination)
        for (const auto& [c, x] : rows_.row[r])
          if (dependent_[c] < 0) sum_.add(c, share * x);
      out.rest = sum_.take();
      out.measure();
    }
  }

  /// Takes rows with a rest back, the largest entry first, and leaves combinations without one.
  void eliminate_rests() {
    std::vector<LeftOut> uncertain;
    for (LeftOut& out : out_) {
      if (out.is_zero(nothing_))
        add_zero(std::move(out.combination));
      else
        uncertain.push_back(std::move(out));
    }
    while (!uncertain.empty()) {
      const auto by_rest = [](const LeftOut& a, const LeftOut& b) { return a.most_rest < b.most_rest; };
      const auto most = std::max_element(uncertain.begin(), uncertain.end(), by_rest);
      if (most->is_zero(nothing_)) break;
      const LeftOut pivot = std::move(*most);
      uncertain.erase(most);
      const auto entry = *std::max_element(
          pivot.rest.begin(), pivot.rest.end(),
          [](const auto& a, const auto& b) { return std::abs(a.second) < std::abs(b.second); });
      for (LeftOut& out : uncertain) {
        const double factor = -at(out.rest, entry.first) / entry.second;
        if (factor == 0.0) continue;
        out.rest = added(out.rest, factor, pivot.rest, entry.first);
        out.combination = added(out.combination, factor, pivot.combination, -1);
        out.measure();
      }
    }
    for (LeftOut& out : uncertain) add_zero(std::move(out.combination));
  }

  /// Gauss and Jordan, from the last row to the first.
  std::vector<std::pair<int, SparseRow>> name_redundant() {
    std::vector<std::pair<int, SparseRow>> named;
    while (!zero_.empty()) {
      const int redundant =
          std::max_element(zero_.begin(), zero_.end(), [this](const Zero& a, const Zero& b) {
            return comes_before(a.last, b.last);
          })->last;
      const auto share_of = [&](const Zero& zero) {
        return std::abs(at(zero.combination, redundant)) / zero.most;
      };
      const auto pivot = std::max_element(zero_.begin(), zero_.end(), [&](const Zero& a, const Zero& b) {
        return share_of(a) < share_of(b);
      });
      SparseRow row = std::move(pivot->combination);
      zero_.erase(pivot);
      divide(row, at(row, redundant));
      const auto eliminate = [&](SparseRow& other) {
        const double share = at(other, redundant);
        if (share == 0.0) return false;
        other = added(other, -share, row, redundant);
        drop_rounding(other);
        return true;
      };
      for (Zero& other : zero_)
        if (eliminate(other.combination)) measure(other);
      for (auto& other : named) eliminate(other.second);
      named.emplace_back(redundant, std::move(row));
    }
    return named;
  }

  const ScaledRows& rows_;
  const std::vector<char>& nonholonomic_;
  const int columns_;
  const double nothing_;
  Accumulator sum_;
  std::vector<int> kept_, left_out_;
  std::vector<int> dependent_;  ///< of each coordinate: its number among the kept rows' pivots, or -1
  std::vector<LeftOut> out_;
  std::vector<Zero> zero_;
};

}  // namespace

Dependencies::Dependencies(const Pattern& position_q, const std::vector<double>& values,
                           const std::vector<double>& scale, const std::vector<char>& normalizes,
                           const std::vector<char>& nonholonomic, double nothing) {
  if (position_q.rows == 0) return;
  const ScaledRows rows = scale_rows(position_q, values, scale, normalizes);
  auto found = Search(rows, normalizes, nonholonomic, position_q.columns, nothing).run();
  std::sort(found.begin(), found.end());
  Accumulator sum(position_q.rows);
  for (const auto& [redundant, combination] : found) {
    for (const auto& [r, share] : combination) {
      const double factor = rows.factor[r] / rows.factor[redundant];
      sum.add(r, factor * share);
      for (const auto& [normalization, part] : rows.along[r])
        sum.add(normalization, -share * part * rows.factor[normalization] / rows.factor[redundant]);
    }
    redundant_.push_back(redundant);
    combination_.push_back(sum.take());
  }
}

void Dependencies::make_basic(std::vector<double>& lambda) const {
  for (std::size_t k = 0; k < redundant_.size(); ++k) {
    const double own = lambda[redundant_[k]];
    for (const auto& [row, share] : combination_[k]) lambda[row] -= own * share;
    lambda[redundant_[k]] = 0.0;
  }
}

// lambda less its projection to the span of the combinations N: N^T (N N^T)^-1 N lambda, all in these units.
void Dependencies::make_least(std::vector<double>& lambda, const std::vector<double>& units) const {
  if (redundant_.empty()) return;
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const auto d = static_cast<Eigen::Index>(redundant_.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index k = 0; k < d; ++k)
    for (const auto& [row, share] : combination_[static_cast<std::size_t>(k)])
      if (units[row] != 0.0) entries.emplace_back(static_cast<int>(k), row, units[row] * share);
  Matrix n(d, static_cast<Eigen::Index>(lambda.size()));
  n.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> squares(n * n.transpose());
  const auto rows = static_cast<Eigen::Index>(lambda.size());
  const Eigen::VectorXd in_units = Eigen::Map<const Eigen::VectorXd>(lambda.data(), rows)
                                       .cwiseProduct(Eigen::Map<const Eigen::VectorXd>(units.data(), rows));
  const Eigen::VectorXd part = squares.solve(n * in_units);
  for (Eigen::Index k = 0; k < d; ++k)
    for (const auto& [row, share] : combination_[static_cast<std::size_t>(k)]) lambda[row] -= part[k] * share;
}

}  // namespace mfs::dae
