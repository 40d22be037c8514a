// What of Tpetra's data lies in memory that a CUDA device reads.
//
// libmfs has a Kokkos of its own, but a process has one context per device: a pointer of Tpetra's is one of
// libmfs' as well. So mfs::Solver reads and writes Tpetra's arrays where they lie, behind the kernels in
// Tpetra's stream.
#pragma once

#include <cstddef>

#include <Kokkos_Core.hpp>

namespace mfs::amesos2 {

/// CudaSpace, and CudaUVMSpace, which the host reaches as well.
template <class MemorySpace>
inline constexpr bool reached_by_cuda =
#ifdef KOKKOS_ENABLE_CUDA
    Kokkos::SpaceAccessibility<Kokkos::Cuda, MemorySpace>::accessible;
#else
    false;
#endif

/// Reduces to the number of places where `a` and `b` differ. A kernel, so no member of anything (nvcc).
template <class View>
struct CountDifferences {
  View a, b;
  KOKKOS_INLINE_FUNCTION void operator()(std::size_t k, std::size_t& count) const {
    if (a(k) != b(k)) ++count;
  }
};

/// The pattern that was analysed, kept on the device: there the comparison with it costs next to nothing.
template <class Graph>
class DevicePattern {
 public:
  DevicePattern() = default;
  explicit DevicePattern(const Graph& graph)
      : offsets_(copy("mfs::pattern_offsets", graph.row_map)),
        columns_(copy("mfs::pattern_columns", graph.entries)) {}

  bool matches(const Graph& graph) const {
    return equal<Offsets>(offsets_, graph.row_map) && equal<Columns>(columns_, graph.entries);
  }

 private:
  using Offsets = typename Graph::row_map_type::const_type;
  using Columns = typename Graph::entries_type::const_type;
  using Range = Kokkos::RangePolicy<typename Graph::execution_space, Kokkos::IndexType<std::size_t>>;

  template <class View>
  static typename View::const_type copy(const char* label, const View& view) {
    const typename View::non_const_type result(Kokkos::ViewAllocateWithoutInitializing(label),
                                               view.extent(0));
    Kokkos::deep_copy(result, view);
    return result;
  }
  template <class View>
  static bool equal(const View& a, const View& b) {
    if (a.extent(0) != b.extent(0)) return false;
    std::size_t differences = 0;
    Kokkos::parallel_reduce("mfs::same_pattern", Range(0, a.extent(0)), CountDifferences<View>{a, b},
                            differences);
    return differences == 0;
  }

  Offsets offsets_;
  Columns columns_;
};

}  // namespace mfs::amesos2
