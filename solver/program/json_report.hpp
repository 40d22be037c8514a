// The report for other programs: one JSON object per matrix, each on its own line, the same keys always.
#pragma once

#include <string>

#include "solver/program/case_result.hpp"

namespace mfs::program {

/// name, n, nnz, field, backend, threads, diagonal_blocks, nnz_factor, flops, flops_getrf, flops_trsm,
/// flops_gemm, bytes_factor, bytes_peak, partial, segments, bytes_out, bytes_in, bytes_back, slowdown,
/// fronts, depths, max_front, time_order, time_symbolic, time_factor, time_refactor, time_solve,
/// refinement_steps, perturbed_pivots, krylov_steps, corrected_pivots, reanalyses, rung, time_ladder,
/// time_reanalyses, precision, condition, determinant_phase (real and imaginary part), determinant_log_abs,
/// backward_error, status, message. Figures of a phase that was not reached are 0; backward_error is null
/// where no x was returned, and where x is not finite; so are condition and determinant where they are not
/// known, not asked for, or (condition, determinant_log_abs) not finite.
std::string json_line(const CaseResult& result);

}  // namespace mfs::program
