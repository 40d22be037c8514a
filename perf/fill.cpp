// Fill beside the field's usual: for each FAMILY:SIZE, the factor entries and operations of MFS's plan
// against those of an exact symbolic factorization of the pattern of A + A^T under METIS_NodeND, by CHOLMOD
// (MUMPS orders the same way). One JSON line per case; no number is factored.
//
//   perf_fill elas3d:20 kkt:20 ...
#include <cholmod.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>

#include <mfs/mfs.hpp>

#include "cases/families.hpp"

namespace {

/// Entries of L + U, the diagonal once, and flops of an LU on the pattern of A + A^T.
struct Fill {
  double entries = 0, flops = 0;
};

/// The pattern of A + A^T as CHOLMOD wants it: the families hold both triangles of a nearly symmetric
/// pattern.
Fill cholmod_metis(const mfs::cases::FamilyMatrix& a) {
  cholmod_common common;
  cholmod_l_start(&common);
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_METIS;
  common.postorder = 1;
  const std::size_t n = static_cast<std::size_t>(a.n), nnz = a.column_indices.size();
  cholmod_triplet* triplets = cholmod_l_allocate_triplet(n, n, nnz, -1, CHOLMOD_PATTERN, &common);
  auto* rows = static_cast<SuiteSparse_long*>(triplets->i);
  auto* columns = static_cast<SuiteSparse_long*>(triplets->j);
  for (std::int64_t row = 0; row < a.n; ++row) {
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      const std::int64_t column = a.column_indices[k];
      rows[triplets->nnz] = std::max(row, column);  // the lower triangle of A + A^T; repeats are summed
      columns[triplets->nnz++] = std::min(row, column);
    }
  }
  cholmod_sparse* matrix = cholmod_l_triplet_to_sparse(triplets, nnz, &common);
  cholmod_l_free_triplet(&triplets, &common);
  cholmod_factor* factor = cholmod_l_analyze(matrix, &common);
  // lnz counts the diagonal; an LU of the same pattern stores L and U and does twice the work of LL^T.
  const Fill fill{2 * common.lnz - static_cast<double>(a.n), 2 * common.fl};
  cholmod_l_free_factor(&factor, &common);
  cholmod_l_free_sparse(&matrix, &common);
  cholmod_l_finish(&common);
  return fill;
}

Fill mfs_plan(const mfs::cases::FamilyMatrix& a) {
  mfs::Solver solver;
  solver.analyze({a.n, a.n, a.offsets.data(), a.column_indices.data(), a.values.data()});
  return {static_cast<double>(solver.report().nnz_factor), solver.report().flops.total()};
}

}  // namespace

int main(int argc, char** argv) try {
  for (int k = 1; k < argc; ++k) {
    const std::string name = argv[k];
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos) throw mfs::InvalidInput(name, "FAMILY:SIZE expected");
    const mfs::cases::FamilyMatrix a =
        mfs::cases::make_family(name.substr(0, colon), std::stoll(name.substr(colon + 1)));
    const Fill ours = mfs_plan(a), theirs = cholmod_metis(a);
    fmt::print(
        "{{\"name\":\"{}\",\"n\":{},\"mfs_entries\":{},\"cholmod_metis_entries\":{},\"entries_ratio\":{:.3f},"
        "\"mfs_flops\":{:.4g},\"cholmod_metis_flops\":{:.4g},\"flops_ratio\":{:.3f}}}\n",
        name, a.n, ours.entries, theirs.entries, ours.entries / theirs.entries, ours.flops, theirs.flops,
        ours.flops / theirs.flops);
    std::fflush(stdout);
  }
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "perf_fill: {}\n", error.what());
  return 2;
}
