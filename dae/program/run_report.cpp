#include "dae/program/run_report.hpp"

#include <sys/resource.h>

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "parts/report_text.hpp"

namespace mfs::dae {
namespace {

double time_rest(const IntegrationReport& r) {
  return std::max(0.0, r.time_total - r.time_analysis - r.time_factor - r.time_solve - r.time_assembly);
}

}  // namespace

std::string run_summary(const RunResult& result) {
  const IntegrationReport& r = result.report;
  std::string text;
  const auto line = [&](const char* label, const std::string& what) {
    text += program::labelled(label, what);
  };
  const auto time = [&](const char* label, double seconds) {
    const double share = r.time_total > 0 ? 100 * seconds / r.time_total : 0.0;
    line(label, fmt::format("{:9.3f} s {:5.1f} %", seconds, share));
  };
  line("model", fmt::format("{}: {} coordinates, {} constraints leave {} degrees of freedom, Newton matrix "
                            "of {} unknowns, {} entries",
                            result.model, r.coordinates, r.constraints, r.coordinates - r.constraints,
                            r.unknowns, r.entries));
  if (!r.redundant.empty()) {
    constexpr std::size_t kMostNamed = 6;
    std::string names;
    for (std::size_t i = 0; i < std::min(r.redundant.size(), kMostNamed); ++i)
      names += (i == 0 ? "" : "; ") + r.redundant[i];
    line("left out", fmt::format("{} redundant constraints: {}{}", r.redundant.size(), names,
                                 r.redundant.size() > kMostNamed ? "; ..." : ""));
  }
  line("steps", fmt::format("{}; rejected {} (error {}, Newton {}, solver {})", r.steps,
                            r.error_rejections + r.newton_rejections + r.solver_rejections,
                            r.error_rejections, r.newton_rejections, r.solver_rejections));
  line("Newton", fmt::format("{} iterations, {} Jacobians, {} factorizations, {} analyses",
                             r.newton_iterations, r.jacobians, r.factorizations, r.analyses));
  line("violation", fmt::format("{:.1e} of positions, {:.1e} of velocities, {:.1e} of accelerations",
                                r.violation[0], r.violation[1], r.violation[2]));
  line("memory", fmt::format("{} solver, {} whole process",
                             program::with_unit(static_cast<double>(r.bytes_solver), "B"),
                             program::with_unit(static_cast<double>(result.bytes_peak), "B")));
  time("reordering", r.time_analysis);
  time("factorization", r.time_factor);
  time("solve", r.time_solve);
  time("assembly", r.time_assembly);
  time("rest", time_rest(r));
  time("analysis", r.time_total);
  line("beside it", fmt::format("{:.3f} s model, {:.3f} s output (waited for {:.3f} s of it)",
                                result.time_model, result.time_output, result.time_waiting));
  for (const std::string& note : result.notes) line("note", note);
  return text;
}

std::string run_json(const RunResult& result) {
  const IntegrationReport& r = result.report;
  nlohmann::ordered_json json;
  json["name"] = result.model;
  json["backend"] = backend_name(result.backend);
  json["threads"] = result.threads;
  json["coordinates"] = r.coordinates;
  json["constraints"] = r.constraints;
  json["unknowns"] = r.unknowns;
  json["entries"] = r.entries;
  json["redundant"] = r.redundant;
  json["steps"] = r.steps;
  json["error_rejections"] = r.error_rejections;
  json["newton_rejections"] = r.newton_rejections;
  json["solver_rejections"] = r.solver_rejections;
  json["newton_iterations"] = r.newton_iterations;
  json["jacobians"] = r.jacobians;
  json["factorizations"] = r.factorizations;
  json["analyses"] = r.analyses;
  json["krylov_solves"] = r.krylov_solves;
  json["violation"] = {r.violation[0], r.violation[1], r.violation[2]};
  json["bytes_solver"] = r.bytes_solver;
  json["bytes_peak"] = result.bytes_peak;
  json["time_model"] = result.time_model;
  json["time_reordering"] = r.time_analysis;
  json["time_factor"] = r.time_factor;
  json["time_solve"] = r.time_solve;
  json["time_assembly"] = r.time_assembly;
  json["time_rest"] = time_rest(r);
  json["time_total"] = r.time_total;
  json["time_output"] = result.time_output;
  json["time_waiting"] = result.time_waiting;
  json["notes"] = result.notes;
  json["status"] = result.status;
  json["message"] = result.message;
  return program::one_line(json);
}

std::int64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

}  // namespace mfs::dae
