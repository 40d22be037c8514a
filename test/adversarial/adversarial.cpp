// Solves adversarial matrices with MFS and holds every answer against plain code and UMFPACK:
//   - a solution that is returned has a componentwise backward error of at most 1e-12, computed here;
//   - a matrix that is singular by construction is refused;
//   - a matrix is refused only where its reciprocal condition, under the best scaling of rows and columns
//     (test/adversarial/best_condition.hpp), is below 1e-14, or where scaling or solution exceed the range of
//     double; "singular" is never said of the latter. UMFPACK's figure is printed beside it: it depends on
//     the scaling, and takes the Hilbert matrix of order 12 (1e-16) for a regular one.
//
//   test_adversarial [COUNT [FIRST_SEED [engineering] [cuda]]]
//
// takes the two backends of the host by turns, or the device, and matrices of either header, and prints the
// seed of each failure and a table by kind. Unproved: refused, and the reference has no inverse to hold
// against it.
#include <umfpack.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include <mfs/mfs.hpp>

#include "test/adversarial/best_condition.hpp"
#include "test/adversarial/engineering_matrices.hpp"
#include "test/adversarial/hard_matrices.hpp"
#include "test/reference/random.hpp"

namespace {

using mfs::test::HardMatrix;
using mfs::test::SparseMatrix;

constexpr double kTolerance = 1e-12, kSingularBelow = 1e-14;

struct Tally {
  int solved = 0, refused = 0, wrong = 0, refused_regular = 0, unproved = 0;
  double worst = 0;
};

// UMFPACK's estimate; 0 where it calls the matrix singular. The arrays are A by columns of A^T: same
// condition.
double reciprocal_condition(const SparseMatrix& a) {
  double control[UMFPACK_CONTROL], info[UMFPACK_INFO];
  umfpack_dl_defaults(control);
  control[UMFPACK_IRSTEP] = 0;
  std::vector<SuiteSparse_long> offsets(a.offsets.begin(), a.offsets.end()),
      columns(a.columns.begin(), a.columns.end());
  void *symbolic = nullptr, *numeric = nullptr;
  double condition = 0;
  if (umfpack_dl_symbolic(a.n, a.n, offsets.data(), columns.data(), a.values.data(), &symbolic, control,
                          info) == UMFPACK_OK &&
      umfpack_dl_numeric(offsets.data(), columns.data(), a.values.data(), symbolic, &numeric, control,
                         info) == UMFPACK_OK) {
    condition = info[UMFPACK_RCOND];
  }
  umfpack_dl_free_symbolic(&symbolic);
  umfpack_dl_free_numeric(&numeric);
  return condition;
}

std::vector<double> right_hand_side(const HardMatrix& hard, std::uint64_t seed) {
  mfs::test::Random random(seed);
  std::vector<double> x = random.vector(hard.matrix.n);
  if (hard.solution_sizes.empty() && !hard.singular) return x;
  for (std::size_t i = 0; i < hard.solution_sizes.size(); ++i) x[i] *= hard.solution_sizes[i];
  return mfs::test::multiply(hard.matrix,
                             x);  // a singular system gets a consistent one: it must be refused as well
}

void check_refusal(const HardMatrix& hard, const std::vector<double>& b, const mfs::Error& error,
                   Tally& tally) {
  const mfs::test::BestCondition condition = mfs::test::best_condition(hard.matrix, b);
  tally.unproved += !condition.proved;
  if (condition.reciprocal < kSingularBelow) return;
  const bool said_singular = dynamic_cast<const mfs::SingularMatrix*>(&error) != nullptr;
  if (condition.beyond_range && !said_singular) return;
  ++tally.refused_regular;
  std::printf("refused: %s, n = %ld, though rcond is %.1e (UMFPACK's: %.1e)%s: %s\n", hard.name.c_str(),
              static_cast<long>(hard.matrix.n), condition.reciprocal, reciprocal_condition(hard.matrix),
              condition.beyond_range ? ", not solvable in double precision" : "", error.what());
}

void check_answer(const HardMatrix& hard, std::uint64_t seed, mfs::Backend backend, Tally& tally) {
  const std::vector<double> b = right_hand_side(hard, seed);
  std::vector<double> x(b.size(), 0.0);
  mfs::Options options;
  options.backend = backend;
  mfs::Solver solver(options);
  try {
    solver.factor(hard.matrix.view());
    solver.solve(b.data(), x.data());
  } catch (const mfs::Error& error) {
    ++tally.refused;
    if (!hard.singular) check_refusal(hard, b, error, tally);
    return;
  }
  ++tally.solved;
  const double error = mfs::test::backward_error(hard.matrix, b, x);
  tally.worst = std::max(tally.worst, error);
  if (hard.singular || !(error <= kTolerance)) {
    ++tally.wrong;
    std::printf("WRONG SUCCESS: %s, n = %ld, backward error %.1e%s\n", hard.name.c_str(),
                static_cast<long>(hard.matrix.n), error, hard.singular ? ", the matrix is singular" : "");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 400;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  bool on_device = false, engineering = false;
  for (int i = 3; i < argc; ++i) {
    const std::string word = argv[i];
    on_device |= word == "cuda";
    engineering |= word == "engineering";
    if (word == "cuda" || word == "engineering") continue;
    std::fprintf(stderr, "%s: neither cuda nor engineering\n", argv[i]);
    return 2;
  }
  std::printf("%lu adversarial matrices from seed %lu\n", static_cast<unsigned long>(count),
              static_cast<unsigned long>(first));
  std::map<std::string, Tally> kinds;
  int bad = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const HardMatrix hard = engineering ? mfs::test::engineering_matrix(seed) : mfs::test::hard_matrix(seed);
    Tally& tally = kinds[hard.name.substr(0, hard.name.rfind(", seed"))];
    const int before = tally.wrong + tally.refused_regular;
    check_answer(hard, seed,
                 on_device  ? mfs::Backend::cuda
                 : seed % 2 ? mfs::Backend::serial
                            : mfs::Backend::openmp,
                 tally);
    bad += tally.wrong + tally.refused_regular - before;
  }
  std::printf("%-28s %8s %8s %8s %8s %8s %10s\n", "kind", "solved", "refused", "unproved", "wrong", "too shy",
              "worst");
  for (const auto& [kind, t] : kinds) {
    std::printf("%-28s %8d %8d %8d %8d %8d %10.1e\n", kind.c_str(), t.solved, t.refused, t.unproved, t.wrong,
                t.refused_regular, t.worst);
  }
  std::printf("%d of %lu not as they should be\n", bad, static_cast<unsigned long>(count));
  return bad ? 1 : 0;
}
