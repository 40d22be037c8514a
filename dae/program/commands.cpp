#include "dae/program/commands.hpp"

#include <omp.h>

#include <algorithm>
#include <exception>
#include <filesystem>

#include <fmt/format.h>

#include <mfs/error.hpp>

#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "dae/output/plots.hpp"
#include "dae/program/alignment.hpp"
#include "dae/program/host_threads.hpp"
#include "dae/program/recorder.hpp"
#include "dae/program/result_files.hpp"
#include "dae/program/run_report.hpp"
#include "ordering/stopwatch.hpp"
#include "parts/interrupt.hpp"
#include "parts/output_file.hpp"
#include "parts/report_text.hpp"

namespace mfs::dae {
namespace {

using program::ExitCode;

// The values are texts, and so expressions of parameters.
void set_parameters(const std::vector<std::string>& parameters, Json& json) {
  for (const std::string& parameter : parameters) {
    const std::size_t equal = std::min(parameter.find('='), parameter.size());
    const std::string name = parameter.substr(0, equal);
    if (equal == parameter.size()) throw InvalidInput("--set " + parameter, "is not NAME=VALUE");
    if (!json.is_object() || !json.contains("parameters") || !json["parameters"].contains(name))
      throw InvalidInput("--set " + parameter, "the model has no parameter '" + name + "'");
    json["parameters"][name] = parameter.substr(equal + 1);
  }
}

// A file, or where there is none of that name (but perhaps a folder of results) a model of the library.
Json read_model(const std::string& path) {
  const LibraryModel* known = find_library_model(path);
  const bool is_file = std::filesystem::exists(path) && !std::filesystem::is_directory(path);
  return known != nullptr && !is_file ? Json::parse(known->text) : read_json(path);
}

bool has_generated_mesh(const Json& model) {
  for (const Json& body : model["bodies"])
    if (body.contains("mesh") && body["mesh"].contains("generator")) return true;
  return false;
}

/// Of so few rigid bodies a step takes less time than threads take to meet.
constexpr std::size_t kFewBodies = 500;

bool has_few_rigid_bodies(const Json& json) {
  const auto bodies = json.is_object() ? json.find("bodies") : json.end();
  if (bodies == json.end() || !bodies->is_object() || bodies->size() > kFewBodies) return false;
  return std::all_of(bodies->begin(), bodies->end(), [](const Json& body) {
    const auto type = body.is_object() ? body.find("type") : body.end();
    return type != body.end() && *type == "rigid";
  });
}

void integrate(const MultibodyModel& model, const Command& command, program::ProgressDisplay& display,
               RunResult& result) {
  Integrator integrator = make_integrator(model);
  ResultFiles files(model, command.folder,
                    host_threads(command.threads, command.backend, omp_get_num_procs()));
  Recorder recorder(files, model.end, display);
  recorder.ask_for(model.integrator.fixed_step);
  const auto take_report = [&] {
    result.report = integrator.report();
    result.time_output = recorder.time_busy();
    result.time_waiting = recorder.time_waited();
    result.notes.insert(result.notes.end(), files.notes().begin(), files.notes().end());
    if (std::string note = recorder.short_steps_note(); !note.empty())
      result.notes.push_back(std::move(note));
    result.bytes_peak = peak_memory();
    display.clear();
  };
  try {
    integrator.run(0.0, model.q0, model.v0, model.end, output_times(model), recorder);
    recorder.finish();
  } catch (...) {
    const std::exception_ptr thrown = std::current_exception();
    try {
      recorder.finish();  // what there is up to here
    } catch (...) {       // the same once more, or less than what ended the run
    }
    take_report();
    std::rethrow_exception(thrown);
  }
  take_report();
}

// For people, unless standard output is for the report.
void sum_up(const Command& command, const RunResult& result) {
  if (command.json == "-") return;
  io::print(run_summary(result) + program::labelled("ParaView", command.folder + "/result.pvd"));
  if (command.plots) show_plots(draw_plots(command.folder));
}

}  // namespace

void show_plots(const PlotOutcome& plots) {
  if (!plots.trouble.empty()) fmt::print(stderr, "mfs-dae: no plots: {}\n", plots.trouble);
  std::string text;
  for (const std::string& file : plots.files) text += program::labelled("plot", file);
  io::print(text);
}

MultibodyModel load_model(const Command& command, Backend forces) {
  Json json = read_model(command.model);
  const int asked = command.threads == 0 && has_few_rigid_bodies(json) ? 1 : command.threads;
  const int threads = host_threads(asked, command.backend, omp_get_num_procs());
  if (threads > 0) omp_set_num_threads(threads);  // also of what is not told
  if (command.refine > 0) refine_meshes(json, command.refine);
  set_parameters(command.parameters, json);
  const std::string folder = std::filesystem::path(command.model).parent_path().string();
  MultibodyModel model = make_model(json, folder, threads, forces);
  model.integrator.backend = command.backend;
  model.integrator.analysis_threads = analysis_threads(asked, command.backend, omp_get_num_procs());
  return model;
}

Integrator make_integrator(const MultibodyModel& model) {
  try {
    return Integrator(*model.system, model.integrator);
  } catch (const InvalidInput& e) {
    throw InvalidInput("integrator", e.what());
  }
}

ExitCode run_model(const Command& command) {
  if (!command.json.empty()) io::check_writable(command.json);
  program::catch_interrupts();
  RunResult result;
  const auto write_json = [&] {
    if (!command.json.empty()) io::write_file(command.json, run_json(result) + "\n");
  };
  result.model = command.model;
  result.backend = command.backend;
  result.threads = command.threads;
  program::ProgressDisplay display;
  try {
    const Stopwatch watch;
    display.show("model", 0.0);
    MultibodyModel model = load_model(command, command.backend);
    program::throw_if_interrupted();
    result.notes = start_model(command, model);
    program::throw_if_interrupted();
    result.model = model.name;
    result.time_model = watch.seconds();
    integrate(model, command, display, result);
  } catch (...) {
    const program::Failure failure = program::describe_current_exception();
    result.status = failure.status;
    result.message = failure.message;
    write_json();
    const bool interrupted = failure.code == ExitCode::interrupted || failure.code == ExitCode::terminated;
    if (interrupted && result.report.steps > 0) sum_up(command, result);
    throw;
  }
  write_json();
  sum_up(command, result);
  return ExitCode::solved;
}

ExitCode plot_results(const Command& command) {
  const bool of_modes = std::filesystem::exists(command.folder + "/modes.csv");
  const PlotOutcome plots = of_modes ? draw_modes(command.folder) : draw_plots(command.folder);
  if (!plots.trouble.empty()) throw Error("no plots: " + plots.trouble);
  if (plots.files.empty()) throw InvalidInput(command.folder, "holds no results of a run");
  show_plots(plots);
  return ExitCode::solved;
}

ExitCode check_model(const Command& command) {
  const MultibodyModel model = load_model(command, command.backend);
  make_integrator(model);  // checks its options
  io::print(fmt::format("{}: {} flexible and {} rigid bodies, {} coordinates, {} constraints, {} unknowns\n",
                        model.name, model.flexible_bodies.size(), model.rigid_bodies.size(),
                        model.system->coordinates(), model.system->constraints(),
                        3 * std::int64_t{model.system->coordinates()} + model.system->constraints()));
  for (const std::string& note : alignment_notes(model, model.q0)) io::print(program::labelled("note", note));
  return ExitCode::solved;
}

ExitCode list_models(const Command& command) {
  std::string text;
  std::size_t width = 0;
  for (const LibraryModel& model : model_library()) width = std::max(width, model.name.size());
  for (const LibraryModel& model : model_library()) {
    Json json = Json::parse(model.text);
    const bool refined = command.refine > 0 && has_generated_mesh(json);
    if (refined) refine_meshes(json, command.refine);
    if (command.folder.empty()) {
      text += fmt::format("{:<{}} {}\n", model.name, width, json["description"].get<std::string>());
      continue;
    }
    std::error_code error;
    std::filesystem::create_directories(command.folder, error);
    const std::string path = (std::filesystem::path(command.folder) / (model.name + ".json")).string();
    io::write_file(path, refined ? json.dump(2) + "\n" : model.text);
    text += path + "\n";
  }
  io::print(text);
  return ExitCode::solved;
}

}  // namespace mfs::dae
