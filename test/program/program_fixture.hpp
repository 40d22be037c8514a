// What the tests of the program have in common: files, runs, complaints.
#pragma once

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "solver/program/matrix_market.hpp"
#include "test/program/run_program.hpp"

inline const std::string kReal = "%%MatrixMarket matrix coordinate real general\n";
inline const std::string kArray = "%%MatrixMarket matrix array real general\n";
// [ 2 1 ]
// [ 0 4 ]
inline const std::string kTriangular = kReal + "2 2 3\n1 1 2\n1 2 1\n2 2 4\n";

class Program : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) { return folder_.write(name, text); }
  std::string path(const std::string& name) { return folder_.path(name); }
  template <class Scalar = double>
  std::vector<Scalar> solution(const std::string& path) {
    return std::get<mfs::io::DenseMatrix<Scalar>>(mfs::io::read_matrix_market(path).content).values;
  }
  /// Runs it, expects this exit code and one line of complaint that begins with "mfs: ", and gives back its
  /// rest.
  std::string complaint(const std::vector<std::string>& arguments, int code) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_THAT(run.err, testing::AllOf(testing::StartsWith("mfs: "), testing::EndsWith("\n")));
    EXPECT_EQ(run.err.find('\n'), run.err.size() - 1) << run.err;
    return run.err.size() > 6 ? run.err.substr(5, run.err.size() - 6) : "";
  }

  TemporaryFolder folder_;
};

/// Of every JSON object, in this order.
inline const std::vector<std::string> kKeys{"name",
                                            "n",
                                            "nnz",
                                            "field",
                                            "backend",
                                            "threads",
                                            "diagonal_blocks",
                                            "nnz_factor",
                                            "flops",
                                            "flops_getrf",
                                            "flops_trsm",
                                            "flops_gemm",
                                            "bytes_factor",
                                            "bytes_peak",
                                            "partial",
                                            "segments",
                                            "bytes_out",
                                            "bytes_in",
                                            "bytes_back",
                                            "slowdown",
                                            "fronts",
                                            "depths",
                                            "max_front",
                                            "time_order",
                                            "time_symbolic",
                                            "time_factor",
                                            "time_refactor",
                                            "time_solve",
                                            "predicted_refactor",
                                            "predicted_solve",
                                            "refinement_steps",
                                            "perturbed_pivots",
                                            "krylov_steps",
                                            "corrected_pivots",
                                            "dependent_rows",
                                            "singularity",
                                            "reanalyses",
                                            "rung",
                                            "time_ladder",
                                            "time_reanalyses",
                                            "precision",
                                            "condition",
                                            "determinant_phase",
                                            "determinant_log_abs",
                                            "backward_error",
                                            "status",
                                            "message"};

inline std::vector<std::string> keys_of(const nlohmann::ordered_json& json) {
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  return keys;
}
