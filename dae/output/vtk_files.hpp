// Grids for ParaView in VTK's XML formats: a .vtu file holds the points and cells of one moment, a .pvd file
// lists the .vtu files of a run with their times. Coordinates and fields are written as base64 of 32 bit
// floats: what a picture needs, at half the size.
//
// Source: The VTK User's Guide, "XML file formats"; https://docs.vtk.org/en/latest/design_documents/.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "dae/fem/mesh.hpp"

namespace mfs::dae {

/// VTK's numbers of the kinds of cells.
enum class VtkCell : std::uint8_t {
  vertex = 1,
  line = 3,
  hexahedron = 12,
  quadratic_tetrahedron = 24,
  quadratic_hexahedron = 25,
};

/// Cells one after another, as VTK has them: the points of cell c are connectivity[end[c - 1]] ...
/// connectivity[end[c] - 1], with end[-1] = 0.
struct VtkCells {
  std::vector<VtkCell> kind;
  std::vector<std::int32_t> connectivity;
  std::vector<std::int32_t> end;

  void add(VtkCell cell, const std::int32_t* points, int count);
};

VtkCells vtk_cells(const Mesh& mesh);

/// A field with `components` values (1: scalar, 3: vector) at each point, point by point.
struct VtkField {
  std::string name;
  int components = 1;
  std::vector<double> values;
};

/// Writes `path` with points of 3 coordinates each, in metres. Throws InvalidInput where the file cannot be
/// written, a cell names a point that is not there, or a field has the wrong length.
void write_vtu(const std::string& path, const std::vector<double>& points, const VtkCells& cells,
               const std::vector<VtkField>& fields);

/// The list of a run. Rewritten with each entry, so that a run can be looked at before it ends.
class PvdFile {
 public:
  explicit PvdFile(std::string path) : path_(std::move(path)) {}
  /// `file` as seen from the folder of the list; `part` numbers the files of one moment. Throws InvalidInput.
  void add(double t, int part, const std::string& file);

 private:
  std::string path_, entries_;
};

}  // namespace mfs::dae
