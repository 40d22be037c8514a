/* A vertex separator by one pass of METIS' multilevel bisection (Karypis and Kumar 1998) over the whole
 * graph: what METIS_ComputeVertexSeparator does to graphs of less than 5000 vertices. To larger ones it does
 * five passes, over a graph that was coarsened before, one after the other; whoever wants more than one trial
 * calls this with several seeds at once.
 *
 * offsets: n + 1; neighbors: offsets[n], without loops, each edge in both rows; weights: n. part[v] becomes 0
 * or 1 for the two sides and 2 for the separator. Returns METIS_OK, METIS_ERROR_MEMORY or METIS_ERROR, and
 * depends on the graph, the seed and the number of refinement passes (METIS_OPTION_NITER) alone. */
#ifndef MFS_ORDERING_METIS_VERTEX_SEPARATOR_H
#define MFS_ORDERING_METIS_VERTEX_SEPARATOR_H

#include <metis.h>

#ifdef __cplusplus
extern "C" {
#endif

int mfs_metis_vertex_separator(idx_t n, const idx_t* offsets, const idx_t* neighbors, const idx_t* weights,
                               idx_t seed, idx_t refinement, idx_t* part);

#ifdef __cplusplus
}
#endif

#endif
