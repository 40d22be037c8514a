// The preconditioners of Trilinos that solve with MFS inside: Ifpack2's Schwarz methods, FROSch, MueLu.
//
// Each is a source file of its own, since their headers take long to compile. The lists are those that
// Stratimikos reads under "Preconditioner Types".
#pragma once

#include <memory>
#include <string>

#include <Teuchos_ParameterList.hpp>

#include "problem.hpp"
#include "types.hpp"

namespace distributed {

class Engine {
 public:
  virtual ~Engine() = default;
  /// Makes the preconditioner of the values that the matrix has now. The first call analyses; each later one
  /// keeps what the engine keeps. Collective; an error may be of one rank only.
  virtual void compute() = 0;
  /// After the first compute(): throws for parameters that nobody has read, where the engine itself lets them
  /// pass. Collective.
  virtual void refuse_unread() const {}
  virtual RCP<const Operator> preconditioner() const = 0;
};

/// `list`: "Prec Type" and "Ifpack2 Settings".
std::unique_ptr<Engine> make_ifpack2(const Problem& problem, const Teuchos::ParameterList& list);
/// `list`: "FROSch Preconditioner Type" (OneLevelPreconditioner, TwoLevelPreconditioner), "Overlap" and the
/// lists of the levels. What FROSch prints is seen where `verbose`.
std::unique_ptr<Engine> make_frosch(const Problem& problem, const Teuchos::ParameterList& list, bool verbose);
std::unique_ptr<Engine> make_muelu(const Problem& problem, const Teuchos::ParameterList& list);

}  // namespace distributed
