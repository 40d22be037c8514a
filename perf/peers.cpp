// Direct solvers of the host that Debian has, measured as perf_device measures MFS: for each FAMILY:SIZE or
// file a JSON line per solver (times in s, memory in bytes; perf/compare reads them beside those of MFS).
//
//   perf_peers --solver cholmod,umfpack --repeat 3 elas3d:20 my_matrix.mtx.gz
//
// CHOLMOD (supernodal Cholesky under METIS) takes symmetric positive definite matrices only, and says
// "failed" of others; its factor entries are those of one triangle. UMFPACK (LU with partial pivoting) orders
// by METIS, too. Both have the threads of their BLAS and no others, so --threads is told to OpenBLAS.
#include <cholmod.h>
#include <umfpack.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <mfs/version.hpp>

#include "perf/measure.hpp"
#include "solver/program/bench_case.hpp"

namespace {

using namespace mfs::perf;
using Long = SuiteSparse_long;

// Of a matrix with sorted rows. Sums of an element's entries may differ by rounding between the triangles.
bool is_symmetric(const FamilyMatrix& a) {
  double largest = 0;
  for (const double value : a.values) largest = std::max(largest, std::abs(value));
  for (std::int64_t row = 0; row < a.n; ++row) {
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      const auto begin = a.column_indices.begin() + a.offsets[a.column_indices[k]];
      const auto end = a.column_indices.begin() + a.offsets[a.column_indices[k] + 1];
      const auto mirrored = std::lower_bound(begin, end, row);
      if (mirrored == end || *mirrored != row) return false;
      const double difference = a.values[mirrored - a.column_indices.begin()] - a.values[k];
      if (std::abs(difference) > 1e-13 * largest) return false;
    }
  }
  return true;
}

/// What both have: indices of 64 bits, and the host's memory only.
class Peer : public Candidate {
 public:
  explicit Peer(const System& system)
      : system_(system),
        offsets_(system.a.offsets.begin(), system.a.offsets.end()),
        indices_(system.a.column_indices.begin(), system.a.column_indices.end()),
        x_(system.b.size()) {}
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), system_.a.n * columns, x); }
  bool refine(int) override { return false; }
  std::int64_t caller_bytes(int) const override { return 0; }

 protected:
  const System& system_;
  std::vector<Long> offsets_, indices_;
  std::vector<double> x_;
};

class Cholmod final : public Peer {
 public:
  explicit Cholmod(const System& system) : Peer(system) {
    if (!is_symmetric(system.a)) throw std::runtime_error("CHOLMOD: the matrix is not symmetric");
    cholmod_l_start(&common_);
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.postorder = 1;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.print = 0;
    const auto n = static_cast<std::size_t>(system.a.n);
    matrix_ = {n,
               n,
               indices_.size(),
               offsets_.data(),
               indices_.data(),
               nullptr,
               const_cast<double*>(system.a.values.data()),  // is read only
               nullptr,
               1,
               CHOLMOD_LONG,
               CHOLMOD_REAL,
               CHOLMOD_DOUBLE,
               1,
               1};
  }
  ~Cholmod() override {
    cholmod_l_free_factor(&factor_, &common_);
    cholmod_l_finish(&common_);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  AnalysisTime analyze() override {
    factor_ = cholmod_l_analyze(&matrix_, &common_);
    require(factor_ != nullptr);
    return {};
  }
  void factor() override { refactor(); }
  void refactor() override {
    require(cholmod_l_factorize(&matrix_, factor_, &common_) != 0);
    if (factor_->minor < matrix_.nrow)
      throw std::runtime_error("CHOLMOD: the matrix is not positive definite");
  }
  void solve(int columns) override {
    const auto n = matrix_.nrow, k = static_cast<std::size_t>(columns);
    cholmod_dense b{
        n, k, n * k, n, const_cast<double*>(system_.b.data()), nullptr, CHOLMOD_REAL, CHOLMOD_DOUBLE};
    cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, factor_, &b, &common_);
    require(x != nullptr);
    std::copy_n(static_cast<const double*>(x->x), n * k, x_.data());
    cholmod_l_free_dense(&x, &common_);
  }
  Facts facts() override {
    Facts facts;
    facts.version =
        "CHOLMOD " + std::to_string(CHOLMOD_MAIN_VERSION) + "." + std::to_string(CHOLMOD_SUB_VERSION);
    facts.vectors = "host";
    facts.factor_entries = static_cast<std::int64_t>(common_.lnz);
    facts.flops = common_.fl;
    facts.device_bytes = static_cast<std::int64_t>(common_.memory_usage);
    return facts;
  }

 private:
  void require(bool done) const {
    if (!done || common_.status < CHOLMOD_OK)
      throw std::runtime_error("CHOLMOD: status " + std::to_string(common_.status));
  }

  cholmod_common common_;
  cholmod_sparse matrix_;
  cholmod_factor* factor_ = nullptr;
};

/// Our rows are its columns: it factors A^T, and solves with that one's transposed.
class Umfpack final : public Peer {
 public:
  explicit Umfpack(const System& system) : Peer(system) {
    umfpack_dl_defaults(control_);
    control_[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
    control_[UMFPACK_PRL] = 0;
  }
  ~Umfpack() override {
    umfpack_dl_free_numeric(&numeric_);
    umfpack_dl_free_symbolic(&symbolic_);
  }
  Umfpack(const Umfpack&) = delete;
  Umfpack& operator=(const Umfpack&) = delete;

  AnalysisTime analyze() override {
    require(umfpack_dl_symbolic(system_.a.n, system_.a.n, offsets_.data(), indices_.data(),
                                system_.a.values.data(), &symbolic_, control_, info_));
    return {};
  }
  void factor() override { refactor(); }
  void refactor() override {
    umfpack_dl_free_numeric(&numeric_);
    require(umfpack_dl_numeric(offsets_.data(), indices_.data(), system_.a.values.data(), symbolic_,
                               &numeric_, control_, info_));
    facts_.factor_entries = static_cast<std::int64_t>(info_[UMFPACK_LNZ] + info_[UMFPACK_UNZ]) - system_.a.n;
    facts_.flops = info_[UMFPACK_FLOPS];
    facts_.device_bytes = static_cast<std::int64_t>(info_[UMFPACK_PEAK_MEMORY] * info_[UMFPACK_SIZE_OF_UNIT]);
  }
  void solve(int columns) override {
    for (int j = 0; j < columns; ++j) {
      require(umfpack_dl_solve(UMFPACK_At, offsets_.data(), indices_.data(), system_.a.values.data(),
                               x_.data() + j * system_.a.n, system_.b.data() + j * system_.a.n, numeric_,
                               control_, info_));
    }
  }
  Facts facts() override {
    facts_.version = UMFPACK_VERSION;
    facts_.vectors = "host";
    return facts_;
  }

 private:
  static void require(Long status) {
    if (status != UMFPACK_OK) throw std::runtime_error("UMFPACK: status " + std::to_string(status));
  }

  double control_[UMFPACK_CONTROL], info_[UMFPACK_INFO];
  void* symbolic_ = nullptr;
  void* numeric_ = nullptr;
  Facts facts_;
};

MakeCandidate maker_of(const std::string& name) {
  if (name == "cholmod") return [](const System& system) { return std::make_unique<Cholmod>(system); };
  if (name == "umfpack") return [](const System& system) { return std::make_unique<Umfpack>(system); };
  throw std::invalid_argument("--solver: '" + name + "' is none of cholmod and umfpack");
}

struct Arguments {
  std::vector<std::string> cases;
  std::string solvers = "cholmod,umfpack";
  int threads = 1, repeat = 3;
};

void run(const Arguments& arguments) {
  std::vector<std::pair<std::string, MakeCandidate>> makers;
  std::istringstream names(arguments.solvers);
  for (std::string name; std::getline(names, name, ',');) makers.emplace_back(name, maker_of(name));
  for (const std::string& name : arguments.cases) mfs::io::check_bench_case(name);
  for (const std::string& name : arguments.cases) {
    const System system = make_system(name, arguments.threads);
    for (const auto& [solver, make] : makers) {
      nlohmann::ordered_json line{
          {"case", mfs::io::bench_case_name(name)}, {"solver", solver}, {"backend", "host"},
          {"threads", arguments.threads},           {"n", system.a.n},  {"nnz", system.a.offsets.back()}};
      line.update(measure(make, system, arguments.repeat));
      std::printf("%s\n", line.dump().c_str());
      std::fflush(stdout);
    }
  }
}

// OpenBLAS reads its environment when it is loaded, so the program begins once more where that says something
// else.
void begin_with_blas_for(int threads, char** argv) {
  const std::string wanted = std::to_string(threads), kernels = mfs::better_blas_kernels();
  const char* told = std::getenv("OPENBLAS_NUM_THREADS");
  if (told != nullptr && told == wanted && kernels.empty()) return;
  setenv("OPENBLAS_NUM_THREADS", wanted.c_str(), 1);
  if (!kernels.empty()) setenv("OPENBLAS_CORETYPE", kernels.c_str(), 0);
  if (std::getenv("PERF_PEERS_BEGUN") != nullptr) return;
  setenv("PERF_PEERS_BEGUN", "1", 1);
  execv("/proc/self/exe", argv);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("CHOLMOD and UMFPACK as JSON lines");
  app.add_option("cases", arguments.cases, "FAMILY:SIZE or a file, Matrix Market or PETSc binary")
      ->required();
  app.add_option("--solver", arguments.solvers, "cholmod, umfpack, or both with a comma");
  app.add_option("--threads", arguments.threads, "of reading and of OpenBLAS")->check(CLI::PositiveNumber);
  app.add_option("--repeat", arguments.repeat, "factorizations and solves that are timed")
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    begin_with_blas_for(arguments.threads, argv);
    run(arguments);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "perf_peers: %s\n", error.what());
    return 2;
  }
}
