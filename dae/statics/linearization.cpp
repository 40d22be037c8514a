#include "dae/statics/linearization.hpp"

#include <filesystem>

#include <fmt/format.h>

#include <mfs/error.hpp>
#include <mfs/matrix_market.hpp>

#include "parts/output_file.hpp"

namespace mfs::dae {
namespace {

void write_block(const std::string& path, const Pattern& pattern, const std::vector<double>& values,
                 const std::string& comment) {
  const std::vector<std::int64_t> offsets(pattern.row_start.begin(), pattern.row_start.end());
  write_matrix_market(
      path,
      CsrView<double>{pattern.rows, pattern.columns, offsets.data(), pattern.column.data(), values.data()},
      comment);
}

/// Names have commas: "joint pin, equation 2 of 5".
void write_rows(const ConstrainedSystem& system, const State& state, const std::string& path) {
  io::OutputFile file(path);
  std::string text = "row,of,name,value\n";
  const auto add = [&](int row, const char* of, const std::string& name, double value) {
    text += fmt::format("{},{},\"{}\",{}\n", row, of, name, value);
  };
  for (int i = 0; i < system.coordinates(); ++i)
    add(i + 1, "coordinate", system.coordinate_name(i), state.q[i]);
  for (int j = 0; j < system.constraints(); ++j)
    add(j + 1, "constraint", system.constraint_name(j), state.lambda[j]);
  file.write(text);
}

}  // namespace

std::vector<std::string> write_linearization(const ConstrainedSystem& system, const State& state,
                                             const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InvalidInput(folder, "cannot be made: " + error.message());
  const StateView view{state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()};
  const TangentPattern& pattern = system.tangent_pattern();
  Tangent tangent = make_tangent(system);
  system.evaluate(view, tangent, BlockSet::all());
  std::vector<std::string> names;
  const auto write = [&](const char* name, Block block, const char* what) {
    names.emplace_back(name);
    write_block(folder + "/" + name + ".mtx", pattern[block], tangent[block],
                fmt::format("{} at t = {} s", what, state.t));
  };
  write("M", Block::force_a, "mass");
  write("D", Block::force_v, "damping, dF/dv");
  write("K", Block::force_q, "stiffness, dF/dq");
  write("Phi_q", Block::position_q, "derivatives of the constraints");
  bool rolls = false;
  for (int row = 0; row < system.constraints(); ++row) rolls = rolls || system.is_nonholonomic(row);
  if (rolls) write("V_q", Block::velocity_q, "derivatives of Phi_q v by q");
  Residual residual = make_residual(system);
  system.evaluate(view, residual);
  std::vector<double> rest = residual.force;
  rest.insert(rest.end(), residual.position.begin(), residual.position.end());
  const auto size = static_cast<std::int64_t>(rest.size());
  write_matrix_market(folder + "/F.mtx", rest.data(), size, 1, size, "F and Phi: 0 where the state is true");
  names.emplace_back("F");
  write_rows(system, state, folder + "/rows.csv");
  return names;
}

}  // namespace mfs::dae
