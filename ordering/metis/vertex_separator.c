#include "vertex_separator.h"

#include "metislib.h"

static int bisect(idx_t n, const idx_t* offsets, const idx_t* neighbors, const idx_t* weights, idx_t seed,
                  idx_t refinement, idx_t* part) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NITER] = refinement;
  options[METIS_OPTION_SEED] = seed;
  ctrl_t* ctrl = SetupCtrl(METIS_OP_OMETIS, options, 1, 3, NULL, NULL);
  if (ctrl == NULL) return METIS_ERROR_INPUT;
  InitRandom(ctrl->seed);
  /* METIS reads the graph that it is given and writes to the coarser ones that it makes. */
  graph_t* graph = SetupGraph(ctrl, n, 1, (idx_t*)offsets, (idx_t*)neighbors, (idx_t*)weights, NULL, NULL);
  AllocateWorkSpace(ctrl, graph);
  MlevelNodeBisectionL1(ctrl, graph, LARGENIPARTS);
  icopy(n, graph->where, part);
  FreeGraph(&graph);
  FreeCtrl(&ctrl);
  return METIS_OK;
}

/* The guard that METIS puts around METIS_NodeND: memory that runs out raises a signal, which comes back here
 * (host_functions.c). */
int mfs_metis_vertex_separator(idx_t n, const idx_t* offsets, const idx_t* neighbors, const idx_t* weights,
                               idx_t seed, idx_t refinement, idx_t* part) {
  if (!gk_malloc_init()) return METIS_ERROR_MEMORY;
  volatile int status = METIS_ERROR;
  if (gk_sigtrap()) {
    const int raised = gk_sigcatch();
    if (raised == 0) {
      status = bisect(n, offsets, neighbors, weights, seed, refinement, part);
    } else {
      status = raised == SIGMEM ? METIS_ERROR_MEMORY : METIS_ERROR;
    }
    gk_siguntrap();
  }
  gk_malloc_cleanup(0);
  return status;
}
