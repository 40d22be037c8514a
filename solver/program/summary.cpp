#include "solver/program/summary.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include <mfs/threads.hpp>
#include <mfs/version.hpp>

#include "parts/comma_list.hpp"
#include "parts/report_text.hpp"

namespace mfs::program {
namespace {

using Text = fmt::memory_buffer;

template <class... Arguments>
void line(Text& text, const char* label, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  text.append(labelled(label, fmt::format(format, std::forward<Arguments>(arguments)...)));
}

std::string count(std::int64_t number, const char* one, const char* many) {
  return fmt::format("{} {}", number, number == 1 ? one : many);
}

std::string rate(double flops, double seconds) {
  return seconds > 0 ? with_unit(flops / seconds, "flop/s") : std::string("-");
}

// Whether all factors are on the device or in memory, and what moves if not.
void version_line(Text& text, const CaseResult& r) {
  const Report& report = *r.report;
  const bool on_device = backend_info(r.backend).memory == MemorySpace::device;
  if (report.partial) {
    line(text, "version", "PARTIAL, {}; a factorization {} {} to {}, a pass of a solve {} {} back",
         count(report.segments, "segment", "segments"), on_device ? "copies" : "writes",
         with_unit(static_cast<double>(report.bytes_out), "B"), on_device ? "the host" : "a file",
         on_device ? "copies" : "reads", with_unit(static_cast<double>(report.bytes_back), "B"));
    if (on_device) line(text, "foreseen", "{:.2f} times the refactorization of FULL", report.slowdown);
  } else if (on_device) {
    line(text, "version", "{}", report.bytes_factor > 0 ? "FULL, all factors on the device" : "none fits");
  }
}

void matrix_lines(Text& text, const CaseResult& r) {
  line(text, "matrix", "{}: n = {}, {}{}", r.name, r.n, count(r.entries, "entry", "entries"),
       r.complex ? ", complex" : "");
  const Report& report = *r.report;
  line(text, "backend", "{}, {}", backend_name(r.backend), count(report.threads, "thread", "threads"));
  line(text, "ordering", "{:.3f} s{}{}", report.time_order, report.matched ? ", rows matched to columns" : "",
       report.diagonal_blocks > 1 ? fmt::format(", {} diagonal blocks", report.diagonal_blocks) : "");
  line(text, "symbolic", "{:.3f} s, {} in {}, largest front {}", report.time_symbolic,
       count(report.fronts, "front", "fronts"), count(report.depths, "depth", "depths"), report.max_front);
  line(text, "factor size", "{} entries, {}; peak of all {}", report.nnz_factor,
       with_unit(static_cast<double>(report.bytes_factor), "B"),
       with_unit(static_cast<double>(report.bytes_peak), "B"));
  version_line(text, r);
}

// What happened stands beside what was foreseen, once it has.
void prediction_line(Text& text, const CaseResult& r) {
  if (!r.prediction) {
    if (!r.no_prediction.empty()) line(text, "prediction", "none: {}", r.no_prediction);
    return;
  }
  const auto with_taken = [](double predicted, double taken) {
    return fmt::format("{:.3g} s{}", predicted,
                       taken > 0 ? fmt::format(" (took {:.3g} s)", taken) : std::string());
  };
  const double factor = r.time_refactor > 0 ? r.time_refactor : r.report->time_factor;
  const double solve = r.right_hand_sides == 1 && r.backward_error ? r.time_solve : 0;
  line(text, "prediction", "refactor {}, solve of one right-hand side {}, by rates of {}",
       with_taken(r.prediction->refactor, factor), with_taken(r.prediction->solve, solve),
       r.prediction->date);
}

void flop_lines(Text& text, const Flops& flops) {
  const auto share = [&](double part) { return flops.total() > 0 ? 100 * part / flops.total() : 0.0; };
  line(text, "flops", "{}", with_unit(flops.total(), "flop"));
  line(text, "  getrf", "{} ({:.1f} %)", with_unit(flops.getrf, "flop"), share(flops.getrf));
  line(text, "  trsm", "{} ({:.1f} %)", with_unit(flops.trsm, "flop"), share(flops.trsm));
  line(text, "  gemm", "{} ({:.1f} %)", with_unit(flops.gemm, "flop"), share(flops.gemm));
}

void examination_lines(Text& text, const CaseResult& r) {
  if (r.condition) line(text, "condition", "{:.1e} (estimate, 1-norm)", *r.condition);
  for (const std::string& name : r.not_known)
    line(text, name.c_str(), "not known: too many pivots were perturbed");
  if (!r.determinant) return;
  const auto [phase, log_abs] = *r.determinant;
  // A sign, or a phase.
  const std::string sign = r.complex ? fmt::format("({:.6g}, {:.6g})", phase.real(), phase.imag())
                                     : fmt::format("{:g}", phase.real());
  line(text, "determinant", "{} exp({:.15g})", sign, log_abs);
}

// What the solution took beyond one pass over the first factors.
void ladder_line(Text& text, const Report& report) {
  if (report.dependent_rows > 0)
    line(text, "singular", "to working precision: some z has |A z| = {:.1e} | |A||z| |", report.singularity);
  if (report.rung == Rung::factors && report.reanalyses == 0 && !report.single_precision) return;
  line(text, "accuracy by", "{}, {:.3f} s; {}, {}, {} in {:.3f} s, {} precision factors",
       rung_name(report.rung), report.time_ladder, count(report.krylov_steps, "FGMRES step", "FGMRES steps"),
       count(report.corrected_pivots, "corrected pivot", "corrected pivots"),
       count(report.reanalyses, "change of the tree", "changes of the tree"), report.time_reanalyses,
       report.single_precision ? "single" : "double");
}

void depth_table(Text& text, const std::vector<DepthSummary>& depths, bool by_segments) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\n{:>5} {:>9} {:>10} {:>9} {:>14} {:>14} {:>13} {:>13} {:>13}{}\n", "depth", "fronts",
                 "pivots", "max front", "factor", "contribution", "getrf", "trsm", "gemm",
                 by_segments ? "  segments" : "");
  for (const DepthSummary& d : depths)
    fmt::format_to(out, "{:>5} {:>9} {:>10} {:>9} {:>14} {:>14} {:>13} {:>13} {:>13}{}\n", d.depth, d.fronts,
                   d.pivots, d.max_front, d.factor_entries, d.contribution_entries,
                   with_unit(d.flops.getrf, "flop"), with_unit(d.flops.trsm, "flop"),
                   with_unit(d.flops.gemm, "flop"),
                   by_segments ? fmt::format(" {:>9}", d.segments) : std::string());
}

}  // namespace

std::string solve_summary(const CaseResult& r) {
  if (!r.report) return "";
  const Report& report = *r.report;
  Text text;
  if (r.time_read > 0) line(text, "read", "{:.3f} s", r.time_read);
  matrix_lines(text, r);
  if (report.time_factor > 0)
    line(text, "factor", "{:.3f} s, {} at {}, {}", report.time_factor,
         with_unit(report.flops.total(), "flop"), rate(report.flops.total(), report.time_factor),
         count(report.perturbed_pivots, "perturbed pivot", "perturbed pivots"));
  if (r.time_refactor > 0)
    line(text, "refactor", "{:.3f} s at {}, the least of {}", r.time_refactor,
         rate(report.flops.total(), r.time_refactor), r.refactorizations);
  examination_lines(text, r);
  if (!r.backward_error) return fmt::to_string(text);
  line(text, "solve", "{:.3f} s, {}, {}{}", r.time_solve,
       count(r.right_hand_sides, "right-hand side", "right-hand sides"),
       count(report.refinement_steps, "refinement step", "refinement steps"),
       r.refactorizations > 0 ? fmt::format(", the least of {}", r.refactorizations + 1) : std::string());
  ladder_line(text, report);
  line(text, "backward error", "{:.2e} (componentwise, asked {:.0e})", *r.backward_error, r.tolerance);
  if (r.prediction) prediction_line(text, r);
  return fmt::to_string(text);
}

std::string analysis_summary(const CaseResult& r) {
  Text text;
  matrix_lines(text, r);
  flop_lines(text, r.report->flops);
  prediction_line(text, r);
  depth_table(text, r.depths, r.report->partial);
  return fmt::to_string(text);
}

std::string rates_summary(const MachineRates& rates, const std::string& path) {
  Text text;
  line(text, "processor", "{}", rates.key.processor);
  line(text, "backend", "{}, {}", rates.key.backend, count(rates.key.threads, "thread", "threads"));
  if (rates.link_bytes_per_second > 0)
    line(text, "link", "{} back to the device in a solve", with_unit(rates.link_bytes_per_second, "B/s"));
  line(text, "kept in", "{}", path);
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\n{:>10} {:>15} {:>15}\n", "front size", "refactor", "solve");
  for (const FrontRate& rate : rates.fronts)
    fmt::format_to(out, "{:>10.0f} {:>15} {:>15}\n", rate.size, with_unit(rate.flops_per_second, "flop/s"),
                   with_unit(rate.entries_per_second * sizeof(double), "B/s"));
  return fmt::to_string(text);
}

std::string usable_backends() {
  return comma_list(backends(), backend_name);
}

std::string device_summary(const DeviceInfo& d) {
  const auto capability = [](int number) { return fmt::format("{}.{}", number / 10, number % 10); };
  Text text;
  line(text, "device", "{}, compute capability {}, {} multiprocessors, {}", d.name,
       capability(d.compute_capability), d.multiprocessors, with_unit(static_cast<double>(d.bytes), "B"));
  line(text, "", "code for {}; products of double precision by {}", capability(d.code),
       d.tensor_cores ? "tensor cores" : "multiply-adds");
  line(text, "", "{} KiB of shared memory for a block: {} pivots at once, fronts of up to {} rows as a whole",
       d.shared_memory / 1024, d.tile, d.small_rows);
  line(text, "", "{} precision factors by default: double precision is {} times as slow as single",
       d.precision == Precision::single ? "single" : "double", d.single_to_double);
  return fmt::to_string(text);
}

std::string library_summary() {
  Text text;
  line(text, "mfs", "{}", version());
  line(text, "backends", "{}", usable_backends());
  for (const DeviceInfo& device : devices()) text.append(device_summary(device));
  line(text, "threads", "{}", default_threads());
  for (const LibraryInfo& library : libraries()) line(text, library.name.c_str(), "{}", library.version);
  return fmt::to_string(text);
}

}  // namespace mfs::program
