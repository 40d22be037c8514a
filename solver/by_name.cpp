#include <mfs/by_name.hpp>

#include <charconv>
#include <cstdint>
#include <initializer_list>
#include <system_error>

namespace mfs {
namespace {

/// What a text should have been. It is caught in set_option, which knows the name of the option.
struct Unreadable {
  std::string expected;
};

template <class Number>
Number number(const std::string& text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || last != end)
    throw Unreadable{std::is_integral_v<Number> ? "an integer" : "a number"};
  return value;
}

bool flag(const std::string& text) {
  if (text == "yes" || text == "true") return true;
  if (text == "no" || text == "false") return false;
  throw Unreadable{"yes, true, no or false"};
}

template <class Enum>
Enum enumerator(const std::string& text, std::initializer_list<Enum> values, const char* (*name)(Enum)) {
  std::string expected = "one of";
  for (const Enum value : values) {
    if (text == name(value)) return value;
    expected += std::string(" ") + name(value);
  }
  throw Unreadable{expected};
}

const char* matching_name(Matching matching) {
  switch (matching) {
    case Matching::automatic:
      return "automatic";
    case Matching::always:
      return "always";
    case Matching::never:
      return "never";
  }
  return "unknown";
}

struct Option {
  const char* name;
  void (*set)(Options& options, const std::string& text);
};

constexpr Option kOptions[] = {
    {"backend",
     [](Options& o, const std::string& text) {
       o.backend =
           enumerator(text, {Backend::serial, Backend::openmp, Backend::cuda, Backend::kokkos}, backend_name);
     }},
    {"memory_limit",
     [](Options& o, const std::string& text) { o.memory_limit = number<std::int64_t>(text); }},
    {"threads", [](Options& o, const std::string& text) { o.threads = number<int>(text); }},
    {"analysis_threads", [](Options& o, const std::string& text) { o.analysis.threads = number<int>(text); }},
    {"matching",
     [](Options& o, const std::string& text) {
       o.analysis.matching =
           enumerator(text, {Matching::automatic, Matching::always, Matching::never}, matching_name);
     }},
    {"scaling", [](Options& o, const std::string& text) { o.analysis.scaling = flag(text); }},
    {"max_block_size",
     [](Options& o, const std::string& text) { o.analysis.max_block_size = number<std::int32_t>(text); }},
    {"leaf_size",
     [](Options& o, const std::string& text) { o.analysis.leaf_size = number<std::int32_t>(text); }},
    {"separator_trials",
     [](Options& o, const std::string& text) { o.analysis.separator_trials = number<std::int32_t>(text); }},
    {"separator_refinement",
     [](Options& o, const std::string& text) {
       o.analysis.separator_refinement = number<std::int32_t>(text);
     }},
    {"dense_row", [](Options& o, const std::string& text) { o.analysis.dense_row = number<double>(text); }},
    {"seed", [](Options& o, const std::string& text) { o.analysis.seed = number<std::int32_t>(text); }},
    {"precision",
     [](Options& o, const std::string& text) {
       o.factor.precision =
           enumerator(text, {Precision::automatic, Precision::full, Precision::single}, precision_name);
     }},
    {"pivot_tolerance",
     [](Options& o, const std::string& text) { o.factor.pivot_tolerance = number<double>(text); }},
    {"max_reanalyses",
     [](Options& o, const std::string& text) { o.factor.max_reanalyses = number<int>(text); }},
    {"tolerance", [](Options& o, const std::string& text) { o.solve.tolerance = number<double>(text); }},
    {"max_refinement_steps",
     [](Options& o, const std::string& text) { o.solve.max_refinement_steps = number<int>(text); }},
    {"row_floor", [](Options& o, const std::string& text) { o.solve.row_floor = number<double>(text); }},
    {"solve_singular", [](Options& o, const std::string& text) { o.solve.solve_singular = flag(text); }},
    {"out_of_core_dir", [](Options& o, const std::string& text) { o.out_of_core_dir = text; }},
    {"dump_prefix", [](Options& o, const std::string& text) { o.dump_prefix = text; }},
};

}  // namespace

void set_option(Options& options, const std::string& name, const std::string& value) {
  for (const Option& option : kOptions) {
    if (name != option.name) continue;
    try {
      option.set(options, value);
    } catch (const Unreadable& unreadable) {
      throw InvalidInput(name, "\"" + value + "\" is not " + unreadable.expected);
    }
    return;
  }
  throw InvalidInput(name, "no option has this name");
}

std::vector<std::string> option_names() {
  std::vector<std::string> names;
  for (const Option& option : kOptions) names.emplace_back(option.name);
  return names;
}

std::vector<Figure> figures(const Report& report) {
  const auto count = [](std::int64_t value) { return static_cast<double>(value); };
  return {{"n", count(report.n)},
          {"nnz", count(report.nnz)},
          {"backend", static_cast<double>(report.backend)},
          {"threads", static_cast<double>(report.threads)},
          {"matched", static_cast<double>(report.matched)},
          {"diagonal_blocks", count(report.diagonal_blocks)},
          {"nnz_factor", count(report.nnz_factor)},
          {"flops_getrf", report.flops.getrf},
          {"flops_trsm", report.flops.trsm},
          {"flops_gemm", report.flops.gemm},
          {"flops", report.flops.total()},
          {"flops_used", report.flops_used.total()},
          {"fronts", count(report.fronts)},
          {"depths", count(report.depths)},
          {"max_front", count(report.max_front)},
          {"bytes_factor", count(report.bytes_factor)},
          {"bytes_peak", count(report.bytes_peak)},
          {"bytes_used", count(report.bytes_used)},
          {"partial", static_cast<double>(report.partial)},
          {"segments", count(report.segments)},
          {"bytes_out", count(report.bytes_out)},
          {"bytes_in", count(report.bytes_in)},
          {"bytes_back", count(report.bytes_back)},
          {"slowdown", report.slowdown},
          {"time_order", report.time_order},
          {"time_symbolic", report.time_symbolic},
          {"time_factor", report.time_factor},
          {"time_refactor", report.time_refactor},
          {"time_solve", report.time_solve},
          {"perturbed_pivots", count(report.perturbed_pivots)},
          {"single_precision", static_cast<double>(report.single_precision)},
          {"reanalyses", static_cast<double>(report.reanalyses)},
          {"time_reanalyses", report.time_reanalyses},
          {"rung", static_cast<double>(report.rung)},
          {"time_ladder", report.time_ladder},
          {"refinement_steps", static_cast<double>(report.refinement_steps)},
          {"krylov_steps", static_cast<double>(report.krylov_steps)},
          {"corrected_pivots", count(report.corrected_pivots)},
          {"backward_error", report.backward_error},
          {"dependent_rows", count(report.dependent_rows)},
          {"singularity", report.singularity}};
}

}  // namespace mfs
