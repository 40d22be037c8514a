// Models in other units than metres, kilograms and seconds.
#pragma once

#include <cmath>
#include <regex>
#include <string>

#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {

/// How many of them a metre, a kilogram and a second are.
struct Units {
  const char* name;
  double length, mass, time;
};

/// Of what has this key, in powers of length, mass and time.
struct Dimension {
  const char* key;
  int length, mass, time;
};
inline constexpr Dimension kDimensions[] = {
    {"angular_velocity", 0, 0, -1},
    {"damping", 0, 1, -1},
    {"density", -3, 1, 0},
    {"end", 0, 0, 1},
    {"free_length", 1, 0, 0},
    {"gravity", 1, 0, -2},
    {"inertia", 2, 1, 0},
    {"mass", 0, 1, 0},
    {"plane", 1, 0, 0},
    {"point", 1, 0, 0},
    {"point_a", 1, 0, 0},
    {"point_b", 1, 0, 0},
    {"position", 1, 0, 0},
    {"radius", 1, 0, 0},
    {"size", 1, 0, 0},
    {"slope", 0, 0, -1},
    {"stiffness", 0, 1, -2},
    {"value", 2, 1, -2},
    {"velocity", 1, 0, -1},
    {"young", -1, 1, -2},
};

/// A number, an expression of parameters or an array of such.
inline void multiply(Json& value, double factor) {
  if (value.is_array())
    for (Json& item : value) multiply(item, factor);
  else if (value.is_string())
    value = Json(factor).dump() + "*(" + value.get<std::string>() + ")";
  else
    value = value.get<double>() * factor;
}

/// A model, or a part of one, whose functions are angles, by a slope or an expression of t, and torques with
/// a value.
inline Json converted(Json object, const Units& units) {
  for (auto& [key, value] : object.items()) {
    if (value.is_object()) value = converted(value, units);
    if (key == "angle" && value.is_string())
      value = std::regex_replace(value.get<std::string>(), std::regex("\\bt\\b"),
                                 "(t/" + Json(units.time).dump() + ")");
    for (const Dimension& of : kDimensions)
      if (key == of.key && !value.is_object())
        multiply(value, std::pow(units.length, of.length) * std::pow(units.mass, of.mass) *
                            std::pow(units.time, of.time));
  }
  return object;
}

}  // namespace mfs::dae::test
