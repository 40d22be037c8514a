// The subcommands that do not integrate: static, modes, linearize.
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <mfs/error.hpp>

#include "dae/output/plots.hpp"
#include "dae/program/commands.hpp"
#include "dae/program/host_threads.hpp"
#include "dae/program/mode_files.hpp"
#include "dae/program/result_files.hpp"
#include "dae/program/run_progress.hpp"
#include "dae/program/run_report.hpp"
#include "dae/statics/equilibrium.hpp"
#include "dae/statics/linearization.hpp"
#include "dae/statics/modes.hpp"
#include "dae/statics/steady_motion.hpp"
#include "ordering/stopwatch.hpp"
#include "parts/interrupt.hpp"
#include "parts/output_file.hpp"
#include "parts/report_text.hpp"

namespace mfs::dae {
namespace {

using program::ExitCode;

bool go_on() {
  return !program::is_interrupted();
}

/// What to know of an equilibrium beside where it is.
std::vector<std::string> stability_notes(const EquilibriumReport& report) {
  if (report.grows_most.empty()) return {};
  const std::string swings =
      report.swings > 0 ? fmt::format("swings at {:.3g} Hz and ", 0.5 * report.swings / std::acos(-1.0)) : "";
  const char* const besides = report.is_mode    ? ""
                              : report.as_given ? " where nothing damps it; it is where the model begins"
                                                : " where nothing damps it, and no other has been found";
  return {
      fmt::format("this equilibrium is unstable: a small motion, in which {} moves most, {}grows by e in "
                  "{:.3g} s{}",
                  report.grows_most, swings, 1.0 / report.growth, besides)};
}

/// Where flexible bodies are evaluated for statics: derivatives of forces on a device stay there
/// (RemoteTangent), and statics composes its matrices on the host.
Backend where_derivatives_are(Backend solver) {
  return backend_info(solver).memory == MemorySpace::device ? Backend::openmp : solver;
}

State search_rest(const MultibodyModel& model, EquilibriumReport& report) {
  return find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}}, &report, go_on);
}

/// `notes`: overwritten.
State equilibrium(const MultibodyModel& model, std::vector<std::string>& notes) {
  EquilibriumReport report;
  State state = search_rest(model, report);
  program::throw_if_interrupted();
  notes = stability_notes(report);
  return state;
}

/// Takes the first output and ends the run.
class FirstOutput : public Observer {
 public:
  struct Taken {};
  /// `t`: of that output.
  explicit FirstOutput(double t) : display_(on_terminal_, t) {}
  void step(const StepReport& step, const std::function<const State&()>&) override {
    display_.tell(step.number, step.t);
    program::throw_if_interrupted();
  }
  void output(const State& state) override {
    taken = state;
    throw Taken();
  }
  State taken;

 private:
  program::ProgressDisplay on_terminal_;
  RunDisplay display_;
};

/// Of the motion from q and v at t0 on, at time t, with accelerations and multipliers. `end`: of the motion.
State state_after(const MultibodyModel& model, double t0, const std::vector<double>& q,
                  const std::vector<double>& v, double end, double t) {
  Integrator integrator = make_integrator(model);
  FirstOutput first(t);
  try {
    integrator.run(t0, q, v, end, {t}, first);
  } catch (const FirstOutput::Taken&) {
  }
  return first.taken;
}

/// Of a motion that tells at what rate all precesses: an error of that is one of the modes. So it is with
/// accelerations where the motion begins.
constexpr double kLaterRtol = 1e-8;

/// Of the motion of the model at time t.
State state_at(MultibodyModel& model, double t, std::vector<std::string>& notes) {
  if (model.starts_at_rest) model.q0 = equilibrium(model, notes).q;
  model.integrator.rtol = std::min(model.integrator.rtol, t > 0.0 ? kMotionRtol : kLaterRtol);
  return state_after(model, 0.0, model.q0, model.v0, std::max(t, model.end), t);
}

/// `notes`: overwritten where it is at rest or begins there.
State state_of(MultibodyModel& model, const Command& command, std::vector<std::string>& notes) {
  return command.at ? state_at(model, *command.at, notes) : equilibrium(model, notes);
}

/// To where the motion comes from `state` until t, by a tighter tolerance if that succeeds; where it ends
/// before, as beside a dead point, that is as if it stood still at once, which no steady motion does.
State state_later(MultibodyModel& model, const State& state, double t) {
  State later = state;
  later.t = t;
  const double given = model.integrator.rtol;
  for (const double rtol : {std::min(given, kLaterRtol), given}) {
    model.integrator.rtol = rtol;
    try {
      later = state_after(model, state.t, state.q, state.v, t, t);
      break;
    } catch (const Error&) {
    }
  }
  model.integrator.rtol = given;
  return later;
}

/// In what sense modes about a state that moves are modes.
std::string motion_note(const ModesInMotion& found) {
  if (!found.steady)
    return "the motion is not steady: its matrices change as it goes on; these are the eigenvalues of those "
           "of this moment, and small motions only where they are much faster than that";
  switch (found.axes.kind()) {
    case TurningAxes::Kind::along:
      return fmt::format(
          "all turns as one body, at {:.4g} rad/s: modes are those seen from axes that turn along",
          found.axes.rate());
    case TurningAxes::Kind::precessing:
      return fmt::format(
          "all turns at {:.4g} rad/s, and bodies turn about axes of their symmetry besides: "
          "modes are those seen from axes that turn along",
          found.axes.rate());
    default:
      return "the motion is steady: modes are those seen from the ground";
  }
}

/// Adds to the notes and to the report.
std::vector<Mode> modes_of(MultibodyModel& model, const State& state, const Command& command,
                           std::vector<std::string>& notes, nlohmann::ordered_json& json) {
  const Damping damping = command.undamped ? Damping::left_out : Damping::as_it_is;
  if (!command.at || !TurningAxes(*model.system, state).moves())
    return find_modes(*model.system, state, command.modes, model.integrator.threads, damping, go_on,
                      command.backend);
  ModesInMotion found = find_modes_in_motion(
      *model.system, state, [&](double t) { return state_later(model, state, t); }, command.modes,
      model.integrator.threads, damping, go_on, command.backend);
  notes.push_back(motion_note(found));
  json["steady"] = found.steady;
  return std::move(found.modes);
}

/// Of a frequency, in parts of it: less uncertainty is no matter, and with more a motion may be free.
constexpr double kUncertain = 1e-6, kFree = 0.1;

/// Names modes far slower than what is stiff, of which rounding of its stiffness leaves fewer digits.
void note_rounding(const std::vector<Mode>& modes, std::vector<std::string>& notes) {
  std::vector<std::size_t> numbers;
  double most = 0.0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (!(modes[i].rounding > kUncertain && modes[i].rounding < kFree)) continue;
    numbers.push_back(i + 1);
    most = std::max(most, modes[i].rounding);
  }
  if (!numbers.empty())
    notes.push_back(
        fmt::format("stiff parts move along in slow modes, and rounding of their stiffness may change "
                    "frequencies by up to "
                    "{:.1g} of them: mode {}",
                    most, fmt::join(numbers, ", ")));
}

std::string where(const Command& command) {
  return command.at ? fmt::format("in motion at t = {} s", *command.at) : "at rest";
}

using Json = nlohmann::ordered_json;

/// Does the work, which adds to the report and throws where it is interrupted, and writes the report however
/// that ends.
template <class Work>
ExitCode with_report(const Command& command, const Work& work) {
  program::catch_interrupts();
  if (!command.json.empty()) io::check_writable(command.json);
  Json json{
      {"name", command.model}, {"backend", backend_name(command.backend)}, {"threads", command.threads}};
  const Stopwatch watch;
  const auto write = [&](const char* status, const std::string& message) {
    json["time_total"] = watch.seconds();
    json["bytes_peak"] = peak_memory();
    json["status"] = status;
    json["message"] = message;
    if (!command.json.empty()) io::write_file(command.json, program::one_line(json) + "\n");
  };
  try {
    MultibodyModel model = load_model(command, where_derivatives_are(command.backend));
    json["name"] = model.name;
    json["coordinates"] = model.system->coordinates();
    json["constraints"] = model.system->constraints();
    program::throw_if_interrupted();
    work(model, json);
  } catch (...) {
    const program::Failure failure = program::describe_current_exception();
    write(failure.status, failure.message);
    throw;
  }
  write(program::status_word(ExitCode::solved), "");
  return ExitCode::solved;
}

/// For people, unless standard output is for the report.
void tell(const Command& command, const std::string& text) {
  if (command.json != "-") io::print(text);
}

void tell_notes(const Command& command, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) tell(command, program::labelled("note", note));
}

void tell_plots(const Command& command, PlotOutcome (*draw)(const std::string&)) {
  if (command.json != "-" && command.plots) show_plots(draw(command.folder));
}

void list(const Command& command, const MultibodyModel& model, const std::vector<Mode>& modes, Json& json) {
  std::string text = fmt::format("{}, {}: {} modes\n", model.name, where(command), modes.size());
  text += "mode   frequency [Hz]   damping ratio      real [1/s]  imaginary [1/s]\n";
  json["modes"] = Json::array();
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double frequency = natural_frequency(modes[i]), damping = damping_ratio(modes[i]);
    text += fmt::format("{:4} {:16.8g} {:15.4g} {:15.6g} {:16.8g}\n", i + 1, frequency, damping,
                        modes[i].s.real(), modes[i].s.imag());
    json["modes"].push_back({{"frequency", frequency},
                             {"damping_ratio", damping},
                             {"s", {modes[i].s.real(), modes[i].s.imag()}}});
  }
  tell(command, text);
}

}  // namespace

std::vector<std::string> start_model(const Command& command, MultibodyModel& model) {
  std::vector<std::string> notes;
  if (!model.starts_at_rest) return notes;
  const Backend forces = where_derivatives_are(command.backend);
  if (forces == command.backend) {
    model.q0 = equilibrium(model, notes).q;
  } else {
    model.q0 = equilibrium(load_model(command, forces), notes).q;
  }
  return notes;
}

ExitCode solve_static(const Command& command) {
  return with_report(command, [&](MultibodyModel& model, Json& json) {
    ResultFiles files(model, command.folder,
                      host_threads(command.threads, command.backend, omp_get_num_procs()));
    EquilibriumReport report;
    const auto state = std::make_shared<const State>(search_rest(model, report));
    json["iterations"] = report.iterations;
    json["escapes"] = report.escapes;
    json["force"] = report.force;
    State begin = *state;
    begin.q = report.begin;
    begin.v = model.v0;
    files.look_at(begin, *state);
    files.add_output(state)();
    std::vector<std::string> notes = stability_notes(report);
    notes.insert(notes.end(), files.notes().begin(), files.notes().end());
    json["notes"] = notes;
    const std::string left =
        report.escapes == 0 ? "" : fmt::format("unstable equilibria left behind: {}, ", report.escapes);
    tell(command,
         program::labelled("equilibrium", fmt::format("{}: {}{} steps, {}largest force left {:.1e}",
                                                      model.name, report.stopped ? "not reached, " : "",
                                                      report.iterations, left, report.force)));
    tell_notes(command, notes);
    tell(command, program::labelled("ParaView", command.folder + "/result.pvd"));
    tell_plots(command, draw_plots);
    program::throw_if_interrupted();
  });
}

ExitCode list_modes(const Command& command) {
  return with_report(command, [&](MultibodyModel& model, Json& json) {
    std::vector<std::string> notes;
    const State state = state_of(model, command, notes);
    const std::vector<Mode> modes = modes_of(model, state, command, notes, json);
    note_rounding(modes, notes);
    json["notes"] = notes;
    list(command, model, modes, json);
    tell_notes(command, notes);
    if (!command.folder.empty()) {
      write_modes(model, state, modes, command.folder);
      tell(command, program::labelled("ParaView", command.folder + "/mode_001.pvd, ..."));
      tell_plots(command, draw_modes);
    }
    program::throw_if_interrupted();
  });
}

ExitCode linearize_model(const Command& command) {
  return with_report(command, [&](MultibodyModel& model, Json& json) {
    std::vector<std::string> notes;
    const State state = state_of(model, command, notes);
    const std::vector<std::string> names = write_linearization(*model.system, state, command.folder);
    if (TurningAxes(*model.system, state).moves())
      notes.emplace_back("the mechanism moves: matrices are those of this moment, in axes of the ground");
    json["notes"] = notes;
    json["matrices"] = names;
    tell(command, program::labelled("matrices", fmt::format("{}, {}: {} in {}", model.name, where(command),
                                                            fmt::join(names, ", "), command.folder)));
    tell_notes(command, notes);
  });
}

}  // namespace mfs::dae
