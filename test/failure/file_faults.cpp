#include "test/failure/file_faults.hpp"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>

namespace mfs::test {

namespace {

FileFault planned;
std::atomic<bool> active{false};
std::atomic<bool> happened{false};
std::atomic<long> counts[4];
std::atomic<int> last_file{-1};

/// Whether this call is the one; then errno is set, or not where it shall be short.
bool strikes(FileCall call) {
  const long number = counts[static_cast<int>(call)]++;
  if (!active || planned.call != call) return false;
  if (number != planned.at && !(planned.for_good && number > planned.at)) return false;
  happened = true;
  errno = planned.error;
  return true;
}

std::size_t shorter(std::size_t bytes) {
  return (bytes + 1) / 2;
}

}  // namespace

void plan_fault(const FileFault& fault) {
  planned = fault;
  happened = false;
  for (auto& count : counts) count = 0;
  active = true;
}
bool end_fault() {
  active = false;
  return happened;
}
long file_calls(FileCall call) {
  return counts[static_cast<int>(call)];
}
int factor_file() {
  return last_file;
}

}  // namespace mfs::test

using mfs::test::FileCall;

extern "C" {

int open(const char* path, int flags, ...) {
  mode_t mode = 0;
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  if (makes) {
    va_list arguments;
    va_start(arguments, flags);
    mode = va_arg(arguments, mode_t);
    va_end(arguments);
  }
  const bool factors = (flags & O_TMPFILE) == O_TMPFILE;
  if (factors && mfs::test::strikes(FileCall::open)) return -1;
  const auto file = static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  if (factors && file >= 0) mfs::test::last_file = file;
  return file;
}

int fallocate(int file, int mode, off_t offset, off_t length) {
  if (mfs::test::strikes(FileCall::reserve)) return -1;
  return static_cast<int>(syscall(SYS_fallocate, file, mode, offset, length));
}

ssize_t pwrite(int file, const void* data, size_t bytes, off_t offset) {
  if (mfs::test::strikes(FileCall::write)) {
    if (errno != 0) return -1;
    bytes = mfs::test::shorter(bytes);
  }
  return syscall(SYS_pwrite64, file, data, bytes, offset);
}

ssize_t pread(int file, void* data, size_t bytes, off_t offset) {
  if (mfs::test::strikes(FileCall::read)) {
    if (errno != 0) return -1;
    bytes = mfs::test::shorter(bytes);
  }
  return syscall(SYS_pread64, file, data, bytes, offset);
}
}
