// The subcommands that do not integrate: static, modes, linearize.
#include <omp.h>

#include <algorithm>

#include <fmt/format.h>

#include <mfs/error.hpp>

#include "dae/output/plots.hpp"
#include "dae/program/commands.hpp"
#include "dae/program/host_threads.hpp"
#include "dae/program/mode_files.hpp"
#include "dae/program/result_files.hpp"
#include "dae/statics/equilibrium.hpp"
#include "dae/statics/linearization.hpp"
#include "dae/statics/modes.hpp"
#include "solver/program/output_file.hpp"
#include "solver/program/summary.hpp"

namespace mfs::dae {
namespace {

using program::ExitCode;

State equilibrium(const MultibodyModel& model, EquilibriumReport* report = nullptr) {
  return find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}}, report);
}

/// Takes the first output and ends the run.
class FirstOutput : public Observer {
 public:
  struct Taken {};
  void output(const State& state) override {
    taken = state;
    throw Taken();
  }
  State taken;
};

/// Of the motion at time t, with accelerations and multipliers.
State state_at(MultibodyModel& model, double t) {
  start_model(model);
  Integrator integrator = make_integrator(model);
  FirstOutput first;
  try {
    integrator.run(0.0, model.q0, model.v0, std::max(t, model.end), {t}, first);
  } catch (const FirstOutput::Taken&) {
  }
  return first.taken;
}

State state_of(MultibodyModel& model, const Command& command) {
  return command.at ? state_at(model, *command.at) : equilibrium(model);
}

std::string where(const Command& command) {
  return command.at ? fmt::format("in motion at t = {} s", *command.at) : "at rest";
}

}  // namespace

void start_model(MultibodyModel& model) {
  if (model.starts_at_rest) model.q0 = equilibrium(model).q;
}

ExitCode solve_static(const Command& command) {
  const MultibodyModel model = load_model(command);
  EquilibriumReport report;
  const State state = equilibrium(model, &report);
  ResultFiles(model, command.folder, host_threads(command.threads, command.backend, omp_get_num_procs()))
      .add_output(state);
  io::print(program::labelled("equilibrium", fmt::format("{}: {} steps, largest force left {:.1e}",
                                                         model.name, report.iterations, report.force)) +
            program::labelled("ParaView", command.folder + "/result.pvd"));
  show_plots(draw_plots(command.folder));
  return ExitCode::solved;
}

ExitCode list_modes(const Command& command) {
  MultibodyModel model = load_model(command);
  const State state = state_of(model, command);
  const std::vector<Mode> modes = find_modes(*model.system, state, command.modes, model.integrator.threads,
                                             command.undamped ? Damping::left_out : Damping::as_it_is);
  std::string text = fmt::format("{}, {}: {} modes\n", model.name, where(command), modes.size());
  text += "mode   frequency [Hz]   damping ratio      real [1/s]  imaginary [1/s]\n";
  for (std::size_t i = 0; i < modes.size(); ++i)
    text += fmt::format("{:4} {:16.8g} {:15.4g} {:15.6g} {:16.8g}\n", i + 1, natural_frequency(modes[i]),
                        damping_ratio(modes[i]), modes[i].s.real(), modes[i].s.imag());
  io::print(text);
  if (command.folder.empty()) return ExitCode::solved;
  write_modes(model, state, modes, command.folder);
  io::print(program::labelled("ParaView", command.folder + "/mode_001.pvd, ..."));
  show_plots(draw_modes(command.folder));
  return ExitCode::solved;
}

ExitCode linearize_model(const Command& command) {
  MultibodyModel model = load_model(command);
  write_linearization(*model.system, state_of(model, command), command.folder);
  io::print(program::labelled("matrices", fmt::format("{}, {}: M, D, K, Phi_q, F in {}", model.name,
                                                      where(command), command.folder)));
  return ExitCode::solved;
}

}  // namespace mfs::dae
