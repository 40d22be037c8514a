// A plane chain of unit masses on rigid links of unit length: large enough that a factorization costs more
// than a few solves.
#pragma once

#include <vector>

#include "test/dae/integrator/dense_system.hpp"

namespace mfs::dae::test {

struct Chain {
  int links = 24;
  int coordinates() const { return 2 * links; }
  int constraints() const { return links; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& /*q*/, const std::vector<T>& /*v*/,
                       const std::vector<T>& a) const {
    std::vector<T> f = a;
    for (int k = 0; k < links; ++k) f[2 * k + 1] = T(a[2 * k + 1] + 9.81);
    return f;
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    std::vector<T> phi;
    for (int k = 0; k < links; ++k) {
      const T dx = k == 0 ? q[0] : T(q[2 * k] - q[2 * k - 2]);
      const T dy = k == 0 ? q[1] : T(q[2 * k + 1] - q[2 * k - 1]);
      phi.push_back(T(0.5 * (dx * dx + dy * dy - 1.0)));
    }
    return phi;
  }
  /// Stretched out horizontally.
  std::vector<double> start() const {
    std::vector<double> q;
    for (int k = 0; k < links; ++k) {
      q.push_back(k + 1.0);
      q.push_back(0.0);
    }
    return q;
  }
};

}  // namespace mfs::dae::test
