// FROSch: overlapping Schwarz methods of one level, and of two with the coarse spaces GDSW and RGDSW. Solvers
// of Amesos2 are asked for in three places: the subdomains, the extensions of the coarse basis into them, and
// the coarse problem.
#include <Amesos2_MFS.hpp>

#include <iostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <vector>

// FROSch's headers come without those that they need.
#include <Xpetra_CrsGraphFactory.hpp>
#include <Xpetra_CrsMatrixWrap.hpp>
#include <Xpetra_ExportFactory.hpp>
#include <Xpetra_ImportFactory.hpp>
#include <Xpetra_MapFactory.hpp>
#include <Xpetra_MatrixFactory.hpp>
#include <Xpetra_MatrixMatrix.hpp>
#include <Xpetra_MultiVectorFactory.hpp>
#include <Xpetra_TpetraCrsMatrix.hpp>
#include <Xpetra_TpetraMultiVector.hpp>
#include <Xpetra_TripleMatrixMultiply.hpp>
#include <Xpetra_VectorFactory.hpp>

#include <FROSch_Tools_def.hpp>  // before the others of FROSch

#include <FROSch_SchwarzPreconditioners_fwd.hpp>

#include <FROSch_OneLevelPreconditioner_def.hpp>
#include <FROSch_TwoLevelPreconditioner_def.hpp>

#include <Teuchos_CommHelpers.hpp>

#include "engine.hpp"

namespace distributed {
namespace {

using Preconditioner = FROSch::SchwarzPreconditioner<double, LocalOrdinal, GlobalOrdinal, Node>;
using OneLevel = FROSch::OneLevelPreconditioner<double, LocalOrdinal, GlobalOrdinal, Node>;
using TwoLevel = FROSch::TwoLevelPreconditioner<double, LocalOrdinal, GlobalOrdinal, Node>;
using XpetraVector = Xpetra::TpetraMultiVector<double, LocalOrdinal, GlobalOrdinal, Node>;
using XpetraVectorBase = Xpetra::MultiVector<double, LocalOrdinal, GlobalOrdinal, Node>;

/// FROSch's operator on Xpetra's vectors as one on Tpetra's.
class OnTpetra : public Operator {
 public:
  OnTpetra(RCP<Preconditioner> inner, RCP<const Map> map) : inner_(std::move(inner)), map_(std::move(map)) {}
  RCP<const Map> getDomainMap() const override { return map_; }
  RCP<const Map> getRangeMap() const override { return map_; }
  void apply(const Vector& x, Vector& y, Teuchos::ETransp mode, double alpha, double beta) const override {
    const XpetraVector from(Teuchos::rcpFromRef(const_cast<Vector&>(x)));
    XpetraVector to(Teuchos::rcpFromRef(y));
    inner_->apply(from, to, mode, alpha, beta);
  }

 private:
  RCP<Preconditioner> inner_;
  RCP<const Map> map_;
};

/// FROSch prints to std::cout whatever its parameters say.
class Silence {
 public:
  explicit Silence(bool silent) : out_(std::cout.rdbuf()) {
    if (silent) std::cout.rdbuf(nowhere_.rdbuf());
  }
  ~Silence() { std::cout.rdbuf(out_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  std::ostringstream nowhere_;
  std::streambuf* out_;
};

/// For each of the `given` parameters, "A -> B" and whether somebody has read it in `list`, where FROSch adds
/// its own. Not those of Amesos2, which reads copies and refuses unknown names itself.
void collect_use(const Teuchos::ParameterList& given, const Teuchos::ParameterList& list,
                 const std::string& path, std::vector<std::string>& names, std::vector<int>& used) {
  for (auto entry = given.begin(); entry != given.end(); ++entry) {
    const std::string& name = given.name(entry);
    if (name == "Amesos2") continue;
    if (given.entry(entry).isList()) {
      collect_use(given.sublist(name), list.sublist(name), path + name + " -> ", names, used);
    } else {
      names.push_back(path + name);
      used.push_back(list.getEntry(name).isUsed() ? 1 : 0);
    }
  }
}

/// The non-overlapping subdomains with their interface, which both neighbours have: this rank's unknowns, and
/// those of the nodes next to them that belong to a lower rank. FROSch makes the same from the graph, but
/// leaves nodes incomplete where only some of their unknowns are fixed.
RCP<const Xpetra::Map<LocalOrdinal, GlobalOrdinal, Node>> repeated_map(const Matrix& a, int per_node) {
  const RCP<const Map> columns = a.getColMap(), rows = a.getRowMap();
  std::set<GlobalOrdinal> nodes;
  for (std::size_t k = 0; k < columns->getMyGlobalIndices().extent(0); ++k)
    nodes.insert(columns->getGlobalElement(static_cast<LocalOrdinal>(k)) / per_node);
  Teuchos::Array<GlobalOrdinal> near, repeated;
  for (const GlobalOrdinal node : nodes)
    for (int i = 0; i < per_node; ++i) near.push_back(node * per_node + i);
  Teuchos::Array<int> owners(near.size());
  rows->getRemoteIndexList(near(), owners());
  for (Teuchos_Ordinal k = 0; k < near.size(); ++k)
    if (owners[k] <= rows->getComm()->getRank()) repeated.push_back(near[k]);
  const auto invalid = Teuchos::OrdinalTraits<Xpetra::global_size_t>::invalid();
  return Xpetra::MapFactory<LocalOrdinal, GlobalOrdinal, Node>::Build(Xpetra::UseTpetra, invalid, repeated(),
                                                                      0, rows->getComm());
}

class FroschEngine : public Engine {
 public:
  FroschEngine(const Problem& problem, const Teuchos::ParameterList& list, bool verbose)
      : tpetra_matrix_(problem.a),
        map_(problem.a->getDomainMap()),
        given_(list),
        list_(rcp(new Teuchos::ParameterList(list))),
        verbose_(verbose) {
    using Crs = Xpetra::TpetraCrsMatrix<double, LocalOrdinal, GlobalOrdinal, Node>;
    using Wrap = Xpetra::CrsMatrixWrap<double, LocalOrdinal, GlobalOrdinal, Node>;
    const RCP<Xpetra::CrsMatrix<double, LocalOrdinal, GlobalOrdinal, Node>> crs = rcp(new Crs(problem.a));
    matrix_ = rcp(new Wrap(crs));
    unknowns_per_node_ = problem.unknowns_per_node;
    if (!problem.coordinates.is_null()) coordinates_ = rcp(new XpetraVector(problem.coordinates));
    if (!problem.null_space.is_null()) null_space_ = rcp(new XpetraVector(problem.null_space));
  }

  void compute() override {
    const Silence silence(!verbose_);
    if (preconditioner_.is_null()) make();
    preconditioner_->compute();
  }

  /// FROSch takes no offence at a name that it does not know. The coarse solver's are read on its ranks only.
  void refuse_unread() const override {
    std::vector<std::string> names;
    std::vector<int> used;
    collect_use(given_, *list_, "", names, used);
    std::vector<int> used_anywhere(used.size());
    Teuchos::reduceAll(*map_->getComm(), Teuchos::REDUCE_MAX, static_cast<int>(used.size()), used.data(),
                       used_anywhere.data());
    std::string unread;
    for (std::size_t k = 0; k < names.size(); ++k)
      if (!used_anywhere[k]) unread += (unread.empty() ? "" : "; ") + names[k];
    if (!unread.empty()) throw std::invalid_argument("FROSch: parameters that nobody has read: " + unread);
  }

  RCP<const Operator> preconditioner() const override { return rcp(new OnTpetra(preconditioner_, map_)); }

 private:
  void make() {
    const std::string type = list_->get<std::string>("FROSch Preconditioner Type");
    const int overlap = list_->get<int>("Overlap");
    if (type == "OneLevelPreconditioner") {
      const auto one = rcp(new OneLevel(matrix_, list_));
      one->initialize(overlap, false);
      preconditioner_ = one;
    } else if (type == "TwoLevelPreconditioner") {
      const auto two = rcp(new TwoLevel(matrix_, list_));
      two->initialize(3u, static_cast<unsigned>(unknowns_per_node_), overlap, null_space_, coordinates_,
                      FROSch::NodeWise, repeated_map(*tpetra_matrix_, unknowns_per_node_), Teuchos::null,
                      Teuchos::null);
      preconditioner_ = two;
    } else {
      throw std::invalid_argument("FROSch Preconditioner Type: " + type);
    }
  }

  RCP<const Matrix> tpetra_matrix_;
  RCP<const Map> map_;
  Teuchos::ParameterList given_;
  RCP<Teuchos::ParameterList> list_;
  bool verbose_;
  RCP<const Xpetra::Matrix<double, LocalOrdinal, GlobalOrdinal, Node>> matrix_;
  int unknowns_per_node_ = 1;
  RCP<const XpetraVectorBase> coordinates_, null_space_;
  RCP<Preconditioner> preconditioner_;
};

}  // namespace

std::unique_ptr<Engine> make_frosch(const Problem& problem, const Teuchos::ParameterList& list,
                                    bool verbose) {
  return std::make_unique<FroschEngine>(problem, list, verbose);
}

}  // namespace distributed
