// A group whose shares mean nothing mechanically: numbers made from the state and the place, so that a share
// that is lost, doubled or put in the wrong place shows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "dae/mechanics/element_group.hpp"

namespace mfs::test {

class ArtificialGroup final : public dae::ElementGroup {
 public:
  ArtificialGroup(std::string name, int nq, int nc, std::vector<int> coordinates,
                  dae::LocalStructure structure)
      : name_(std::move(name)),
        nq_(nq),
        nc_(nc),
        coordinates_(std::move(coordinates)),
        structure_(structure) {}

  int size() const override { return static_cast<int>(coordinates_.size()) / nq_; }
  int local_coordinates() const override { return nq_; }
  int local_constraints() const override { return nc_; }
  const int* coordinates(int e) const override { return coordinates_.data() + e * nq_; }
  dae::LocalStructure structure() const override { return structure_; }
  /// Whether entry (i, j) of an element's block of this kind may differ from zero.
  bool has_entry(dae::LocalStructure::Kind kind, int i, int j) const {
    using Kind = dae::LocalStructure::Kind;
    return kind == Kind::dense ? std::min(i, j) >= structure_.coupled_from : kind == Kind::diagonal && i == j;
  }
  std::string name(int e) const override { return name_ + ", element " + std::to_string(e); }

  void residual(int e, const dae::LocalState& s, dae::LocalResidual& r) const override {
    if (e == throws_at) throw std::runtime_error(name(e));
    for (int k = 0; k < nq_; ++k) r.force[k] += number(e, k, 1) * s.q[k] + s.v[k] * s.t + 0.1 * s.a[k];
    for (int i = 0; i < nc_; ++i) {
      r.position[i] = number(e, i, 2) * s.q[i % nq_];
      r.velocity[i] = number(e, i, 3) * s.v[i % nq_];
      r.acceleration[i] = number(e, i, 4) * s.a[i % nq_] + s.lambda[i];
    }
  }
  void tangent(int e, const dae::LocalState& s, dae::LocalTangent& t) const override {
    fill(t.force_q, structure_.force_q, e, 5, s);
    fill(t.force_v, structure_.force_v, e, 6, s);
    fill(t.force_a, structure_.force_a, e, 7, s);
    double* const blocks[] = {t.position_q, t.velocity_q, t.acceleration_q, t.acceleration_v};
    for (int b = 0; b < 4; ++b)
      for (int i = 0; i < nc_ * nq_; ++i) blocks[b][i] = number(e, i, 8 + b) * s.q[i % nq_];
  }

  int throws_at = -1;
  /// Plays a group that a device evaluates: how often F was begun and taken.
  struct Device {
    int begun = 0, taken = 0;
  };
  std::shared_ptr<Device> device;

  std::unique_ptr<dae::DeviceForce> device_force(int coordinates, int) const override {
    return device == nullptr ? nullptr : std::make_unique<Played>(*this, coordinates);
  }

 private:
  // The same sums as the host's, by itself.
  class Played final : public dae::DeviceForce {
   public:
    Played(const ArtificialGroup& group, int coordinates)
        : group_(group), tangent_({coordinates, coordinates, {}, {}}) {}
    void begin(const dae::StateView& state) override {
      ++group_.device->begun;
      sum_.clear();
      const auto nq = static_cast<std::size_t>(group_.nq_);
      std::vector<double> q(nq), v(nq), a(nq);
      for (int e = 0; e < group_.size(); ++e) {
        const int* c = group_.coordinates(e);
        for (std::size_t k = 0; k < nq; ++k) {
          q[k] = state.q[c[k]];
          v[k] = state.v[c[k]];
          a[k] = state.a[c[k]];
        }
        sum_.resize(sum_.size() + nq);
        dae::LocalResidual residual{&sum_[sum_.size() - nq], nullptr, nullptr, nullptr};
        group_.residual(e, {state.t, q.data(), v.data(), a.data(), nullptr}, residual);
      }
    }
    void add_to(std::vector<double>& force) override {
      ++group_.device->taken;
      for (std::size_t k = 0; k < sum_.size(); ++k) force[group_.coordinates_[k]] += sum_[k];
    }
    void write(const dae::Executor&, const dae::StateView& state, double* force) override {
      begin(state);
      for (std::size_t k = 0; k < sum_.size(); ++k) force[group_.coordinates_[k]] += sum_[k];
    }
    // Its derivatives are nobody's business but the integrator's.
    const dae::Pattern& pattern() const override { return tangent_; }
    std::unique_ptr<dae::RemoteMatrix> make_matrix(std::size_t, const std::vector<int>&) override {
      return nullptr;
    }
    void place(const std::array<const int*, 3>&, dae::RemoteMatrix&) override {}
    void begin_tangent(const dae::StateView&) override {}
    void begin_tangent(const dae::Executor&, const dae::StateView&) override {}
    void add_diagonals(const dae::ByAVQ&, dae::DiagonalsByAVQ&) override {}
    void begin_sum(const dae::ByAVQ&) override {}

   private:
    const ArtificialGroup& group_;
    std::vector<double> sum_;
    dae::Pattern tangent_;
  };

  static double number(int e, int k, int kind) { return std::sin(1.0 + e + 0.37 * k + 11.0 * kind); }
  void fill(double* block, dae::LocalStructure::Kind kind, int e, int seed, const dae::LocalState& s) const {
    using Kind = dae::LocalStructure::Kind;
    if ((block == nullptr) != (kind == Kind::zero)) throw std::logic_error("block given where there is none");
    if (kind == Kind::zero) return;
    for (int i = 0; i < nq_; ++i)
      for (int j = 0; j < nq_; ++j)
        if (has_entry(kind, i, j)) block[i * nq_ + j] += number(e, i * nq_ + j, seed) * s.q[j];
  }

  std::string name_;
  int nq_, nc_;
  std::vector<int> coordinates_;
  dae::LocalStructure structure_;
};

}  // namespace mfs::test
