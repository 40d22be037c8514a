#include "dae/vectors/operations.hpp"

#include <algorithm>
#include <cmath>

#include "dae/vectors/loops.hpp"

namespace mfs::dae {
namespace {

struct Fill {
  double* x;
  double value;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { x[i] = value; }
};

struct Copy {
  const double* from;
  double* to;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { to[i] = from[i]; }
};

struct Scale {
  double* x;
  double factor;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { x[i] *= factor; }
};

struct Combine {
  static constexpr std::size_t kMost = 4;
  double* x;
  double beta;
  const double* term[kMost];
  double alpha[kMost];
  std::size_t count;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    double sum = beta == 0.0 ? 0.0 : beta * x[i];
    for (std::size_t t = 0; t < count; ++t) sum += alpha[t] * term[t][i];
    x[i] = sum;
  }
};

struct Square {
  const double* x;
  MFS_HOST_DEVICE double operator()(std::size_t i) const { return x[i] * x[i]; }
};

}  // namespace

void fill(const Executor& executor, std::size_t count, double value, double* x) {
  for_each(executor, count, Fill{x, value});
}

void copy(const Executor& executor, std::size_t count, const double* from, double* to) {
  for_each(executor, count, Copy{from, to});
}

void scale(const Executor& executor, std::size_t count, double factor, double* x) {
  for_each(executor, count, Scale{x, factor});
}

void combine(const Executor& executor, std::size_t count, double beta, double* x,
             const std::vector<double>& alpha, const std::vector<const double*>& terms) {
  std::size_t done = 0;
  do {
    Combine some{x, done == 0 ? beta : 1.0, {}, {}, std::min(Combine::kMost, terms.size() - done)};
    std::copy_n(terms.begin() + static_cast<std::ptrdiff_t>(done), some.count, some.term);
    std::copy_n(alpha.begin() + static_cast<std::ptrdiff_t>(done), some.count, some.alpha);
    for_each(executor, count, some);
    done += some.count;
  } while (done < terms.size());
}

double norm(const Executor& executor, std::size_t count, const double* x) {
  return std::sqrt(fold(executor, count, 0.0, Square{x}, Sum{}));
}

}  // namespace mfs::dae
