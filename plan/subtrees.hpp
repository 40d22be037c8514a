// Which parts of the tree one thread of the host does alone, before anything else: the subtrees below a
// depth, each in postorder, so that a front finds its children's contribution blocks in the cache of its
// core.
//
//        depth 0            o                    steps from `steps` on: depth after depth (plan/schedule.hpp)
//              1        o       o
//        -----------------------------------
//              2      o   o   o   o              roots of subtrees: their blocks lie where the plan has them
//              3     o o o o o o o o             the others' lie on the stack of who does the subtree
//
// The plan's places serve one depth at a time, so subtrees cannot use them. A front is made while its
// children's blocks are still read, so that a stack has two ends for fronts of even and of odd depth:
//
//        | even: earlier siblings of f and of its grandparent ... f -> |     | <- children of f, ... : odd |
//
// The stacks lie where nothing is before the subtrees are done: behind the factors of the subtrees, beside
// the blocks of their roots.
#pragma once

#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

struct Subtrees {
  Vertex steps = 0;           // of the plan that the subtrees cover; 0: there are none
  std::vector<Vertex> front;  // in postorder, subtree after subtree, those with most work first
  std::vector<Vertex> begin;  // task t: front[begin[t]] ... front[begin[t+1] - 1], one subtree or several
  std::vector<Offset> place;  // by front, entries: on a stack; -1 where the plan has the block's place
  std::vector<Offset> stack;  // entries of the region: where each stack begins, one for each thread

  Vertex tasks() const { return begin.empty() ? 0 : static_cast<Vertex>(begin.size()) - 1; }
};

/// Subtrees as large as their work can be shared by the threads and as their stacks fit a core's cache, if
/// there is room for the stacks.
Subtrees make_subtrees(const SymbolicPlan& plan, int threads);

}  // namespace mfs
