// Where the small dense matrices of elements go in a sparse block. Two coordinates are coupled when an
// element couples both; the pattern is found once, and with it, for each element, the place of its matrix,
// kept small: consecutive coordinates that have the same elements, as the three of a mesh's node, form a run.
// Rows of one run have the same columns, and the columns of a run are consecutive entries of a row, so that
// one number per pair of runs says where that piece of the matrix begins in its rows:
//
//   coordinates of an element   3 4 5 | 12 13 14 | 30        3 runs, 9 numbers instead of 49
//   row 4 of the pattern        0 1 2 3 4 5 9 10 11 12 13 14 30
//                                     ^0,0           ^0,1  ^0,2     begins: 3, 9, 12
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

using Groups = std::vector<std::shared_ptr<const ElementGroup>>;

/// The first local coordinates of an element's runs and, at the end, the number nq of all.
using Runs = std::vector<int>;

class Coupling {
 public:
  /// `coupled_from` says of each group from which of the local coordinates on its elements couple them, nq or
  /// more: none; there are `coordinates` in all. Writes `pattern`. Throws InvalidInput when there are more
  /// entries than an int can count.
  Coupling(const Groups& groups, std::vector<int> coupled_from, int coordinates, int threads,
           Pattern& pattern);

  /// Adds the nq x nq matrix `local` of element e of group g, row by row, to the values of `pattern`: that of
  /// the constructor, or one with more entries in rows that have none there. `runs` is a work array.
  void add(int g, int e, const ElementGroup& group, const double* local, const Pattern& pattern,
           std::vector<double>& values, Runs& runs) const;

 private:
  struct Incidence;
  struct Begins {
    std::vector<std::size_t> of_element;  // elements + 1
    std::vector<int> begin;               // runs x runs of each
  };

  void find_pattern(const Groups& groups, const Incidence& incidence, int threads, Pattern& pattern) const;
  void find_begins(const Groups& groups, int threads, const Pattern& pattern);
  void find_runs(const int* coordinates, int first, int nq, Runs& runs) const;

  std::vector<int> coupled_from_;  // of each group
  std::vector<char>
      continues_;  // coordinate i is coupled to the same coordinates as i - 1, by the same elements
  std::vector<Begins> begins_;  // of each group; empty where it is not dense
};

}  // namespace mfs::dae
