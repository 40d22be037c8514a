#include "plan/level_schedule.hpp"

#include <algorithm>
#include <numeric>

namespace mfs {

namespace {

/// Products of some targets, each with the level from which on it can be had.
class Products {
 public:
  explicit Products(Offset targets)
      : level_(static_cast<std::size_t>(targets)), count_(level_.size()), pivot_(level_.size()) {}

  void add(Offset target, Offset m, Offset d, Offset s, Vertex level) {
    target_.push_back(static_cast<Vertex>(target));
    available_.push_back(level);
    packed_.push_back(Packed::product(m, d, s));
    level_[target] = std::max(level_[target], level);
    ++count_[target];
  }
  void set_pivot(Offset target) { pivot_[target] = 1; }
  /// The level that completes what has been added.
  Vertex level(Offset target) const { return level_[target]; }

  /// Returns the number of levels.
  Vertex append(LevelSchedule& to, int together) {
    sort_by_target();
    divide(static_cast<Vertex>(together));
    std::stable_sort(tasks_.begin(), tasks_.end(), [](const Task& a, const Task& b) {
      return a.level != b.level ? a.level < b.level : a.count > b.count;
    });
    Vertex levels = 0;
    for (std::size_t first = 0, last = 0; first < tasks_.size(); first = last, ++levels) {
      while (last < tasks_.size() && tasks_[last].level == tasks_[first].level) ++last;
      append_level(first, last, to);
    }
    return levels;
  }

 private:
  struct Task {
    Vertex level, target, first, count;
    bool is_last;
  };

  // By target, then by level; products of a level keep the order of columns.
  void sort_by_target() {
    std::vector<Vertex> next(count_.size() + 1);
    std::partial_sum(count_.begin(), count_.end(), next.begin() + 1);
    order_.resize(target_.size());
    for (std::size_t i = 0; i < target_.size(); ++i) order_[next[target_[i]]++] = static_cast<Vertex>(i);
    for (std::size_t t = 0, first = 0; t < count_.size(); first += count_[t++]) {
      const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first);
      std::stable_sort(begin, begin + count_[t],
                       [&](Vertex a, Vertex b) { return available_[a] < available_[b]; });
    }
  }
  void divide(Vertex together) {
    Vertex first = 0;
    for (std::size_t t = 0; t < count_.size(); ++t) {
      const Vertex end = first + count_[t];
      if (first == end && pivot_[t]) tasks_.push_back({0, static_cast<Vertex>(t), 0, 0, true});
      for (Vertex next = first; first < end;) {
        const Vertex level = available_[order_[next]];
        while (next < end && available_[order_[next]] == level) ++next;
        if (next < end && next - first < together) continue;
        tasks_.push_back({level, static_cast<Vertex>(t), first, next - first, next == end});
        first = next;
      }
    }
  }
  void append_level(std::size_t first, std::size_t last, LevelSchedule& to) const {
    to.level_begin.push_back(static_cast<Vertex>(to.tasks.size()));
    for (std::size_t slice = first; slice < last; slice += kSliceTasks) {
      const std::size_t begin = to.products.size(), end = std::min<std::size_t>(last, slice + kSliceTasks);
      to.products.resize(begin + static_cast<std::size_t>(tasks_[slice].count) * kSliceTasks);
      for (std::size_t t = slice; t < end; ++t) {
        const Task& task = tasks_[t];
        to.tasks.push_back(Packed::task(task.target, task.is_last && pivot_[task.target], task.count,
                                        static_cast<Offset>(begin / kSliceTasks)));
        for (Vertex k = 0; k < task.count; ++k)
          to.products[begin + static_cast<std::size_t>(k) * kSliceTasks + (t - slice)] =
              packed_[order_[task.first + k]];
      }
      to.tasks.resize((to.tasks.size() + kSliceTasks - 1) / kSliceTasks * kSliceTasks);
    }
  }

  std::vector<Vertex> level_, count_;       // by target
  std::vector<char> pivot_;                 // likewise
  std::vector<Vertex> target_, available_;  // by product
  std::vector<std::uint64_t> packed_;
  std::vector<Vertex> order_;
  std::vector<Task> tasks_;
};

Vertex append_factorization(const ScalarProgram& p, int together, LevelSchedule& to) {
  Products products(p.entries());
  const auto level = [&](Vertex entry) { return products.level(entry); };
  std::vector<Vertex> place(static_cast<std::size_t>(p.n));  // of a row in the column
  for (Vertex k = 0; k < p.n; ++k) {
    for (Vertex e = p.column_begin[k]; e < p.column_begin[k + 1]; ++e) place[p.row[e]] = e;
    for (Vertex u = p.column_begin[k]; u < p.pivot[k]; ++u) {
      const Vertex j = p.row[u], d = p.pivot[j], earliest = std::max(level(u), level(d));
      for (Vertex l = d + 1; l < p.column_begin[j + 1]; ++l)
        products.add(place[p.row[l]], l, d, u, 1 + std::max(earliest, level(l)));
    }
    products.set_pivot(p.pivot[k]);
  }
  return products.append(to, together);
}

Vertex append_forward(const ScalarProgram& p, LevelSchedule& to) {
  Products products(p.n);
  for (Vertex j = 0; j < p.n; ++j) {
    for (Vertex l = p.pivot[j] + 1; l < p.column_begin[j + 1]; ++l)
      products.add(p.row[l], l, p.pivot[j], j, 1 + products.level(j));
  }
  return products.append(to, 1);
}

Vertex append_backward(const ScalarProgram& p, LevelSchedule& to) {
  Products products(p.n);
  for (Vertex k = p.n - 1; k >= 0; --k) {
    for (Vertex u = p.column_begin[k]; u < p.pivot[k]; ++u)
      products.add(p.row[u], u, p.pivot[k], k, 1 + products.level(k));
  }
  return products.append(to, 1);
}

}  // namespace

LevelSchedule make_level_schedule(const ScalarProgram& program, int together) {
  LevelSchedule schedule;
  schedule.factor_levels = append_factorization(program, together, schedule);
  schedule.forward_levels = append_forward(program, schedule);
  schedule.levels = schedule.factor_levels + schedule.forward_levels + append_backward(program, schedule);
  schedule.level_begin.resize(schedule.level_begin.size() + kLevelsAhead + 1,
                              static_cast<Vertex>(schedule.tasks.size()));
  return schedule;
}

}  // namespace mfs
