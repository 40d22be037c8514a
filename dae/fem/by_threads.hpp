// Loops over the elements of a body for the results of a run. They have threads of their own, not OpenMP's: a
// team more than there are processors lets OpenMP's threads sleep between the loops of the integrator, beside
// which results are made (dae/program/host_threads.hpp).
#pragma once

#include <algorithm>
#include <system_error>
#include <thread>
#include <vector>

namespace mfs::dae {

/// work(begin, end) for parts of 0 ... count, each by a thread of its own; work must not throw.
template <class Work>
void by_threads(int threads, int count, const Work& work) {
  constexpr int kWorthAThread = 256;
  const int parts = std::clamp(count / kWorthAThread, 1, std::max(threads, 1));
  const auto begin = [&](int part) { return static_cast<int>(static_cast<long long>(count) * part / parts); };
  std::vector<std::thread> team;
  for (int part = 1; part < parts; ++part) {
    const int first = begin(part), end = begin(part + 1);
    try {
      team.emplace_back([&work, first, end] { work(first, end); });
    } catch (const std::system_error&) {  // the system gives no more
      work(first, end);
    }
  }
  work(0, begin(1));
  for (std::thread& thread : team) thread.join();
}

/// The sum of of_element(e) over all elements, in an order that does not depend on the number of threads.
template <class Sum, class OfElement>
Sum sum_by_threads(int threads, int count, const OfElement& of_element) {
  constexpr int kBlock = 256;
  std::vector<Sum> blocks(static_cast<std::size_t>((count + kBlock - 1) / kBlock));
  by_threads(threads, static_cast<int>(blocks.size()) * kBlock, [&](int first, int last) {
    for (int block = first / kBlock; block < last / kBlock; ++block)
      for (int e = kBlock * block; e < std::min(count, kBlock * (block + 1)); ++e)
        blocks[static_cast<std::size_t>(block)] += of_element(e);
  });
  Sum sum{};
  for (const Sum& block : blocks) sum += block;
  return sum;
}

}  // namespace mfs::dae
