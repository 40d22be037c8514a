// A model with a bit of everything: a flexible bar on a hinge in the ground, a block at its tip.
#pragma once

#include <string>

#include "dae/model/model.hpp"

inline const char* const kSmallModel = R"({
  "name": "small",
  "end": 0.5,
  "outputs": 5,
  "gravity": [0, -10, 0],
  "materials": {"steel": {"law": "neo_hookean", "young": 2e11, "poisson": 0.3, "density": 8000}},
  "bodies": {
    "bar": {
      "type": "flexible", "material": "steel", "mass": "lumped", "damping": {"alpha": 0.1, "beta": 1e-5},
      "mesh": {"generator": "box", "element": "hex8", "refine": 2, "size": [1, 0.1, 0.2], "divisions": [4, 1, 1]},
      "position": [0, 2, 0], "rotation": {"axis": [0, 0, 2], "angle": 1.5707963267948966},
      "velocity": [0, 0, 1], "angular_velocity": [0, 0, 3]
    },
    "block": {"type": "rigid", "mass": 3, "inertia": [1.5, 2, 3, 0.1, 0.2, 0.3], "position": [0, 3.5, 0.1]}
  },
  "joints": {
    "hinge": {"type": "revolute", "a": "ground", "b": "bar:x0", "point": [0, 2, 0.1], "axis": [0, 0, 1]},
    "tip": {"type": "spherical", "a": "bar:x1", "b": "block", "point": [-0.05, 3, 0.1]}
  },
  "motions": {
    "turn": {"type": "rotation", "joint": "hinge", "angle": {"type": "linear", "slope": 3}}
  },
  "forces": {
    "cushion": {
      "type": "bushing", "a": "ground", "b": "block", "point": [0, 3.5, 0.1], "stiffness": [1, 2, 3, 4, 5, 6]
    },
    "strut": {
      "type": "spring_damper", "a": "ground", "b": "block", "point_a": [0, 4.5, 0.1], "point_b": [0, 3.5, 0.1],
      "stiffness": 100, "damping": 1
    },
    "push": {"type": "point", "side": "block", "point": [0, 3.5, 0.1], "x": {"type": "constant", "value": 7}},
    "wind": {"type": "surface", "side": "bar:y0", "x": {"type": "constant", "value": 5}}
  },
  "points": {
    "block_top": {"body": "block", "point": [0, 4, 0.1]},
    "tip": {"body": "bar", "point": [-0.01, 3.02, 0.19]}
  },
  "reactions": ["tip"],
  "integrator": {"method": "bdf", "unknowns": "full", "rtol": 1e-5, "max_order": 3, "keep_factors": false}
})";

inline mfs::dae::Json small_model() {
  return mfs::dae::Json::parse(kSmallModel);
}
