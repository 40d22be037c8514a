// Ifpack2's additive Schwarz method (or another of its preconditioners) with a solver of Amesos2.
#include <Amesos2_MFS.hpp>

#include <stdexcept>

#include <Ifpack2_Factory.hpp>

#include <mfs/error.hpp>

#include "engine.hpp"

namespace distributed {
namespace {

class Ifpack2Engine : public Engine {
 public:
  Ifpack2Engine(const Problem& problem, const Teuchos::ParameterList& list)
      : matrix_(problem.a),
        type_(list.get<std::string>("Prec Type")),
        settings_(list.sublist("Ifpack2 Settings")) {}

  /// Ifpack2 copies the subdomain's values when it analyses, so new values need a new analysis; and its
  /// Amesos2 solvers forget their parameters when they are made a second time. So all is made anew.
  void compute() override {
    preconditioner_ = Ifpack2::Factory::create<Tpetra::RowMatrix<double>>(type_, matrix_);
    preconditioner_->setParameters(settings_);
    try {
      preconditioner_->initialize();
      preconditioner_->compute();
    } catch (const mfs::SingularMatrix& e) {
      throw std::runtime_error(e.what() + place(e.row()));
    }
  }

  RCP<const Operator> preconditioner() const override { return preconditioner_; }

 private:
  /// A subdomain counts its rows from 0: first the rank's own, in their order, then those of the overlap.
  std::string place(std::int64_t row) const {
    const auto map = matrix_->getRowMap();
    if (row < 0 || settings_.isParameter("schwarz: use reordering")) return "";
    if (row >= static_cast<std::int64_t>(map->getMyGlobalIndices().extent(0))) return " (in the overlap)";
    return " (global row " + std::to_string(map->getGlobalElement(static_cast<LocalOrdinal>(row))) + ")";
  }

  RCP<const Matrix> matrix_;
  std::string type_;
  Teuchos::ParameterList settings_;
  RCP<Ifpack2::Preconditioner<>> preconditioner_;
};

}  // namespace

std::unique_ptr<Engine> make_ifpack2(const Problem& problem, const Teuchos::ParameterList& list) {
  return std::make_unique<Ifpack2Engine>(problem, list);
}

}  // namespace distributed
