#include "plan/assembly_lists.hpp"

#include <algorithm>

namespace mfs {

namespace {

constexpr int kFrontsAtOnce = 64;  // of a thread

}  // namespace

void AssemblyLists::add_depth(const std::vector<Vertex>& large, DepthLaunches& depth) {
  depth.assemble.begin = parts_;
  for (const Vertex f : large) {
    add_block(f, {0, plan_.rows(f)}, {0, plan_.pivots(f)}, true, plan_.lower_begin[f]);
    add_border_columns(f, true);
  }
  depth.assemble.end = parts_;
  Vertex last = 0;
  for (const Vertex f : large) last = std::max(last, plan_.assembly_turn[f]);
  for (Vertex turn = 0; turn <= last; ++turn) {
    const Offset begin = parts_;
    for (const Vertex f : large) {
      if (plan_.assembly_turn[f] == turn) add_border_columns(f, false);
    }
    depth.assemble_contribution.push_back({begin, parts_});
  }
}

void AssemblyLists::finish() {
  list_parts();
  list_child_rows();
  place_entries();
}

// U, or C; those of a divided front by its groups of columns.
void AssemblyLists::add_border_columns(Vertex f, bool of_pivots) {
  const Vertex p = plan_.pivots(f), rows = plan_.rows(f);
  const auto add = [&](Span right, Offset upper, Offset contribution) {
    if (of_pivots) {
      add_block(f, {0, p}, right, true, upper - static_cast<Offset>(p) * p);
    } else {
      const Offset before = p + static_cast<Offset>(p) * plan_.contribution_ld(f);
      add_block(f, {p, rows}, right, false, contribution - before);
    }
  };
  const auto [columns, end] = made_.segments.columns_of(f);
  if (columns == end) add({p, rows}, plan_.upper_begin[f], plan_.contribution_begin[f]);
  for (auto own = columns; own != end; ++own) add({own->begin, own->end}, own->upper, own->contribution);
}

void AssemblyLists::add_block(Vertex f, Span down, Span right, bool has_entries, Offset place) {
  if (down.length() == 0) return;
  const Vertex columns = std::max(kAssembleColumns, kAssembleEntries / down.length());
  blocks_.push_back({f, down, right, columns, has_entries, place, parts_});
  parts_ += tiles_of(right.length(), columns);
}

void AssemblyLists::list_parts() {
  made_.assemble.resize(static_cast<std::size_t>(parts_));
  const auto blocks = static_cast<Offset>(blocks_.size());
#pragma omp parallel for schedule(dynamic)
  for (Offset i = 0; i < blocks; ++i) {
    const AssemblyBlock& block = blocks_[i];
    const Vertex f = block.front;
    Offset part = block.first_part;
    Offset entry = block.has_entries ? first_entry_from(f, plan_.entry_begin[f], block.right.begin)
                                     : plan_.entry_begin[f + 1];
    for (Vertex begin = block.right.begin; begin < block.right.end; begin += block.columns) {
      const Vertex end = std::min(begin + block.columns, block.right.end);
      const Offset first = entry;
      entry = first_entry_from(f, entry, end);
      made_.assemble[part++] = {f, begin, end, block.down.begin, block.down.end, first, entry, block.place};
    }
  }
}

// The first entry of f from `entry` on in column `end` or right of it.
Offset AssemblyLists::first_entry_from(Vertex f, Offset entry, Vertex end) const {
  Offset past = plan_.entry_begin[f + 1];
  while (entry < past) {
    const Offset middle = entry + (past - entry) / 2;
    if (column_of_entry(f, middle) < end) {
      entry = middle + 1;
    } else {
      past = middle;
    }
  }
  return entry;
}

// Of the front; the entries of a front ascend by it.
Vertex AssemblyLists::column_of_entry(Vertex f, Offset entry) const {
  const Offset p = plan_.pivots(f), lower = plan_.entry_target[entry] - plan_.lower_begin[f];
  if (lower < p * plan_.lower_ld(f)) return static_cast<Vertex>(lower / plan_.lower_ld(f));
  return static_cast<Vertex>(p + (plan_.entry_target[entry] - plan_.upper_begin[f]) / p);
}

// Only of larger fronts: small ones add their children up in shared memory.
void AssemblyLists::list_child_rows() {
  made_.child_row_begin.assign(plan_.children.size() + 1, 0);
  for (Vertex f = 0; f < plan_.num_fronts; ++f) {
    for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c)
      made_.child_row_begin[c + 1] =
          made_.child_row_begin[c] + (plan_.rows(f) > made_.small_rows ? plan_.rows(f) : 0);
  }
  made_.child_row.resize(static_cast<std::size_t>(made_.child_row_begin.back()));
#pragma omp parallel for schedule(dynamic, kFrontsAtOnce)
  for (Vertex f = 0; f < plan_.num_fronts; ++f) {
    if (plan_.rows(f) <= made_.small_rows) continue;
    for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
      const Vertex child = plan_.children[c];
      const Vertex* map = plan_.border_in_parent.data() + plan_.border_begin[child];
      Vertex* const child_row = made_.child_row.data() + made_.child_row_begin[c];
      std::fill_n(child_row, plan_.rows(f), -1);
      for (Vertex i = 0; i < plan_.border_rows(child); ++i) child_row[map[i]] = i;
    }
  }
}

void AssemblyLists::place_entries() {
  made_.entry_place.resize(static_cast<std::size_t>(plan_.nnz));
  const auto place_from = [&](Offset begin, Offset first, Offset last) {
    for (Offset e = first; e < last; ++e)
      made_.entry_place[e] = static_cast<Vertex>(plan_.entry_target[e] - begin);
  };
  const auto parts = static_cast<Offset>(made_.assemble.size());
#pragma omp parallel for schedule(static)
  for (Offset i = 0; i < parts; ++i) {
    const AssemblyPart& part = made_.assemble[i];
    place_from(column_begin(part.front, part.begin), part.first_entry, part.last_entry);
  }
  const auto small = static_cast<Offset>(made_.small_fronts.size());
#pragma omp parallel for schedule(static)
  for (Offset i = 0; i < small; ++i) {
    const Vertex f = made_.small_fronts[i];
    const Offset lower = static_cast<Offset>(plan_.pivots(f)) * plan_.lower_ld(f);
    const Offset *const targets = plan_.entry_target.data(), *const end = targets + plan_.entry_begin[f + 1];
    const Offset beyond =
        std::lower_bound(targets + plan_.entry_begin[f], end, plan_.upper_begin[f]) - targets;
    place_from(plan_.lower_begin[f], plan_.entry_begin[f], beyond);
    place_from(plan_.upper_begin[f] - lower, beyond, plan_.entry_begin[f + 1]);
  }
}

// Of [P; L] or U.
Offset AssemblyLists::column_begin(Vertex f, Vertex column) const {
  const Offset p = plan_.pivots(f);
  return column < p ? plan_.lower_begin[f] + column * static_cast<Offset>(plan_.lower_ld(f))
                    : plan_.upper_begin[f] + (column - p) * p;
}

}  // namespace mfs
