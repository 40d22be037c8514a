// A solver with PARDISO's interface for small matrices: plain elimination with row exchanges, the matrix kept
// as it is and eliminated again for every right-hand side. With STUB_PARDISO=fails its factorizations end
// with error -4, with STUB_PARDISO=wrong its solutions are not accurate until they are refined.
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

namespace {

bool is_asked_for(const char* fault) {
  const char* const asked = std::getenv("STUB_PARDISO");
  return asked != nullptr && std::strcmp(asked, fault) == 0;
}

std::vector<double> eliminate(int n, const double* a, const int* begin, const int* columns, const double* b) {
  std::vector<std::vector<double>> rows(n, std::vector<double>(n + 1));
  for (int i = 0; i < n; ++i) {
    for (int k = begin[i]; k < begin[i + 1]; ++k) rows[i][columns[k]] += a[k];
    rows[i][n] = b[i];
  }
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(rows[i][k]) > std::abs(rows[best][k])) best = i;
    }
    std::swap(rows[k], rows[best]);
    for (int i = k + 1; i < n; ++i) {
      const double factor = rows[i][k] / rows[k][k];
      for (int j = k; j <= n; ++j) rows[i][j] -= factor * rows[k][j];
    }
  }
  std::vector<double> x(n);
  for (int i = n - 1; i >= 0; --i) {
    double sum = rows[i][n];
    for (int j = i + 1; j < n; ++j) sum -= rows[i][j] * x[j];
    x[i] = sum / rows[i][i];
  }
  return x;
}

}  // namespace

extern "C" {

void MKL_Set_Num_Threads(int) {}

void pardiso(void**, const int*, const int*, const int*, const int* phase, const int* n, const double* a,
             const int* begin, const int* columns, int*, const int* count, int* iparm, const int*, double* b,
             double* x, int* error) {
  *error = *phase == 22 && is_asked_for("fails") ? -4 : 0;
  if (*phase == 22) iparm[17] = begin[*n];
  if (*phase != 33) return;
  iparm[6] = iparm[7];
  for (int j = 0; j < *count; ++j) {
    std::vector<double> found = eliminate(*n, a, begin, columns, b + j * *n);
    if (is_asked_for("wrong") && iparm[7] < 2) found[0] += 1e-3;
    std::memcpy(x + j * *n, found.data(), found.size() * sizeof(double));
  }
}
}
