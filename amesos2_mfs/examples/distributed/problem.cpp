#include "problem.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <MatrixMarket_Tpetra.hpp>

namespace distributed {
namespace {

constexpr int kCorners = 8;

/// The matrix of one element as m * stiffness + coupling + compressibility / m for a medium of modulus m.
/// Unknowns are numbered node by node.
struct Element {
  int unknowns = 3;  ///< per node
  std::vector<double> stiffness, coupling, compressibility;

  explicit Element(int unknowns_per_node)
      : unknowns(unknowns_per_node),
        stiffness(kCorners * kCorners * unknowns * unknowns),
        coupling(stiffness.size()),
        compressibility(stiffness.size()) {}
  std::size_t place(int a, int i, int b, int j) const {
    return static_cast<std::size_t>(((a * unknowns + i) * kCorners + b) * unknowns + j);
  }
  double value(std::size_t k, double modulus) const {
    return modulus * stiffness[k] + coupling[k] + compressibility[k] / modulus;
  }
};

/// Values and gradients of the trilinear shape functions in one of the 2 * 2 * 2 Gauss points.
struct Shapes {
  double value[kCorners], gradient[kCorners][3], weight;

  Shapes(int point, double h) : weight(h * h * h / 8) {
    const double gauss = 1 / std::sqrt(3.0);
    for (int a = 0; a < kCorners; ++a) {
      double factor[3], slope[3];
      for (int c = 0; c < 3; ++c) {
        const double sign = a >> c & 1 ? 1 : -1, place = point >> c & 1 ? gauss : -gauss;
        factor[c] = (1 + sign * place) / 2;
        slope[c] = sign / h;
      }
      value[a] = factor[0] * factor[1] * factor[2];
      for (int c = 0; c < 3; ++c) gradient[a][c] = slope[c] * factor[(c + 1) % 3] * factor[(c + 2) % 3];
    }
  }
};

/// Adds the elastic energy of Lame's constants to the first three unknowns of each node.
void add_stiffness(Element& element, const Shapes& s, double lambda, double mu) {
  for (int a = 0; a < kCorners; ++a)
    for (int b = 0; b < kCorners; ++b) {
      const double *ga = s.gradient[a], *gb = s.gradient[b];
      const double dot = ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          element.stiffness[element.place(a, i, b, j)] +=
              s.weight * (lambda * ga[i] * gb[j] + mu * (ga[j] * gb[i] + (i == j ? dot : 0)));
    }
}

Element elastic_element(double h) {
  Element element(3);
  const double modulus = 1, poisson = 0.3;
  for (int point = 0; point < kCorners; ++point)
    add_stiffness(element, Shapes(point, h), modulus * poisson / ((1 + poisson) * (1 - 2 * poisson)),
                  modulus / (2 * (1 + poisson)));
  return element;
}

Element stokes_element(double h) {
  Element element(4);
  constexpr int pressure = 3;
  for (int point = 0; point < kCorners; ++point) {
    const Shapes s(point, h);
    add_stiffness(element, s, 0, 1);
    for (int a = 0; a < kCorners; ++a)
      for (int b = 0; b < kCorners; ++b) {
        for (int i = 0; i < 3; ++i) {
          element.coupling[element.place(a, i, b, pressure)] -= s.weight * s.gradient[a][i] * s.value[b];
          element.coupling[element.place(b, pressure, a, i)] -= s.weight * s.gradient[a][i] * s.value[b];
        }
        const double mean = 1.0 / kCorners;  // of every shape function
        element.compressibility[element.place(a, pressure, b, pressure)] -=
            s.weight * (s.value[a] - mean) * (s.value[b] - mean);
      }
  }
  return element;
}

/// The nodes of one rank: a brick [first, last) of the body's.
class Brick {
 public:
  Brick(const Comm& comm, const Counts& nodes) : nodes_(nodes) {
    const Counts ranks = divide_ranks(comm.getSize());
    GlobalOrdinal rank = comm.getRank();
    for (int c = 0; c < 3; ++c) {
      if (nodes[c] < std::max<GlobalOrdinal>(2, ranks[c]))
        throw std::invalid_argument(std::to_string(nodes[c]) + " nodes in direction " + "xyz"[c] + " for " +
                                    std::to_string(ranks[c]) + " ranks");
      const GlobalOrdinal place = rank % ranks[c];
      rank /= ranks[c];
      first_[c] = nodes[c] * place / ranks[c];
      last_[c] = nodes[c] * (place + 1) / ranks[c];
    }
  }

  double element_size() const {
    return 1.0 / static_cast<double>(*std::max_element(nodes_.begin(), nodes_.end()) - 1);
  }
  GlobalOrdinal id(GlobalOrdinal x, GlobalOrdinal y, GlobalOrdinal z) const {
    return (z * nodes_[1] + y) * nodes_[0] + x;
  }
  bool clamped(GlobalOrdinal node) const { return node % nodes_[0] == 0; }
  std::array<double, 3> coordinates(GlobalOrdinal node) const {
    const GlobalOrdinal x = node % nodes_[0], y = node / nodes_[0] % nodes_[1],
                        z = node / (nodes_[0] * nodes_[1]);
    const double h = element_size();
    return {static_cast<double>(x) * h, static_cast<double>(y) * h, static_cast<double>(z) * h};
  }
  std::vector<GlobalOrdinal> own_nodes() const {
    std::vector<GlobalOrdinal> own;
    for (GlobalOrdinal z = first_[2]; z < last_[2]; ++z)
      for (GlobalOrdinal y = first_[1]; y < last_[1]; ++y)
        for (GlobalOrdinal x = first_[0]; x < last_[0]; ++x) own.push_back(id(x, y, z));
    return own;
  }
  /// visit(ids of the corners, x + y + z of the first) for each element with a node of this rank.
  template <class Visit>
  void each_element(const Visit& visit) const {
    const auto first = [&](int c) { return std::max<GlobalOrdinal>(first_[c] - 1, 0); };
    const auto last = [&](int c) { return std::min(last_[c], nodes_[c] - 1); };
    for (GlobalOrdinal z = first(2); z < last(2); ++z)
      for (GlobalOrdinal y = first(1); y < last(1); ++y)
        for (GlobalOrdinal x = first(0); x < last(0); ++x) {
          std::array<GlobalOrdinal, kCorners> corners;
          for (int a = 0; a < kCorners; ++a) corners[a] = id(x + (a & 1), y + (a >> 1 & 1), z + (a >> 2));
          visit(corners, x + y + z);
        }
  }

 private:
  Counts nodes_, first_, last_;
};

/// A body made of one kind of element.
class Body {
 public:
  Body(const RCP<const Comm>& comm, const Counts& nodes, Element (*element)(double h))
      : brick_(*comm, nodes), element_(element(brick_.element_size())), own_(brick_.own_nodes()) {
    const int unknowns = element_.unknowns;
    std::vector<GlobalOrdinal> rows;
    for (const GlobalOrdinal node : own_)
      for (int i = 0; i < unknowns; ++i) rows.push_back(node * unknowns + i);
    const auto invalid = Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid();
    node_map_ = rcp(new Map(invalid, Teuchos::arrayViewFromVector(own_), 0, comm));
    row_map_ = rcp(new Map(invalid, Teuchos::arrayViewFromVector(rows), 0, comm));
    a_ = rcp(new Matrix(row_map_, static_cast<std::size_t>(27 * unknowns)));
  }

  RCP<Matrix> matrix() const { return a_; }
  int unknowns_per_node() const { return element_.unknowns; }

  /// Elements of odd x + y + z are stiffer by half of the step.
  void assemble(int step) {
    const bool first = !a_->isFillComplete();
    if (!first) {
      a_->resumeFill();
      a_->setAllToScalar(0.0);
    }
    brick_.each_element([&](const auto& corners, GlobalOrdinal place) {
      add_element(corners, 1.0 + (place % 2 == 1 ? 0.5 * step : 0.0), first);
    });
    for (const GlobalOrdinal node : own_)
      for (int i = 0; i < element_.unknowns; ++i)
        if (fixed(node, i)) add(node * element_.unknowns + i, {node * element_.unknowns + i}, {1.0}, first);
    a_->fillComplete();
  }

  /// Downwards in z on every node that is free.
  RCP<Vector> weight() const {
    const auto b = rcp(new Vector(row_map_, 1));
    for (const GlobalOrdinal node : own_)
      if (!fixed(node, 2)) b->replaceGlobalValue(node * element_.unknowns + 2, 0, -1e-4);
    return b;
  }

  RCP<Vector> coordinates() const {
    const auto all = rcp(new Vector(node_map_, 3));
    for (const GlobalOrdinal node : own_)
      for (std::size_t c = 0; c < 3; ++c) all->replaceGlobalValue(node, c, brick_.coordinates(node)[c]);
    return all;
  }

  /// A constant in each unknown, and the rotations where there are displacements only. (With velocity and
  /// pressure they can make RGDSW's coarse matrix singular.)
  RCP<Vector> null_space() const {
    const int unknowns = element_.unknowns, rotations = unknowns == 3 ? 3 : 0;
    const auto modes = rcp(new Vector(row_map_, static_cast<std::size_t>(unknowns + rotations)));
    for (const GlobalOrdinal node : own_) {
      const auto x = brick_.coordinates(node);
      const auto set = [&](int i, int mode, double value) {
        modes->replaceGlobalValue(node * unknowns + i, static_cast<std::size_t>(mode), value);
      };
      for (int i = 0; i < unknowns; ++i) set(i, i, 1.0);
      for (int c = 0; c < rotations; ++c) {
        const int d = (c + 1) % 3, e = (c + 2) % 3;
        set(d, unknowns + c, -x[e]);
        set(e, unknowns + c, x[d]);
      }
    }
    return modes;
  }

 private:
  using Ids = std::vector<GlobalOrdinal>;
  using Values = std::vector<double>;

  bool fixed(GlobalOrdinal node, int unknown) const { return unknown < 3 && brick_.clamped(node); }

  void add(GlobalOrdinal row, const Ids& columns, const Values& values, bool first) {
    const auto c = Teuchos::arrayViewFromVector(columns);
    const auto v = Teuchos::arrayViewFromVector(values);
    if (first)
      a_->insertGlobalValues(row, c, v);
    else
      a_->sumIntoGlobalValues(row, c, v);
  }

  /// Rows of this rank's nodes only; what is fixed has neither row nor column.
  void add_element(const std::array<GlobalOrdinal, kCorners>& corners, double modulus, bool first) {
    const int unknowns = element_.unknowns;
    for (int a = 0; a < kCorners; ++a) {
      if (!node_map_->isNodeGlobalElement(corners[a])) continue;
      for (int i = 0; i < unknowns; ++i) {
        if (fixed(corners[a], i)) continue;
        Ids columns;
        Values values;
        for (int b = 0; b < kCorners; ++b)
          for (int j = 0; j < unknowns; ++j) {
            if (fixed(corners[b], j)) continue;
            columns.push_back(corners[b] * unknowns + j);
            values.push_back(element_.value(element_.place(a, i, b, j), modulus));
          }
        add(corners[a] * unknowns + i, columns, values, first);
      }
    }
  }

  Brick brick_;
  Element element_;
  std::vector<GlobalOrdinal> own_;
  RCP<const Map> node_map_, row_map_;
  RCP<Matrix> a_;
};

Problem body_problem(const std::string& name, const RCP<const Comm>& comm, const Counts& nodes,
                     Element (*element)(double h)) {
  const auto body = std::make_shared<Body>(comm, nodes, element);
  body->assemble(0);
  Problem problem;
  problem.name = name;
  problem.unknowns_per_node = body->unknowns_per_node();
  problem.a = body->matrix();
  problem.b = body->weight();
  problem.coordinates = body->coordinates();
  problem.null_space = body->null_space();
  problem.set_values = [body](int step) { body->assemble(step); };
  return problem;
}

}  // namespace

Counts divide_ranks(int ranks) {
  Counts best{1, 1, ranks};
  for (GlobalOrdinal x = 1; x * x * x <= ranks; ++x)
    for (GlobalOrdinal y = x; x * y * y <= ranks; ++y)
      if (ranks % (x * y) == 0 && ranks / (x * y) - x < best[2] - best[0]) best = {x, y, ranks / (x * y)};
  return best;
}

Problem elasticity(const RCP<const Comm>& comm, const Counts& nodes) {
  return body_problem("elasticity", comm, nodes, elastic_element);
}

Problem stokes(const RCP<const Comm>& comm, const Counts& nodes) {
  return body_problem("stokes", comm, nodes, stokes_element);
}

Problem from_file(const RCP<const Comm>& comm, const std::string& path) {
  Problem problem;
  problem.name = path;
  problem.a = Tpetra::MatrixMarket::Reader<Matrix>::readSparseFile(path, comm);
  problem.b = rcp(new Vector(problem.a->getRangeMap(), 1));
  problem.b->putScalar(1.0);
  const RCP<const Matrix> original = rcp(new Matrix(*problem.a, Teuchos::Copy));
  const RCP<Matrix> a = problem.a;
  problem.set_values = [a, original](int step) {
    Tpetra::Vector<double> diagonal(original->getRowMap());
    original->getLocalDiagCopy(diagonal);
    const auto values = diagonal.getLocalViewHost(Tpetra::Access::ReadOnly);
    a->resumeFill();
    for (std::size_t i = 0; i < values.extent(0); ++i) {
      const GlobalOrdinal id = a->getRowMap()->getGlobalElement(static_cast<LocalOrdinal>(i));
      a->replaceGlobalValues(id, Teuchos::tuple(id), Teuchos::tuple(values(i, 0) * (1 + 0.1 * step)));
    }
    a->fillComplete(original->getDomainMap(), original->getRangeMap());
  };
  return problem;
}

}  // namespace distributed
