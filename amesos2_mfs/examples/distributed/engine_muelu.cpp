// MueLu's multigrid with a solver of Amesos2 on the coarsest grid.
#include <MueLu_MFS.hpp>

#include <MueLu_CreateTpetraPreconditioner.hpp>

#include "engine.hpp"

namespace distributed {
namespace {

class MueLuEngine : public Engine {
 public:
  MueLuEngine(const Problem& problem, const Teuchos::ParameterList& list)
      : matrix_(problem.a), parameters_(list) {
    parameters_.set("number of equations", problem.unknowns_per_node);
    Teuchos::ParameterList& known = parameters_.sublist("user data");
    if (!problem.coordinates.is_null()) known.set("Coordinates", problem.coordinates);
    if (!problem.null_space.is_null()) known.set("Nullspace", problem.null_space);
  }

  /// What a second call keeps is MueLu's "reuse: type"; the coarse solver is always a new one.
  void compute() override {
    if (!preconditioner_.is_null()) {
      MueLu::ReuseTpetraPreconditioner(matrix_, *preconditioner_);
      return;
    }
    Teuchos::ParameterList parameters(parameters_);
    preconditioner_ = MueLu::CreateTpetraPreconditioner(RCP<Operator>(matrix_), parameters);
  }

  RCP<const Operator> preconditioner() const override { return preconditioner_; }

 private:
  RCP<Matrix> matrix_;
  Teuchos::ParameterList parameters_;
  RCP<MueLu::TpetraOperator<double, LocalOrdinal, GlobalOrdinal, Node>> preconditioner_;
};

}  // namespace

std::unique_ptr<Engine> make_muelu(const Problem& problem, const Teuchos::ParameterList& list) {
  return std::make_unique<MueLuEngine>(problem, list);
}

}  // namespace distributed
