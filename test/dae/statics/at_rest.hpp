// Models that come to rest.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "dae/statics/equilibrium.hpp"
#include "test/dae/statics/models.hpp"

namespace mfs::test {

class AtRest : public testing::Test {
 protected:
  void find(const dae::Json& json) {
    model_ = dae::make_model(json, "", 1);
    model_.integrator.threads = 1;
    state_ = dae::find_equilibrium(*model_.system, model_.integrator, {0.0, model_.q0, model_.v0, {}, {}},
                                   &report_);
  }
  double q(const std::string& name) const { return state_.q[coordinate(*model_.system, name)]; }

  dae::MultibodyModel model_;
  dae::State state_;
  dae::EquilibriumReport report_;
};

}  // namespace mfs::test
