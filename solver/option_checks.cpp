#include "solver/option_checks.hpp"

#include <string>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/threads.hpp>

#include "kernels/runtime/engine.hpp"
#include "solver/backend.hpp"

namespace mfs {

void check_options(const Options& options) {
  const auto refuse = [](const char* name, const std::string& what) { throw InvalidInput(name, what); };
  if (options.analysis.max_block_size < 1) refuse("max_block_size", "must be at least 1");
  if (options.analysis.leaf_size < 1) refuse("leaf_size", "must be at least 1");
  if (options.analysis.separator_trials < 1) refuse("separator_trials", "must be at least 1");
  if (options.analysis.separator_refinement < 1) refuse("separator_refinement", "must be at least 1");
  if (!(options.analysis.dense_row > 0)) refuse("dense_row", "must be positive");
  for (const auto& [name, threads] :
       {std::pair{"threads", options.threads}, {"analysis.threads", options.analysis.threads}}) {
    if (threads < 0) refuse(name, "must not be negative");
    if (threads > kMostThreads) refuse(name, "must be at most " + std::to_string(kMostThreads));
  }
  if (!(options.factor.pivot_tolerance >= 0 && options.factor.pivot_tolerance < 1)) {
    refuse("pivot_tolerance", "must be in [0, 1)");
  }
  if (options.memory_limit < 0) refuse("memory_limit", "must not be negative");
  if (options.factor.max_reanalyses < 0) refuse("max_reanalyses", "must not be negative");
  if (!(options.solve.tolerance >= 0)) refuse("tolerance", "must not be negative");
  if (!(options.solve.row_floor >= 0 && options.solve.row_floor <= 1))
    refuse("row_floor", "must be in [0, 1]");
  if (options.solve.max_refinement_steps < 0) refuse("max_refinement_steps", "must not be negative");
  rules_of(options.backend).check(options);
}

int threads_of(const Options& options) {
  if (rules_of(options.backend).one_thread()) return 1;
  return options.threads ? options.threads : default_threads();
}

int analysis_threads_of(const Options& options) {
  const bool own = options.analysis.threads > 0 && !rules_of(options.backend).one_thread();
  return own ? options.analysis.threads : threads_of(options);
}

}  // namespace mfs
