// An OpenBLAS without threads, as this program makes the one at hand seem to be, may be called by one thread
// only.
#include <dlfcn.h>

#include <mutex>
#include <set>
#include <thread>

#include <mfs/mfs.hpp>

#include "test/failure/fresh_solver.hpp"

namespace {

std::mutex guard;
std::set<std::thread::id> callers;
int parallel = 0;

void note_caller() {
  const std::lock_guard<std::mutex> lock(guard);
  callers.insert(std::this_thread::get_id());
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// They stand before those of BLAS: the program exports them.
extern "C" {
int openblas_get_parallel() {
  return parallel;
}
void dgemm_(const char* ta, const char* tb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c,
            const int* ldc) {
  static auto* const blas = next<decltype(dgemm_)>("dgemm_");
  note_caller();
  blas(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc);
}
void dgemv_(const char* ta, const int* m, const int* n, const double* alpha, const double* a, const int* lda,
            const double* x, const int* incx, const double* beta, double* y, const int* incy) {
  static auto* const blas = next<decltype(dgemv_)>("dgemv_");
  note_caller();
  blas(ta, m, n, alpha, a, lda, x, incx, beta, y, incy);
}
}

namespace mfs::test {
namespace {

TEST(SerialBlas, IsCalledByOneThread) {
  // 2e8 operations are enough to be shared; its largest fronts are too large for kernels of our own.
  const SparseMatrix a = grid_3d(16);
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
  std::vector<double> x(b.size());
  const auto callers_of = [&](int kind) {
    parallel = kind;
    callers.clear();
    Solver solver(with_threads(4));
    for (int k = 0; k < 5; ++k) {
      solver.factor(a.view());
      solver.solve(b.data(), x.data());
    }
    return callers.size();
  };
  EXPECT_EQ(callers_of(0), 1u);
  EXPECT_GE(callers_of(1), 1u);  // and that calls come by here
}

TEST(SerialBlas, IsNamed) {
  parallel = 0;
  for (const LibraryInfo& library : libraries()) {
    if (library.name == "BLAS" && library.version.rfind("OpenBLAS", 0) == 0) {
      EXPECT_NE(library.version.find("serial"), std::string::npos) << library.version;
    }
  }
}

}  // namespace
}  // namespace mfs::test
