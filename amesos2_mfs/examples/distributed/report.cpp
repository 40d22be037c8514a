#include "report.hpp"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace distributed {
namespace {

constexpr std::size_t kMostRanksListed = 16;

struct Column {
  const char* heading;
  const char* key;  ///< in JSON
  double (*value)(const RankFigures&);
  int decimals;
};

constexpr Column kColumns[] = {
    {"rows", "rows", [](const RankFigures& r) { return r.rows; }, 0},
    {"analyses", "analyses", [](const RankFigures& r) { return r.analyses; }, 0},
    {"again", "analyses_again", [](const RankFigures& r) { return r.analyses_again; }, 0},
    {"factored", "factorizations", [](const RankFigures& r) { return r.factorizations; }, 0},
    {"solved", "solves", [](const RankFigures& r) { return r.solves; }, 0},
    {"analysis s", "analysis_s", [](const RankFigures& r) { return r.seconds_analyses; }, 3},
    {"factor s", "factorization_s", [](const RankFigures& r) { return r.seconds_factorizations; }, 3},
    {"solve s", "mfs_solve_s", [](const RankFigures& r) { return r.seconds_solves; }, 3},
    {"MFS MB", "mfs_mb", [](const RankFigures& r) { return r.bytes / 1e6; }, 1},
    {"process MB", "process_mb", [](const RankFigures& r) { return r.resident_peak / 1e6; }, 1},
};

std::string fixed(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << value;
  return text.str();
}

std::string short_number(double value) {
  std::ostringstream text;
  text << std::setprecision(3) << value;
  return text.str();
}

void print_line(std::ostream& out, const std::string& name, const std::vector<std::string>& cells) {
  out << std::left << std::setw(8) << name << std::right;
  for (const std::string& cell : cells) out << std::setw(12) << cell;
  out << "\n";
}

void print_ranks(std::ostream& out, const std::vector<RankFigures>& ranks) {
  std::vector<std::string> headings, least, most;
  for (const Column& column : kColumns) {
    headings.push_back(column.heading);
    const auto [low, high] =
        std::minmax_element(ranks.begin(), ranks.end(),
                            [&](const auto& a, const auto& b) { return column.value(a) < column.value(b); });
    least.push_back(fixed(column.value(*low), column.decimals));
    most.push_back(fixed(column.value(*high), column.decimals));
  }
  print_line(out, "rank", headings);
  for (std::size_t rank = 0; rank < ranks.size() && ranks.size() <= kMostRanksListed; ++rank) {
    std::vector<std::string> cells;
    for (const Column& column : kColumns) cells.push_back(fixed(column.value(ranks[rank]), column.decimals));
    print_line(out, std::to_string(rank), cells);
  }
  if (ranks.size() > kMostRanksListed) {
    print_line(out, "least", least);
    print_line(out, "most", most);
  }
}

/// A list of what `value` gives for each item.
template <class Items, class Value>
std::string json_list(const Items& items, const Value& value) {
  std::ostringstream text;
  text << std::setprecision(15) << "[";
  const char* comma = "";
  for (const auto& item : items) {
    text << comma << value(item);
    comma = ", ";
  }
  text << "]";
  return text.str();
}

std::string json_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

void print_heading(std::ostream& out, const Problem& problem) {
  out << problem.name << ": " << problem.a->getGlobalNumRows() << " unknowns, "
      << problem.a->getGlobalNumEntries() << " entries, " << problem.a->getComm()->getSize() << " ranks\n";
}

void print_table(std::ostream& out, const Measured& measured) {
  out << "\n" << measured.settings << " with " << measured.solver << "\n";
  print_line(out, "values", {"set-up s", "iterations", "solve s", "residual", "difference"});
  for (std::size_t k = 0; k < measured.steps.size(); ++k) {
    const Step& step = measured.steps[k];
    print_line(out, k == 0 ? "first" : "new",
               {fixed(step.setup_s, 3), std::to_string(step.iterations), fixed(step.solve_s, 3),
                short_number(step.residual), short_number(step.difference)});
    if (!step.converged) out << "NOT CONVERGED\n";
  }
  if (measured.solver == "MFS") print_ranks(out, measured.ranks);
  out << std::flush;
}

void print_json(std::ostream& out, const Problem& problem, const Measured& measured) {
  const auto& steps = measured.steps;
  out << "{\"problem\": " << json_text(problem.name) << ", \"unknowns\": " << problem.a->getGlobalNumRows()
      << ", \"ranks\": " << measured.ranks.size() << ", \"settings\": " << json_text(measured.settings)
      << ", \"solver\": " << json_text(measured.solver)
      << ", \"converged\": " << (measured.converged() ? "true" : "false")
      << ", \"setup_s\": " << json_list(steps, [](const Step& s) { return s.setup_s; })
      << ", \"solve_s\": " << json_list(steps, [](const Step& s) { return s.solve_s; })
      << ", \"iterations\": " << json_list(steps, [](const Step& s) { return s.iterations; })
      << ", \"residual\": " << json_list(steps, [](const Step& s) { return s.residual; })
      << ", \"norm\": " << json_list(steps, [](const Step& s) { return s.norm; })
      << ", \"difference\": " << json_list(steps, [](const Step& s) { return s.difference; });
  for (const Column& column : kColumns)
    out << ", \"" << column.key << "\": " << json_list(measured.ranks, column.value);
  out << "}" << std::endl;
}

}  // namespace distributed
