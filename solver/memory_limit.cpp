#include "solver/memory_limit.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>

#include "kernels/runtime/control_groups.hpp"

namespace mfs {

namespace {

constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

// The first number in a file, or after `key` at a line's begin; `otherwise` when it is not there. Allocates
// nothing: it is asked when there may be nothing left.
std::size_t read_number(const char* path, const char* key, std::size_t otherwise) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return otherwise;
  char text[4096];
  const ssize_t length = read(file, text, sizeof text - 1);
  close(file);
  if (length <= 0) return otherwise;
  text[length] = '\0';
  const std::size_t key_length = std::strlen(key);
  for (const char* line = text; line; line = std::strchr(line, '\n')) {
    line += *line == '\n';
    unsigned long long number = 0;
    if (std::strncmp(line, key, key_length) == 0 && std::sscanf(line + key_length, "%llu", &number) == 1) {
      return static_cast<std::size_t>(number);
    }
  }
  return otherwise;
}

std::size_t difference(std::size_t limit, std::size_t used) {
  if (limit == kUnlimited) return kUnlimited;
  return limit > used ? limit - used : 0;
}

}  // namespace

std::size_t available_host_memory() {
  const std::size_t kilobytes = read_number("/proc/meminfo", "MemAvailable:", kUnlimited / 1024);
  const std::size_t machine = kilobytes * 1024;
  rlimit address_space{};
  std::size_t process = kUnlimited;
  if (getrlimit(RLIMIT_AS, &address_space) == 0 && address_space.rlim_cur != RLIM_INFINITY) {
    process = difference(address_space.rlim_cur, read_number("/proc/self/statm", "", 0) * 4096);
  }
  return std::min({machine, group_memory(), process});
}

}  // namespace mfs
