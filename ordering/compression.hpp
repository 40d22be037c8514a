// A smaller graph with the same elimination: unknowns that have to stay together, or that are alike, become
// one vertex.
//
//   pairs                 unknowns that the matching joined (they need one pivot block)
//   indistinguishable     unknowns with the same closed neighbourhood (the neighbours and itself): once one
//                         is eliminated the others cost no new fill, so they are eliminated together. The
//                         degrees of freedom of a finite-element node are like that, without being named
//                         (Ashcraft 1995)
//
// Indistinguishable unknowns are neighbours of each other. So each looks among its neighbours for one with an
// equal hash of the closed neighbourhood. That takes linear time, and neither sorting nor a table.
#pragma once

#include "ordering/graph.hpp"
#include "ordering/types.hpp"

namespace mfs {

struct CompressedGraph {
  Graph graph;
  Partition partition;  // unknowns of the matrix -> vertices of `graph`
};

/// The same result for any number of threads.
CompressedGraph compressed_graph(const Pattern& pattern, const MatchedScaling& matched, int threads);

/// Only the pairs are merged: for an order that the caller gave.
CompressedGraph paired_graph(const Pattern& pattern, const MatchedScaling& matched, int threads);

}  // namespace mfs
