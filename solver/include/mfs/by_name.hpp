// Options and figures by name, as other languages, command lines and files have them. The names are those of
// the members of Options and Report; `threads` of the analysis is "analysis_threads".
#pragma once

#include <string>
#include <vector>

#include <mfs/error.hpp>
#include <mfs/export.hpp>
#include <mfs/options.hpp>
#include <mfs/report.hpp>

namespace mfs {

/// Sets one option from its text: a number in the C locale; "yes", "true", "no" or "false"; or the name of an
/// enumerator. Throws InvalidInput, whose argument() is `name`, where no option has that name, or `value`
/// cannot be read. `options` is then unchanged. Whether a number makes sense is checked by the solver that
/// the options are given to. Callbacks, AnalysisOptions::permutation and AnalysisOptions::tree have no text.
MFS_API void set_option(Options& options, const std::string& name, const std::string& value);
/// The names that set_option knows.
MFS_API std::vector<std::string> option_names();

/// A number of a report. Flags are 0 or 1, `backend` and `rung` the values of their enumerators.
struct Figure {
  const char* name;  ///< never freed
  double value;      ///< a count is exact up to 2^53
};
/// All numbers of `report`. Those of Report::flops are "flops_getrf", "flops_trsm", "flops_gemm" and "flops",
/// their sum; "flops_used" is that of Report::flops_used.
MFS_API std::vector<Figure> figures(const Report& report);

}  // namespace mfs
