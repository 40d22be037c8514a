#include "solver/program/json_report.hpp"

#include <nlohmann/json.hpp>

#include "parts/report_text.hpp"

namespace mfs::program {

std::string json_line(const CaseResult& result) {
  const Report report = result.report.value_or(Report());
  nlohmann::ordered_json json;
  json["name"] = result.name;
  json["n"] = result.n;
  json["nnz"] = result.report ? report.nnz : result.entries;
  json["field"] = result.complex ? "complex" : "real";
  json["backend"] = backend_name(result.backend);
  json["threads"] = result.report ? report.threads : result.threads;
  json["diagonal_blocks"] = report.diagonal_blocks;
  json["nnz_factor"] = report.nnz_factor;
  json["flops"] = report.flops.total();
  json["flops_getrf"] = report.flops.getrf;
  json["flops_trsm"] = report.flops.trsm;
  json["flops_gemm"] = report.flops.gemm;
  json["bytes_factor"] = report.bytes_factor;
  json["bytes_peak"] = report.bytes_peak;
  json["partial"] = report.partial;
  json["segments"] = report.segments;
  json["bytes_out"] = report.bytes_out;
  json["bytes_in"] = report.bytes_in;
  json["bytes_back"] = report.bytes_back;
  json["slowdown"] = report.slowdown;
  json["fronts"] = report.fronts;
  json["depths"] = report.depths;
  json["max_front"] = report.max_front;
  json["time_order"] = report.time_order;
  json["time_symbolic"] = report.time_symbolic;
  json["time_factor"] = report.time_factor;
  json["time_refactor"] = result.time_refactor;
  json["time_solve"] = result.time_solve > 0 ? result.time_solve : report.time_solve;  // of one that failed
  json["predicted_refactor"] = nullptr;
  json["predicted_solve"] = nullptr;
  if (result.prediction) {
    json["predicted_refactor"] = result.prediction->refactor;
    json["predicted_solve"] = result.prediction->solve;
  }
  json["refinement_steps"] = report.refinement_steps;
  json["perturbed_pivots"] = report.perturbed_pivots;
  json["krylov_steps"] = report.krylov_steps;
  json["corrected_pivots"] = report.corrected_pivots;
  json["dependent_rows"] = report.dependent_rows;
  json["singularity"] = report.singularity;
  json["reanalyses"] = report.reanalyses;
  json["rung"] = rung_name(report.rung);
  json["time_ladder"] = report.time_ladder;
  json["time_reanalyses"] = report.time_reanalyses;
  json["precision"] = report.single_precision ? "single" : "double";
  json["condition"] = nullptr;
  if (result.condition) json["condition"] = *result.condition;  // infinite: null as well
  json["determinant_phase"] = nullptr;
  json["determinant_log_abs"] = nullptr;
  if (result.determinant) {
    json["determinant_phase"] = {result.determinant->phase.real(), result.determinant->phase.imag()};
    json["determinant_log_abs"] = result.determinant->log_abs;  // of 0: null as well
  }
  json["backward_error"] = nullptr;
  if (result.backward_error) json["backward_error"] = *result.backward_error;  // infinite: null as well
  json["status"] = status_word(result.code);
  json["message"] = result.message;
  return one_line(json);
}

}  // namespace mfs::program
