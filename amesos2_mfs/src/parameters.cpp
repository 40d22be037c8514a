#include "parameters.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>

#include <Teuchos_StandardParameterEntryValidators.hpp>
#include <Teuchos_VerboseObject.hpp>

namespace mfs::amesos2 {
namespace {

using Teuchos::ParameterList;

/// A name that a parameter may have, and what it means.
template <class Value>
struct Choice {
  const char* name;
  Value value;
};

constexpr Choice<Backend> kBackends[] = {{"serial", Backend::serial},
                                         {"openmp", Backend::openmp},
                                         {"cuda", Backend::cuda},
                                         {"kokkos", Backend::kokkos}};
constexpr Choice<Matching> kMatchings[] = {
    {"automatic", Matching::automatic}, {"always", Matching::always}, {"never", Matching::never}};
constexpr Choice<Precision> kPrecisions[] = {
    {"automatic", Precision::automatic}, {"full", Precision::full}, {"single", Precision::single}};
/// As the other serial adapters spell it. Values are real: CONJ is TRANS.
constexpr Choice<bool> kTrans[] = {{"NOTRANS", false}, {"TRANS", true}, {"CONJ", true}};

template <class Choices, class Value>
void set_choice(ParameterList& list, const std::string& name, Value value, const Choices& choices,
                const std::string& documentation) {
  Teuchos::Array<std::string> names;
  std::string default_name;
  for (const auto& choice : choices) {
    names.push_back(choice.name);
    if (choice.value == value && default_name.empty()) default_name = choice.name;
  }
  list.set(name, default_name, documentation, Teuchos::rcp(new Teuchos::StringValidator(names)));
}

/// The list has been validated: one of the names it is.
template <class Choices>
auto get_choice(const ParameterList& list, const std::string& name, const Choices& choices) {
  const std::string& given = list.get<std::string>(name);
  return std::find_if(std::begin(choices), std::end(choices), [&](const auto& c) { return given == c.name; })
      ->value;
}

/// A number in a range; NaN is in none. Checked here and not by Teuchos' validators of numbers, which take
/// strings as well and let NaN through.
template <class T>
T in_range(const ParameterList& list, const std::string& name, T least, T most) {
  const T value = list.get<T>(name);
  if (value >= least && value <= most) return value;
  std::ostringstream text;
  text << "MFS: parameter \"" << name << "\" is " << value << ", not in " << least << " ... " << most;
  throw Teuchos::Exceptions::InvalidParameterValue(text.str());
}

constexpr int kAny = std::numeric_limits<int>::max();

}  // namespace

Teuchos::RCP<ParameterList> valid_parameters() {
  const Options defaults;
  const auto list = Teuchos::parameterList("MFS");
  set_choice(*list, "Trans", false, kTrans, "Solve with A (NOTRANS) or with its transpose (TRANS, CONJ)");
  list->set("IsContiguous", true,
            "Whether global ids are contiguous; accepted as by the other solvers, MFS handles both");
  set_choice(*list, "Backend", defaults.backend, kBackends, "Where the numeric phases run");
  list->set("Threads", defaults.threads,
            "Threads of every phase; 0 takes the default of the process: this rank's share of its node, or "
            "what DefaultThreads, mfs::set_default_threads or MFS_NUM_THREADS say");
  list->set("DefaultThreads", 0,
            "Not 0: threads of every solver of this process made from now on whose Threads is 0");
  list->set("AnalysisThreads", defaults.analysis.threads,
            "Threads of the analysis alone; 0 takes as many as every phase has");
  set_choice(*list, "Matching", defaults.analysis.matching, kMatchings,
             "When rows are matched to columns so that large entries come to the diagonal");
  list->set("Scaling", defaults.analysis.scaling, "Whether rows and columns are scaled");
  list->set("MaxBlockSize", defaults.analysis.max_block_size,
            "Widest block into which a pivot block is divided; backend cuda has blocks of its own");
  list->set("MemoryLimit", static_cast<double>(defaults.memory_limit),
            "Bytes of a device's memory for backend cuda, beyond which factors lie in the memory of the "
            "host, or of "
            "the host's for serial and openmp, beyond which they go to a file; 0: all that are free");
  list->set("OutOfCoreDir", defaults.out_of_core_dir,
            "Not empty: a folder for a file of factors that the memory of the host has no room for; backends "
            "serial and openmp");
  list->set("LeafSize", defaults.analysis.leaf_size,
            "Sub-graphs of at most this many unknowns are not dissected further");
  set_choice(
      *list, "Precision", defaults.factor.precision, kPrecisions,
      "Precision of the factors; solutions are refined to the same accuracy. automatic: single on a device "
      "that is slow in double precision, else full");
  list->set("PivotTolerance", defaults.factor.pivot_tolerance,
            "Smallest pivot relative to the scaled matrix; 0 takes sqrt(machine epsilon)");
  list->set("MaxReanalyses", defaults.factor.max_reanalyses,
            "How often the tree may be changed because pivots failed");
  list->set("Tolerance", defaults.solve.tolerance,
            "Componentwise backward error that every solution must reach; 0 takes 1e-12");
  list->set("MaxRefinementSteps", defaults.solve.max_refinement_steps,
            "Most steps of iterative refinement per solve");
  list->set(
      "RowFloor", defaults.solve.row_floor,
      "Rows that hold only rounding count at least this part of a row of full size; 0 counts them as any");
  list->set("SolveSingular", defaults.solve.solve_singular,
            "Whether a matrix that is singular to working precision is solved all the same, where a solution "
            "reaches the tolerance");
  list->set("DumpPrefix", defaults.dump_prefix,
            "Not empty: rank 0 leaves a system that fails in the files PREFIX_A.mtx and PREFIX_b.mtx");
  list->set("Verbosity", defaults.verbosity,
            "0 silent, 1 phases, 2 details; printed on Teuchos' default stream of rank 0");
  return list;
}

Parameters read_parameters(const ParameterList& list) {
  ParameterList all(list);
  all.remove("Transpose", false);  // Amesos2 adds it to the list of every solver and reads it itself
  all.validateParametersAndSetDefaults(*valid_parameters());
  Parameters parameters;
  parameters.has_trans = list.isParameter("Trans");
  parameters.transpose = get_choice(all, "Trans", kTrans);
  Options& options = parameters.options;
  options.backend = get_choice(all, "Backend", kBackends);
  options.threads = in_range(all, "Threads", 0, kAny);
  parameters.default_threads = in_range(all, "DefaultThreads", 0, kAny);
  options.analysis.threads = in_range(all, "AnalysisThreads", 0, kAny);
  options.analysis.matching = get_choice(all, "Matching", kMatchings);
  options.analysis.scaling = all.get<bool>("Scaling");
  options.analysis.max_block_size = in_range(all, "MaxBlockSize", 1, kAny);
  options.memory_limit = static_cast<std::int64_t>(in_range(all, "MemoryLimit", 0.0, 1e15));
  options.out_of_core_dir = all.get<std::string>("OutOfCoreDir");
  options.analysis.leaf_size = in_range(all, "LeafSize", 1, kAny);
  options.factor.precision = get_choice(all, "Precision", kPrecisions);
  options.factor.max_reanalyses = in_range(all, "MaxReanalyses", 0, kAny);
  options.factor.pivot_tolerance = in_range(all, "PivotTolerance", 0.0, 1.0);
  options.solve.tolerance = in_range(all, "Tolerance", 0.0, 1.0);
  options.solve.max_refinement_steps = in_range(all, "MaxRefinementSteps", 0, kAny);
  options.solve.row_floor = in_range(all, "RowFloor", 0.0, 1.0);
  options.solve.solve_singular = all.get<bool>("SolveSingular");
  options.dump_prefix = all.get<std::string>("DumpPrefix");
  options.verbosity = in_range(all, "Verbosity", 0, 2);
  if (options.verbosity > 0)
    options.log = [](const std::string& line) {
      *Teuchos::VerboseObjectBase::getDefaultOStream() << "MFS: " << line << "\n";
    };
  return parameters;
}

bool same_options(const ParameterList& a, const ParameterList& b) {
  const auto options_of = [](const ParameterList& list) {
    ParameterList all(*valid_parameters());  // haveSameValues compares in the order of the entries
    all.setParameters(list);
    for (const char* name : {"Transpose", "Trans", "IsContiguous"}) all.remove(name, false);
    return all.setName("MFS");
  };
  return Teuchos::haveSameValues(options_of(a), options_of(b));
}

}  // namespace mfs::amesos2
