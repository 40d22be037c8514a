#include "dae/fem/gmsh.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mfs/error.hpp>
#include <set>
#include <sstream>
#include <unordered_map>
#include <utility>

namespace mfs::dae {

namespace {

// Element types by Gmsh's number; lower-dimensional ones only mark nodes.
struct GmshType {
  int number, dimension, nodes;
};

constexpr GmshType kTypes[] = {{15, 0, 1}, {1, 1, 2},  {8, 1, 3}, {2, 2, 3},   {3, 2, 4},  {9, 2, 6},
                               {16, 2, 8}, {10, 2, 9}, {5, 3, 8}, {17, 3, 20}, {11, 3, 10}};

// VTK's node k is Gmsh's node order[k].
std::vector<std::size_t> vtk_order(ElementKind kind) {
  switch (kind) {
    case ElementKind::hex8:
      return {0, 1, 2, 3, 4, 5, 6, 7};
    case ElementKind::hex20:
      return {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15};
    case ElementKind::tet10:
      break;
  }
  return {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
}

ElementKind kind_of(const GmshType& type) {
  return type.number == 5 ? ElementKind::hex8 : type.number == 17 ? ElementKind::hex20 : ElementKind::tet10;
}

// Lines of the file, each a row of values.
class Lines {
 public:
  Lines(std::istream& file, std::string name) : file_(file), name_(std::move(name)) {}

  /// Goes to the next line that is not blank; false at the end of the file.
  bool advance() {
    while (std::getline(file_, line_)) {
      ++number_;
      if (line_.find_first_not_of(" \t\r") == std::string::npos) continue;
      values_ = std::istringstream(line_);
      return true;
    }
    return false;
  }
  void next(const char* wanted) {
    if (!advance()) fail(std::string("the file ends where ") + wanted + " should follow");
  }
  template <class T>
  T value(const char* wanted) {
    T result{};
    if (!(values_ >> result)) fail(std::string("cannot read ") + wanted);
    return result;
  }
  int count(const char* wanted) {
    const int result = value<int>(wanted);
    if (result < 0) fail(std::string(wanted) + " is negative");
    return result;
  }
  std::string section() {
    std::string word;
    std::istringstream(line_) >> word;
    return word;
  }
  void expect(const std::string& section) {
    next(section.c_str());
    if (this->section() != section) fail(section + " should follow");
  }
  const std::string& line() const { return line_; }
  [[noreturn]] void fail(const std::string& what) const {
    throw InvalidInput(name_, "line " + std::to_string(number_) + ": " + what, number_ - 1);
  }

 private:
  std::istream& file_;
  std::string name_, line_;
  std::istringstream values_;
  long number_ = 0;
};

using Tag = long long;
using Group = std::pair<int, int>;  // dimension, physical tag

class Reader {
 public:
  Reader(std::istream& file, const std::string& name) : lines_(file, name) {}

  Mesh read() {
    while (lines_.advance()) {
      const std::string section = lines_.section();
      if (section == "$MeshFormat")
        read_format();
      else if (section == "$PhysicalNames")
        read_names();
      else if (section == "$Entities")
        read_entities();
      else if (section == "$Nodes")
        version_ == 4 ? read_nodes_4() : read_nodes_2();
      else if (section == "$Elements")
        version_ == 4 ? read_elements_4() : read_elements_2();
      else if (section.empty() || section[0] != '$')
        lines_.fail("a section should begin here");
      else {
        skip("$End" + section.substr(1));
        continue;
      }
      lines_.expect("$End" + section.substr(1));
    }
    return result();
  }

 private:
  void skip(const std::string& end) {
    do lines_.next(end.c_str());
    while (lines_.section() != end);
  }

  void read_format() {
    lines_.next("the version");
    const auto version = lines_.value<std::string>("the version");
    if (version != "2.2" && version != "4.1") lines_.fail("version " + version + "; 2.2 and 4.1 can be read");
    version_ = version == "4.1" ? 4 : 2;
    if (lines_.value<int>("the file type") != 0) lines_.fail("a binary file; only ASCII can be read");
  }

  void read_names() {
    lines_.next("a number of names");
    for (int left = lines_.count("a number of names"); left > 0; --left) {
      lines_.next("a physical name");
      const int dimension = lines_.value<int>("a dimension"), tag = lines_.value<int>("a tag");
      const std::size_t begin = lines_.line().find('"'), end = lines_.line().rfind('"');
      if (begin == end) lines_.fail("a name in quotes should follow");
      names_[{dimension, tag}] = lines_.line().substr(begin + 1, end - begin - 1);
    }
  }

  void read_entities() {
    lines_.next("numbers of entities");
    int counts[4];
    for (int& count : counts) count = lines_.count("a number of entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (int left = counts[dimension]; left > 0; --left) {
        lines_.next("an entity");
        const int tag = lines_.value<int>("a tag");
        for (int skipped = dimension == 0 ? 3 : 6; skipped > 0; --skipped)
          lines_.value<double>("a coordinate");
        // A minus says that the group has the entity turned round.
        for (int groups = lines_.count("a number of groups"); groups > 0; --groups)
          entity_groups_[{dimension, tag}].push_back(std::abs(lines_.value<int>("a physical tag")));
      }
  }

  void add_node(Tag tag) {
    Point x;
    for (double& coordinate : x) coordinate = lines_.value<double>("a coordinate");
    if (!node_of_.insert({tag, static_cast<int>(nodes_.size())}).second)
      lines_.fail("node " + std::to_string(tag) + " is there twice");
    nodes_.push_back(x);
  }

  void read_nodes_2() {
    require_format();
    lines_.next("a number of nodes");
    for (int left = lines_.count("a number of nodes"); left > 0; --left) {
      lines_.next("a node");
      add_node(lines_.value<Tag>("a node's tag"));
    }
  }

  void read_nodes_4() {
    lines_.next("a number of blocks");
    for (int blocks = lines_.count("a number of blocks"); blocks > 0; --blocks) {
      lines_.next("a block of nodes");
      for (int skipped = 0; skipped < 3; ++skipped) lines_.value<int>("a block's head");
      std::vector<Tag> tags(static_cast<std::size_t>(lines_.count("a number of nodes")));
      for (Tag& tag : tags) {
        lines_.next("a node's tag");
        tag = lines_.value<Tag>("a node's tag");
      }
      for (const Tag tag : tags) {
        lines_.next("a node");
        add_node(tag);
      }
    }
  }

  const GmshType& type_of(int number) {
    for (const GmshType& type : kTypes)
      if (type.number == number) return type;
    lines_.fail(
        "element type " + std::to_string(number) +
        "; volumes may be of type 5 (hex8), 17 (hex20: Mesh.SecondOrderIncomplete = 1) or 11 (tet10)");
  }

  // The line's remaining values are the nodes of an element in these physical groups.
  void add_element(const GmshType& type, const std::vector<int>& groups) {
    std::vector<int> nodes(static_cast<std::size_t>(type.nodes));
    for (int& node : nodes) {
      const Tag tag = lines_.value<Tag>("a node of the element");
      const auto found = node_of_.find(tag);
      if (found == node_of_.end()) lines_.fail("there is no node " + std::to_string(tag));
      node = found->second;
    }
    for (const int group : groups) groups_[{type.dimension, group}].insert(nodes.begin(), nodes.end());
    if (type.dimension < 3 || !volumes_.insert(nodes).second)
      return;  // 2.2 repeats it for each of its groups
    if (!mesh_.elements.empty() && mesh_.kind != kind_of(type)) lines_.fail("volume elements of two types");
    mesh_.kind = kind_of(type);
    for (const std::size_t k : vtk_order(mesh_.kind)) mesh_.elements.push_back(nodes[k]);
  }

  void read_elements_2() {
    require_format();
    lines_.next("a number of elements");
    for (int left = lines_.count("a number of elements"); left > 0; --left) {
      lines_.next("an element");
      lines_.value<Tag>("an element's tag");
      const GmshType& type = type_of(lines_.value<int>("an element's type"));
      std::vector<int> tags(static_cast<std::size_t>(lines_.count("a number of tags")));
      for (int& tag : tags) tag = lines_.value<int>("a tag");
      if (!tags.empty())
        tags.erase(tags.begin() + (tags[0] != 0), tags.end());  // the first is the physical group, 0: none
      add_element(type, tags);
    }
  }

  void read_elements_4() {
    lines_.next("a number of blocks");
    for (int blocks = lines_.count("a number of blocks"); blocks > 0; --blocks) {
      lines_.next("a block of elements");
      const int dimension = lines_.value<int>("a dimension"), entity = lines_.value<int>("an entity");
      const GmshType& type = type_of(lines_.value<int>("an element type"));
      if (type.dimension != dimension) lines_.fail("the element type does not have the entity's dimension");
      const std::vector<int>& groups = entity_groups_[{dimension, entity}];
      for (int left = lines_.count("a number of elements"); left > 0; --left) {
        lines_.next("an element");
        lines_.value<Tag>("an element's tag");
        add_element(type, groups);
      }
    }
  }

  void require_format() {
    if (version_ == 0) lines_.fail("$MeshFormat should come first");
  }

  std::string name_of(const Group& group) const {
    static const char* const kDimensions[] = {"point_", "curve_", "surface_", "volume_"};
    const auto found = names_.find(group);
    return found != names_.end() ? found->second : kDimensions[group.first] + std::to_string(group.second);
  }

  Mesh result() {
    if (mesh_.elements.empty()) lines_.fail("the file has no volume elements");
    std::vector<int> number(nodes_.size(), -1);
    for (int& node : mesh_.elements) {
      int& at = number[static_cast<std::size_t>(node)];
      if (at < 0) {
        at = static_cast<int>(mesh_.nodes.size());
        mesh_.nodes.push_back(nodes_[static_cast<std::size_t>(node)]);
      }
      node = at;
    }
    for (const auto& [group, nodes] : groups_) {
      std::vector<int>& set = mesh_.node_sets[name_of(group)];
      for (const int node : nodes)
        if (number[static_cast<std::size_t>(node)] >= 0)
          set.push_back(number[static_cast<std::size_t>(node)]);
      std::sort(set.begin(), set.end());
      set.erase(std::unique(set.begin(), set.end()), set.end());
    }
    return std::move(mesh_);
  }

  using Point = std::array<double, 3>;

  Lines lines_;
  int version_ = 0;
  Mesh mesh_;
  std::vector<Point> nodes_;
  std::unordered_map<Tag, int> node_of_;
  std::map<Group, std::string> names_;
  std::map<std::pair<int, int>, std::vector<int>> entity_groups_;  // (dimension, entity) -> physical tags
  std::map<Group, std::set<int>> groups_;
  std::set<std::vector<int>> volumes_;
};

}  // namespace

Mesh read_gmsh(std::istream& file, const std::string& name) {
  return Reader(file, name).read();
}

Mesh read_gmsh(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw InvalidInput(path, "the file cannot be read");
  if (std::filesystem::is_directory(path)) throw InvalidInput(path, "cannot be read: it is a folder");
  return read_gmsh(file, path);
}

}  // namespace mfs::dae
