// Measures: quantities of a mechanism that have a coordinate of their own, so that forces can act along them
// and expressions can use them and their rates. A constraint ties the coordinate w to what it measures,
//
//   x(q) - w = 0,     and for an angle   cos(w) a_y . b_x - sin(w) a_x . b_x = 0,
//
// which counts turns: w goes on where an arc tangent would jump.
#pragma once

#include <string>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"

namespace mfs::dae {

enum class Measure {
  angle,     ///< of b's x axis from a's about a's z axis, rad; the axes z have to stay together
  travel,    ///< of b's point from a's, along a's z axis, m
  distance,  ///< of b's point from a's, which must stay apart, m
  x,
  y,
  z,  ///< of b's point from a's, along the ground's axes, m
};

/// Adds the coordinate, which begins as a and b do, with its constraint; returns its number. Throws
/// InvalidInput("NAME") where both sides are on the same body, or the points of a distance are together.
int add_measure(MultibodyBuilder& builder, const std::string& name, const Attachment& a, const Attachment& b,
                Measure measure);

/// The same for coordinate `coordinate` of the system itself, a length.
int add_coordinate_measure(MultibodyBuilder& builder, const std::string& name, int coordinate);

}  // namespace mfs::dae
