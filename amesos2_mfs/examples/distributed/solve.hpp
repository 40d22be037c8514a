// One preconditioner with one solver inside, measured: set-up, solution, and both again for new values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "all_ranks.hpp"
#include "problem.hpp"
#include "settings.hpp"

namespace distributed {

/// One set-up and solution.
struct Step {
  double setup_s = 0, solve_s = 0;  ///< until the last rank is ready
  int iterations = 0;
  bool converged = false;
  double residual = 0;    ///< |b - A x| / |b|
  double norm = 0;        ///< |x|
  double difference = 0;  ///< |x - y| / |y|, y the direct solution; 0 where that was not asked for
};

/// What MFS did on one rank in all steps, and its memory.
struct RankFigures {
  double rows = 0;
  double analyses = 0, analyses_again = 0;  ///< in the first step, in all later ones
  double factorizations = 0, solves = 0;
  double seconds_analyses = 0, seconds_factorizations = 0, seconds_solves = 0;
  double bytes = 0;          ///< that MFS holds
  double resident_peak = 0;  ///< bytes of the process in the first step; 0 where the system does not tell
};

struct Measured {
  std::string settings, solver;
  std::vector<Step> steps;
  std::vector<RankFigures> ranks;  ///< on rank 0
  bool converged() const;
};

struct Task {
  int new_values = 0;    ///< how often the values change
  bool check = false;    ///< compare with the direct solution
  bool verbose = false;  ///< let the engine print
};

/// Throws on all ranks, or ends all of them (AllRanks), for what the engine throws, and where "MFS" was asked
/// for but nobody made a solver of that name.
Measured measure(const Problem& problem, const Settings& settings, const std::string& solver,
                 const Task& task, const AllRanks& all_ranks);

}  // namespace distributed
