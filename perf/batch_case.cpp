#include "perf/batch_case.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <stdexcept>

#include "perf/measure.hpp"

namespace mfs::perf {

namespace {

constexpr int kMotions = 6, kForces = 5;  // of a body, of a joint

class Chain {
 public:
  explicit Chain(int bodies) : bodies_(bodies) {}

  cases::FamilyMatrix matrix() {
    for (int body = 0; body < bodies_; ++body) add_body(body);
    for (int joint = 0; joint < bodies_; ++joint) add_joint(joint, kForces);
    add_joint(bodies_, 2);  // the last body's end
    cases::FamilyMatrix a;
    a.n = n();
    a.offsets.push_back(0);
    for (int row = 0; row < n(); ++row) {
      for (const auto& [column, value] : rows_[row]) {
        a.column_indices.push_back(column);
        a.values.push_back(value);
      }
      a.offsets.push_back(static_cast<std::int64_t>(a.values.size()));
    }
    return a;
  }

 private:
  int n() const { return bodies_ * (kMotions + kForces) + 2; }
  double entry() { return distribution_(engine_); }

  // Mass, and a part of the damping and stiffness of an implicit step.
  void add_body(int body) {
    for (int i = 0; i < kMotions; ++i) {
      for (int j = 0; j < kMotions; ++j)
        rows_[body * kMotions + i][body * kMotions + j] = (i == j ? 4.0 : 0.0) + 0.5 * entry();
    }
  }
  // Joint j holds bodies j - 1, if there is one, and j, if there is one.
  void add_joint(int joint, int forces) {
    const int first = bodies_ * kMotions + joint * kForces;
    for (int body = std::max(joint - 1, 0); body <= std::min(joint, bodies_ - 1); ++body) {
      for (int i = 0; i < forces; ++i) {
        for (int j = 0; j < kMotions; ++j) {
          const double value = (i == j ? 1.0 : 0.0) + 0.3 * entry();
          rows_[first + i][body * kMotions + j] = value;
          rows_[body * kMotions + j][first + i] = value;
        }
      }
    }
  }

  const int bodies_;
  std::map<int, std::map<int, double>> rows_;
  std::mt19937_64 engine_{7};
  std::uniform_real_distribution<double> distribution_{-1, 1};
};

cases::FamilyMatrix matrix_of(const std::string& name) {
  const std::string chain = "chain:";
  if (name.rfind(chain, 0) != 0) return make_system(name, 1).a;
  const int bodies = std::stoi(name.substr(chain.size()));
  if (bodies < 2) throw std::invalid_argument(name + ": a chain has two bodies or more");
  return Chain(bodies).matrix();
}

}  // namespace

BatchCase make_batch_case(const std::string& name, std::int64_t count) {
  BatchCase batch;
  batch.a = matrix_of(name);
  batch.count = count;
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> distribution(-1, 1);
  batch.values.reserve(batch.a.values.size() * static_cast<std::size_t>(count));
  for (std::int64_t k = 0; k < count; ++k) {
    for (const double value : batch.a.values)
      batch.values.push_back(value * (1 + 0.1 * distribution(engine)));
    for (std::int64_t i = 0; i < batch.a.n; ++i) batch.b.push_back(distribution(engine));
  }
  return batch;
}

double worst_error(const BatchCase& batch, const double* x) {
  const std::int64_t n = batch.a.n, entries = batch.a.offsets.back();
  double worst = 0;
  for (std::int64_t k = 0; k < batch.count; ++k) {
    const Errors errors =
        column_errors(batch.a, batch.values.data() + k * entries, batch.b.data() + k * n, x + k * n);
    worst = std::max(worst, errors.backward);
  }
  return worst;
}

}  // namespace mfs::perf
