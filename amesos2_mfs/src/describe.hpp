// What Amesos2's description() and describe() say.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include <Teuchos_Describable.hpp>
#include <Teuchos_ParameterList.hpp>

#include "rooted_solver.hpp"

namespace mfs::amesos2 {

/// One line: "MFS solver interface: 1448 unknowns, factored".
std::string description(std::int64_t unknowns, const RootedSolver& solver);

/// Several lines, more with each level.
void describe(std::ostream& out, Teuchos::EVerbosityLevel level, const std::string& title,
              const RootedSolver& solver, const Teuchos::ParameterList& parameters);

}  // namespace mfs::amesos2
