// Mass of one element, the same for the three directions. Consistent: m_ij = int rho N_i N_j dV. Lumped: a
// diagonal one, the consistent diagonal scaled to the element's mass (Hinton, Rock and Zienkiewicz 1976),
// positive for all elements, where row sums of quadratic ones are not.
#pragma once

#include <vector>

#include "dae/fem/shape.hpp"

namespace mfs::dae {

/// The full matrix m_ij by rows, nodes x nodes, for a density of 1; nodes: positions (nodes x 3).
std::vector<double> consistent_mass(ElementKind kind, const double* nodes);

/// Its lumped form, one entry per node.
std::vector<double> lumped_mass(ElementKind kind, const double* nodes);

}  // namespace mfs::dae
