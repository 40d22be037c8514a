// A mesh of solid elements of one kind, with named sets of nodes to which joints and forces are attached.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

namespace mfs::dae {

/// Numbering of nodes as in VTK (VTK_HEXAHEDRON, VTK_QUADRATIC_HEXAHEDRON, VTK_QUADRATIC_TETRA).
enum class ElementKind { hex8, hex20, tet10 };

constexpr int nodes_per_element(ElementKind kind) {
  return kind == ElementKind::hex8 ? 8 : kind == ElementKind::hex20 ? 20 : 10;
}

struct Mesh {
  ElementKind kind = ElementKind::hex8;
  std::vector<std::array<double, 3>> nodes;  ///< reference positions, metres
  std::vector<int> elements;                 ///< nodes_per_element(kind) node numbers each, 0-based
  std::map<std::string, std::vector<int>> node_sets;

  int element_count() const { return static_cast<int>(elements.size()) / nodes_per_element(kind); }
};

}  // namespace mfs::dae
