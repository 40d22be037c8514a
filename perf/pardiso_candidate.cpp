#include <dlfcn.h>

#include <stdexcept>

#include "perf/host_peer.hpp"
#include "perf/peers.hpp"

namespace mfs::perf {

namespace {

using PardisoFunction = void(void** pt, const int* maxfct, const int* mnum, const int* mtype,
                             const int* phase, const int* n, const double* a, const int* ia, const int* ja,
                             int* perm, const int* nrhs, int* iparm, const int* msglvl, double* b, double* x,
                             int* error);

class Pardiso final : public HostPeer<int> {
 public:
  Pardiso(const System& system, PardisoFunction* function) : HostPeer(system), function_(function) {
    iparm_[0] = 1;    // not the defaults, which are these but for the numbering and the counts:
    iparm_[1] = 2;    // nested dissection
    iparm_[9] = 13;   // pivots are perturbed by 1e-13
    iparm_[10] = 1;   // scaling
    iparm_[12] = 1;   // matching
    iparm_[17] = -1;  // count the entries of the factors
    iparm_[18] = -1;  // and the operations, in 1e6
    iparm_[34] = 1;   // indices begin at 0
  }
  Pardiso(const Pardiso&) = delete;
  Pardiso& operator=(const Pardiso&) = delete;
  ~Pardiso() override {
    try {
      call(-1, 1);
    } catch (const std::exception&) {  // there is nobody left to tell
    }
  }
  AnalysisTime analyze() override {
    call(11, 1);
    return {};
  }
  void factor() override { call(22, 1); }
  void refactor() override { call(22, 1); }
  void solve(int columns) override { call(33, columns); }
  bool refine(int steps) override {
    iparm_[7] = steps;
    return true;
  }
  Facts facts() override {
    Facts facts = facts_of("PARDISO");
    facts.factor_entries = iparm_[17];
    facts.flops = 1e6 * iparm_[18];
    facts.perturbed_pivots = iparm_[13];
    facts.refinement_steps = iparm_[6];
    return facts;
  }

 private:
  void call(int phase, int columns) {
    const int one = 1, unsymmetric = 11, silent = 0, rows = n();
    int error = 0;
    function_(pt_, &one, &one, &unsymmetric, &phase, &rows, values(), offsets_.data(), indices_.data(),
              nullptr, &columns, iparm_, &silent, right_hand_sides(), x_.data(), &error);
    if (error != 0)
      throw std::runtime_error("PARDISO: error " + std::to_string(error) + " in phase " +
                               std::to_string(phase));
  }
  PardisoFunction* function_;
  void* pt_[64] = {};
  int iparm_[64] = {};
};

}  // namespace

MakeCandidate load_pardiso(const std::string& library, int threads) {
  void* const loaded = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!loaded) throw std::runtime_error(dlerror());
  const auto symbol = [&](const char* name) {
    void* const found = dlsym(loaded, name);
    if (!found) throw std::runtime_error(library + " has no " + name);
    return found;
  };
  constexpr int kGnuThreads = 3;  // those that MFS has as well
  if (void* const layer = dlsym(loaded, "MKL_Set_Threading_Layer"))
    reinterpret_cast<int (*)(int)>(layer)(kGnuThreads);
  reinterpret_cast<void (*)(int)>(symbol("MKL_Set_Num_Threads"))(threads);
  auto* const function = reinterpret_cast<PardisoFunction*>(symbol("pardiso"));
  return [function](const System& system) { return std::make_unique<Pardiso>(system, function); };
}

}  // namespace mfs::perf
