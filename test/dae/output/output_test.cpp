// Results in files: what is written can be read back, and a plot can be drawn of it.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <sstream>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "dae/output/csv_table.hpp"
#include "dae/output/plots.hpp"
#include "dae/output/vtk_files.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using mfs::dae::CsvTable;
using mfs::dae::VtkCell;
using mfs::dae::VtkCells;
using mfs::dae::VtkField;
using testing::ElementsAre;
using testing::HasSubstr;

// What stands behind the XML at the place that it names.
template <class Number>
std::vector<Number> array_in(const std::string& file, const std::string& name) {
  const std::size_t at = file.find("Name=\"" + name + "\"");
  if (at == std::string::npos) return {};
  const std::size_t offset = file.find("offset=\"", at) + 8;
  const std::size_t begin = file.find('_', file.find("<AppendedData")) + 1 + std::stoul(file.substr(offset));
  std::uint64_t length = 0;
  std::memcpy(&length, &file[begin], sizeof length);
  EXPECT_LE(begin + sizeof length + length, file.size());
  std::vector<Number> numbers(length / sizeof(Number));
  std::memcpy(numbers.data(), &file[begin + sizeof length], length);
  return numbers;
}

std::string what_is_refused(const std::function<void()>& call) {
  try {
    call();
  } catch (const mfs::InvalidInput& e) {
    return e.what();
  }
  return "nothing";
}

TEST(CsvTable, KeepsEveryBitAndIsReadableAtOnce) {
  const TemporaryFolder folder;
  CsvTable table(folder.path("t.csv"), {"t [s]", "von_mises arm [Pa]"});
  table.add_row({0.1, 1.0 / 3.0});
  std::istringstream lines(text_of(folder.path("t.csv")));
  std::string header, row;
  std::getline(lines, header);
  std::getline(lines, row);
  EXPECT_EQ(header, "t [s],von_mises arm [Pa]");
  const std::size_t comma = row.find(',');
  EXPECT_EQ(std::stod(row.substr(0, comma)), 0.1);
  EXPECT_EQ(std::stod(row.substr(comma + 1)), 1.0 / 3.0);
}

TEST(CsvTable, RefusesWhatWouldNotBeATable) {
  const TemporaryFolder folder;
  EXPECT_THAT(what_is_refused([&] { CsvTable(folder.path("t.csv"), {"a,b"}); }), HasSubstr("a,b"));
  CsvTable table(folder.path("t.csv"), {"a", "b"});
  EXPECT_THAT(what_is_refused([&] { table.add_row({1.0}); }), HasSubstr("1 for 2 columns"));
  EXPECT_THAT(what_is_refused([&] { CsvTable(folder.path("no/t.csv"), {"a"}); }), HasSubstr("no/t.csv"));
  EXPECT_THAT(what_is_refused([&] { CsvTable("/dev/full", {"a"}); }), HasSubstr("/dev/full"));
}

TEST(VtuFile, HoldsPointsCellsAndFieldsToTheLastBit) {
  const TemporaryFolder folder;
  mfs::dae::VtkGrid grid;
  const std::int32_t edge[] = {0, 2};
  const std::int32_t corner[] = {1};
  grid.cells.add(VtkCell::line, edge, 2);
  grid.cells.add(VtkCell::vertex, corner, 1);
  grid.points = {0, 0, 0, 1, 1.0 / 3, 0, 0.25, 2, -3};
  grid.point_fields = {{"von_mises", 1, {1, 2, 1.0 / 7}}, {"displacement", 3, {0, 0, 0, 1, 1, 1, 2, 2, 2}}};
  grid.cell_fields = {{"orientation", 4, {1, 0, 0, 0, 0, 1, 0, 0}}};
  grid.cell_ids = {{"body", {7, -1}}};
  grid.names = {{"bodies", {"arm", "rod"}}};
  mfs::dae::write_vtu(folder.path("a.vtu"), grid);
  const std::string file = text_of(folder.path("a.vtu"));
  EXPECT_THAT(file, HasSubstr("NumberOfPoints=\"3\" NumberOfCells=\"2\""));
  EXPECT_THAT(file, HasSubstr("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\""));
  EXPECT_EQ(array_in<double>(file, "Points"), grid.points);
  EXPECT_THAT(array_in<double>(file, "von_mises"), ElementsAre(1, 2, 1.0 / 7));
  EXPECT_THAT(array_in<double>(file, "displacement"), ElementsAre(0, 0, 0, 1, 1, 1, 2, 2, 2));
  EXPECT_THAT(array_in<double>(file, "orientation"), ElementsAre(1, 0, 0, 0, 0, 1, 0, 0));
  EXPECT_THAT(array_in<std::int32_t>(file, "body"), ElementsAre(7, -1));
  EXPECT_THAT(array_in<std::int32_t>(file, "connectivity"), ElementsAre(0, 2, 1));
  EXPECT_THAT(array_in<std::int32_t>(file, "offsets"), ElementsAre(2, 3));
  EXPECT_THAT(array_in<std::uint8_t>(file, "types"), ElementsAre(3, 1));
  EXPECT_THAT(file, HasSubstr(">97 114 109 0 114 111 100 0 </DataArray>"));  // "arm", "rod"
  EXPECT_THAT(file, testing::EndsWith("\n</AppendedData>\n</VTKFile>\n"));
}

TEST(VtuFile, CellsOfAMesh) {
  mfs::dae::Mesh mesh;
  mesh.kind = mfs::dae::ElementKind::tet10;
  for (int i = 0; i < 20; ++i) mesh.elements.push_back(19 - i);
  const VtkCells cells = mfs::dae::vtk_cells(mesh);
  EXPECT_THAT(cells.kind, ElementsAre(VtkCell::quadratic_tetrahedron, VtkCell::quadratic_tetrahedron));
  EXPECT_THAT(cells.end, ElementsAre(10, 20));
  EXPECT_EQ(cells.connectivity.front(), 19);
  mesh.kind = mfs::dae::ElementKind::hex20;
  EXPECT_THAT(mfs::dae::vtk_cells(mesh).kind, ElementsAre(VtkCell::quadratic_hexahedron));
  mesh.kind = mfs::dae::ElementKind::hex8;
  mesh.elements.resize(8);
  EXPECT_THAT(mfs::dae::vtk_cells(mesh).kind, ElementsAre(VtkCell::hexahedron));
}

TEST(VtuFile, RefusesWhatDoesNotFit) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.vtu");
  mfs::dae::VtkGrid sound;
  const std::int32_t first[] = {0}, beyond[] = {1};
  sound.cells.add(VtkCell::vertex, first, 1);
  sound.points = {0, 0, 0};
  const auto refused = [&](const std::function<void(mfs::dae::VtkGrid&)>& spoil) {
    mfs::dae::VtkGrid grid = sound;
    spoil(grid);
    return what_is_refused([&] { mfs::dae::write_vtu(path, grid); });
  };
  EXPECT_THAT(refused([&](auto& grid) { grid.cells.add(VtkCell::vertex, beyond, 1); }),
              HasSubstr("point 1 of 1"));
  EXPECT_THAT(refused([](auto& grid) { grid.points.pop_back(); }), HasSubstr("points"));
  EXPECT_THAT(refused([](auto& grid) { grid.point_fields = {{"u", 3, {1}}}; }), HasSubstr("field u"));
  EXPECT_THAT(refused([](auto& grid) { grid.cell_fields = {{"w", 1, {1, 2}}}; }), HasSubstr("field w"));
  EXPECT_THAT(refused([](auto& grid) { grid.cell_ids = {{"body", {}}}; }), HasSubstr("field body"));
  EXPECT_FALSE(std::filesystem::exists(path));
  mfs::dae::write_vtu(path, sound);
  EXPECT_THAT(what_is_refused([&] { mfs::dae::write_vtu("/dev/full", sound); }), HasSubstr("/dev/full"));
}

TEST(PvdFile, ListsWhatWasAddedSoFar) {
  const TemporaryFolder folder;
  mfs::dae::PvdFile list(folder.path("result.pvd"));
  const std::string empty = text_of(folder.path("result.pvd"));
  EXPECT_THAT(empty, testing::EndsWith("<Collection>\n</Collection>\n</VTKFile>\n"));
  list.add(0.0, 0, "arm_0000.vtu");
  list.add(0.25, 1, "rigid_0001.vtu");
  const std::string text = text_of(folder.path("result.pvd"));
  EXPECT_THAT(text, HasSubstr("timestep=\"0.25\" part=\"1\" file=\"rigid_0001.vtu\""));
  EXPECT_THAT(text, HasSubstr("arm_0000.vtu"));
  EXPECT_THAT(text, testing::EndsWith("</VTKFile>\n"));
}

void write_small_results(const TemporaryFolder& folder, bool with_stress) {
  CsvTable series(
      folder.path("time_series.csv"),
      {"t [s]", with_stress ? "von_mises box [Pa]" : "bodies.box.position.x [m]", "energy.kinetic [J]"});
  CsvTable steps(folder.path("steps.csv"), {"t [s]", "h [s]", "order", "newton", "factorizations"});
  mfs::dae::PvdFile list(folder.path("result.pvd"));
  VtkCells cells;
  const std::int32_t box[] = {0, 1, 2, 3, 4, 5, 6, 7};
  cells.add(VtkCell::hexahedron, box, 8);
  for (int i = 0; i < 3; ++i) {
    const double x = 1 + 0.1 * i;
    const std::string name = "box_" + std::to_string(i) + ".vtu";
    series.add_row({0.5 * i, 1e6 * i, 3});
    steps.add_row({0.5 * i, 0.5, 1.0 + i, 2, 1});
    mfs::dae::VtkGrid grid;
    grid.cells = cells;
    grid.points = {0, 0, 0, x, 0, 0, x, 1, 0, 0, 1, 0, 0, 0, 1, x, 0, 1, x, 1, 1, 0, 1, 1};
    if (with_stress)
      grid.point_fields = {{"von_mises", 1, {0, 1e6, 2e6, 0, 0, 1e6, 1e6, 0}}};
    else
      grid.cell_ids = {{"body", {0}}};
    mfs::dae::write_vtu(folder.path(name), grid);
    list.add(0.5 * i, 0, name);
  }
}

class PlotsOf : public testing::TestWithParam<bool> {};

TEST_P(PlotsOf, AreDrawnWhereMatplotlibIs) {
  const TemporaryFolder folder;
  write_small_results(folder, GetParam());
  const mfs::dae::PlotOutcome plots = mfs::dae::draw_plots(folder.path(""));
  if (plots.trouble.find("needs matplotlib") != std::string::npos) GTEST_SKIP() << plots.trouble;
  EXPECT_EQ(plots.trouble, "");
  ASSERT_EQ(plots.files.size(), 3U);
  for (const std::string& file : plots.files) EXPECT_EQ(text_of(file).substr(1, 3), "PNG") << file;
}

INSTANTIATE_TEST_SUITE_P(FlexibleAndRigid, PlotsOf, testing::Bool());

// It has no extent by which a picture could be scaled.
TEST(Plots, OfASinglePoint) {
  const TemporaryFolder folder;
  CsvTable(folder.path("time_series.csv"), {"t [s]"}).add_row({0});
  VtkCells cells;
  const std::int32_t first[] = {0};
  cells.add(VtkCell::vertex, first, 1);
  mfs::dae::VtkGrid grid;
  grid.cells = cells;
  grid.points = {1, 2, 3};
  mfs::dae::write_vtu(folder.path("point.vtu"), grid);
  mfs::dae::PvdFile(folder.path("result.pvd")).add(0, 0, "point.vtu");
  const mfs::dae::PlotOutcome plots = mfs::dae::draw_plots(folder.path(""));
  if (plots.trouble.find("needs matplotlib") != std::string::npos) GTEST_SKIP() << plots.trouble;
  EXPECT_EQ(plots.trouble, "");
  EXPECT_EQ(plots.files.size(), 1U);
}

TEST(Plots, TroubleIsSaidInOneLine) {
  const TemporaryFolder folder;
  folder.write("steps.csv", "t [s],h [s]\nnonsense,1\n");
  const mfs::dae::PlotOutcome plots = mfs::dae::draw_plots(folder.path(""));
  EXPECT_TRUE(plots.files.empty());
  EXPECT_NE(plots.trouble, "");
  EXPECT_EQ(plots.trouble.find('\n'), std::string::npos);
}

}  // namespace
