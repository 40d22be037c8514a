// Modes as files: a table, and for each mode the bodies at some moments of one swing, for ParaView.
#pragma once

#include <string>
#include <vector>

#include "dae/model/model.hpp"
#include "dae/statics/modes.hpp"

namespace mfs::dae {

/// Writes modes.csv, shapes.mtx (n x modes, complex), mode_001.pvd, ... and vtu/ into `folder`, which it
/// makes. Bodies are drawn around `state`, with the largest displacement a tenth of what they span. Throws
/// InvalidInput where files cannot be written.
void write_modes(const MultibodyModel& model, const State& state, const std::vector<Mode>& modes,
                 const std::string& folder);

}  // namespace mfs::dae
