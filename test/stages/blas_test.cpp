// What the seam to BLAS does itself: products and triangles for one right-hand side, and the choice of
// OpenBLAS' kernels.
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <new>
#include <vector>

#include "kernels/dense/blas.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

using blas::Transpose;
using testing::Each;

template <class Scalar>
class OneRightHandSide : public testing::Test {
 protected:
  static constexpr double kTolerance = 100 * std::numeric_limits<decltype(std::abs(Scalar()))>::epsilon();

  // Random entries; those of a triangle's diagonal are large, so that it is well conditioned.
  void make(Vertex rows, Vertex columns, Offset ld) {
    ld_ = ld;
    Random random(static_cast<unsigned>(1 + rows + 1000 * columns));
    a_ = random.vector<Scalar>(std::max<Offset>(1, ld * columns));
    for (Vertex j = 0; j < std::min(rows, columns); ++j)
      a_[j + j * ld] += Scalar(static_cast<float>(columns));
    x_ = random.vector<Scalar>(columns);
    y_ = random.vector<Scalar>(rows + kGuard);
  }
  Scalar at(Vertex i, Vertex j) const { return a_[i + j * ld_]; }

  static constexpr Vertex kGuard = 9;
  Offset ld_ = 0;
  std::vector<Scalar> a_, x_, y_;
};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(OneRightHandSide, Scalars);

constexpr Vertex kSizes[] = {0, 1, 2, 7, 8, 9, 15, 16, 17, 31, 32, 33, 65, 257, 514};

TYPED_TEST(OneRightHandSide, IsMultiplied) {
  for (const Vertex m : kSizes) {
    for (const Vertex k : kSizes) {
      this->make(m, k, m + 3);
      const std::vector<TypeParam> before = this->y_;
      blas::gemm_minus(Transpose::no, m, 1, k, this->a_.data(), this->ld_, this->x_.data(), std::max(k, 1),
                       this->y_.data(), std::max(m, 1));
      for (Vertex i = 0; i < m + this->kGuard; ++i) {
        TypeParam expected = before[i];
        for (Vertex j = 0; i < m && j < k; ++j) expected -= this->at(i, j) * this->x_[j];
        ASSERT_LE(std::abs(this->y_[i] - expected), (1 + k) * this->kTolerance)
            << m << " x " << k << ", " << i;
      }
    }
  }
}

// T x is what was there before; entries of the other triangle, and the diagonal of L, are not looked at.
TYPED_TEST(OneRightHandSide, IsSolvedForWithTriangles) {
  const TypeParam nan(std::numeric_limits<float>::quiet_NaN());
  for (const Vertex n : kSizes) {
    for (const bool upper : {true, false}) {
      this->make(n, n, n + 5);
      for (Vertex j = 0; j < n; ++j) {
        for (Vertex i = 0; i < n; ++i) {
          TypeParam& entry = this->a_[i + j * this->ld_];
          if (upper ? i > j : i <= j) entry = nan;
          if (!upper && i > j) entry /= static_cast<float>(n);
        }
      }
      std::vector<TypeParam> x = this->y_;
      (upper ? blas::solve_upper<TypeParam> : blas::solve_unit_lower<TypeParam>)(Transpose::no, n, 1,
                                                                                 this->a_.data(), this->ld_,
                                                                                 x.data(), std::max(n, 1));
      for (Vertex i = 0; i < n + this->kGuard; ++i) {
        TypeParam product = i < n && upper ? TypeParam(0) : x[i];
        double size = 1;
        for (Vertex j = upper ? i : 0; i < n && j < (upper ? n : i); ++j) {
          product += this->at(i, j) * x[j];
          size += std::abs(this->at(i, j) * x[j]);
        }
        ASSERT_LE(std::abs(product - this->y_[i]), size * this->kTolerance)
            << n << (upper ? " U " : " L ") << i;
      }
    }
  }
}

/// Memory that ends with a page, behind which nothing may be read.
class EndOfPage {
 public:
  explicit EndOfPage(std::size_t bytes) : page_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))) {
    whole_ = (bytes + page_ - 1) / page_ * page_;
    at_ = static_cast<char*>(
        mmap(nullptr, whole_ + page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (at_ == MAP_FAILED || mprotect(at_ + whole_, page_, PROT_NONE) != 0) throw std::bad_alloc();
    begin_ = at_ + whole_ - bytes;
  }
  EndOfPage(const EndOfPage&) = delete;
  EndOfPage& operator=(const EndOfPage&) = delete;
  ~EndOfPage() { munmap(at_, whole_ + page_); }
  void* begin() const { return begin_; }

 private:
  std::size_t page_, whole_;
  char *at_, *begin_;
};

// As trsv of complex numbers does (OpenBLAS 0.3.21, where the rows are even and no multiple of four).
TYPED_TEST(OneRightHandSide, IsNotReadBehindItsEnd) {
  for (const Vertex n : {30, 129, 256, 257, 258, 259, 260, 262, 301, 514}) {
    this->make(n, n, n);
    const EndOfPage memory(n * sizeof(TypeParam));
    auto* const x = static_cast<TypeParam*>(memory.begin());
    for (const Transpose transpose : {Transpose::no, Transpose::yes}) {
      for (const auto& solve : {blas::solve_upper<TypeParam>, blas::solve_unit_lower<TypeParam>}) {
        std::fill_n(x, n, TypeParam(0));
        solve(transpose, n, 1, this->a_.data(), n, x, n);
        EXPECT_THAT(std::vector<TypeParam>(x, x + n), Each(TypeParam(0)));
      }
    }
    std::fill_n(x, n, TypeParam(0));
    blas::gemm_minus(Transpose::no, n, 1, n, this->a_.data(), n, std::vector<TypeParam>(n).data(), n, x, n);
    EXPECT_THAT(std::vector<TypeParam>(x, x + n), Each(TypeParam(0)));
  }
}

// The reciprocal of such a pivot is infinite, what is divided by it is not.
TYPED_TEST(OneRightHandSide, IsDividedByTheSmallestPivots) {
  using Real = decltype(std::abs(TypeParam()));
  if (!std::is_same_v<Real, TypeParam>) GTEST_SKIP() << "BLAS takes such reciprocals of complex numbers";
  const TypeParam least(std::numeric_limits<Real>::denorm_min() * 8);
  for (const Vertex n : {1, 3, 4, 6, 8, 11, 20, 129}) {
    for (const Vertex place : {Vertex(0), n / 2, n - 1}) {
      std::vector<TypeParam> u(static_cast<std::size_t>(n) * n, TypeParam(0)), x(n, TypeParam(Real(4)));
      for (Vertex i = 0; i < n; ++i) u[i + i * n] = i == place ? least : TypeParam(Real(2));
      x[place] = least * TypeParam(Real(3));
      blas::solve_upper<TypeParam>(Transpose::no, n, 1, u.data(), n, x.data(), n);
      for (Vertex i = 0; i < n; ++i)
        ASSERT_EQ(x[i], TypeParam(Real(i == place ? 3 : 2))) << n << ", row " << i;
    }
  }
}

TEST(OpenBlasKernels, AreChosenWhereThoseOfAnOldProcessorWereTaken) {
  EXPECT_EQ(blas::better_kernels("Prescott", true, true), "SkylakeX");
  EXPECT_EQ(blas::better_kernels("Prescott", true, false), "Haswell");
  EXPECT_EQ(blas::better_kernels("Prescott", false, false), "");
  EXPECT_EQ(blas::better_kernels("Nehalem", true, true), "SkylakeX");
  std::vector<std::string> known;
  for (const char* core :
       {"Haswell", "Zen", "Excavator", "SkylakeX", "Cooperlake", "Sapphirerapids", "a new one"})
    known.push_back(blas::better_kernels(core, true, true));
  EXPECT_THAT(known, Each(""));
}

}  // namespace
}  // namespace mfs::test
