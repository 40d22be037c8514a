// How a force on a surface is shared out to its nodes.
#pragma once

#include <vector>

#include "dae/fem/mesh.hpp"

namespace mfs::dae {

/// For each node of `nodes`, its share of a force that is spread evenly over the surface they span: the
/// integral of its shape function over the outer faces of elements that have all their nodes in the set,
/// divided by the area of these faces (shares of corners of quadratic faces may be negative or zero). Where
/// the nodes span no face, all have equal shares. The shares sum to 1. Throws InvalidInput where `nodes` is
/// empty.
std::vector<double> surface_shares(const Mesh& mesh, const std::vector<int>& nodes);

}  // namespace mfs::dae
