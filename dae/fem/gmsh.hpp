// Reads meshes written by Gmsh (https://gmsh.info, MSH file format, versions 2.2 and 4.1, ASCII).
#pragma once

#include <istream>
#include <string>

#include "dae/fem/mesh.hpp"

namespace mfs::dae {

/// The volume elements of the file, all 8-node hexahedra, all 20-node hexahedra or all 10-node tetrahedra;
/// nodes that none of them uses are dropped. Each physical group gives a node set of its name ("surface_7"
/// and the like without one). Lengths are metres. Throws InvalidInput with `name` and the line where the file
/// is malformed or holds volume elements of another type.
Mesh read_gmsh(std::istream& file, const std::string& name);

/// The same for the file at `path`; InvalidInput also where it cannot be read.
Mesh read_gmsh(const std::string& path);

}  // namespace mfs::dae
