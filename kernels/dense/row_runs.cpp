#include "kernels/dense/row_runs.hpp"

#include <complex>

#include "kernels/runtime/scalars.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs {

namespace {

// `parts` real numbers are one number of the matrices.
#define MFS_ADD_PARTS(R)                                                                                    \
  MFS_SIMD_CLONES void add_parts(const RowRun* runs, Vertex count, Offset parts, const R* from,             \
                                 Offset from_ld, const Vertex* map, Vertex begin, Vertex end, Vertex shift, \
                                 R* to, Offset to_ld) {                                                     \
    for (Vertex j = begin; j < end; ++j) {                                                                  \
      const R* const column = from + j * from_ld * parts;                                                   \
      R* const target = to + (map[j] - shift) * to_ld * parts;                                              \
      for (Vertex k = 0; k < count; ++k) {                                                                  \
        const R* const __restrict added = column + runs[k].from * parts;                                    \
        R* const __restrict sum = target + runs[k].to * parts;                                              \
        const Offset entries = runs[k].count * parts;                                                       \
        for (Offset i = 0; i < entries; ++i) sum[i] += added[i];                                            \
      }                                                                                                     \
    }                                                                                                       \
  }
MFS_ADD_PARTS(float)
MFS_ADD_PARTS(double)

}  // namespace

Vertex find_runs(const Vertex* map, Vertex rows, Vertex shift, Vertex& row, RowRun* runs) {
  Vertex count = 0;
  while (row < rows && count < kRunsAtOnce) {
    const Vertex first = row;
    do {
      ++row;
    } while (row < rows && map[row] == map[row - 1] + 1);
    runs[count++] = {first, map[first] - shift, row - first};
  }
  return count;
}

template <class Scalar>
void add_runs(const RowRun* runs, Vertex count, const Scalar* from, Offset from_ld, const Vertex* map,
              Vertex begin, Vertex end, Vertex shift, Scalar* to, Offset to_ld) {
  using Real = RealOf<Scalar>;
  constexpr Offset parts = sizeof(Scalar) / sizeof(Real);
  add_parts(runs, count, parts, reinterpret_cast<const Real*>(from), from_ld, map, begin, end, shift,
            reinterpret_cast<Real*>(to), to_ld);
}

#define MFS_INSTANTIATE(S)                                                                                  \
  template void add_runs<S>(const RowRun*, Vertex, const S*, Offset, const Vertex*, Vertex, Vertex, Vertex, \
                            S*, Offset);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
