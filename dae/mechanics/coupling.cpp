#include "dae/mechanics/coupling.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <mfs/error.hpp>

namespace mfs::dae {

/// The dense elements of each coordinate, in compressed form.
struct Coupling::Incidence {
  struct Element {
    int group, element;
    bool operator==(const Element& other) const { return group == other.group && element == other.element; }
  };
  std::vector<std::size_t> start;
  std::vector<Element> element;

  Incidence(const Groups& groups, const std::vector<int>& coupled_from, int coordinates)
      : start(static_cast<std::size_t>(coordinates) + 2) {
    const auto for_each = [&](auto&& visit) {
      for (std::size_t g = 0; g < groups.size(); ++g)
        for (int e = 0; e < groups[g]->size(); ++e)
          for (int k = coupled_from[g]; k < groups[g]->local_coordinates(); ++k)
            visit(groups[g]->coordinates(e)[k], Element{static_cast<int>(g), e});
    };
    for_each([&](int i, Element) { ++start[i + 2]; });
    for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
    element.resize(start.back());
    for_each([&](int i, Element e) { element[start[i + 1]++] = e; });
    start.pop_back();
  }

  const Element* begin(int i) const { return element.data() + start[i]; }
  const Element* end(int i) const { return element.data() + start[i + 1]; }
  bool continues(int i) const {
    return i > 0 && begin(i) != end(i) && std::equal(begin(i), end(i), begin(i - 1), end(i - 1));
  }
};

Coupling::Coupling(const Groups& groups, std::vector<int> coupled_from, int coordinates, int threads,
                   Pattern& pattern)
    : coupled_from_(std::move(coupled_from)),
      continues_(static_cast<std::size_t>(coordinates)),
      begins_(groups.size()) {
  pattern.rows = pattern.columns = coordinates;
  const Incidence incidence(groups, coupled_from_, coordinates);
  for (int i = 0; i < coordinates; ++i) continues_[i] = incidence.continues(i);
  find_pattern(groups, incidence, threads, pattern);
  find_begins(groups, threads, pattern);
}

void Coupling::find_pattern(const Groups& groups, const Incidence& incidence, int threads,
                            Pattern& pattern) const {
  const int n = pattern.rows;
  std::vector<int> length(static_cast<std::size_t>(n));
  // Calls use(i, its columns) for the first row of each run; columns are in any order.
  const auto for_each_first_row = [&](auto&& use) {
#pragma omp parallel num_threads(threads)
    {
      std::vector<int> seen_by(static_cast<std::size_t>(n), -1), columns;
#pragma omp for schedule(dynamic, 256)
      for (int i = 0; i < n; ++i) {
        if (continues_[i]) continue;
        columns.clear();
        for (const auto* e = incidence.begin(i); e != incidence.end(i); ++e) {
          const ElementGroup& group = *groups[e->group];
          const int* coordinates = group.coordinates(e->element);
          for (int k = coupled_from_[e->group]; k < group.local_coordinates(); ++k)
            if (seen_by[coordinates[k]] != i) {
              seen_by[coordinates[k]] = i;
              columns.push_back(coordinates[k]);
            }
        }
        use(i, columns);
      }
    }
  };

  for_each_first_row(
      [&](int i, const std::vector<int>& columns) { length[i] = static_cast<int>(columns.size()); });
  pattern.row_start.resize(static_cast<std::size_t>(n) + 1);
  std::size_t entries = 0;
  for (int i = 0; i < n; ++i) {
    if (continues_[i]) length[i] = length[i - 1];
    entries += static_cast<std::size_t>(length[i]);
    if (entries > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw InvalidInput("groups", "the elements couple more pairs of coordinates than an int can count");
    pattern.row_start[i + 1] = static_cast<int>(entries);
  }

  pattern.column.resize(entries);
  for_each_first_row([&](int i, std::vector<int>& columns) {
    std::sort(columns.begin(), columns.end());
    do {
      std::copy(columns.begin(), columns.end(), pattern.column.begin() + pattern.row_start[i]);
    } while (++i < n && continues_[i]);
  });
}

void Coupling::find_begins(const Groups& groups, int threads, const Pattern& pattern) {
  Runs runs;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const ElementGroup& group = *groups[g];
    const int first_local = coupled_from_[g], nq = group.local_coordinates();
    if (first_local >= nq) continue;
    Begins& begins = begins_[g];
    begins.of_element.resize(static_cast<std::size_t>(group.size()) + 1);
    for (int e = 0; e < group.size(); ++e) {
      find_runs(group.coordinates(e), first_local, nq, runs);
      begins.of_element[e + 1] = begins.of_element[e] + (runs.size() - 1) * (runs.size() - 1);
    }
    begins.begin.resize(begins.of_element.back());
#pragma omp parallel for num_threads(threads) firstprivate(runs)
    for (int e = 0; e < group.size(); ++e) {
      const int* coordinates = group.coordinates(e);
      find_runs(coordinates, first_local, nq, runs);
      int* begin = begins.begin.data() + begins.of_element[e];
      for (std::size_t r = 0; r + 1 < runs.size(); ++r) {
        const int row = coordinates[runs[r]];
        const auto first = pattern.column.begin() + pattern.row_start[row];
        const auto last = pattern.column.begin() + pattern.row_start[row + 1];
        for (std::size_t c = 0; c + 1 < runs.size(); ++c)
          *begin++ = static_cast<int>(std::lower_bound(first, last, coordinates[runs[c]]) - first);
      }
    }
  }
}

void Coupling::find_runs(const int* coordinates, int first, int nq, Runs& runs) const {
  runs.clear();
  for (int k = first; k < nq; ++k)
    if (k == first || coordinates[k] != coordinates[k - 1] + 1 || !continues_[coordinates[k]])
      runs.push_back(k);
  runs.push_back(nq);
}

void Coupling::add(int g, int e, const ElementGroup& group, const double* local, const Pattern& pattern,
                   std::vector<double>& values, Runs& runs) const {
  const int nq = group.local_coordinates();
  if (coupled_from_[g] >= nq) return;
  const int* coordinates = group.coordinates(e);
  find_runs(coordinates, coupled_from_[g], nq, runs);
  const int* begins = begins_[g].begin.data() + begins_[g].of_element[e];
  const std::size_t count = runs.size() - 1;
  for (std::size_t r = 0; r < count; ++r, begins += count)
    for (int i = runs[r]; i < runs[r + 1]; ++i) {
      double* row = values.data() + pattern.row_start[coordinates[i]];
      const double* local_row = local + static_cast<std::ptrdiff_t>(i) * nq;
      for (std::size_t c = 0; c < count; ++c)
        for (int j = runs[c], entry = begins[c]; j < runs[c + 1]; ++j, ++entry) row[entry] += local_row[j];
    }
}

}  // namespace mfs::dae
