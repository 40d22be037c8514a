// libmfs and the program's own Kokkos (the one of Trilinos), started and ended in every order. Each must stay
// as if the other were not there.
#include <Kokkos_Core.hpp>
#include <map>
#include <memory>
#include <string>

#include "expect.hpp"
#include "tiny_system.hpp"

namespace {

bool kokkos_counts() {
  long sum = 0;
  Kokkos::View<long*> numbers("numbers", 1000);
  Kokkos::parallel_for(
      "fill", 1000, KOKKOS_LAMBDA(int i) { numbers(i) = i; });
  Kokkos::parallel_reduce(
      "sum", 1000, KOKKOS_LAMBDA(int i, long& s) { s += numbers(i); }, sum);
  return sum == 499500;
}

bool mfs_solves() {
  return TinySystem().solve();
}

void kokkos_first() {
  Kokkos::initialize();
  expect(mfs_solves(), "MFS while Kokkos lives");
  expect(kokkos_counts(), "Kokkos after MFS");
  Kokkos::finalize();
  expect(mfs_solves(), "MFS after Kokkos has ended");
}

void mfs_first() {
  expect(mfs_solves(), "MFS before Kokkos");
  expect(!Kokkos::is_initialized(), "MFS does not start the program's Kokkos");
  Kokkos::initialize();
  expect(kokkos_counts(), "Kokkos");
  expect(mfs_solves(), "MFS while Kokkos lives");
  Kokkos::finalize();
}

void mfs_alive() {
  TinySystem system;
  Kokkos::initialize();
  expect(system.solve(), "MFS object older than Kokkos");
  expect(kokkos_counts(), "Kokkos");
  Kokkos::finalize();
  expect(system.solve(), "MFS object that outlives Kokkos");
}

void mfs_outlives_main() {
  static std::unique_ptr<TinySystem> system;
  Kokkos::initialize();
  system = std::make_unique<TinySystem>();
  expect(system->solve(), "MFS object destroyed after main");
  Kokkos::finalize();
}

void kokkos_after_mfs() {
  { TinySystem system; }
  Kokkos::initialize();
  expect(kokkos_counts(), "Kokkos after the last MFS object is gone");
  Kokkos::finalize();
  expect(!Kokkos::is_initialized(), "Kokkos ended");
}

void kokkos_inside() {
  Kokkos::initialize();
  bool solved = false;
  Kokkos::parallel_for("one", 1, [&](int) { solved = mfs_solves(); });
  expect(solved, "MFS called from a kernel of the program's Kokkos");
  Kokkos::finalize();
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, void (*)()> orders = {
      {"kokkos_first", kokkos_first},
      {"mfs_first", mfs_first},
      {"mfs_alive", mfs_alive},
      {"mfs_outlives_main", mfs_outlives_main},
      {"kokkos_after_mfs", kokkos_after_mfs},
      {"kokkos_inside", kokkos_inside},
  };
  if (argc != 2 || orders.count(argv[1]) == 0) return 2;
  orders.at(argv[1])();
  return failures == 0 ? 0 : 1;
}
