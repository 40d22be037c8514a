// What a run took: for people, a table like Table 5 of Jung and Bae (Multibody System Dynamics 2017); for
// other programs, a JSON object.
#pragma once

#include <string>
#include <vector>

#include <mfs/options.hpp>

#include "dae/integrator/integrator.hpp"
#include "parts/exit_code.hpp"

namespace mfs::dae {

struct RunResult {
  std::string model;
  Backend backend = Backend::openmp;
  int threads = 0;  ///< as asked for; 0: all
  IntegrationReport report;
  double time_model = 0;    ///< s: reading the file, meshes, putting the system together
  double time_output = 0;   ///< s: results and files, by a thread beside the analysis
  double time_waiting = 0;  ///< s: that the run waited for that
  std::vector<std::string> notes;
  std::int64_t bytes_peak = 0;  ///< of the whole process on the host, the most so far
  std::string status = program::status_word(program::ExitCode::solved);
  std::string message;
};

/// A few lines.
std::string run_summary(const RunResult& result);

/// One line: name, backend, threads, coordinates, constraints, unknowns, entries, redundant (names), steps,
/// error_rejections, newton_rejections, solver_rejections, newton_iterations, jacobians, factorizations,
/// analyses, krylov_solves, violation (of positions, velocities, accelerations), bytes_solver,
/// bytes_peak, time_model, time_reordering, time_factor, time_solve, time_assembly, time_rest, time_total,
/// time_output, time_waiting, notes, status, message.
std::string run_json(const RunResult& result);

/// Of this process, bytes.
std::int64_t peak_memory();

}  // namespace mfs::dae
