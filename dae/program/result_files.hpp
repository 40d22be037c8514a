// The files of a run, one row or picture after another:
//   time_series.csv   a row per output: an overview, then what is recorded (quantities.hpp), number by number
//   results.npy       a record per output: what is recorded, with a name for each quantity
//   steps.csv         a row per step of the integrator
//   result.pvd        for ParaView, with the files in vtu/
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dae/model/quantities.hpp"
#include "dae/output/csv_table.hpp"
#include "dae/output/npy_table.hpp"
#include "dae/output/vtk_files.hpp"
#include "dae/program/grids.hpp"

namespace mfs::dae {

class ResultFiles {
 public:
  /// Makes the folder. `model` has to live as long. `threads`: of loops over elements; 0: all. Throws
  /// InvalidInput where files cannot be written.
  ResultFiles(const MultibodyModel& model, const std::string& folder, int threads);

  /// Whether add_step() needs the states.
  bool along_steps() const { return along_steps_; }
  /// `state`: at the end of the step; empty vectors unless along_steps(). All throw InvalidInput.
  void add_step(const StepReport& step, const State& state);
  /// Finds notes() at the first output, `state`. `begin`: with the corrected initial conditions. This
  /// evaluates the system of the model, which nobody else may do meanwhile.
  void look_at(const State& begin, const State& state);
  /// Adds the rows of an output. What is returned writes its pictures and enters them into their list; it may
  /// be called by another thread, beside others of its kind and the functions of this class, and throws
  /// InvalidInput.
  std::function<void()> add_output(const std::shared_ptr<const State>& state);
  /// How many threads pictures are worth.
  int worth_threads() const { return model_.flexible_bodies.empty() ? 1 : threads_; }

  /// What the user should know of the model or the files; complete after look_at().
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct Picture {
    double t;
    int part;
    std::string file;
  };
  void add_row(Measurement& measurement);
  std::vector<double> overview(Measurement& measurement) const;
  void draw(int output, Measurement& measurement);
  std::unique_ptr<Grids> take_grids();

  const MultibodyModel& model_;
  std::string folder_;
  int threads_;
  std::vector<Quantity> chosen_;
  bool along_steps_, all_in_series_;
  CsvTable time_series_, steps_;
  NpyTable results_;
  // Of pictures, which several threads write.
  std::mutex pictures_;
  PvdFile list_;
  std::map<int, std::vector<Picture>> not_listed_;  // outputs whose turn has not come
  int listed_ = 0;                                  // outputs
  std::vector<std::unique_ptr<Grids>> grids_;       // in no thread's use
  Account account_;
  int outputs_ = 0;
  std::vector<std::string> notes_;
};

/// How far bodies were moved or given other velocities, so that the constraints hold at the beginning; a note
/// each, none where that is a matter of rounding.
std::vector<std::string> correction_notes(const MultibodyModel& model, const State& begin);

}  // namespace mfs::dae
