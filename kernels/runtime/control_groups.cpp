#include "kernels/runtime/control_groups.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>

namespace mfs {

namespace {

constexpr std::size_t kLongest = 4096;  // of a path, and of what is read of a file
using Text = char[kLongest];

// Its begin; empty where it cannot be read.
void read_text(const char* path, Text& text) {
  text[0] = '\0';
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  const ssize_t length = read(file, text, sizeof text - 1);
  close(file);
  text[std::max<ssize_t>(length, 0)] = '\0';
}

/// A control group: the folder of its files.
class Group {
 public:
  Group(const char* root, const char* hierarchy, const char* path) {
    const int length = std::snprintf(folder_, sizeof folder_, "%s/sys/fs/cgroup%s%s", root, hierarchy, path);
    known_ = length >= 0 && length < static_cast<int>(sizeof folder_);
  }

  /// The numbers at the begin of a file, or after `key` at the begin of a line; how many of the two there
  /// are.
  int read(const char* name, const char* key, long long& first, long long& second) const {
    Text path, text;
    const int length = std::snprintf(path, sizeof path, "%s/%s", folder_, name);
    if (!known_ || length < 0 || length >= static_cast<int>(sizeof path)) return 0;
    read_text(path, text);
    const std::size_t key_length = std::strlen(key);
    for (const char* line = text; line; line = std::strchr(line, '\n')) {
      line += *line == '\n';
      if (std::strncmp(line, key, key_length) == 0)
        return std::max(std::sscanf(line + key_length, "%lld %lld", &first, &second), 0);
    }
    return 0;
  }
  /// False, and `number` as it was, where there is none.
  bool read(const char* name, const char* key, long long& number) const {
    long long found = 0, other = 0;
    if (read(name, key, found, other) == 0) return false;
    number = found;
    return true;
  }

 private:
  Text folder_;
  bool known_;
};

// Whether a list, as "cpu,cpuacct", has the name.
bool lists(const char* names, const char* name) {
  const std::size_t length = std::strlen(name);
  for (const char* item = names; item; item = std::strchr(item, ',')) {
    item += *item == ',';
    if (std::strncmp(item, name, length) == 0 && (item[length] == ',' || item[length] == '\0')) return true;
  }
  return false;
}

// The group of a path and all above it.
template <class Visit>
void visit_upwards(const char* root, const char* hierarchy, char* path, const Visit& visit) {
  while (true) {
    visit(Group(root, hierarchy, path));
    char* const last = std::strrchr(path, '/');
    if (!last) return;
    *last = '\0';
  }
}

/// Calls visit(group) for the groups that may limit what `controller` ("cpu", "memory") controls.
template <class Visit>
void visit_groups(const char* root, const char* controller, const Visit& visit) {
  Text path, text;
  std::snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
  read_text(path, text);
  char* rest = nullptr;
  for (char* line = strtok_r(text, "\n", &rest); line; line = strtok_r(nullptr, "\n", &rest)) {
    char* const names = std::strchr(line, ':');
    char* const group = names ? std::strchr(names + 1, ':') : nullptr;
    if (!group) continue;
    *group = '\0';
    if (names[1] == '\0') {
      visit_upwards(root, "", group + 1, visit);
    } else if (lists(names + 1, controller)) {
      char hierarchy[32];
      std::snprintf(hierarchy, sizeof hierarchy, "/%s", controller);
      visit_upwards(root, hierarchy, group + 1, visit);
    }
  }
}

}  // namespace

int processor_quota(const char* root) {
  long long least = 0;
  visit_groups(root, "cpu", [&](const Group& group) {
    long long quota = 0, period = 0;
    const bool limited =
        group.read("cpu.max", "", quota, period) == 2 ||
        (group.read("cpu.cfs_quota_us", "", quota) && group.read("cpu.cfs_period_us", "", period));
    if (!limited || quota <= 0 || period <= 0) return;
    const long long processors = (quota - 1) / period + 1;
    least = least == 0 ? processors : std::min(least, processors);
  });
  return static_cast<int>(std::min<long long>(least, std::numeric_limits<int>::max()));
}

std::size_t group_memory(const char* root) {
  std::size_t least = std::numeric_limits<std::size_t>::max();
  visit_groups(root, "memory", [&](const Group& group) {
    long long limit = 0, used = 0, droppable = 0;
    if (group.read("memory.max", "", limit)) {
      group.read("memory.current", "", used);
      group.read("memory.stat", "inactive_file ", droppable);
    } else if (group.read("memory.limit_in_bytes", "", limit)) {
      group.read("memory.usage_in_bytes", "", used);
      group.read("memory.stat", "total_inactive_file ", droppable);
    } else {
      return;
    }
    const long long left = limit - std::max(used - droppable, 0LL);
    least = std::min(least, static_cast<std::size_t>(std::max(left, 0LL)));
  });
  return least;
}

}  // namespace mfs
