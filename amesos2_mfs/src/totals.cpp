#include "totals.hpp"

#include <chrono>
#include <mutex>

#include "Amesos2_MFS_decl.hpp"

namespace mfs::amesos2 {
namespace {

std::mutex mutex;
::Amesos2::MfsTotals totals;

}  // namespace

void counted(Phase phase, std::int64_t times, const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::lock_guard lock(mutex);
  switch (phase) {
    case Phase::analysis:
      totals.analyses += times;
      totals.seconds_analyses += seconds;
      break;
    case Phase::factorization:
      totals.factorizations += times;
      totals.seconds_factorizations += seconds;
      break;
    case Phase::solve:
      totals.solves += times;
      totals.seconds_solves += seconds;
      break;
  }
}

void CountedBytes::set(std::int64_t bytes) {
  const std::lock_guard lock(mutex);
  totals.bytes += bytes - bytes_;
  bytes_ = bytes;
}

}  // namespace mfs::amesos2

namespace Amesos2 {

MfsTotals mfs_totals() {
  const std::lock_guard lock(mfs::amesos2::mutex);
  return mfs::amesos2::totals;
}

}  // namespace Amesos2
