// The generators of dae/fem/generators.hpp by their names in a model file.
#pragma once

#include "dae/fem/mesh.hpp"
#include "dae/model/json_object.hpp"

namespace mfs::dae {

/// Of the keys "generator", "element", "refine" and the dimensions, each with the default of its shape.
Mesh generate_mesh(JsonObject& object);

}  // namespace mfs::dae
