#include "kernels/dense/blas.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <mutex>
#include <type_traits>
#include <vector>

#include <mfs/error.hpp>

#include "kernels/dense/column_kernels.hpp"
#include "kernels/dense/small_kernels.hpp"
#include "kernels/dense/transposed_kernels.hpp"
#include "kernels/runtime/openblas_buffer.hpp"

using mfs::Offset;
using mfs::Vertex;

// What the names of the BLAS at hand begin with: nothing, but with an OpenBLAS that lives beside another.
#ifdef MFS_BLAS_PREFIX
#define MFS_JOINED(a, b) a##b
#define MFS_PREFIXED(prefix, symbol) MFS_JOINED(prefix, symbol)
#define MFS_BLAS(symbol) MFS_PREFIXED(MFS_BLAS_PREFIX, symbol)
#else
#define MFS_BLAS(symbol) symbol
#endif

extern "C" {
#define MFS_DECLARE_BLAS(prefix, S)                                                                        \
  void MFS_BLAS(prefix##gemm_)(const char*, const char*, const int*, const int*, const int*, const S*,     \
                               const S*, const int*, const S*, const int*, const S*, S*, const int*);      \
  void MFS_BLAS(prefix##trsm_)(const char*, const char*, const char*, const char*, const int*, const int*, \
                               const S*, const S*, const int*, S*, const int*);
MFS_DECLARE_BLAS(s, float)
MFS_DECLARE_BLAS(d, double)
MFS_DECLARE_BLAS(c, std::complex<float>)
MFS_DECLARE_BLAS(z, std::complex<double>)

#define MFS_DECLARE_GESVD(prefix, S, R, RWORK)                                                            \
  void MFS_BLAS(prefix##gesvd_)(const char*, const char*, const int*, const int*, S*, const int*, R*, S*, \
                                const int*, S*, const int*, S*, const int*, RWORK int*);
#define MFS_RWORK(R) R*,
MFS_DECLARE_GESVD(s, float, float, )
MFS_DECLARE_GESVD(d, double, double, )
MFS_DECLARE_GESVD(c, std::complex<float>, float, MFS_RWORK(float))
MFS_DECLARE_GESVD(z, std::complex<double>, double, MFS_RWORK(double))

void MFS_BLAS(slacn2_)(const int*, float*, float*, int*, float*, int*, int*);
void MFS_BLAS(dlacn2_)(const int*, double*, double*, int*, double*, int*, int*);
void MFS_BLAS(clacn2_)(const int*, std::complex<float>*, std::complex<float>*, float*, int*, int*);
void MFS_BLAS(zlacn2_)(const int*, std::complex<double>*, std::complex<double>*, double*, int*, int*);

// What the BLAS at hand offers to hold its own threads back; the others stay null.
int MFS_BLAS(openblas_get_num_threads)() __attribute__((weak));
void MFS_BLAS(openblas_set_num_threads)(int) __attribute__((weak));
char* MFS_BLAS(openblas_get_config)() __attribute__((weak));
char* MFS_BLAS(openblas_get_corename)() __attribute__((weak));
int MFS_BLAS(openblas_get_parallel)() __attribute__((weak));
#ifndef MFS_BLAS_PREFIX
void* blas_memory_alloc(int) __attribute__((weak));
void blas_memory_free(void*) __attribute__((weak));
extern int blas_server_avail __attribute__((weak));
int MKL_Set_Num_Threads_Local(int) __attribute__((weak));
void MKL_Get_Version_String(char*, int) __attribute__((weak));
const char* bli_info_get_version_str() __attribute__((weak));
#endif
}

namespace mfs::blas {

namespace {

#ifdef MFS_BLAS_PREFIX
// If the process has any of these, they are another library's.
constexpr void* (*blas_memory_alloc)(int) = nullptr;
constexpr void (*blas_memory_free)(void*) = nullptr;
constexpr int (*MKL_Set_Num_Threads_Local)(int) = nullptr;
constexpr void (*MKL_Get_Version_String)(char*, int) = nullptr;
constexpr const char* (*bli_info_get_version_str)() = nullptr;
constexpr int* server_of_threads = nullptr;
#else
int* const server_of_threads = &blas_server_avail;
#endif

#define MFS_OVERLOAD_BLAS(prefix, S)                                                                        \
  void gemm(const char* ta, int m, int n, int k, S alpha, const S* a, int lda, const S* b, int ldb, S beta, \
            S* c, int ldc) {                                                                                \
    MFS_BLAS(prefix##gemm_)(ta, "N", &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);                 \
  }                                                                                                         \
  void trsm(const char* side, const char* uplo, const char* ta, const char* diag, int m, int n, const S* t, \
            int ldt, S* b, int ldb) {                                                                       \
    const S one(1);                                                                                         \
    MFS_BLAS(prefix##trsm_)(side, uplo, ta, diag, &m, &n, &one, t, &ldt, b, &ldb);                          \
  }
MFS_OVERLOAD_BLAS(s, float)
MFS_OVERLOAD_BLAS(d, double)
MFS_OVERLOAD_BLAS(c, std::complex<float>)
MFS_OVERLOAD_BLAS(z, std::complex<double>)

#define MFS_OVERLOAD_GESVD(prefix, S, R, RWORK)                                                              \
  int gesvd(int n, S* a, R* singular, S* u, S* vt, S* work, int length, [[maybe_unused]] R* rwork) {         \
    int info = 0;                                                                                            \
    MFS_BLAS(prefix##gesvd_)("A", "A", &n, &n, a, &n, singular, u, &n, vt, &n, work, &length, RWORK & info); \
    return info;                                                                                             \
  }
MFS_OVERLOAD_GESVD(s, float, float, )
MFS_OVERLOAD_GESVD(d, double, double, )
#define MFS_RWORK_ARGUMENT rwork,
MFS_OVERLOAD_GESVD(c, std::complex<float>, float, MFS_RWORK_ARGUMENT)
MFS_OVERLOAD_GESVD(z, std::complex<double>, double, MFS_RWORK_ARGUMENT)

#define MFS_OVERLOAD_LACN2(prefix, S, R, SIGNS)                                                   \
  void lacn2(int n, S* v, S* x, [[maybe_unused]] int* signs, R* estimate, int* kase, int* save) { \
    MFS_BLAS(prefix##lacn2_)(&n, v, x, SIGNS estimate, kase, save);                               \
  }
#define MFS_SIGNS_ARGUMENT signs,
MFS_OVERLOAD_LACN2(s, float, float, MFS_SIGNS_ARGUMENT)
MFS_OVERLOAD_LACN2(d, double, double, MFS_SIGNS_ARGUMENT)
MFS_OVERLOAD_LACN2(c, std::complex<float>, float, )
MFS_OVERLOAD_LACN2(z, std::complex<double>, double, )

int leading(Offset ld) {
  return ld > 0 ? static_cast<int>(ld) : 1;
}

/// Up to so many rows and columns products are made without BLAS, and triangles are solved with.
constexpr Vertex kSmallProduct = small::kMost, kSmallTriangle = 128;
/// And all triangles and longer products for so few columns, as those of a solve: BLAS packs the large
/// operand, each of whose entries meets only these. Products inside a panel have no more terms than columns;
/// there BLAS is faster.
constexpr Vertex kFewColumns = 16;

template <class Scalar>
void solve_left(const char* uplo, const char* diag, Transpose transpose, Vertex n, Vertex columns,
                const Scalar* t, Offset ldt, Scalar* b, Offset ldb);

// One right-hand side reads the triangle once; trsm would pack it first, and trsv of complex numbers reads
// behind x (OpenBLAS 0.3.21, github.com/OpenMathLib/OpenBLAS/issues/4013).
template <class Scalar>
void solve_column_by_blocks(const char* uplo, const char* diag, Vertex n, const Scalar* t, Offset ldt,
                            Scalar* x) {
  const bool upper = *uplo == 'U';
  for (Vertex done = 0; done < n; done += small::kMost) {
    const Vertex width = std::min(small::kMost, n - done), begin = upper ? n - done - width : done;
    solve_left(uplo, diag, Transpose::no, width, 1, t + begin + begin * ldt, ldt, x + begin, n);
    const Vertex rest = upper ? 0 : begin + width;
    small::gemm_minus(n - done - width, 1, width, t + rest + begin * ldt, ldt, x + begin, n, x + rest, n);
  }
}

template <class Scalar>
void solve_left(const char* uplo, const char* diag, Transpose transpose, Vertex n, Vertex columns,
                const Scalar* t, Offset ldt, Scalar* b, Offset ldb) {
  if (n == 0 || columns == 0) return;
  if constexpr (std::is_floating_point_v<Scalar>) {
    if (columns == 1 && transpose == Transpose::no) return small::solve_column(*uplo == 'U', n, t, ldt, b);
  }
  if (columns <= kFewColumns && transpose == Transpose::yes) {
    return *uplo == 'U' ? small::solve_upper_transposed(n, columns, t, ldt, b, ldb)
                        : small::solve_unit_lower_transposed(n, columns, t, ldt, b, ldb);
  }
  if (n <= (columns > kFewColumns ? kSmallTriangle : small::kMost) && transpose == Transpose::no) {
    if (*uplo == 'L') return small::solve_unit_lower(n, columns, t, ldt, b, ldb);
    if (small::solve_upper(n, columns, t, ldt, b, ldb)) return;
  }
  if (columns == 1 && n > small::kMost) return solve_column_by_blocks(uplo, diag, n, t, ldt, b);
  const char ta = static_cast<char>(transpose);
  trsm("L", uplo, &ta, diag, n, columns, t, leading(ldt), b, leading(ldb));
}

}  // namespace

template <class Scalar>
void gemm_minus(Transpose transpose_a, Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda,
                const Scalar* b, Offset ldb, Scalar* c, Offset ldc) {
  if (m == 0 || n == 0 || k == 0) return;
  const bool plain = transpose_a == Transpose::no;
  if constexpr (std::is_floating_point_v<Scalar>) {
    if (n == 1 && plain) return small::subtract_product(m, k, a, lda, b, c);
  }
  if (n <= kFewColumns && !plain) return small::gemm_minus_transposed(m, n, k, a, lda, b, ldb, c, ldc);
  if (plain && (n == 1 || (n <= kFewColumns && k > n) || std::max({m, n, k}) <= kSmallProduct))
    return small::gemm_minus(m, n, k, a, lda, b, ldb, c, ldc);
  const char ta = static_cast<char>(transpose_a);
  gemm(&ta, m, n, k, Scalar(-1), a, leading(lda), b, leading(ldb), Scalar(1), c, leading(ldc));
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
  if (n <= kSmallTriangle && small::solve_upper_right(rows, n, u, ldu, b, ldb)) return;
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
  // Kernels of BLAS add in another order where a vector begins elsewhere in a line of cache (dasum of
  // OpenBLAS with AVX-512), so that two estimates would differ in their last bits.
  constexpr std::size_t kLine = 64, kOfLine = kLine / sizeof(Scalar);
  const std::size_t length = (static_cast<std::size_t>(n) + kOfLine - 1) / kOfLine * kOfLine;
  std::vector<Scalar> room(2 * length + kOfLine);
  void* begin = room.data();
  std::size_t space = room.size() * sizeof(Scalar);
  Scalar* const v = static_cast<Scalar*>(std::align(kLine, 2 * length * sizeof(Scalar), begin, space));
  Scalar* const x = v + length;
  std::vector<int> signs(static_cast<std::size_t>(n));
  decltype(std::abs(Scalar())) estimate = 0;
  int kase = 0, save[3] = {};
  for (;;) {
    lacn2(n, v, x, signs.data(), &estimate, &kase, save);
    if (kase == 0) return estimate;
    (kase == 1 ? apply : apply_adjoint)(x);
  }
}

namespace {

// What the scopes of a process have in common; `guard` guards it.
struct Scopes {
  std::mutex guard;
  int open = 0, callers = 0;  // scopes, and the threads that call BLAS in them
  int threads_before = 0;     // of BLAS, when the first was opened
  int buffers = 0;            // that OpenBLAS has
  /// Held in every scope where only one thread may call BLAS.
  std::recursive_mutex one_caller;
};
Scopes& scopes() {
  static auto* const all = new Scopes;  // never destroyed: threads may outlive static destructors
  return *all;
}

// A buffer that was given back stays with OpenBLAS, so `callers` of them held together are enough for good.
void take_buffers(int callers, int& taken) {
  if (!blas_memory_alloc || !blas_memory_free) return;
  if (callers <= taken) return;
  std::vector<void*> held;
  held.reserve(static_cast<std::size_t>(callers));
  while (static_cast<int>(held.size()) < callers) {
    const bool kept = static_cast<int>(held.size()) < taken;
    if (!kept && !room_for_openblas_buffer()) break;
    held.push_back(blas_memory_alloc(0));
  }
  for (void* buffer : held) blas_memory_free(buffer);
  taken = static_cast<int>(held.size());
  if (taken < callers) throw OutOfMemory(MemorySpace::host, kOpenblasBuffer, 0);
}

// OpenBLAS' own threads look for their buffers without end as well, and at the end of the process it waits
// for them. Where there is no room for one, they never come; without its server OpenBLAS waits for nobody.
struct LetTheProcessEnd {
  ~LetTheProcessEnd() {
    if (server_of_threads && !room_for_openblas_buffer()) *server_of_threads = 0;
  }
} const let_the_process_end;

}  // namespace

SequentialScope::SequentialScope(int callers) : callers_(callers) {
  Scopes& all = scopes();
  std::unique_lock<std::recursive_mutex> only_caller(all.one_caller, std::defer_lock);
  if (!many_callers()) only_caller.lock();
  const std::lock_guard<std::mutex> lock(all.guard);
  take_buffers(all.callers + callers, all.buffers);
  if (MKL_Set_Num_Threads_Local) {
    previous_ = MKL_Set_Num_Threads_Local(1);
  } else if (MFS_BLAS(openblas_get_num_threads) && MFS_BLAS(openblas_set_num_threads) && all.open == 0) {
    all.threads_before = MFS_BLAS(openblas_get_num_threads)();
    if (all.threads_before != 1) MFS_BLAS(openblas_set_num_threads)(1);
  }
  ++all.open;
  all.callers += callers;
  alone_ = only_caller.owns_lock();
  only_caller.release();
}

SequentialScope::~SequentialScope() {
  Scopes& all = scopes();
  {
    const std::lock_guard<std::mutex> lock(all.guard);
    all.callers -= callers_;
    --all.open;
    if (MKL_Set_Num_Threads_Local) {
      MKL_Set_Num_Threads_Local(previous_);
    } else if (all.open == 0 && all.threads_before > 1) {
      MFS_BLAS(openblas_set_num_threads)(all.threads_before);
    }
  }
  if (alone_) all.one_caller.unlock();
}

namespace {

std::string linked_library() {
  if (MKL_Get_Version_String) {
    char text[200] = {};
    MKL_Get_Version_String(text, sizeof text - 1);
    return text;
  }
  if (bli_info_get_version_str) return std::string("BLIS ") + bli_info_get_version_str();
  if (!MFS_BLAS(openblas_get_config)) return "BLAS (unnamed)";
  const std::string config = MFS_BLAS(openblas_get_config)();  // names the kind of processor, too
  if (!MFS_BLAS(openblas_get_parallel)) return config;
  switch (MFS_BLAS(openblas_get_parallel)()) {
    case 0:
      return config + ", serial: MFS uses one thread";
    case 1:
      return config + ", pthread";
    default:
      return config + ", openmp";
  }
}

}  // namespace

std::string library_name() {
  const std::string better = better_kernels();
  return linked_library() + (better.empty() ? "" : "; OPENBLAS_CORETYPE=" + better + " would be faster");
}

std::string better_kernels() {
#ifdef __x86_64__
  const bool chosen_at_run_time = MFS_BLAS(openblas_get_corename) && MFS_BLAS(openblas_get_config) &&
                                  std::strstr(MFS_BLAS(openblas_get_config)(), "DYNAMIC_ARCH");
  if (!chosen_at_run_time || std::getenv("OPENBLAS_CORETYPE")) return "";
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"),
             avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512cd");
  return better_kernels(MFS_BLAS(openblas_get_corename)(), avx2, avx512);
#else
  return "";
#endif
}

std::string better_kernels(const std::string& taken, bool avx2, bool avx512) {
  // Of processors without AVX2, as OpenBLAS 0.3 names them.
  static const char* const kOld[] = {"Katmai", "Coppermine",  "Northwood",    "Prescott",   "Banias",
                                     "Atom",   "Core2",       "Penryn",       "Dunnington", "Nehalem",
                                     "Athlon", "Opteron",     "Opteron_SSE3", "Barcelona",  "Bobcat",
                                     "Nano",   "Sandybridge", "Bulldozer",    "Piledriver", "Steamroller"};
  const bool old = std::find(std::begin(kOld), std::end(kOld), taken) != std::end(kOld);
  return !old || !avx2 ? "" : avx512 ? "SkylakeX" : "Haswell";
}

bool many_callers() {
  if (MKL_Get_Version_String || bli_info_get_version_str) return true;
  return !MFS_BLAS(openblas_get_parallel) || MFS_BLAS(openblas_get_parallel)() != 0;
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
