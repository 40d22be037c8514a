#include "perf/measure.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <utility>
#include <variant>

#include <mfs/mfs.hpp>

#include "ordering/stopwatch.hpp"
#include "perf/chain.hpp"
#include "perf/device_info.hpp"
#include "solver/program/bench_case.hpp"

namespace mfs::perf {
namespace {

constexpr double kTolerance = 1e-12;  // of the backward error: mfs::SolveOptions' default
constexpr int kMostRefinements = 4;

template <class Call>
double seconds(const Call& call) {
  const Stopwatch watch;
  call();
  return watch.seconds();
}

struct Times {
  double least = 0, median = 0;
};

template <class Call>
Times repeated(int repeat, const Call& call) {
  std::vector<double> times(static_cast<std::size_t>(repeat));
  for (double& time : times) time = seconds(call);
  std::sort(times.begin(), times.end());
  const std::size_t half = times.size() / 2;
  return {times.front(), times.size() % 2 ? times[half] : (times[half - 1] + times[half]) / 2};
}

/// Of the bits of a solution (Fowler, Noll and Vo, 64 bits), to see that two are the same.
std::string hash_of(const double* x, std::int64_t count) {
  std::uint64_t hash = 14695981039346656037u;
  for (std::int64_t i = 0; i < count; ++i) {
    std::uint64_t bits;
    std::memcpy(&bits, x + i, sizeof bits);
    hash = (hash ^ bits) * 1099511628211u;
  }
  return std::to_string(hash);
}

struct SolveFigures {
  Times one, many;
  Errors errors_one, errors_many;
  double worst() const { return std::max(errors_one.backward, errors_many.backward); }
};

class Measurement {
 public:
  /// `bytes`: of the device that others have taken.
  Measurement(Candidate& candidate, const System& system, int repeat, std::int64_t bytes,
              nlohmann::ordered_json& json)
      : candidate_(candidate),
        system_(system),
        repeat_(repeat),
        others_bytes_(bytes),
        json_(json),
        x_(system.b.size()) {}

  void run() {
    analyze();
    factor();
    solve();
    add_facts();
  }

 private:
  void analyze() {
    AnalysisTime time;
    json_["analysis_s"] = seconds([&] { time = candidate_.analyze(); });
    json_["reorder_s"] = time.reorder;
    json_["symbolic_s"] = time.symbolic;
  }

  // Whether new factors of the same values give the same bits is seen from all right-hand sides.
  void factor() {
    json_["first_factor_s"] = seconds([&] { candidate_.factor(); });
    candidate_.solve(1);
    bytes_one_ = device_bytes_in_use() - others_bytes_;
    const std::vector<double> first = solution();
    const Times times = repeated(repeat_, [&] { candidate_.refactor(); });
    json_["refactor_s"] = times.least;
    json_["refactor_median_s"] = times.median;
    json_["bitwise_equal"] = std::memcmp(first.data(), solution().data(), first.size() * sizeof(double)) == 0;
  }

  std::vector<double> solution() {
    candidate_.solve(kColumns);
    candidate_.read_solution(kColumns, x_.data());
    return x_;
  }

  void solve() {
    SolveFigures figures = solve_figures();
    if (figures.worst() > kTolerance && candidate_.refine(1)) {
      json_["unrefined_solve_1_s"] = figures.one.least;
      json_["unrefined_solve_16_s"] = figures.many.least;
      json_["unrefined_backward_error"] = figures.worst();
      int steps = 1;
      for (figures = solve_figures(); figures.worst() > kTolerance && steps < kMostRefinements;
           figures = solve_figures())
        candidate_.refine(++steps);
    }
    json_["solve_1_s"] = figures.one.least;
    json_["solve_1_median_s"] = figures.one.median;
    json_["solve_16_s"] = figures.many.least;
    json_["solve_16_median_s"] = figures.many.median;
    json_["backward_error_1"] = figures.errors_one.backward;
    json_["backward_error_16"] = figures.errors_many.backward;
    json_["residual_1"] = figures.errors_one.residual;
    json_["residual_16"] = figures.errors_many.residual;
    json_["accurate"] = figures.worst() <= kTolerance;
    step();
  }

  // A factorization with the first solve after it, which may have to find out what later ones know.
  void step() {
    const Times times = repeated(repeat_, [&] {
      candidate_.refactor();
      candidate_.solve(1);
    });
    json_["step_s"] = times.least;
    json_["step_median_s"] = times.median;
  }

  SolveFigures solve_figures() {
    SolveFigures figures;
    for (const int columns : {1, kColumns}) {
      candidate_.solve(columns);  // memory for so many columns is taken once
      const Times times = repeated(repeat_, [&] { candidate_.solve(columns); });
      candidate_.read_solution(columns, x_.data());
      json_["solution_" + std::to_string(columns)] = hash_of(x_.data(), system_.a.n * columns);
      (columns == 1 ? figures.one : figures.many) = times;
      (columns == 1 ? figures.errors_one : figures.errors_many) = errors_of(system_, x_.data(), columns);
    }
    return figures;
  }

  // Of the arrays that the caller has from the start, one that solves for one column needs a part.
  void add_facts() {
    const Facts facts = candidate_.facts();
    const std::int64_t caller = candidate_.caller_bytes(kColumns), caller_one = candidate_.caller_bytes(1);
    json_["refinement_steps"] = facts.refinement_steps;
    json_["perturbed_pivots"] = facts.perturbed_pivots;
    json_["factor_entries"] = facts.factor_entries;
    json_["flops"] = facts.flops;
    json_["device_bytes"] = device_bytes_in_use() - others_bytes_;
    json_["device_bytes_caller"] = caller;
    json_["device_bytes_1"] = bytes_one_ - caller + caller_one;
    json_["device_bytes_1_caller"] = caller_one;
    json_["device_bytes_said"] = facts.device_bytes;
    json_["device_bytes_held"] = device_bytes_in_use() - caller;  // with the context
    json_["segments"] = facts.segments;
    json_["bytes_out"] = facts.bytes_out;
    json_["bytes_in"] = facts.bytes_in;
    json_["bytes_back"] = facts.bytes_back;
    json_["vectors"] = facts.vectors;
    json_["version"] = facts.version;
  }

  Candidate& candidate_;
  const System& system_;
  int repeat_;
  std::int64_t others_bytes_, bytes_one_ = 0;
  nlohmann::ordered_json& json_;
  std::vector<double> x_;
};

/// With the entries of a row sorted, and those of one place summed, as every solver takes them.
FamilyMatrix summed(const io::CsrMatrix<double>& a) {
  FamilyMatrix result{a.rows, {0}, {}, {}};
  result.column_indices.reserve(a.column_indices.size());
  result.values.reserve(a.values.size());
  std::vector<std::pair<std::int32_t, double>> row;
  for (std::int64_t i = 0; i < a.rows; ++i) {
    row.clear();
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      row.emplace_back(a.column_indices[k], a.values[k]);
    std::stable_sort(row.begin(), row.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    for (const auto& [column, value] : row) {
      if (static_cast<std::int64_t>(result.values.size()) > result.offsets.back() &&
          result.column_indices.back() == column) {
        result.values.back() += value;
        continue;
      }
      result.column_indices.push_back(column);
      result.values.push_back(value);
    }
    result.offsets.push_back(static_cast<std::int64_t>(result.values.size()));
  }
  return result;
}

}  // namespace

System make_system(const std::string& name, int threads) {
  System system;
  if (const auto chain = chain_of(name)) {
    system.a = *chain;
  } else {
    const io::SquareMatrix matrix = io::load_bench_case(name, threads);
    const auto* a = std::get_if<io::CsrMatrix<double>>(&matrix);
    if (!a) throw InvalidInput(name, "the matrix is complex");
    system.a = summed(*a);
  }
  system.b.resize(static_cast<std::size_t>(system.a.n * kColumns));
  std::mt19937_64 random(3);
  for (double& value : system.b) value = static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
  return system;
}

Errors column_errors(const FamilyMatrix& a, const double* values, const double* b, const double* x) {
  double backward = 0, residual = 0, norm_a = 0, norm_x = 0, norm_b = 0;
  bool finite = true;
#pragma omp parallel for schedule(static) reduction(max : backward, residual, norm_a, norm_x, norm_b) reduction(&& : finite)
  for (std::int64_t row = 0; row < a.n; ++row) {
    long double sum = b[row], scale = std::abs(b[row]);
    double row_norm = 0;
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      const long double term = static_cast<long double>(values[k]) * x[a.column_indices[k]];
      sum -= term;
      scale += std::abs(term);
      row_norm += std::abs(values[k]);
    }
    finite = finite && std::isfinite(x[row]);
    const double rest = static_cast<double>(std::abs(sum));
    if (scale > 0) backward = std::max(backward, static_cast<double>(rest / scale));
    residual = std::max(residual, rest);
    norm_a = std::max(norm_a, row_norm);
    norm_x = std::max(norm_x, std::abs(x[row]));
    norm_b = std::max(norm_b, std::abs(b[row]));
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return finite ? Errors{backward, residual / (norm_a * norm_x + norm_b)} : Errors{kInfinity, kInfinity};
}

Errors errors_of(const System& system, const double* x, int columns) {
  Errors worst;
  for (int j = 0; j < columns; ++j) {
    const Errors errors =
        column_errors(system.a, system.a.values.data(), system.b.data() + j * system.a.n, x + j * system.a.n);
    worst = {std::max(worst.backward, errors.backward), std::max(worst.residual, errors.residual)};
  }
  return worst;
}

nlohmann::ordered_json measure(const MakeCandidate& make, const System& system, int repeat) {
  nlohmann::ordered_json json{{"status", "solved"}, {"message", ""}};
  try {
    const std::int64_t before = device_bytes_in_use();
    const std::unique_ptr<Candidate> candidate = make(system);
    Measurement(*candidate, system, repeat, before, json).run();
  } catch (const std::exception& error) {
    json["status"] = "failed";
    json["message"] = error.what();
  }
  return json;
}

}  // namespace mfs::perf
