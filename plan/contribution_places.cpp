#include "plan/contribution_places.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

namespace mfs {

namespace {

constexpr Vertex kNever = std::numeric_limits<Vertex>::max();

struct Gap {
  Offset begin, end;
  Offset entries() const { return end - begin; }
};

// Places the blocks of one plan and is thrown away. Blocks are packed from the last step back, so that it is
// known what one must keep clear of, the largest first. That leaves gaps which another order would not leave,
// so some are tried in which sizes count for up to half as much again, and the smallest region is taken.
class Placer {
 public:
  Placer(SymbolicPlan& plan, const std::vector<Offset>& factors_end, const AssemblyTurns& turns)
      : plan_(plan), factors_end_(factors_end), turns_(turns) {}

  void run() {
    constexpr int kTrials = 32;
    constexpr Offset kLittle = Offset(1) << 17, kPart = 64;  // a trial takes a tenth of the time of a plan
    plan_.contribution_begin.assign(plan_.num_fronts, 0);
    plan_.assembly_turn.assign(plan_.num_fronts, 0);
    reserve();
    const Offset least = plan_.storage_entries;
    place_all();
    const Offset enough = least + std::min(kLittle, least / kPart);
    for (int trial = 1; trial < kTrials && plan_.storage_entries > enough; ++trial) try_another(least);
  }

 private:
  // What every step needs at least.
  void reserve() {
    plan_.storage_entries = plan_.factor_entries;
    for (Vertex k = 0; k < plan_.num_depths; ++k) contribution_.push_back(entries_of(k));
    for (Vertex k = 1; k < plan_.num_depths; ++k) {
      const Offset live = factors_end_[k] + std::max(contribution_[k], contribution_[k - 1]);
      plan_.storage_entries = std::max(plan_.storage_entries, live);
    }
    for (Vertex k = 1; k < plan_.num_depths; ++k) assign_turns(k);
  }

  // Keeps what it finds where the region is smaller than before.
  void try_another(Offset least) {
    const Offset best = std::exchange(plan_.storage_entries, least);
    const std::vector<Offset> places = plan_.contribution_begin;
    const std::vector<Vertex> turns = plan_.assembly_turn;
    shuffled_ = true;
    if (place_all(best)) return;
    plan_.storage_entries = best;
    plan_.contribution_begin = places;
    plan_.assembly_turn = turns;
  }

  // False as soon as the region reaches `limit`.
  bool place_all(Offset limit = std::numeric_limits<Offset>::max()) {
    for (Vertex k = plan_.num_depths - 1; k > 0 && plan_.storage_entries < limit; --k) {
      assign_turns(k);
      place_step(k - 1);
    }
    return plan_.storage_entries < limit;
  }

  // Each turn takes what has room; then the blocks of its children are free for the next one. Where nothing
  // has room the region grows.
  void assign_turns(Vertex step) {
    Offset room = plan_.storage_entries - factors_end_[step] - contribution_[step - 1], read = 0;
    std::vector<Vertex> fronts;
    for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
      if (takes_turns(f)) {
        fronts.push_back(f);
      } else {
        room -= entries(f);
      }
    }
    sort_by_size(fronts);
    Vertex turn = 0;
    for (const Vertex f : fronts) {
      if (entries(f) > room && read > 0 && turn + 1 < turns_.most) {
        ++turn;
        room += std::exchange(read, 0);
      }
      if (entries(f) > room) {
        plan_.storage_entries += entries(f) - room;
        room = entries(f);
      }
      plan_.assembly_turn[f] = turn;
      room -= entries(f);
      for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c)
        read += entries(plan_.children[c]);
    }
    plan_.storage_entries += std::max<Offset>(-room, 0);
  }

  bool takes_turns(Vertex f) const {
    return turns_.most > 1 && plan_.pivots(f) + plan_.border_rows(f) > turns_.rows;
  }

  // Blocks that are read longest come first; those of one turn side by side where a gap has room for all,
  // else each in the first that has room for it.
  void place_step(Vertex step) {
    std::vector<Vertex> fronts(plan_.depth_begin[step + 1] - plan_.depth_begin[step]);
    std::iota(fronts.begin(), fronts.end(), plan_.depth_begin[step]);
    std::stable_sort(fronts.begin(), fronts.end(),
                     [&](Vertex a, Vertex b) { return last_read(a) > last_read(b); });
    std::vector<Gap> placed;
    for (auto begin = fronts.begin(); begin != fronts.end();) {
      const Vertex turn = last_read(*begin);
      const auto end = std::find_if(begin, fronts.end(), [&](Vertex f) { return last_read(f) != turn; });
      place_blocks({begin, end}, gaps_beside(step + 1, turn, placed), placed);
      begin = end;
    }
  }

  // The turn of the next step in which a block is read.
  Vertex last_read(Vertex f) const {
    const Vertex parent = plan_.parent[f];
    return parent >= 0 && takes_turns(parent) ? plan_.assembly_turn[parent] : kNever;
  }

  void place_blocks(std::vector<Vertex> fronts, std::vector<Gap> gaps, std::vector<Gap>& placed) {
    Offset all = 0;
    for (const Vertex f : fronts) all += entries(f);
    const auto roomy =
        std::find_if(gaps.begin(), gaps.end(), [&](const Gap& gap) { return gap.entries() >= all; });
    if (roomy != gaps.end()) {
      gaps = {*roomy};
      std::stable_sort(fronts.begin(), fronts.end(),
                       [&](Vertex a, Vertex b) { return plan_.assembly_turn[a] < plan_.assembly_turn[b]; });
    } else {
      sort_by_size(fronts);
    }
    for (const Vertex f : fronts) {
      plan_.contribution_begin[f] = take(entries(f), gaps);
      placed.push_back({plan_.contribution_begin[f], plan_.contribution_begin[f] + entries(f)});
    }
  }

  // Of the region behind the factors of a step, beside its blocks up to a turn and those placed already; the
  // last ends where the region does.
  std::vector<Gap> gaps_beside(Vertex step, Vertex turn, std::vector<Gap> blocks) const {
    for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
      const Offset place = plan_.contribution_begin[f];
      if (plan_.assembly_turn[f] <= turn) blocks.push_back({place, place + entries(f)});
    }
    std::sort(blocks.begin(), blocks.end(), [](const Gap& a, const Gap& b) { return a.begin < b.begin; });
    std::vector<Gap> gaps;
    Offset begin = factors_end_[step];
    for (const Gap& block : blocks) {
      if (block.begin > begin) gaps.push_back({begin, block.begin});
      begin = std::max(begin, block.end);
    }
    gaps.push_back({begin, plan_.storage_entries});
    return gaps;
  }

  // Where no gap has room, the region grows.
  Offset take(Offset entries, std::vector<Gap>& gaps) {
    auto gap = std::find_if(gaps.begin(), gaps.end(), [&](const Gap& g) { return g.entries() >= entries; });
    if (gap == gaps.end()) {
      --gap;
      gap->end = plan_.storage_entries = gap->begin + entries;
    }
    gap->begin += entries;
    return gap->begin - entries;
  }

  void sort_by_size(std::vector<Vertex>& fronts) {
    std::vector<std::pair<double, Vertex>> sized;
    for (const Vertex f : fronts) {
      const double part = shuffled_ ? static_cast<double>(random_()) / std::minstd_rand::max() : 0;
      sized.push_back({static_cast<double>(entries(f)) * (1 + part / 2), f});
    }
    std::stable_sort(sized.begin(), sized.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::transform(sized.begin(), sized.end(), fronts.begin(),
                   [](const auto& front) { return front.second; });
  }

  // That the block of a front takes.
  Offset entries(Vertex f) const {
    return aligned(static_cast<Offset>(plan_.border_rows(f)) * plan_.contribution_ld(f));
  }
  Offset entries_of(Vertex step) const {
    Offset sum = 0;
    for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) sum += entries(f);
    return sum;
  }

  SymbolicPlan& plan_;
  const std::vector<Offset>& factors_end_;
  const AssemblyTurns turns_;
  std::vector<Offset> contribution_;  // entries, by step
  std::minstd_rand random_;           // whose numbers the standard fixes
  bool shuffled_ = false;
};

}  // namespace

void place_contributions(SymbolicPlan& plan, const std::vector<Offset>& factors_end,
                         const AssemblyTurns& turns) {
  Placer(plan, factors_end, turns).run();
}

}  // namespace mfs
