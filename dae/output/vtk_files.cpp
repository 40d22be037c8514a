#include "dae/output/vtk_files.hpp"

#include <filesystem>
#include <fstream>
#include <regex>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include <mfs/error.hpp>

namespace mfs::dae {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the files say so");

// The arrays behind the XML, which names the place of each.
class Appended {
 public:
  /// The element that stands for it. `values` has to live until write().
  template <class Value>
  std::string add(const char* type, const std::string& name, int components,
                  const std::vector<Value>& values) {
    const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    arrays_.push_back(bytes);
    const std::uint64_t offset = size_;
    size_ += sizeof(std::uint64_t) + bytes.size();
    return fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
        type, name, components, offset);
  }
  std::string add(const VtkField& field) {
    return add("Float64", field.name, field.components, field.values);
  }

  void write(io::OutputFile& file) const {
    for (const std::string_view bytes : arrays_) {
      const std::uint64_t length = bytes.size();
      file.write({reinterpret_cast<const char*>(&length), sizeof length});
      file.write(bytes);
    }
  }

 private:
  std::vector<std::string_view> arrays_;
  std::uint64_t size_ = 0;
};

// The characters' numbers, each text with a zero behind it.
std::string text_array(const VtkNames& names) {
  std::string codes;
  for (const std::string& text : names.values) {
    for (const char c : text) codes += fmt::format("{} ", static_cast<int>(static_cast<unsigned char>(c)));
    codes += "0 ";
  }
  return fmt::format(
      "<DataArray type=\"String\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</DataArray>\n",
      names.name, names.values.size(), codes);
}

void check_length(const std::string& name, std::size_t values, const char* of, std::size_t count,
                  int components) {
  if (values != count * static_cast<std::size_t>(components))
    throw InvalidInput("field " + name,
                       fmt::format("{} values for {} {} of {} components", values, count, of, components));
}

void check(const VtkGrid& grid) {
  const std::size_t points = grid.points.size() / 3, cells = grid.cells.kind.size();
  if (grid.points.size() % 3 != 0) throw InvalidInput("points", "not three coordinates for each");
  for (const std::int32_t point : grid.cells.connectivity)
    if (point < 0 || static_cast<std::size_t>(point) >= points)
      throw InvalidInput("cells", fmt::format("point {} of {} is named", point, points));
  for (const VtkField& field : grid.point_fields)
    check_length(field.name, field.values.size(), "points", points, field.components);
  for (const VtkField& field : grid.cell_fields)
    check_length(field.name, field.values.size(), "cells", cells, field.components);
  for (const VtkIds& ids : grid.cell_ids) check_length(ids.name, ids.values.size(), "cells", cells, 1);
}

constexpr const char* kBegin =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
    "header_type=\"UInt64\">\n";
constexpr const char* kEndOfList = "</Collection>\n</VTKFile>\n";

}  // namespace

void VtkCells::add(VtkCell cell, const std::int32_t* points, int count) {
  kind.push_back(cell);
  connectivity.insert(connectivity.end(), points, points + count);
  end.push_back(static_cast<std::int32_t>(connectivity.size()));
}

VtkCells vtk_cells(const Mesh& mesh) {
  const VtkCell cell = mesh.kind == ElementKind::hex8    ? VtkCell::hexahedron
                       : mesh.kind == ElementKind::hex20 ? VtkCell::quadratic_hexahedron
                                                         : VtkCell::quadratic_tetrahedron;
  const int count = nodes_per_element(mesh.kind);
  VtkCells cells;
  for (std::size_t first = 0; first < mesh.elements.size(); first += static_cast<std::size_t>(count))
    cells.add(cell, mesh.elements.data() + first, count);
  return cells;
}

void write_vtu(const std::string& path, const VtkGrid& grid) {
  check(grid);
  Appended arrays;
  std::string text = fmt::format(kBegin, "UnstructuredGrid") + "<UnstructuredGrid>\n<FieldData>\n";
  for (const VtkNames& names : grid.names) text += text_array(names);
  text += fmt::format("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>\n",
                      grid.points.size() / 3, grid.cells.kind.size());
  for (const VtkField& field : grid.point_fields) text += arrays.add(field);
  text += "</PointData>\n<CellData>\n";
  for (const VtkField& field : grid.cell_fields) text += arrays.add(field);
  for (const VtkIds& ids : grid.cell_ids) text += arrays.add("Int32", ids.name, 1, ids.values);
  text +=
      "</CellData>\n<Points>\n" + arrays.add("Float64", "Points", 3, grid.points) + "</Points>\n<Cells>\n";
  text += arrays.add("Int32", "connectivity", 1, grid.cells.connectivity);
  text += arrays.add("Int32", "offsets", 1, grid.cells.end);
  text += arrays.add("UInt8", "types", 1, grid.cells.kind);
  text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  io::OutputFile file(path);
  file.write(text);
  arrays.write(file);
  file.write("\n</AppendedData>\n</VTKFile>\n");
}

PvdFile::PvdFile(const std::string& path) : file_(path) {
  const std::string begin = fmt::format(kBegin, "Collection") + "<Collection>\n";
  file_.write(begin + kEndOfList);
  end_ = begin.size();
}

void PvdFile::add(double t, int part, const std::string& file) {
  const std::string entry =
      fmt::format("<DataSet timestep=\"{}\" part=\"{}\" file=\"{}\"/>\n", t, part, file);
  file_.overwrite(end_, entry + kEndOfList);
  end_ += entry.size();
}

void remove_pvd(const std::string& path) {
  // Names of bodies are letters, digits, _ and - (json_object.cpp); of all rigid ones it is rigid.bodies.
  const std::regex entry("<DataSet .* file=\"(vtu/[A-Za-z0-9_.-]+_[0-9]{2,}\\.vtu)\"/>");
  constexpr std::size_t kLongest = 512;  // entry of a run; std::regex takes stack by the length
  std::ifstream list(path);
  std::smatch found;
  for (std::string line; std::getline(list, line);)
    if (line.size() < kLongest && std::regex_match(line, found, entry))
      remove_file((std::filesystem::path(path).parent_path() / found[1].str()).string());
  list.close();
  remove_file(path);
}

void remove_file(const std::string& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) throw InvalidInput(path, "cannot be removed: " + error.message());
}

}  // namespace mfs::dae
