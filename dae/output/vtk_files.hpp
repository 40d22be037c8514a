// Grids for ParaView in VTK's XML formats: a .vtu file holds the points and cells of one moment, a .pvd file
// lists the .vtu files of a run with their times. Numbers are 64-bit floats, raw and behind the XML
// ("appended"), each array as its number of bytes (8 bytes) and the bytes: nothing is converted, and a file
// is no larger than what it holds.
//
// Source: The VTK User's Guide, "XML file formats"; https://docs.vtk.org/en/latest/design_documents/.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "dae/fem/mesh.hpp"
#include "parts/output_file.hpp"

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

/// A field with `components` values (1: scalar, 3: vector) at each point or cell, one after the other.
struct VtkField {
  std::string name;
  int components = 1;
  std::vector<double> values;
};

/// A number for each cell, as of the body to which it belongs.
struct VtkIds {
  std::string name;
  std::vector<std::int32_t> values;
};

/// Texts of the grid as a whole, as the names of the bodies by their numbers.
struct VtkNames {
  std::string name;
  std::vector<std::string> values;
};

struct VtkGrid {
  std::vector<double> points;  ///< 3 coordinates each, m
  VtkCells cells;
  std::vector<VtkField> point_fields, cell_fields;
  std::vector<VtkIds> cell_ids;
  std::vector<VtkNames> names;
};

/// Throws InvalidInput where the file cannot be written, a cell names a point that is not there, or a field
/// has the wrong length.
void write_vtu(const std::string& path, const VtkGrid& grid);

/// The list of a run, whole after each entry, so that a run can be looked at before it ends.
class PvdFile {
 public:
  /// Throws InvalidInput.
  explicit PvdFile(const std::string& path);
  /// `file` as seen from the folder of the list; `part` numbers the files of one moment. Throws InvalidInput.
  void add(double t, int part, const std::string& file);

 private:
  io::OutputFile file_;
  std::size_t end_ = 0;  // of the entries in the file
};

/// Removes the list that an earlier run left, and the files of that run in its folder vtu/ that it names;
/// what is not called as a run calls its files stays. Nothing happens where there is no list. Throws
/// InvalidInput.
void remove_pvd(const std::string& path);
/// Removes the file, if there is one. Throws InvalidInput.
void remove_file(const std::string& path);

}  // namespace mfs::dae
