#include "solver/orthogonal_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <Eigen/SparseQR>

namespace mfs {

namespace {

/// Ten seconds of SparseQR at most.
constexpr double kMostOperations = 1e10, kMostBytes = 1e9;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Wide>
using Sparse = Eigen::SparseMatrix<Wide>;
using Permutation = Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int>;
template <class Wide>
using Vector = Eigen::Matrix<Wide, Eigen::Dynamic, 1>;
using RealVector = Eigen::VectorXd;

using Order = std::vector<Vertex>;  // by position

/// As in kernels/stages/residual.hpp, which this file can do without Kokkos: nvcc does not compile Eigen.
double row_error(double off, double size) {
  const double ratio = off == 0 ? 0 : std::isfinite(size) ? off / size : kInfinity;
  return ratio <= 1e300 ? ratio : kInfinity;
}

/// Whose column k has its one in the row order[k].
Permutation permutation(const Order& order) {
  Permutation result(static_cast<Eigen::Index>(order.size()));
  std::copy(order.begin(), order.end(), result.indices().data());
  return result;
}

/// Columns and rows in which a matrix is factored, and what that takes; infinite where a column has no row
/// left.
struct Plan {
  Order columns, rows;
  double operations = 0, bytes = 0;

  bool exceeds(double most_operations, double room) const {
    return operations > most_operations || bytes > room;
  }
};

/// Rows by their first column, merged as reflections fill them in (George and Heath, Linear Algebra Appl. 34,
/// 1980): in each column the rows that meet there take the columns of all, one of them stays, the others go
/// on. `a` has its columns in the order of the plan. Ends early where it costs more than may be.
template <class Wide>
Plan plan_for(const Eigen::SparseMatrix<Wide, Eigen::RowMajor>& a, Order columns, double most_operations,
              double room) {
  const auto n = static_cast<Vertex>(a.rows());
  constexpr double kEntry = sizeof(Wide) + sizeof(int);
  const auto row = [&](Vertex i) {
    return std::make_pair(a.innerIndexPtr() + a.outerIndexPtr()[i],
                          a.innerIndexPtr() + a.outerIndexPtr()[i + 1]);
  };
  std::vector<std::vector<Vertex>> meeting(n), width_of(n), children(n);
  for (Vertex i = 0; i < n; ++i) {
    if (row(i).first != row(i).second) meeting[*row(i).first].push_back(i);
  }
  Plan plan;
  plan.columns = std::move(columns);
  Order seen_by(n, -1);
  for (Vertex k = 0; k < n; ++k) {
    std::vector<Vertex>&rows = meeting[k], &held = width_of[k];
    Vertex next = n;
    const auto take = [&](Vertex column) {
      if (column < k || seen_by[column] == k) return;
      seen_by[column] = k;
      held.push_back(column);
      if (column > k) next = std::min(next, column);
    };
    for (const Vertex i : rows) {
      if (*row(i).first == k) std::for_each(row(i).first, row(i).second, take);
    }
    for (const Vertex child : children[k]) {
      std::for_each(width_of[child].begin(), width_of[child].end(), take);
      width_of[child] = {};
    }
    if (rows.empty()) plan.operations = kInfinity;
    const auto met = static_cast<double>(rows.size()), width = static_cast<double>(held.size());
    plan.operations += 4 * met * width;
    plan.bytes += kEntry * (met + width);
    if (plan.exceeds(most_operations, room)) return plan;
    plan.rows.push_back(rows.back());
    rows.pop_back();
    if (next == n) continue;
    if (!rows.empty()) children[next].push_back(k);
    meeting[next].insert(meeting[next].end(), rows.begin(), rows.end());
    rows = {};
  }
  return plan;
}

}  // namespace

template <class Scalar>
struct OrthogonalSolver<Scalar>::Parts {
  using Wide = WideOf<Scalar>;

  Parts(const CsrView<Scalar>& a, bool transposed, const MatchedScaling& scaling) {
    const auto n = static_cast<Eigen::Index>(a.rows);
    std::vector<Eigen::Triplet<Wide>> entries;
    entries.reserve(static_cast<std::size_t>(a.row_offsets[a.rows]));
    for (Vertex i = 0; i < n; ++i) {
      for (Offset k = a.row_offsets[i]; k < a.row_offsets[i + 1]; ++k) {
        const auto j = static_cast<Vertex>(a.column_indices[k]);
        entries.emplace_back(transposed ? j : i, transposed ? i : j, Wide(a.values[k]));
      }
    }
    matrix.resize(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    row_scale =
        Eigen::Map<const RealVector>((transposed ? scaling.column_scale : scaling.row_scale).data(), n);
    column_scale =
        Eigen::Map<const RealVector>((transposed ? scaling.row_scale : scaling.column_scale).data(), n);
  }

  /// Scaled, with its columns in that order, and its rows where there is one for them.
  Sparse<Wide> ordered(const Order& column_order, const Order& row_order) const {
    Sparse<Wide> scaled = row_scale.asDiagonal() * matrix * column_scale.asDiagonal();
    scaled = scaled * permutation(column_order);
    if (!row_order.empty()) scaled = permutation(row_order).transpose() * scaled;
    scaled.makeCompressed();
    return scaled;
  }
  Order by_colamd() const {
    Sparse<Wide> of_columns(matrix);
    of_columns.makeCompressed();
    Permutation found;
    Eigen::COLAMDOrdering<int>()(of_columns, found);
    Order order(static_cast<std::size_t>(matrix.rows()));
    for (Vertex j = 0; j < matrix.rows(); ++j) order[found.indices()[j]] = j;
    return order;
  }

  Vector<Wide> corrected(const Vector<Wide>& residual) const {
    const Vector<Wide> scaled = permutation(plan.rows).transpose() * (row_scale.asDiagonal() * residual);
    const Vector<Wide> found = factors.solve(scaled);
    return column_scale.asDiagonal() * (permutation(plan.columns) * found);
  }
  // No pivot is called small: the probe tells, by a right-hand side that is as good as random. Where A is
  // singular its solution z has a small |A z|.
  void factor() {
    factors.setPivotThreshold(0);
    factors.compute(ordered(plan.columns, plan.rows));
    std::mt19937 random;
    Vector<Wide> b(matrix.rows());
    for (Wide& entry : b) entry = static_cast<double>(random()) / static_cast<double>(random.max()) - 0.5;
    const Vector<Wide> z = corrected(row_scale.cwiseInverse().asDiagonal() * b);
    const double product = (row_scale.asDiagonal() * (matrix * z)).norm(),
                 size = (row_scale.asDiagonal() * sizes(z)).norm();
    smallness = product / size;
    column_scale.cwiseInverse().cwiseProduct(z.cwiseAbs()).maxCoeff(&dependent_column);
  }
  RealVector sizes(const Vector<Wide>& x) const { return matrix.cwiseAbs() * x.cwiseAbs(); }

  Eigen::SparseMatrix<Wide, Eigen::RowMajor> matrix;
  RealVector row_scale, column_scale;
  Plan plan;
  double smallness = 0;  // |A z| / | |A||z| | in scaled rows for some z
  Vertex dependent_column = -1;
  Eigen::SparseQR<Sparse<Wide>, Eigen::NaturalOrdering<int>> factors;
};

template <class Scalar>
OrthogonalSolver<Scalar>::OrthogonalSolver(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

template <class Scalar>
OrthogonalSolver<Scalar>::~OrthogonalSolver() = default;

template <class Scalar>
std::unique_ptr<OrthogonalSolver<Scalar>> OrthogonalSolver<Scalar>::make(const CsrView<Scalar>& a,
                                                                         bool transposed,
                                                                         const MatchedScaling& scaling,
                                                                         const std::vector<Vertex>& order,
                                                                         double room) {
  using Wide = WideOf<Scalar>;
  constexpr double kCopies = 8;  // of the matrix, at most, while it is ordered
  room = std::min(room, kMostBytes);
  room -= kCopies * static_cast<double>(a.row_offsets[a.rows]) * (sizeof(Wide) + sizeof(int));
  if (room <= 0) return nullptr;
  auto parts = std::make_unique<Parts>(a, transposed, scaling);
  double most = kMostOperations;
  for (const Order& columns : {order, parts->by_colamd()}) {
    Plan plan = plan_for<Wide>(parts->ordered(columns, {}), columns, most, room);
    if (plan.exceeds(most, room)) continue;
    most = plan.operations;
    parts->plan = std::move(plan);
  }
  if (parts->plan.columns.empty()) return nullptr;
  parts->factor();
  return std::unique_ptr<OrthogonalSolver>(new OrthogonalSolver(std::move(parts)));
}

template <class Scalar>
double OrthogonalSolver<Scalar>::smallness() const {
  return parts_->smallness;
}

template <class Scalar>
Vertex OrthogonalSolver<Scalar>::dependent_column() const {
  return parts_->dependent_column;
}

template <class Scalar>
SolveOutcome OrthogonalSolver<Scalar>::solve(const Scalar* b, Scalar* x,
                                             const SolveControls& controls) const {
  using Wide = WideOf<Scalar>;
  const Eigen::Index n = parts_->matrix.rows();
  const Vector<Wide> rhs = Eigen::Map<const Vector<Scalar>>(b, n).template cast<Wide>();
  Vector<Wide> found = Vector<Wide>::Zero(n), best = found, residual = rhs;
  SolveOutcome outcome;
  outcome.backward_error = kInfinity;
  for (int step = 0; step <= controls.max_steps && outcome.backward_error > controls.tolerance; ++step) {
    found += parts_->corrected(residual);
    const Vector<Scalar> rounded = found.template cast<Scalar>();
    found = rounded.template cast<Wide>();  // two casts in one expression leave complex numbers as they were
    const RealVector sizes = parts_->sizes(found) + rhs.cwiseAbs();
    residual = rhs - parts_->matrix * found;
    double error = 0;
    for (Eigen::Index i = 0; i < n; ++i) error = std::max(error, row_error(std::abs(residual[i]), sizes[i]));
    if (!(error < outcome.backward_error)) break;
    outcome.backward_error = error;
    outcome.refinement_steps = step;
    best = found;
  }
  Eigen::Map<Vector<Scalar>>(x, n) = best.template cast<Scalar>();
  return outcome;
}

template class OrthogonalSolver<float>;
template class OrthogonalSolver<double>;
template class OrthogonalSolver<std::complex<float>>;
template class OrthogonalSolver<std::complex<double>>;

}  // namespace mfs
