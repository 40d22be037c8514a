#include "kernels/blas.hpp"

#include <algorithm>
#include <vector>

using mfs::Offset;
using mfs::Vertex;

extern "C" {
#define MFS_DECLARE_BLAS(prefix, S)                                                                        \
  void prefix##gemm_(const char*, const char*, const int*, const int*, const int*, const S*, const S*,     \
                     const int*, const S*, const int*, const S*, S*, const int*);                          \
  void prefix##gemv_(const char*, const int*, const int*, const S*, const S*, const int*, const S*,        \
                     const int*, const S*, S*, const int*);                                                \
  void prefix##trsm_(const char*, const char*, const char*, const char*, const int*, const int*, const S*, \
                     const S*, const int*, S*, const int*);                                                \
  void prefix##trsv_(const char*, const char*, const char*, const int*, const S*, const int*, S*, const int*);
MFS_DECLARE_BLAS(s, float)
MFS_DECLARE_BLAS(d, double)
MFS_DECLARE_BLAS(c, std::complex<float>)
MFS_DECLARE_BLAS(z, std::complex<double>)

#define MFS_DECLARE_GESVD(prefix, S, R, RWORK)                                                              \
  void prefix##gesvd_(const char*, const char*, const int*, const int*, S*, const int*, R*, S*, const int*, \
                      S*, const int*, S*, const int*, RWORK int*);
#define MFS_RWORK(R) R*,
MFS_DECLARE_GESVD(s, float, float, )
MFS_DECLARE_GESVD(d, double, double, )
MFS_DECLARE_GESVD(c, std::complex<float>, float, MFS_RWORK(float))
MFS_DECLARE_GESVD(z, std::complex<double>, double, MFS_RWORK(double))

void slacn2_(const int*, float*, float*, int*, float*, int*, int*);
void dlacn2_(const int*, double*, double*, int*, double*, int*, int*);
void clacn2_(const int*, std::complex<float>*, std::complex<float>*, float*, int*, int*);
void zlacn2_(const int*, std::complex<double>*, std::complex<double>*, double*, int*, int*);

// What the BLAS at hand offers to hold its own threads back; the others stay null.
int openblas_get_num_threads() __attribute__((weak));
void openblas_set_num_threads(int) __attribute__((weak));
char* openblas_get_config() __attribute__((weak));
int openblas_get_parallel() __attribute__((weak));
int MKL_Set_Num_Threads_Local(int) __attribute__((weak));
void MKL_Get_Version_String(char*, int) __attribute__((weak));
const char* bli_info_get_version_str() __attribute__((weak));
}

namespace mfs::blas {

namespace {

#define MFS_OVERLOAD_BLAS(prefix, S)                                                                        \
  void gemm(const char* ta, int m, int n, int k, S alpha, const S* a, int lda, const S* b, int ldb, S beta, \
            S* c, int ldc) {                                                                                \
    prefix##gemm_(ta, "N", &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);                           \
  }                                                                                                         \
  void gemv(const char* ta, int m, int n, S alpha, const S* a, int lda, const S* x, S beta, S* y) {         \
    const int one = 1;                                                                                      \
    prefix##gemv_(ta, &m, &n, &alpha, a, &lda, x, &one, &beta, y, &one);                                    \
  }                                                                                                         \
  void trsm(const char* side, const char* uplo, const char* ta, const char* diag, int m, int n, const S* t, \
            int ldt, S* b, int ldb) {                                                                       \
    const S one(1);                                                                                         \
    prefix##trsm_(side, uplo, ta, diag, &m, &n, &one, t, &ldt, b, &ldb);                                    \
  }                                                                                                         \
  void trsv(const char* uplo, const char* ta, const char* diag, int n, const S* t, int ldt, S* x) {         \
    const int one = 1;                                                                                      \
    prefix##trsv_(uplo, ta, diag, &n, t, &ldt, x, &one);                                                    \
  }
MFS_OVERLOAD_BLAS(s, float)
MFS_OVERLOAD_BLAS(d, double)
MFS_OVERLOAD_BLAS(c, std::complex<float>)
MFS_OVERLOAD_BLAS(z, std::complex<double>)

#define MFS_OVERLOAD_GESVD(prefix, S, R, RWORK)                                                      \
  int gesvd(int n, S* a, R* singular, S* u, S* vt, S* work, int length, [[maybe_unused]] R* rwork) { \
    int info = 0;                                                                                    \
    prefix##gesvd_("A", "A", &n, &n, a, &n, singular, u, &n, vt, &n, work, &length, RWORK& info);    \
    return info;                                                                                     \
  }
MFS_OVERLOAD_GESVD(s, float, float, )
MFS_OVERLOAD_GESVD(d, double, double, )
#define MFS_RWORK_ARGUMENT rwork,
MFS_OVERLOAD_GESVD(c, std::complex<float>, float, MFS_RWORK_ARGUMENT)
MFS_OVERLOAD_GESVD(z, std::complex<double>, double, MFS_RWORK_ARGUMENT)

#define MFS_OVERLOAD_LACN2(prefix, S, R, SIGNS)                                                   \
  void lacn2(int n, S* v, S* x, [[maybe_unused]] int* signs, R* estimate, int* kase, int* save) { \
    prefix##lacn2_(&n, v, x, SIGNS estimate, kase, save);                                         \
  }
#define MFS_SIGNS_ARGUMENT signs,
MFS_OVERLOAD_LACN2(s, float, float, MFS_SIGNS_ARGUMENT)
MFS_OVERLOAD_LACN2(d, double, double, MFS_SIGNS_ARGUMENT)
MFS_OVERLOAD_LACN2(c, std::complex<float>, float, )
MFS_OVERLOAD_LACN2(z, std::complex<double>, double, )

int leading(Offset ld) {
  return ld > 0 ? static_cast<int>(ld) : 1;
}

// One right-hand side reads the triangle once; trsm would pack it first.
template <class Scalar>
void solve_left(const char* uplo, const char* diag, Transpose transpose, Vertex n, Vertex columns,
                const Scalar* t, Offset ldt, Scalar* b, Offset ldb) {
  if (n == 0 || columns == 0) return;
  const char ta = static_cast<char>(transpose);
  if (columns == 1) {
    trsv(uplo, &ta, diag, n, t, leading(ldt), b);
  } else {
    trsm("L", uplo, &ta, diag, n, columns, t, leading(ldt), b, leading(ldb));
  }
}

}  // namespace

template <class Scalar>
void gemm_minus(Transpose transpose_a, Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda,
                const Scalar* b, Offset ldb, Scalar* c, Offset ldc) {
  if (m == 0 || n == 0 || k == 0) return;
  const char ta = static_cast<char>(transpose_a);
  if (n == 1) {
    const bool plain = transpose_a == Transpose::no;
    gemv(&ta, plain ? m : k, plain ? k : m, Scalar(-1), a, leading(lda), b, Scalar(1), c);
  } else {
    gemm(&ta, m, n, k, Scalar(-1), a, leading(lda), b, leading(ldb), Scalar(1), c, leading(ldc));
  }
}

template <class Scalar>
void solve_unit_lower(Transpose transpose, Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b,
                      Offset ldb) {
  solve_left("L", "U", transpose, n, columns, t, ldt, b, ldb);
}

template <class Scalar>
void solve_upper(Transpose transpose, Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b,
                 Offset ldb) {
  solve_left("U", "N", transpose, n, columns, t, ldt, b, ldb);
}

template <class Scalar>
void solve_upper_right(Vertex rows, Vertex n, const Scalar* u, Offset ldu, Scalar* b, Offset ldb) {
  if (rows == 0 || n == 0) return;
  trsm("R", "U", "N", "N", rows, n, u, leading(ldu), b, leading(ldb));
}

template <class Scalar>
int singular_values(Vertex n, Scalar* a, double* singular, Scalar* u, Scalar* v_transposed) {
  using Real = decltype(std::abs(*a));
  std::vector<Real> values(static_cast<std::size_t>(n)), rwork(static_cast<std::size_t>(5 * n));
  std::vector<Scalar> work(static_cast<std::size_t>(8 * n));
  const int info = gesvd(n, a, values.data(), u, v_transposed, work.data(), 8 * n, rwork.data());
  std::copy(values.begin(), values.end(), singular);
  return info;
}

template <class Scalar>
double estimate_norm(Vertex n, const std::function<void(Scalar*)>& apply,
                     const std::function<void(Scalar*)>& apply_adjoint) {
  std::vector<Scalar> v(static_cast<std::size_t>(n)), x(static_cast<std::size_t>(n));
  std::vector<int> signs(static_cast<std::size_t>(n));
  decltype(std::abs(Scalar())) estimate = 0;
  int kase = 0, save[3] = {};
  for (;;) {
    lacn2(n, v.data(), x.data(), signs.data(), &estimate, &kase, save);
    if (kase == 0) return estimate;
    (kase == 1 ? apply : apply_adjoint)(x.data());
  }
}

SequentialScope::SequentialScope() {
  if (MKL_Set_Num_Threads_Local) {
    previous_ = MKL_Set_Num_Threads_Local(1);
  } else if (openblas_get_num_threads && openblas_set_num_threads) {
    previous_ = openblas_get_num_threads();
    if (previous_ != 1) openblas_set_num_threads(1);
  }
}

SequentialScope::~SequentialScope() {
  if (MKL_Set_Num_Threads_Local) {
    MKL_Set_Num_Threads_Local(previous_);
  } else if (previous_ > 1) {
    openblas_set_num_threads(previous_);
  }
}

std::string library_name() {
  if (MKL_Get_Version_String) {
    char text[200] = {};
    MKL_Get_Version_String(text, sizeof text - 1);
    return text;
  }
  if (bli_info_get_version_str) return std::string("BLIS ") + bli_info_get_version_str();
  if (!openblas_get_config) return "BLAS (unnamed)";
  const std::string config = openblas_get_config();  // names the kind of processor, too
  if (!openblas_get_parallel) return config;
  switch (openblas_get_parallel()) {
    case 0:
      return config + ", serial: MFS uses one thread";
    case 1:
      return config + ", pthread";
    default:
      return config + ", openmp";
  }
}

bool many_callers() {
  if (MKL_Get_Version_String || bli_info_get_version_str) return true;
  return !openblas_get_parallel || openblas_get_parallel() != 0;
}

#define MFS_INSTANTIATE(S)                                                                               \
  template void gemm_minus<S>(Transpose, Vertex, Vertex, Vertex, const S*, Offset, const S*, Offset, S*, \
                              Offset);                                                                   \
  template void solve_unit_lower<S>(Transpose, Vertex, Vertex, const S*, Offset, S*, Offset);            \
  template void solve_upper<S>(Transpose, Vertex, Vertex, const S*, Offset, S*, Offset);                 \
  template void solve_upper_right<S>(Vertex, Vertex, const S*, Offset, S*, Offset);                      \
  template int singular_values<S>(Vertex, S*, double*, S*, S*);                                          \
  template double estimate_norm<S>(Vertex, const std::function<void(S*)>&, const std::function<void(S*)>&);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::blas
