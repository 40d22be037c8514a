// Writes the results of a run into a folder while it goes on:
//   time_series.csv   a row per output: largest stress of each flexible body, named points, joints
//   steps.csv         a row per step of the integrator
//   result.pvd        for ParaView, with the files in vtu/
#pragma once

#include <string>

#include "dae/integrator/integrator.hpp"
#include "dae/model/model.hpp"
#include "dae/output/csv_table.hpp"
#include "dae/output/vtk_files.hpp"
#include "solver/program/progress_display.hpp"

namespace mfs::dae {

class Recorder final : public Observer {
 public:
  /// Makes the folder. `model` has to live as long. Throws InvalidInput where files cannot be written.
  Recorder(const MultibodyModel& model, const std::string& folder, program::ProgressDisplay& display);

  void step(const StepReport& step, const std::function<const State&()>& state) override;
  void output(const State& state) override;

  double time_output() const { return time_output_; }  ///< s spent in output()

 private:
  void write_flexible(const State& state, std::size_t body, const std::vector<double>& von_mises);
  void write_rigid(const State& state);
  std::string grid_file(const std::string& body) const;

  const MultibodyModel& model_;
  std::string folder_;
  program::ProgressDisplay& display_;
  CsvTable time_series_, steps_;
  PvdFile list_;
  std::vector<VtkCells> cells_;  // of each flexible body
  int outputs_ = 0;
  double time_output_ = 0.0;
};

}  // namespace mfs::dae
