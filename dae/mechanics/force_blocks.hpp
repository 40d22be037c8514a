// The three blocks of F's derivatives, n x n: what each group adds to them, their patterns, and the places.
// Blocks to which the same groups add dense matrices, as the mass and the stiffness of finite elements, share
// the places.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "dae/mechanics/coupling.hpp"

namespace mfs::dae {

constexpr std::array<Block, 3> kForceBlocks{Block::force_q, Block::force_v, Block::force_a};

/// What an element adds to `block`, one of kForceBlocks.
LocalStructure::Kind kind_of(const LocalStructure& structure, Block block);

class ForceBlock {
 public:
  /// Adds the matrix `local` (nq x nq; null where the group adds nothing) of element e of group g to the
  /// values of the block, whose pattern is `pattern`.
  void add(int g, int e, const ElementGroup& group, const double* local, const Pattern& pattern,
           std::vector<double>& values, Runs& runs) const;

 private:
  friend std::array<ForceBlock, 3> find_force_blocks(const Groups&, const std::vector<LocalStructure>&, int,
                                                     int, TangentPattern&);
  void find_diagonal(const Groups& groups, const Pattern& coupled, Pattern& pattern);

  std::vector<LocalStructure::Kind> kinds_;  // of each group
  std::shared_ptr<const Coupling> coupling_;
  std::vector<int> diagonal_;  // entry of (i, i); empty where no group is diagonal
};

/// The blocks of `groups` with these `structures`, in the order of kForceBlocks; writes their patterns and
/// whether they are constant into `pattern`.
std::array<ForceBlock, 3> find_force_blocks(const Groups& groups,
                                            const std::vector<LocalStructure>& structures, int coordinates,
                                            int threads, TangentPattern& pattern);

}  // namespace mfs::dae
