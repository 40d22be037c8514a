#include "dae/integrator/composition.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include <mfs/error.hpp>

#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {

TransposedPattern::TransposedPattern(const Pattern& original) : source(original.entries()) {
  pattern.rows = original.columns;
  pattern.columns = original.rows;
  pattern.row_start.assign(static_cast<std::size_t>(original.columns) + 1, 0);
  pattern.column.resize(original.entries());
  for (const int column : original.column) ++pattern.row_start[column + 1];
  for (int row = 0; row < pattern.rows; ++row) pattern.row_start[row + 1] += pattern.row_start[row];
  std::vector<int> next(pattern.row_start.begin(), pattern.row_start.end() - 1);
  for (int row = 0; row < original.rows; ++row)
    for (int k = original.row_start[row]; k < original.row_start[row + 1]; ++k) {
      const int place = next[original.column[k]]++;
      pattern.column[place] = row;
      source[place] = k;
    }
}

std::pair<Pattern, std::vector<int>> take_rows(const Pattern& pattern, const std::vector<int>& rows) {
  Pattern taken{static_cast<int>(rows.size()), pattern.columns, {0}, {}};
  std::vector<int> place;
  for (const int row : rows) {
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k) {
      taken.column.push_back(pattern.column[k]);
      place.push_back(k);
    }
    taken.row_start.push_back(static_cast<int>(place.size()));
  }
  return {std::move(taken), std::move(place)};
}

std::vector<int> find_diagonal(const Pattern& pattern) {
  std::vector<int> places;
  for (int row = 0; row < pattern.rows; ++row) {
    const auto begin = pattern.column.begin() + pattern.row_start[row];
    const auto end = pattern.column.begin() + pattern.row_start[row + 1];
    const auto place = std::lower_bound(begin, end, row);
    places.push_back(place != end && *place == row ? static_cast<int>(place - pattern.column.begin()) : -1);
  }
  return places;
}

std::vector<int> consecutive(int first, int count) {
  std::vector<int> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

Composition::Composition(int size, std::vector<Term> terms, int threads)
    : threads_(team_size(threads)), terms_(std::move(terms)) {
  pattern_.rows = pattern_.columns = size;
  make_groups();
  make_pattern();
  make_targets();
  find_own();
  list_rows();
}

void Composition::make_groups() {
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const auto same = std::find_if(groups_.begin(), groups_.end(),
                                   [&](const Group& g) { return g.first_row == terms_[t].first_row; });
    if (same != groups_.end())
      same->terms.push_back(t);
    else
      groups_.push_back({terms_[t].first_row, terms_[t].block->rows, {t}});
  }
}

/// Those of the matrix that a row of the term's block reaches, ascending.
void Composition::list_columns(const Term& term, int row, std::vector<int>& columns) {
  const Pattern& block = *term.block;
  const int begin = block.row_start[row], end = block.row_start[row + 1];
  columns.resize(static_cast<std::size_t>(end - begin));
  bool ascending = true;
  int last = -1;
  for (int k = begin; k < end; ++k) {
    const int column = columns[k - begin] = term.column[block.column[k]];
    ascending &= column > last;
    last = column;
  }
  if (ascending) return;
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
}

/// Rows are merged twice, to be counted and to be written: that takes less time than memory for all of them.
void Composition::make_pattern() {
  std::vector<std::int64_t> start(static_cast<std::size_t>(pattern_.rows) + 1, 0);
  for_merged_rows([&](int row, const std::vector<int>& columns) {
    start[row + 1] = static_cast<std::int64_t>(columns.size());
  });
  std::partial_sum(start.begin(), start.end(), start.begin());
  if (start.back() > std::numeric_limits<int>::max())
    throw InvalidInput("system", "the matrix of Newton's method has 2^31 entries or more");
  pattern_.row_start.assign(start.begin(), start.end());
  pattern_.column.resize(static_cast<std::size_t>(start.back()));
  for_merged_rows([&](int row, const std::vector<int>& columns) {
    std::copy(columns.begin(), columns.end(), pattern_.column.begin() + pattern_.row_start[row]);
  });
}

/// visit(row, columns) for each row of the matrix, by all threads.
template <class Visit>
void Composition::for_merged_rows(const Visit& visit) const {
  for (const Group& group : groups_) {
#pragma omp parallel num_threads(threads_)
    {
      std::vector<int> columns, of_term, both;  // of one row
#pragma omp for schedule(static)
      for (int row = 0; row < group.rows; ++row) {
        columns.clear();
        for (const std::size_t t : group.terms) {
          list_columns(terms_[t], row, of_term);
          if (of_term == columns) continue;
          if (columns.empty()) {
            columns.swap(of_term);
            continue;
          }
          both.clear();
          std::set_union(columns.begin(), columns.end(), of_term.begin(), of_term.end(),
                         std::back_inserter(both));
          columns.swap(both);
        }
        visit(group.first_row + row, columns);
      }
    }
  }
}

void Composition::make_targets() {
  target_.resize(terms_.size());
  for (const Group& group : groups_)
    for (const std::size_t t : group.terms) {
      const Pattern& block = *terms_[t].block;
      target_[t].resize(block.entries());
#pragma omp parallel for num_threads(threads_) schedule(static)
      for (int row = 0; row < group.rows; ++row) {
        const auto begin = pattern_.column.begin() + pattern_.row_start[group.first_row + row];
        const auto end = pattern_.column.begin() + pattern_.row_start[group.first_row + row + 1];
        auto place = begin;
        for (int k = block.row_start[row]; k < block.row_start[row + 1]; ++k, ++place) {
          const int column = terms_[t].column[block.column[k]];
          // Mostly it is the next one.
          if (place == end || *place != column) place = std::lower_bound(begin, end, column);
          target_[t][k] = static_cast<int>(place - pattern_.column.begin());
        }
      }
    }
}

/// Numbers the entries that are composed here, and lets the targets of the terms name those numbers.
void Composition::find_own() {
  if (std::none_of(terms_.begin(), terms_.end(), [](const Term& term) { return term.elsewhere; })) {
    own_start_ = pattern_.row_start;
    return;
  }
  RawVector<int> number(pattern_.entries());
  parallel_for(number.size(), threads_, [&](std::size_t entry) { number[entry] = -1; });
  for (std::size_t t = 0; t < terms_.size(); ++t)
    if (!terms_[t].elsewhere)
      for (const int entry : target_[t]) number[entry] = 0;
  const auto rows = static_cast<std::size_t>(pattern_.rows);
  own_start_.assign(rows + 1, 0);
  const auto first = [&](std::size_t row) { return number.begin() + pattern_.row_start[row]; };
  parallel_for(
      rows, threads_,
      [&](std::size_t row) {
        own_start_[row + 1] = static_cast<int>(std::count(first(row), first(row + 1), 0));
      },
      number.size());
  std::partial_sum(own_start_.begin(), own_start_.end(), own_start_.begin());
  own_.resize(static_cast<std::size_t>(own_start_.back()));
  const auto number_row = [&](std::size_t row) {
    int next = own_start_[row];
    for (int entry = pattern_.row_start[row]; entry < pattern_.row_start[row + 1]; ++entry)
      if (number[entry] == 0) {
        own_[next] = entry;
        number[entry] = next++;
      }
  };
  parallel_for(rows, threads_, number_row, number.size());
  for (std::size_t t = 0; t < terms_.size(); ++t)
    if (!terms_[t].elsewhere)
      parallel_for(target_[t].size(), threads_,
                   [&](std::size_t k) { target_[t][k] = number[target_[t][k]]; });
}

/// Rows with entries that are composed here, and how many terms these have.
void Composition::list_rows() {
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (int row = 0; row < groups_[g].rows; ++row) {
      std::size_t work = 0;
      for (const std::size_t t : groups_[g].terms)
        if (!terms_[t].elsewhere)
          work +=
              static_cast<std::size_t>(terms_[t].block->row_start[row + 1] - terms_[t].block->row_start[row]);
      if (work == 0) continue;
      rows_.push_back({static_cast<int>(g), row});
      work_start_.push_back(work_start_.back() + work);
    }
}

void Composition::compose(const std::vector<Values>& values, double* own) const {
  parallel_for_shares(work_start_, threads_, [&](std::size_t i) {
    const Group& group = groups_[rows_[i].group];
    const int row = rows_[i].row;
    std::fill(own + own_start_[group.first_row + row], own + own_start_[group.first_row + row + 1], 0.0);
    for (const std::size_t t : group.terms) {
      if (terms_[t].elsewhere) continue;
      const Pattern& block = *terms_[t].block;
      const int* const source = terms_[t].source;
      const int* const target = target_[t].data();
      const Values& from = values[t];
      for (int k = block.row_start[row]; k < block.row_start[row + 1]; ++k)
        own[target[k]] += from.factor * from.block[source != nullptr ? source[k] : k];
    }
  });
}

}  // namespace mfs::dae
