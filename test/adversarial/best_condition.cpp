#include "test/adversarial/best_condition.hpp"

#include <algorithm>
#include <cfloat>
#include <cstddef>
#include <utility>

namespace mfs::test {

namespace {

#if LDBL_MANT_DIG == 113  // as on aarch64
using Quad = long double;
#else
__extension__ using Quad = __float128;
#endif
using Matrix = std::vector<std::vector<Quad>>;
using Vector = std::vector<Quad>;

Quad absolute(Quad value) {
  return value < 0 ? -value : value;
}

// row -= factor * other, where other is not zero: the matrices here are sparse.
void subtract(Quad factor, const Vector& other, Vector& row) {
  if (factor == 0) return;
  for (std::size_t j = 0; j < row.size(); ++j) {
    if (other[j] != 0) row[j] -= factor * other[j];
  }
}

Matrix transposed(const Matrix& a) {
  Matrix result(a.size(), Vector(a.size()));
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < a.size(); ++j) result[j][i] = a[i][j];
  }
  return result;
}

// Powers of two near the reciprocals of the square roots of each row's largest entry.
Vector balancing(const Matrix& a) {
  Vector scale;
  for (const Vector& row : a) {
    Quad largest = 0, power = 1;
    for (const Quad value : row) largest = std::max(largest, absolute(value));
    for (; largest > 0 && largest * power * power > 4; power /= 2) {
    }
    for (; largest > 0 && largest * power * power < 1; power *= 2) {
    }
    scale.push_back(power);
  }
  return scale;
}

struct Scaling {
  Vector row, column;
};

// Rows and columns by powers of two until the largest entry of each is about 1 (Ruiz 2001).
Scaling equilibrated(Matrix a) {
  constexpr int kSweeps = 40;
  const std::size_t n = a.size();
  Scaling total{Vector(n, 1), Vector(n, 1)};
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const Vector row = balancing(a), column = balancing(transposed(a));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) a[i][j] *= row[i] * column[j];
      total.row[i] *= row[i];
      total.column[i] *= column[i];
    }
  }
  return total;
}

// Gauss-Jordan elimination with complete pivoting; empty where no pivot is left.
Matrix inverse(Matrix a) {
  const std::size_t n = a.size();
  Matrix result(n, Vector(n, 0));
  for (std::size_t i = 0; i < n; ++i) result[i][i] = 1;
  std::vector<std::size_t> column_at(n);
  for (std::size_t j = 0; j < n; ++j) column_at[j] = j;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t row = k, place = k;
    for (std::size_t i = k; i < n; ++i) {
      for (std::size_t j = k; j < n; ++j) {
        if (absolute(a[i][column_at[j]]) > absolute(a[row][column_at[place]])) {
          row = i;
          place = j;
        }
      }
    }
    std::swap(a[k], a[row]);
    std::swap(result[k], result[row]);
    std::swap(column_at[k], column_at[place]);
    const std::size_t column = column_at[k];
    const Quad pivot = a[k][column];
    if (pivot == 0) return {};
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k || a[i][column] == 0) continue;
      const Quad factor = a[i][column] / pivot;
      subtract(factor, a[k], a[i]);
      subtract(factor, result[k], result[i]);
      a[i][column] = 0;
    }
  }
  Matrix ordered(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Quad pivot = a[k][column_at[k]];
    for (Quad& value : result[k]) value /= pivot;
    ordered[column_at[k]] = std::move(result[k]);
  }
  return ordered;
}

// |matrix| x
Vector multiply_absolute(const Matrix& matrix, const Vector& x) {
  Vector y(matrix.size(), 0);
  for (std::size_t i = 0; i < y.size(); ++i) {
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (matrix[i][j] != 0) y[i] += absolute(matrix[i][j]) * x[j];
    }
  }
  return y;
}

// The x found by power iteration, scaled so that its largest entry is 1, and its condition number.
std::pair<Vector, Quad> best_scaling(const Matrix& a, const Matrix& inverse_of_a) {
  constexpr int kSteps = 60;
  Vector x(a.size(), 1), best = x;
  Quad least = 0;
  for (int step = 0; step < kSteps; ++step) {
    Vector next = multiply_absolute(inverse_of_a, multiply_absolute(a, x));
    Quad condition = 0;
    for (std::size_t i = 0; i < x.size(); ++i) condition = std::max(condition, next[i] / x[i]);
    if (step == 0 || condition < least) {
      least = condition;
      best = x;
    }
    const Quad largest = *std::max_element(next.begin(), next.end());
    for (Quad& value : next) value /= largest;
    x = std::move(next);
  }
  return {best, least};
}

// |X A - I| x <= x / 1000: then X is the inverse of A to three digits, as scaled.
bool proved_inverse(const Matrix& a, const Matrix& candidate, const Vector& x) {
  const std::size_t n = a.size();
  for (std::size_t i = 0; i < n; ++i) {
    Vector error(n, 0);
    error[i] = 1;
    for (std::size_t k = 0; k < n; ++k) subtract(candidate[i][k], a[k], error);
    Quad sum = 0;
    for (std::size_t j = 0; j < n; ++j) sum += absolute(error[j]) * x[j];
    if (!(sum <= x[i] / 1000)) return false;
  }
  return true;
}

bool product_beyond_range(const Matrix& a, const Matrix& inverse_of_a, const std::vector<double>& b) {
  const std::size_t n = a.size();
  Vector x(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) x[i] += inverse_of_a[i][j] * b[j];
    x[i] = absolute(x[i]);
  }
  const auto huge = [](Quad value) { return !(value <= DBL_MAX); };
  const Vector product = multiply_absolute(a, x);
  return std::any_of(product.begin(), product.end(), huge) || std::any_of(x.begin(), x.end(), huge);
}

// The largest of the positive entries exceeds the smallest by more than double precision can say.
bool spread_beyond_range(const Vector& x) {
  const auto [least, most] = std::minmax_element(x.begin(), x.end());
  return *most > *least * DBL_MAX;
}

}  // namespace

BestCondition best_condition(const SparseMatrix& a, const std::vector<double>& b) {
  const std::size_t n = static_cast<std::size_t>(a.n);
  Matrix dense(n, Vector(n, 0));
  for (const Entry& e : entries_of(a)) dense[e.row][e.column] += e.value;
  // Complete pivoting copes with most gradings, equilibration with most others.
  for (const Scaling& scaling : {Scaling{Vector(n, 1), Vector(n, 1)}, equilibrated(dense)}) {
    Matrix scaled = dense;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) scaled[i][j] *= scaling.row[i] * scaling.column[j];
    }
    Matrix candidate = inverse(std::move(scaled));
    if (candidate.empty()) continue;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) candidate[i][j] *= scaling.column[i] * scaling.row[j];
    }
    const auto [x, condition] = best_scaling(dense, candidate);
    if (!proved_inverse(dense, candidate, x)) continue;
    const bool beyond = spread_beyond_range(x) || spread_beyond_range(multiply_absolute(dense, x)) ||
                        product_beyond_range(dense, candidate, b);
    return {static_cast<double>(1 / condition), true, beyond};
  }
  return {};
}

}  // namespace mfs::test
