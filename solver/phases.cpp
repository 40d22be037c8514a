#include "solver/phases.hpp"

#include <new>
#include <system_error>

#include <mfs/error.hpp>

#include "kernels/runtime/engine.hpp"
#include "solver/memory_limit.hpp"

namespace mfs {

void Phases::run_here(const char* phase, const std::function<void()>& work) {
  if (logs(1)) log(1, phase);
  told_as_out_of_memory([&] { Engine::instance().run_here(work); });
}

void Phases::run_in_engine(const char* phase, int threads, const std::function<void()>& work) {
  const Needs needs = uses_kokkos_ ? Needs::kokkos : Needs::threads;
  tell(phase, 0.0);
  log(1, phase);
  try {
    if (options_.progress) {
      Engine::instance().run(
          threads, work, [this] { report_progress(); }, needs);
      report_progress();
    } else {
      Engine::instance().run(threads, work, {}, needs);
    }
  } catch (const std::bad_alloc&) {
    throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
  } catch (const std::system_error& error) {
    if (std::current_exception() == thrown_by_caller_) throw;
    throw BackendError("threads", error.code().value(), error.code().message());
  }
}

void Phases::tell(const char* phase, double fraction) {
  phase_ = phase;
  fraction_ = fraction;
}

}  // namespace mfs
