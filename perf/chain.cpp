#include "perf/chain.hpp"

#include <map>
#include <random>
#include <stdexcept>

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

}  // namespace

std::optional<cases::FamilyMatrix> chain_of(const std::string& name) {
  if (!is_chain(name)) return std::nullopt;
  const int bodies = std::stoi(name.substr(name.find(':') + 1));
  if (bodies < 2) throw std::invalid_argument(name + ": a chain has two bodies or more");
  return Chain(bodies).matrix();
}

}  // namespace mfs::perf
