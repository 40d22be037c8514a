// Plots of a folder of results, drawn by plot_results, a Python program that needs matplotlib. It is
// installed in libexec and found from where the running program lies, so an installed tree may be moved.
#pragma once

#include <string>
#include <vector>

namespace mfs::dae {

/// The plots that were drawn (paths), or why there are none, in one line.
struct PlotOutcome {
  std::vector<std::string> files;
  std::string trouble;
};

/// Draws what `folder` holds (time_series.csv, steps.csv, result.pvd). Never throws for want of Python or
/// matplotlib: plots are an extra.
PlotOutcome draw_plots(const std::string& folder);
/// The same by plot_modes: the shapes that list_modes() has left in `folder`.
PlotOutcome draw_modes(const std::string& folder);

}  // namespace mfs::dae
