#include "dae/mechanics/force_blocks.hpp"

#include <algorithm>

namespace mfs::dae {

using Kind = LocalStructure::Kind;

Kind kind_of(const LocalStructure& structure, Block block) {
  return block == Block::force_q   ? structure.force_q
         : block == Block::force_v ? structure.force_v
                                   : structure.force_a;
}

namespace {

bool constant(const LocalStructure& structure, Block block) {
  return kind_of(structure, block) == Kind::zero || (block == Block::force_a && structure.constant_force_a) ||
         (block == Block::force_v && structure.constant_force_v);
}

}  // namespace

std::array<ForceBlock, 3> find_force_blocks(const Groups& groups,
                                            const std::vector<LocalStructure>& structures, int coordinates,
                                            int threads, TangentPattern& pattern) {
  std::array<ForceBlock, 3> blocks;
  std::array<std::vector<int>, 3> coupled_from;
  std::array<Pattern, 3> coupled;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = kForceBlocks[i];
    const auto b = static_cast<std::size_t>(block);
    pattern.constant[b] = true;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const LocalStructure& structure = structures[g];
      blocks[i].kinds_.push_back(kind_of(structure, block));
      coupled_from[i].push_back(blocks[i].kinds_.back() == Kind::dense ? structure.coupled_from
                                                                       : groups[g]->local_coordinates());
      pattern.constant[b] = pattern.constant[b] && constant(structure, block);
    }
    const auto same = static_cast<std::size_t>(
        std::find(coupled_from.begin(), coupled_from.begin() + i, coupled_from[i]) - coupled_from.begin());
    blocks[i].coupling_ =
        same < i ? blocks[same].coupling_
                 : std::make_shared<Coupling>(groups, coupled_from[i], coordinates, threads, coupled[i]);
    blocks[i].find_diagonal(groups, coupled[same], pattern.block[b]);
  }
  return blocks;
}

/// Makes `pattern` of that of the dense groups and the diagonal entries of the others where they are not in
/// it.
void ForceBlock::find_diagonal(const Groups& groups, const Pattern& coupled, Pattern& pattern) {
  pattern = coupled;
  if (std::find(kinds_.begin(), kinds_.end(), Kind::diagonal) == kinds_.end()) return;
  const int n = coupled.rows;
  diagonal_.assign(static_cast<std::size_t>(n), -1);
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (kinds_[g] == Kind::diagonal)
      for (int e = 0; e < groups[g]->size(); ++e)
        for (int k = 0; k < groups[g]->local_coordinates(); ++k) diagonal_[groups[g]->coordinates(e)[k]] = 0;

  pattern.column.clear();
  for (int i = 0; i < n; ++i) {
    const auto first = coupled.column.begin() + coupled.row_start[i];
    const auto last = coupled.column.begin() + coupled.row_start[i + 1];
    pattern.row_start[i] = static_cast<int>(pattern.column.size());
    pattern.column.insert(pattern.column.end(), first, last);
    if (diagonal_[i] < 0) continue;
    if (first == last) pattern.column.push_back(i);  // a row with columns has its diagonal entry
    diagonal_[i] = pattern.row_start[i] + static_cast<int>(std::lower_bound(first, last, i) - first);
  }
  pattern.row_start[n] = static_cast<int>(pattern.column.size());
}

void ForceBlock::add(int g, int e, const ElementGroup& group, const double* local, const Pattern& pattern,
                     std::vector<double>& values, Runs& runs) const {
  if (kinds_[g] == Kind::dense) coupling_->add(g, e, group, local, pattern, values, runs);
  if (kinds_[g] == Kind::diagonal) {
    const int nq = group.local_coordinates();
    const int* coordinates = group.coordinates(e);
    for (int k = 0; k < nq; ++k) values[diagonal_[coordinates[k]]] += local[k * (nq + 1)];
  }
}

}  // namespace mfs::dae
