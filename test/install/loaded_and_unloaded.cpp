// libmfs loaded at run time, used and unloaded, again and again, in a program with a Kokkos of its own.
#include <Kokkos_Core.hpp>
#include <cstdio>
#include <string>
#include <thread>

#include <dlfcn.h>

namespace {

bool load_solve_unload(const char* path) {
  void* plugin = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (plugin == nullptr) {
    std::printf("%s\n", dlerror());
    return false;
  }
  const auto solve = reinterpret_cast<int (*)()>(dlsym(plugin, "solve_tiny_system"));
  const bool solved = solve != nullptr && solve() == 0;
  return dlclose(plugin) == 0 && solved;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const char* path = argv[1];
  const bool kokkos_first = std::string(argv[2]) == "kokkos_first";
  bool good = true;
  if (kokkos_first) Kokkos::initialize();
  for (int round = 0; round < 5; ++round) {
    good = good && load_solve_unload(path);
    if (round == 2 && !kokkos_first) Kokkos::initialize();
    std::thread([&] { good = good && load_solve_unload(path); }).join();
  }
  Kokkos::finalize();
  return good && load_solve_unload(path) ? 0 : 1;
}
