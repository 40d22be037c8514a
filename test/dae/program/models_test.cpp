// The models that come with the program, coarse and for 1 s with 100 outputs, from end to end.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "test/dae/program/results.hpp"
#include "test/program/run_program.hpp"

namespace {

using nlohmann::ordered_json;
using testing::HasSubstr;

class DaeModels : public testing::TestWithParam<const char*> {
 protected:
  // Runs the model and gives back the report.
  ordered_json run(const std::string& backend) {
    const std::string models = folder_.path("models");
    EXPECT_EQ(run_program({"models", "--write", models}).code, 0);
    const ProgramRun run =
        run_program({"run", models + "/" + GetParam() + ".json", "-o", folder_.path(backend), "--backend",
                     backend, "--threads", "2", "--json", "-"});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    return ordered_json::parse(run.out);
  }
  TemporaryFolder folder_;
};

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

// "bodies.arm.velocity.x [m/s]" -> "velocity"
std::string quantity_of(const std::string& column) {
  std::istringstream parts(column.substr(0, column.find(' ')));
  std::string kind, name, quantity;
  std::getline(parts, kind, '.');
  std::getline(parts, name, '.');
  return std::getline(parts, quantity, '.') ? quantity : kind;
}

void expect_steps_and_report_to_agree(const Table& steps, const ordered_json& report) {
  const std::vector<double>& t = steps.at("t [s]");
  ASSERT_EQ(t.size(), report["steps"].get<std::size_t>());
  EXPECT_EQ(t.back(), 1.0);
  for (std::size_t i = 0; i < t.size(); ++i)
    EXPECT_NEAR(t[i] - (i ? t[i - 1] : 0.0), steps.at("h [s]")[i], 1e-12);
  EXPECT_EQ(sum(steps.at("newton")), report["newton_iterations"].get<double>());
  EXPECT_LE(sum(steps.at("factorizations")), report["factorizations"].get<double>());
  EXPECT_EQ(sum(steps.at("rejections")), report["error_rejections"].get<double>() +
                                             report["newton_rejections"].get<double>() +
                                             report["solver_rejections"].get<double>());
  EXPECT_LE(largest(steps.at("order")), 5);
}

void expect_sensible_report(const ordered_json& report) {
  EXPECT_EQ(report["status"], "solved");
  // What the models do not say is IntegratorOptions' default.
  EXPECT_LE(report["violation"][0].get<double>(), 1e-8);
  EXPECT_LE(report["violation"][1].get<double>(), 1e-6);
  EXPECT_LE(report["violation"][2].get<double>(), 1e-4);
  double parts = 0;
  for (const char* key : {"time_reordering", "time_factor", "time_solve", "time_assembly", "time_rest"}) {
    EXPECT_GE(report[key].get<double>(), 0) << key;
    parts += report[key].get<double>();
  }
  EXPECT_NEAR(parts, report["time_total"].get<double>(), 1e-6 * parts);
  EXPECT_GT(report["bytes_solver"].get<double>(), 0);
  EXPECT_GT(report["bytes_peak"], report["bytes_solver"]);
}

TEST_P(DaeModels, RunAndLeaveWhatTheySay) {
  const ordered_json report = run("openmp");
  expect_sensible_report(report);
  expect_steps_and_report_to_agree(read_table(folder_.path("openmp/steps.csv")), report);
  const Table series = read_table(folder_.path("openmp/time_series.csv"));
  const std::string list = text_of(folder_.path("openmp/result.pvd"));
  int bodies = 0;
  for (const auto& [name, values] : series) {
    ASSERT_EQ(values.size(), 101U) << name;
    for (const double value : values) ASSERT_TRUE(std::isfinite(value)) << name;
    // What is recorded beside the overview has a point in its name, and may be zero.
    if (name == "t [s]" || name.find("_node") != std::string::npos || name.find('.') != std::string::npos)
      continue;
    EXPECT_GT(largest(values), 0) << name;
    if (name.rfind("von_mises ", 0) != 0) continue;
    ++bodies;
    // Steel that bends, and does not break.
    EXPECT_GT(largest(values), 1e5) << name;
    EXPECT_LT(largest(values), 3e8) << name;
    const std::string body = name.substr(10, name.rfind(' ') - 10);
    for (const char* number : {"0000", "0050", "0100"}) {
      const std::string file = "vtu/" + body + "_" + number + ".vtu";
      EXPECT_THAT(list, HasSubstr("file=\"" + file + "\""));
      EXPECT_THAT(text_of(folder_.path("openmp/" + file)), HasSubstr("Name=\"von_mises\""));
    }
  }
  EXPECT_GE(bodies, 1);
}

// Equation (9) of Jung and Bae (Multibody System Dynamics 2017): the largest difference of a result, relative
// to its largest value.
TEST_P(DaeModels, BackendsAgree) {
  run("openmp");
  run("serial");
  const Table openmp = read_table(folder_.path("openmp/time_series.csv")),
              serial = read_table(folder_.path("serial/time_series.csv"));
  ASSERT_EQ(openmp.size(), serial.size());
  std::map<std::string, double> sizes;  // of each quantity, the largest of all bodies or joints
  for (const auto& [name, values] : openmp)
    for (const double value : values) {
      double& size = sizes[quantity_of(name)];
      size = std::max(size, std::abs(value));
    }
  for (const auto& [name, values] : openmp) {
    if (name.find("_node") != std::string::npos) continue;  // of two that are equal, rounding decides
    const std::vector<double>& other = serial.at(name);
    ASSERT_EQ(values.size(), other.size());
    double difference = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      difference = std::max(difference, std::abs(values[i] - other[i]));
    if (name.find('.') == std::string::npos)
      EXPECT_LT(difference, 1e-7 * largest(values)) << name;
    else  // a component may be zero beside the others
      EXPECT_LE(difference, 1e-6 * sizes.at(quantity_of(name))) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(OfTheLibrary, DaeModels,
                         testing::Values("crank_piston", "suspension", "bell_crank"));

// Newton's method does not converge with a first step of 1 s.
TEST(FixedStep, TellsOfStepsThatAreShorterThanAskedFor) {
  TemporaryFolder folder;
  ordered_json json =
      ordered_json::parse(R"({"name": "pendulum", "end": 1, "outputs": 4, "gravity": [0, -9.81, 0],
    "bodies": {"p": {"type": "rigid", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [0.5, 0, 0]}},
    "joints": {"h": {"type": "revolute", "a": "ground", "b": "p", "point": [0, 0, 0], "axis": [0, 0, 1]}}})");
  for (const double step : {2.0, 0.01}) {
    json["integrator"] = {{"fixed_step", step}};
    const ProgramRun run = run_program(
        {"run", folder.write("pendulum.json", json.dump()), "-o", folder.path("out"), "--no-plots"});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.out.find("than a tenth shorter than") != std::string::npos, step > 1) << run.out;
  }
}

}  // namespace
