#include "solve.hpp"

#include <Amesos2_MFS.hpp>

#include <algorithm>
#include <fstream>
#include <memory>
#include <stdexcept>

#include <BelosLinearProblem.hpp>
#include <BelosSolverFactory_Tpetra.hpp>
#include <BelosTpetraAdapter.hpp>
#include <Teuchos_CommHelpers.hpp>
#include <Teuchos_Time.hpp>

#include "engine.hpp"

namespace distributed {
namespace {

double norm_of(const Vector& v) {
  return v.getVector(0)->norm2();
}

/// Seconds until `work` is done on all ranks.
double seconds(const Comm& comm, const std::function<void()>& work) {
  comm.barrier();
  const double start = Teuchos::Time::wallTime();
  work();
  comm.barrier();
  return Teuchos::Time::wallTime() - start;
}

/// Highest resident size of this process in bytes; 0 where the system does not tell.
double resident_peak() {
  std::ifstream status("/proc/self/status");
  double kilobytes = 0;
  for (std::string word; status >> word;)
    if (word == "VmHWM:") status >> kilobytes;
  return kilobytes * 1024;
}

/// From here on, where Linux allows it.
void restart_resident_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

std::unique_ptr<Engine> make_engine(const Problem& problem, const Settings& settings, bool verbose) {
  if (settings.engine_type == "Ifpack2") return make_ifpack2(problem, settings.engine);
  if (settings.engine_type == "FROSch") return make_frosch(problem, settings.engine, verbose);
  if (settings.engine_type == "MueLu") return make_muelu(problem, settings.engine);
  throw std::invalid_argument("Preconditioner Type: " + settings.engine_type +
                              " is none of Ifpack2, FROSch, MueLu");
}

RCP<Vector> direct_solution(const Problem& problem) {
  const auto x = rcp(new Vector(problem.a->getDomainMap(), 1));
  Amesos2::create<Matrix, Vector>("MFS", problem.a, x, problem.b)->solve();
  return x;
}

class Run {
 public:
  Run(const Problem& problem, const Settings& settings, const Task& task, const AllRanks& all_ranks)
      : problem_(problem), settings_(settings), task_(task), all_ranks_(all_ranks) {}

  double set_up() {
    return seconds(*problem_.a->getComm(), [&] {
      all_ranks_.run([&] {
        if (!engine_) engine_ = make_engine(problem_, settings_, task_.verbose);
        engine_->compute();
      });
    });
  }

  void refuse_unread() const {
    all_ranks_.run([&] { engine_->refuse_unread(); });
  }

  void solve(Step& step) {
    x_ = rcp(new Vector(problem_.a->getDomainMap(), 1));
    step.solve_s = seconds(*problem_.a->getComm(), [&] { all_ranks_.run([&] { iterate(step); }); });
    Vector residual(*problem_.b, Teuchos::Copy);
    problem_.a->apply(*x_, residual, Teuchos::NO_TRANS, -1.0, 1.0);
    step.residual = norm_of(residual) / norm_of(*problem_.b);
    step.norm = norm_of(*x_);
    // A wrong preconditioner makes Belos report a residual that is none.
    const double asked = settings_.krylov.get<double>("Convergence Tolerance");
    step.converged = step.converged && step.residual <= 10 * asked;
  }

  void compare(Step& step) const {
    const auto direct = direct_solution(problem_);
    Vector difference(*direct, Teuchos::Copy);
    difference.update(1.0, *x_, -1.0);
    step.difference = norm_of(difference) / norm_of(*direct);
  }

 private:
  void iterate(Step& step) {
    const auto system = rcp(new Belos::LinearProblem<double, Vector, Operator>(problem_.a, x_, problem_.b));
    system->setRightPrec(engine_->preconditioner());
    system->setProblem();
    Belos::SolverFactory<double, Vector, Operator> factory;
    const auto krylov =
        factory.create(settings_.krylov_type, rcp(new Teuchos::ParameterList(settings_.krylov)));
    krylov->setProblem(system);
    step.converged = krylov->solve() == Belos::Converged;
    step.iterations = krylov->getNumIters();
  }

  const Problem& problem_;
  const Settings& settings_;
  Task task_;
  const AllRanks& all_ranks_;
  std::unique_ptr<Engine> engine_;
  RCP<Vector> x_;
};

/// A name that the engine does not look for would leave the work to its default solver.
void require_mfs(const Comm& comm, const Amesos2::MfsTotals& before, const Settings& settings) {
  const int mine = Amesos2::mfs_totals().analyses > before.analyses ? 1 : 0;
  int anywhere = 0;
  Teuchos::reduceAll(comm, Teuchos::REDUCE_MAX, mine, Teuchos::outArg(anywhere));
  if (!anywhere)
    throw std::invalid_argument(
        settings.name + ": " + settings.engine_type +
        " has made no solver MFS: its parameters do not ask for one in the right place");
}

/// Figures of MFS since `before`.
void add_totals(RankFigures& figures, const Amesos2::MfsTotals& before, const Amesos2::MfsTotals& after) {
  figures.factorizations += static_cast<double>(after.factorizations - before.factorizations);
  figures.solves += static_cast<double>(after.solves - before.solves);
  figures.seconds_analyses += after.seconds_analyses - before.seconds_analyses;
  figures.seconds_factorizations += after.seconds_factorizations - before.seconds_factorizations;
  figures.seconds_solves += after.seconds_solves - before.seconds_solves;
}

std::vector<RankFigures> gather(const Comm& comm, const RankFigures& mine) {
  constexpr int numbers = sizeof(RankFigures) / sizeof(double);
  std::vector<RankFigures> all(static_cast<std::size_t>(comm.getSize()));
  Teuchos::gatherAll(comm, numbers, reinterpret_cast<const double*>(&mine), numbers * comm.getSize(),
                     reinterpret_cast<double*>(all.data()));
  return all;
}

}  // namespace

bool Measured::converged() const {
  return std::all_of(steps.begin(), steps.end(), [](const Step& step) { return step.converged; });
}

Measured measure(const Problem& problem, const Settings& settings, const std::string& solver,
                 const Task& task, const AllRanks& all_ranks) {
  Measured measured{settings.name, solver, {}, {}};
  const Comm& comm = *problem.a->getComm();
  Settings used = settings;
  if (solver != "MFS") replace_solver(used.engine, solver);
  Run run(problem, used, task, all_ranks);
  RankFigures mine;
  mine.rows = static_cast<double>(problem.b->getLocalLength());
  restart_resident_peak();
  for (int k = 0; k <= task.new_values; ++k) {
    problem.set_values(k);
    Step step;
    const Amesos2::MfsTotals before = Amesos2::mfs_totals();
    step.setup_s = run.set_up();
    if (k == 0) run.refuse_unread();
    run.solve(step);  // MueLu's coarse solver analyses in its first solution only
    if (k == 0 && solver == "MFS") require_mfs(comm, before, used);
    const Amesos2::MfsTotals after = Amesos2::mfs_totals();
    (k == 0 ? mine.analyses : mine.analyses_again) += static_cast<double>(after.analyses - before.analyses);
    add_totals(mine, before, after);
    mine.bytes = static_cast<double>(after.bytes);
    if (k == 0) mine.resident_peak = resident_peak();
    if (task.check) run.compare(step);
    measured.steps.push_back(step);
  }
  measured.ranks = gather(comm, mine);
  return measured;
}

}  // namespace distributed
