#include "plan/panel_program.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "ordering/transpose.hpp"

namespace mfs {

namespace {

/// A plan of more is none of a tiny system.
constexpr double kTinyFlops = 1e7;
constexpr Vertex kTinyUnknowns = 20'000;

/// Makes one program and is thrown away.
class PanelPlanner {
 public:
  PanelPlanner(const SymbolicPlan& plan, const Pattern& pattern)
      : plan_(plan),
        by_column_(transpose(pattern, 1)),
        panel_of_(static_cast<std::size_t>(plan.n)),
        local_(panel_of_.size()) {
    made_.row_position = plan.position_of_rows();
    made_.column_position = plan.position_of_columns();
    made_.place.assign(static_cast<std::size_t>(plan.nnz), 0);
    for (const Offset slot : plan.triangle.slot) made_.place[slot] = kCoupling;
  }

  PanelProgram make() {
    divide_fronts();
    find_sources();
    for (PanelProgram::Panel& panel : made_.panels) {
      number_rows(panel);
      place_entries(panel);
    }
    place_couplings();
    return std::move(made_);
  }

 private:
  // Into panels of about the same width.
  void divide_fronts() {
    made_.panel_begin.push_back(0);
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      const Vertex begin = plan_.pivot_begin[f], pivots = plan_.pivots(f);
      const Vertex parts = (pivots + kMostTogether - 1) / kMostTogether;
      for (Vertex part = 0; part < parts; ++part) {
        const Vertex first = begin + pivots * part / parts, end = begin + pivots * (part + 1) / parts;
        std::fill(panel_of_.begin() + first, panel_of_.begin() + end,
                  static_cast<Vertex>(made_.panels.size()));
        made_.panels.push_back({first, end - first, f, first - begin, 0, 0, 0, 0, 0});
      }
      made_.panel_begin.push_back(static_cast<Vertex>(made_.panels.size()));
      made_.most_pivots = std::max(made_.most_pivots, pivots);
    }
  }

  // Each front is a source of the panels that its border meets.
  void find_sources() {
    for_sources([&](PanelProgram::Panel& panel, Vertex) { ++panel.source_end; });
    Vertex sum = 0;
    for (PanelProgram::Panel& panel : made_.panels) {
      panel.source_begin = sum;
      sum += std::exchange(panel.source_end, sum);
    }
    made_.sources.resize(static_cast<std::size_t>(sum));
    for_sources(
        [&](PanelProgram::Panel& panel, Vertex front) { made_.sources[panel.source_end++].front = front; });
  }

  /// visit(panel, front), fronts ascending.
  template <class Visit>
  void for_sources(const Visit& visit) {
    std::vector<Vertex> last(made_.panels.size(), -1);
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      for (Offset b = plan_.border_begin[f]; b < plan_.border_begin[f + 1]; ++b) {
        const Vertex panel = panel_of_[plan_.border[b]];
        if (std::exchange(last[panel], f) != f) visit(made_.panels[panel], f);
      }
    }
  }

  void number_rows(PanelProgram::Panel& panel) {
    const Vertex own = panel.front;
    Vertex rows = 0;
    const auto add_pivots = [&](Vertex f) {
      for (Vertex p = plan_.pivot_begin[f]; p < plan_.pivot_begin[f + 1]; ++p) local_[p] = rows++;
    };
    for (Vertex s = panel.source_begin; s < panel.source_end; ++s) add_pivots(made_.sources[s].front);
    panel.pivot_row = rows;
    add_pivots(own);
    for (Offset b = plan_.border_begin[own]; b < plan_.border_begin[own + 1]; ++b)
      local_[plan_.border[b]] = rows++;
    panel.rows = rows;
    panel.numbers = made_.numbers;
    made_.numbers += static_cast<Offset>(panel.columns) * rows;
    for (Vertex s = panel.source_begin; s < panel.source_end; ++s) add_runs(made_.sources[s]);
  }

  void add_runs(PanelProgram::Source& source) {
    const Vertex f = source.front, begin = static_cast<Vertex>(made_.runs.size());
    for (Offset b = plan_.border_begin[f]; b < plan_.border_begin[f + 1]; ++b) {
      const Vertex row = local_[plan_.border[b]];
      const bool goes_on = static_cast<Vertex>(made_.runs.size()) > begin &&
                           made_.runs.back().row + made_.runs.back().rows == row;
      if (goes_on) {
        ++made_.runs.back().rows;
      } else {
        made_.runs.push_back({row, 1});
      }
    }
    source = {f, local_[plan_.pivot_begin[f]], begin, static_cast<Vertex>(made_.runs.size())};
  }

  void place_entries(const PanelProgram::Panel& panel) {
    for (Vertex c = 0; c < panel.columns; ++c) {
      const Vertex column = plan_.column_of[panel.first + c];
      const Offset begin = panel.numbers + static_cast<Offset>(c) * panel.rows;
      for (Offset e = by_column_.offsets[column]; e < by_column_.offsets[column + 1]; ++e) {
        Vertex& place = made_.place[by_column_.slots[e]];
        if (place != kCoupling)
          place = static_cast<Vertex>(begin + local_[made_.row_position[by_column_.columns[e]]]);
      }
    }
  }

  void place_couplings() {
    made_.couplings = made_.numbers;
    for (const Offset slot : plan_.triangle.slot) made_.place[slot] = static_cast<Vertex>(made_.numbers++);
  }

  static constexpr Vertex kCoupling = -1;

  const SymbolicPlan& plan_;
  const TransposedPattern by_column_;
  PanelProgram made_;
  std::vector<Vertex> panel_of_;
  std::vector<Vertex> local_;  // by position: row of the present panel
};

// ns: of a panel's source and its run, of a front and its operation, and of an entry of A, which both have.
// Measured on a Xeon with AVX-512, OpenBLAS 0.3.21; 2026-11-25, docs/experiments/host.md.
constexpr double kPanel = 25, kRun = 8, kFront = 1100, kOperation = 0.02, kEntry = 40;

double expected_time(const PanelProgram& program) {
  double time = 0;
  for (const PanelProgram::Panel& panel : program.panels) {
    for (Vertex s = panel.source_begin; s < panel.source_end; ++s) {
      const PanelProgram::Source& source = program.sources[s];
      const Vertex by = program.panel_begin[source.front + 1] - program.panel_begin[source.front];
      time += by * (kPanel + kRun * (source.run_end - source.run_begin));
    }
  }
  return time;
}
double expected_time_of_fronts(const SymbolicPlan& plan) {
  return kFront * plan.num_fronts + kOperation * plan.flops.total();
}

/// Places are numbers of 32 bits. A row of a panel has an entry of the factors in one of its columns at
/// least.
bool has_places(const SymbolicPlan& plan) {
  return plan.nnz_factor + plan.triangle.couplings() <= std::numeric_limits<Vertex>::max() / kMostTogether;
}

}  // namespace

PanelProgram plan_panels(const SymbolicPlan& plan, const Pattern& pattern) {
  return PanelPlanner(plan, pattern).make();
}

std::shared_ptr<const PanelProgram> make_panel_program(const SymbolicPlan& plan, const Pattern& pattern,
                                                       int threads) {
  const bool is_tiny = plan.n <= kTinyUnknowns && plan.flops.total() <= kTinyFlops;
  const bool has_small_fronts = kOperation * plan.flops.total() <= kFront * plan.num_fronts;
  const double fronts = expected_time_of_fronts(plan), in_common = kEntry * static_cast<double>(plan.nnz);
  const auto pays = [&](double panels) {
    constexpr double kClearly = 0.4;  // what is not tiny is not in cache, either
    if (is_tiny) return panels <= fronts;
    return panels <= kClearly * fronts && threads * (panels + in_common) <= fronts + in_common;
  };
  if (!is_tiny && !(has_small_fronts && has_places(plan))) return nullptr;
  if (!pays(0)) return nullptr;
  auto made = std::make_shared<PanelProgram>(plan_panels(plan, pattern));
  return pays(expected_time(*made)) ? made : nullptr;
}

bool is_for_one_thread(const SymbolicPlan& plan) {
  constexpr double kFlops = 2e7;  // about a millisecond
  return plan.n <= kTinyUnknowns && plan.flops.total() < kFlops;
}

}  // namespace mfs
