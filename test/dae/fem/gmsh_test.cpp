// Gmsh files written by hand: both formats, all three elements, and every way in which a file may be wrong.
#include <gmock/gmock.h>

#include <mfs/error.hpp>
#include <sstream>

#include "dae/fem/gmsh.hpp"
#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Mesh read(const std::string& text) {
  std::istringstream file(text);
  return read_gmsh(file, "part.msh");
}

std::string message(const std::string& text) {
  try {
    read(text);
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.argument(), "part.msh");
    return error.what();
  }
  return "no error";
}

const std::string kFormat2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string kFormat4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";

// A unit cube and, under tag 99, a node that no volume uses.
const std::string kCube2 =
    kFormat2 +
    "$PhysicalNames\n2\n2 7 \"left side\"\n3 1 \"all\"\n$EndPhysicalNames\n"
    "$Nodes\n9\n99 5 5 5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n"
    "$Elements\n4\n1 15 2 3 1 99\n2 3 2 7 1 1 4 8 5\n3 5 2 1 1 1 2 3 4 5 6 7 8\n"
    "4 5 2 2 1 1 2 3 4 5 6 7 8\n$EndElements\n";

TEST(Gmsh, ReadsVersion2) {
  const Mesh mesh = read(kCube2);
  EXPECT_EQ(mesh.kind, ElementKind::hex8);
  EXPECT_EQ(mesh.nodes.size(), 8u);
  EXPECT_EQ(mesh.element_count(), 1);  // the second is the first again, in another group
  EXPECT_THAT(mesh.elements, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(mesh.node_sets.at("left side"), ElementsAre(0, 3, 4, 7));
  EXPECT_EQ(mesh.node_sets.at("all").size(), 8u);
  EXPECT_EQ(mesh.node_sets.at("volume_2").size(), 8u);
  EXPECT_TRUE(mesh.node_sets.at("point_3").empty());
  EXPECT_NEAR(make_body(mesh, {MaterialLaw::neo_hookean, 1, 0, 3}).mass(), 3, 1e-14);
}

// The group has its surface turned round.
TEST(Gmsh, ReadsVersion4) {
  const Mesh mesh = read(
      kFormat4 +
      "$PhysicalNames\n1\n2 7 \"left\"\n$EndPhysicalNames\n"
      "$Entities\n1 0 2 1\n1 0 0 0 0\n4 0 0 0 0 1 1 1 -7 0\n5 0 0 0 0 1 1 0 0\n1 0 0 0 1 1 1 2 1 2 "
      "0\n$EndEntities\n"
      "$Nodes\n2 8 1 8\n0 1 0 1\n1\n0 0 0\n3 1 0 7\n2\n3\n4\n5\n6\n7\n8\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 "
      "1\n1 1 1\n0 1 1\n$EndNodes\n"
      "$Elements\n3 3 1 3\n2 4 3 1\n1 1 4 8 5\n2 5 3 1\n2 2 3 7 6\n3 1 5 1\n3 1 2 3 4 5 6 7 8\n$EndElements\n"
      "$Comment\nignored\n$EndComment\n");
  EXPECT_EQ(mesh.element_count(), 1);
  EXPECT_THAT(mesh.node_sets.at("left"), ElementsAre(0, 3, 4, 7));
  EXPECT_EQ(mesh.node_sets.at("volume_1").size(), 8u);
  EXPECT_EQ(mesh.node_sets.at("volume_2").size(), 8u);
  EXPECT_EQ(mesh.node_sets.size(), 3u);
}

// A quadratic element whose nodes lie where Gmsh's manual draws them; with the wrong order its Jacobian would
// not be positive, or its volume wrong.
std::string quadratic(int type, const std::vector<Point3>& corners,
                      const std::vector<std::array<int, 2>>& edges) {
  std::vector<Point3> nodes = corners;
  for (const auto& [p, q] : edges) {
    Point3 middle;
    for (std::size_t k = 0; k < 3; ++k)
      middle[k] = (corners[static_cast<std::size_t>(p)][k] + corners[static_cast<std::size_t>(q)][k]) / 2;
    nodes.push_back(middle);
  }
  std::ostringstream text;
  text << kFormat2 << "$Nodes\n" << nodes.size() << '\n';
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text << i + 1 << ' ' << nodes[i][0] << ' ' << nodes[i][1] << ' ' << nodes[i][2] << '\n';
  text << "$EndNodes\n$Elements\n1\n1 " << type << " 2 1 1";
  for (std::size_t i = 0; i < nodes.size(); ++i) text << ' ' << i + 1;
  text << "\n$EndElements\n";
  return text.str();
}

void expect_middles(const Mesh& mesh) {
  const std::vector<Point3>& cell = reference_nodes(mesh.kind);
  std::vector<double> nodes;
  for (const int node : mesh.elements)
    for (const double x : mesh.nodes[static_cast<std::size_t>(node)]) nodes.push_back(x);
  for (const Point3& at : cell) {  // the map from the cell is affine
    const auto j = jacobian(mesh.kind, at, nodes.data()), first = jacobian(mesh.kind, cell[0], nodes.data());
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) EXPECT_NEAR(j[a][b], first[a][b], 1e-12);
  }
}

TEST(Gmsh, PutsNodesOfQuadraticElementsInOrder) {
  const Mesh tet = read(quadratic(11, {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 4}},
                                  {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}}));
  EXPECT_EQ(tet.kind, ElementKind::tet10);
  expect_middles(tet);
  const Mesh hex = read(quadratic(
      17, {{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0}, {0, 0, 4}, {2, 0, 4}, {2, 3, 4}, {0, 3, 4}},
      {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}}));
  EXPECT_EQ(hex.kind, ElementKind::hex20);
  expect_middles(hex);
}

// `text` with the first `from` replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Gmsh, NamesTheLineThatIsWrong) {
  EXPECT_THAT(message(""), HasSubstr("no volume elements"));
  EXPECT_THAT(message("hello\n"), HasSubstr("line 1: a section should begin here"));
  EXPECT_THAT(message(with(kCube2, "2.2 0", "3.0 0")), HasSubstr("line 2: version 3.0"));
  EXPECT_THAT(message(with(kCube2, "2.2 0", "2.2 1")), HasSubstr("line 2: a binary file"));
  EXPECT_THAT(message(with(kCube2, "\"all\"", "all")), HasSubstr("line 7: a name in quotes"));
  EXPECT_THAT(message(with(kCube2, "1 0 0 0\n", "1 0 zero 0\n")),
              HasSubstr("line 12: cannot read a coordinate"));
  EXPECT_THAT(message(with(kCube2, "2 1 0 0\n", "1 1 0 0\n")), HasSubstr("line 13: node 1 is there twice"));
  EXPECT_THAT(message(with(kCube2, "$Nodes\n9", "$Nodes\n8")), HasSubstr("line 19: $EndNodes should follow"));
  EXPECT_THAT(message(with(kCube2, "$Nodes\n9", "$Nodes\n-9")),
              HasSubstr("line 10: a number of nodes is negative"));
  EXPECT_THAT(message(with(kCube2, "1 4 8 5\n", "1 4 8 50\n")), HasSubstr("line 24: there is no node 50"));
  EXPECT_THAT(message(with(kCube2, "5 6 7 8\n", "5 6 7\n")),
              HasSubstr("line 25: cannot read a node of the element"));
  EXPECT_THAT(message(with(kCube2, "3 5 2 1 1 1 2 3 4 5 6 7 8", "3 4 2 1 1 1 2 3 4")),
              HasSubstr("line 25: element type 4"));
  EXPECT_THAT(message(kCube2.substr(0, kCube2.find("4 5 2 2"))),
              HasSubstr("the file ends where an element should follow"));
  EXPECT_THAT(message(kCube2.substr(kFormat2.size())), HasSubstr("$MeshFormat should come first"));
  EXPECT_THAT(message(kFormat4 + "$Elements\n1 1 1 1\n2 4 5 1\n"),
              HasSubstr("does not have the entity's dimension"));
  EXPECT_THROW(read_gmsh("/no/such/file.msh"), InvalidInput);
}

}  // namespace
}  // namespace mfs::dae::testing
