#include "plan/scalar_program.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

#include "ordering/transpose.hpp"

namespace mfs {

namespace {

/// Makes one column after another.
class Elimination {
 public:
  Elimination(const Pattern& pattern, ScalarProgram& program)
      : columns_(transpose(pattern, 1)),
        program_(program),
        position_(static_cast<std::size_t>(pattern.n)),
        last_column_(position_.size(), -1),
        local_(position_.size()) {
    for (Vertex k = 0; k < program.n; ++k) position_[program.row_of[k]] = k;
    program.column_begin.push_back(0);
    program.place.resize(static_cast<std::size_t>(pattern.nnz()));
  }

  /// False where the pivot is no entry of the factors, or where there are more entries than that, or more
  /// products than so many entries may have.
  bool add_column(Vertex k, const ScalarProgramLimits& limits) {
    ScalarProgram& to = program_;
    find_rows(k);
    std::sort(rows_.begin(), rows_.end());
    const auto pivot = std::lower_bound(rows_.begin(), rows_.end(), k);
    if (pivot == rows_.end() || *pivot != k) return false;
    const Vertex begin = to.column_begin.back();
    to.pivot.push_back(begin + static_cast<Vertex>(pivot - rows_.begin()));
    to.row.insert(to.row.end(), rows_.begin(), rows_.end());
    to.column_begin.push_back(static_cast<Vertex>(to.row.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i) local_[rows_[i]] = static_cast<Vertex>(i);
    to.width.resize(to.row.size(), 0);
    for (auto u = rows_.begin(); u != pivot;) {
      const Vertex width = widest(*u, static_cast<Vertex>(pivot - u)), last = *u + width - 1;
      to.width[static_cast<std::size_t>(begin + (u - rows_.begin()))] = static_cast<std::uint8_t>(width);
      for (Vertex e = to.pivot[last] + 1; e < to.column_begin[last + 1]; ++e)
        to.target.push_back(local_[to.row[e]]);
      for (Vertex j = *u; j <= last; ++j) to.products += to.column_begin[j + 1] - to.pivot[j] - 1;
      u += width;
    }
    if (to.entries() > limits.entries || to.products > limits.entries * limits.products_of_entry)
      return false;
    same_below_.push_back(k > 0 && same_below(k - 1));
    place_slots(k, begin);
    return true;
  }

 private:
  void add_row(Vertex row, Vertex k) {
    if (last_column_[row] == k) return;
    last_column_[row] = k;
    rows_.push_back(row);
    if (row < k) waiting_.push(row);
  }
  // The entries of A, and what products with earlier columns leave, each of which may ask for a later one.
  void find_rows(Vertex k) {
    rows_.clear();
    const Vertex column = program_.column_of[k];
    for (Offset e = columns_.offsets[column]; e < columns_.offsets[column + 1]; ++e)
      add_row(position_[columns_.columns[e]], k);
    while (!waiting_.empty()) {
      const Vertex j = waiting_.top();
      waiting_.pop();
      for (Vertex e = program_.pivot[j] + 1; e < program_.column_begin[j + 1]; ++e)
        add_row(program_.row[e], k);
    }
  }
  // How many columns from j on are taken together, at most `most`.
  Vertex widest(Vertex j, Vertex most) const {
    Vertex width = 1;
    while (width < std::min<Vertex>(most, kMostWidth) && same_below_[j + width]) ++width;
    return width;
  }
  // Whether column j has the l of the next one and that of its pivot's row.
  bool same_below(Vertex j) const {
    const auto &row = program_.row, &begin = program_.column_begin, &pivot = program_.pivot;
    const auto l = row.begin() + pivot[j] + 1, end = row.begin() + begin[j + 1];
    return l != end && std::equal(l, end, row.begin() + pivot[j + 1], row.begin() + begin[j + 2]);
  }
  void place_slots(Vertex k, Vertex begin) {
    const Vertex column = program_.column_of[k];
    taken_.assign(rows_.size(), 0);
    for (Offset e = columns_.offsets[column]; e < columns_.offsets[column + 1]; ++e) {
      const Vertex local = local_[position_[columns_.columns[e]]];
      program_.place[columns_.slots[e]] = begin + local;
      taken_[local] = 1;
    }
    for (std::size_t i = 0; i < taken_.size(); ++i) {
      if (!taken_[i]) program_.fill.push_back(begin + static_cast<Vertex>(i));
    }
  }

  const TransposedPattern columns_;
  ScalarProgram& program_;
  std::vector<Vertex> position_;             // of a row of A
  std::vector<Vertex> last_column_, local_;  // by position: the last column with it, its place there
  std::vector<Vertex> rows_;
  std::vector<char> taken_;
  std::vector<char> same_below_;  // by position: what same_below says of the one before
  std::priority_queue<Vertex, std::vector<Vertex>, std::greater<Vertex>> waiting_;
};

}  // namespace

std::optional<ScalarProgram> make_scalar_program(const Pattern& pattern, std::vector<Vertex> row_of,
                                                 std::vector<Vertex> column_of,
                                                 const ScalarProgramLimits& limits) {
  ScalarProgram program;
  program.n = pattern.n;
  program.row_of = std::move(row_of);
  program.column_of = std::move(column_of);
  Elimination elimination(pattern, program);
  for (Vertex k = 0; k < program.n; ++k) {
    if (!elimination.add_column(k, limits)) return std::nullopt;
  }
  if (program.products > program.entries() * limits.products_of_entry) return std::nullopt;
  return program;
}

}  // namespace mfs
