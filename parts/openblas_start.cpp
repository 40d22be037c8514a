#include "parts/openblas_start.hpp"

#include <dlfcn.h>
#include <sys/auxv.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <vector>

#include "kernels/runtime/openblas_buffer.hpp"
#include "parts/exit_code.hpp"

namespace mfs::program {
namespace {

constexpr char kThreads[] = "OPENBLAS_NUM_THREADS=";
char one_thread[] = "OPENBLAS_NUM_THREADS=1";

bool address_space_is_limited() {
  rlimit space{};
  return getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY;
}

// The C library makes its own environment of `environment` only later, so a variable cannot be set: the
// program begins once more. Goes on where that cannot be, or where the loader was run by name (it has no
// interpreter).
void begin_with_one_thread(char** argv, char** environment) {
  std::vector<char*> changed;
  for (char** variable = environment; *variable != nullptr; ++variable) {
    if (std::strcmp(*variable, one_thread) == 0) return;
    if (std::strncmp(*variable, kThreads, sizeof kThreads - 1) != 0) changed.push_back(*variable);
  }
  changed.push_back(one_thread);
  changed.push_back(nullptr);
  if (getauxval(AT_BASE) != 0) execve("/proc/self/exe", argv, changed.data());
}

}  // namespace

void prepare_openblas(int argc, char** argv, char** environment) {
  const bool there = dlsym(RTLD_DEFAULT, "blas_memory_alloc") != nullptr;
  if (!there || !address_space_is_limited()) return;
  begin_with_one_thread(argv, environment);
  if (room_for_openblas_buffer()) return;
  const char* name = argc > 0 ? argv[0] : "mfs";
  if (const char* slash = std::strrchr(name, '/')) name = slash + 1;
  std::fprintf(stderr,
               "%s: out of memory: the limit of the address space leaves less than the %zu bytes of "
               "OpenBLAS' buffer\n",
               name, kOpenblasBuffer);
  _exit(static_cast<int>(ExitCode::out_of_memory));
}

}  // namespace mfs::program
