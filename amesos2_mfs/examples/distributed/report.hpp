// What mfs_distributed prints: a table for people, one JSON line per solver for scripts.
#pragma once

#include <ostream>

#include "problem.hpp"
#include "solve.hpp"

namespace distributed {

void print_heading(std::ostream& out, const Problem& problem);
void print_table(std::ostream& out, const Measured& measured);
void print_json(std::ostream& out, const Problem& problem, const Measured& measured);

}  // namespace distributed
