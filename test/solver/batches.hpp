// Batches for tests: systems of one pattern in arrays with gaps, good ones and bad ones.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "test/solver/systems.hpp"

namespace mfs::test {

/// Systems of one pattern in arrays with gaps, which hold NaN and must stay as they are.
template <class Scalar>
struct Systems {
  std::vector<BasicSparseMatrix<Scalar>> matrices;
  std::vector<Scalar> values, b, x;
  Batch<Scalar> batch;

  Systems(const SparseMatrix& pattern, std::int64_t count, std::int64_t nrhs, std::int64_t gap) {
    const std::int64_t n = pattern.n, entries = static_cast<std::int64_t>(pattern.values.size());
    const Scalar none(std::numeric_limits<float>::quiet_NaN());
    batch.count = count;
    batch.nrhs = nrhs;
    batch.values_stride = entries + gap;
    batch.ldb = n + gap;
    batch.ldx = n + 2 * gap;
    batch.b_stride = nrhs * batch.ldb + gap;
    batch.x_stride = nrhs * batch.ldx + 3 * gap;
    values.assign(static_cast<std::size_t>(count * batch.values_stride), none);
    b.assign(static_cast<std::size_t>(count * batch.b_stride), none);
    x.assign(static_cast<std::size_t>(count * batch.x_stride), none);
    Random random(5);
    for (std::int64_t k = 0; k < count; ++k) {
      BasicSparseMatrix<Scalar> a = in_scalar<Scalar>(pattern);
      for (Scalar& value : a.values) value *= static_cast<Scalar>(1 + 0.2 * random.entry());
      matrices.push_back(a);
      put_values(k);
      const auto rhs = right_hand_sides(a, nrhs, batch.ldb, static_cast<std::uint64_t>(k));
      std::copy(rhs.begin(), rhs.end(), b.begin() + k * batch.b_stride);
    }
    batch.values = values.data();
    batch.b = b.data();
    batch.x = x.data();
  }
  Systems(const Systems&) = delete;
  Systems& operator=(const Systems&) = delete;

  void put_values(std::int64_t k) {
    const std::vector<Scalar>& own = matrices[static_cast<std::size_t>(k)].values;
    std::copy(own.begin(), own.end(), values.begin() + k * batch.values_stride);
  }
  double error_of(std::int64_t k) const {
    const auto& a = matrices[static_cast<std::size_t>(k)];
    double worst = 0;
    for (std::int64_t j = 0; j < batch.nrhs; ++j)
      worst = std::max(worst, backward_error(a, b.data() + k * batch.b_stride + j * batch.ldb,
                                             x.data() + k * batch.x_stride + j * batch.ldx));
    return worst;
  }
  bool untouched(std::int64_t k) const {
    for (std::int64_t i = 0; i < batch.x_stride; ++i) {
      if (!std::isnan(std::abs(x[static_cast<std::size_t>(k * batch.x_stride + i)]))) return false;
    }
    return true;
  }
};

template <class Scalar>
bool same_bits(const std::vector<Scalar>& a, const std::vector<Scalar>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Scalar)) == 0);
}

/// Of every kind: good ones, singular ones, ones with NaN, and ones that need another matching.
inline void spoil(Systems<double>& all) {
  for (std::int64_t k = 0; k < all.batch.count; ++k) {
    SparseMatrix& a = all.matrices[static_cast<std::size_t>(k)];
    const auto row = static_cast<std::size_t>(a.offsets[4]);
    if (k % 5 == 1) {
      for (auto e = row; e < static_cast<std::size_t>(a.offsets[5]); ++e) a.values[e] = 0;
    } else if (k % 5 == 2) {
      a.values[row] = std::numeric_limits<double>::quiet_NaN();
    } else if (k % 5 == 3) {  // rows whose diagonal is nothing beside an entry that was small
      for (std::int64_t i = 0; i < a.n; ++i) {
        for (auto e = a.offsets[i]; e < a.offsets[i + 1]; ++e) {
          if (a.columns[e] == i) a.values[e] *= 1e-20;
        }
      }
    }
    all.put_values(k);
  }
  all.b[static_cast<std::size_t>(9 * all.batch.b_stride + 3)] = std::numeric_limits<double>::infinity();
}

}  // namespace mfs::test
