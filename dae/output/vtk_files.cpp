#include "dae/output/vtk_files.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <mfs/error.hpp>

#include "solver/program/output_file.hpp"

namespace mfs::dae {
namespace {

static_assert(sizeof(float) == 4);
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the files say so");

// RFC 4648, section 4.
std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t have = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < have ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= have ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

// A data array inline: the number of bytes, then the bytes.
template <class Number, class Value>
std::string data_array(const char* type, const std::string& name, int components,
                       const std::vector<Value>& values) {
  std::string bytes(sizeof(std::uint64_t) + values.size() * sizeof(Number), '\0');
  const std::uint64_t length = values.size() * sizeof(Number);
  char* to = std::copy_n(reinterpret_cast<const char*>(&length), sizeof length, bytes.data());
  for (const Value value : values) {
    const auto number = static_cast<Number>(value);
    to = std::copy_n(reinterpret_cast<const char*>(&number), sizeof number, to);
  }
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">{}</DataArray>\n", type,
      name, components, base64(bytes));
}

void check(const std::vector<double>& points, const VtkCells& cells, const std::vector<VtkField>& fields) {
  const std::size_t count = points.size() / 3;
  if (points.size() % 3 != 0) throw InvalidInput("points", "not three coordinates for each");
  for (const std::int32_t point : cells.connectivity)
    if (point < 0 || static_cast<std::size_t>(point) >= count)
      throw InvalidInput("cells", fmt::format("point {} of {} is named", point, count));
  for (const VtkField& field : fields)
    if (field.values.size() != count * static_cast<std::size_t>(field.components))
      throw InvalidInput("field " + field.name, fmt::format("{} values for {} points of {} components",
                                                            field.values.size(), count, field.components));
}

std::string vtk_file(const char* type, const std::string& content) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n{}</VTKFile>\n",
      type, content);
}

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

void write_vtu(const std::string& path, const std::vector<double>& points, const VtkCells& cells,
               const std::vector<VtkField>& fields) {
  check(points, cells, fields);
  std::string text = fmt::format("<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                                 points.size() / 3, cells.kind.size());
  text += "<PointData>\n";
  for (const VtkField& field : fields)
    text += data_array<float>("Float32", field.name, field.components, field.values);
  text +=
      "</PointData>\n<Points>\n" + data_array<float>("Float32", "Points", 3, points) + "</Points>\n<Cells>\n";
  text += data_array<std::int32_t>("Int32", "connectivity", 1, cells.connectivity);
  text += data_array<std::int32_t>("Int32", "offsets", 1, cells.end);
  text += data_array<std::uint8_t>("UInt8", "types", 1, cells.kind);
  text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n";
  io::OutputFile(path).write(vtk_file("UnstructuredGrid", text));
}

void PvdFile::add(double t, int part, const std::string& file) {
  entries_ += fmt::format("<DataSet timestep=\"{}\" part=\"{}\" file=\"{}\"/>\n", t, part, file);
  io::OutputFile(path_).write(vtk_file("Collection", "<Collection>\n" + entries_ + "</Collection>\n"));
}

}  // namespace mfs::dae
