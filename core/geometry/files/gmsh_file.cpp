#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <unordered_map>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/detail/mesh_formats.hpp"

namespace klang::mesh::detail {
namespace {

// Gmsh runs the last two mid-nodes of its ten-node tetrahedron (edges 23, 13) the other way round than VTK
// (13, 23).
constexpr std::array<int, 10> kFromGmsh{0, 1, 2, 3, 4, 5, 6, 7, 9, 8};

struct ElementType {
  int dimension, n_nodes;
};

/// Nodes of an element type, 0 for unknown ones.
ElementType element_type(long long type) {
  static const std::map<long long, ElementType> kTypes{
      {1, {1, 2}},   {2, {2, 3}},   {3, {2, 4}},   {4, {3, 4}},   {5, {3, 8}},   {6, {3, 6}},   {7, {3, 5}},
      {8, {1, 3}},   {9, {2, 6}},   {10, {2, 9}},  {11, {3, 10}}, {12, {3, 27}}, {13, {3, 18}}, {14, {3, 14}},
      {15, {0, 1}},  {16, {2, 8}},  {17, {3, 20}}, {18, {3, 15}}, {19, {3, 13}}, {20, {2, 9}},  {21, {2, 10}},
      {22, {2, 12}}, {23, {2, 15}}, {24, {2, 15}}, {25, {2, 21}}, {26, {1, 4}},  {27, {1, 5}},  {28, {1, 6}},
      {29, {3, 20}}, {30, {3, 35}}, {31, {3, 56}}};
  const auto it = kTypes.find(type);
  return it == kTypes.end() ? ElementType{0, 0} : it->second;
}

class GmshReader {
 public:
  GmshReader(std::string_view bytes, const std::string& name) : cursor_(bytes, name), bytes_(bytes) {}

  TetMesh read() {
    bool have_nodes = false, have_elements = false;
    while (cursor_.skip_blanks()) {
      const std::string section(cursor_.word("a section"));
      if (section.size() < 2 || section[0] != '$')
        cursor_.fail("not a section of a Gmsh file", section.substr(0, 32), "$Name");
      if (section == "$Comments") {  // Gmsh allows remarks anywhere, before the format too
        skip_section(section);
        continue;
      }
      if (section != "$MeshFormat" && version_ == 0.0) cursor_.fail("the file does not start with $MeshFormat");
      if (section == "$MeshFormat") {
        read_format();
      } else if (section == "$PhysicalNames") {
        read_physical_names();
      } else if (section == "$Entities" && version_ >= 4.0) {
        start_body();
        read_entities();
      } else if (section == "$Nodes") {
        start_body();
        version_ >= 4.0 ? read_nodes_4() : read_nodes_2();
        have_nodes = true;
      } else if (section == "$Elements") {
        if (!have_nodes) cursor_.fail("$Elements before $Nodes");
        start_body();
        version_ >= 4.0 ? read_elements_4() : read_elements_2();
        have_elements = true;
      } else {
        skip_section(section);
        continue;
      }
      cursor_.set_binary(false);
      const std::string end = "$End" + section.substr(1);
      if (cursor_.word(end) != end) cursor_.fail("section does not end where it should", section, end);
    }
    if (!have_nodes || !have_elements) cursor_.fail("the file ends before $Nodes and $Elements");
    return finish();
  }

 private:
  void read_format() {
    version_ = cursor_.number("the version");
    if (version_ != 2.2 && version_ != 2.1 && version_ != 2.0 && version_ != 4.1)
      cursor_.fail("unsupported Gmsh version", to_text(version_), "2.2 or 4.1");
    const long long type = cursor_.integer("the file type");
    if (type != 0 && type != 1) cursor_.fail("file type", std::to_string(type), "0 ASCII, 1 binary");
    binary_ = type == 1;
    if (cursor_.integer("the data size") != 8) cursor_.fail("data size is not 8");
    if (binary_) {
      cursor_.line();
      if (cursor_.raw<std::int32_t>("the byte-order mark") != 1) cursor_.fail("the file has another byte order");
    }
  }

  /// Binary bodies start after the line break of the section's name.
  void start_body() {
    if (!binary_) return;
    cursor_.line();
    cursor_.set_binary(true);
  }

  void skip_section(const std::string& section) {
    const std::string end = "$End" + section.substr(1);
    const std::size_t at = bytes_.find(end, cursor_.position());
    if (at == std::string_view::npos) cursor_.fail("section does not end", section.substr(0, 32), end.substr(0, 36));
    cursor_.seek(at + end.size());
  }

  void read_physical_names() {
    const std::size_t n = cursor_.count("the count of physical names", 6);
    for (std::size_t i = 0; i < n; ++i) {
      const long long dimension = cursor_.integer("a dimension"), tag = cursor_.integer("a physical tag");
      std::string_view name = cursor_.line();
      const std::size_t open = name.find('"'), close = name.rfind('"');
      if (open == std::string_view::npos || close == open) cursor_.fail("physical name without quotes");
      physical_names_[{dimension, tag}] = std::string(name.substr(open + 1, close - open - 1));
    }
  }

  long long value_4(std::string_view what, std::size_t n_bytes) {
    if (!binary_) return cursor_.integer(what);
    return n_bytes == 4 ? cursor_.raw<std::int32_t>(what) : static_cast<long long>(cursor_.raw<std::uint64_t>(what));
  }
  double coordinate(std::string_view what) { return binary_ ? cursor_.raw<double>(what) : cursor_.number(what); }
  std::size_t count_4(std::string_view what, std::size_t bytes_each_binary, std::size_t bytes_each_ascii) {
    return cursor_.checked_count(static_cast<double>(value_4(what, 8)), what,
                                 binary_ ? bytes_each_binary : bytes_each_ascii);
  }

  void read_entities() {
    std::array<std::size_t, 4> counts;
    for (std::size_t& count : counts) count = count_4("an entity count", 8, 4);
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < counts[dimension]; ++i) {
        const long long tag = value_4("an entity's tag", 4);
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) coordinate("an entity's box");
        const std::size_t n_physical = count_4("a count of physical tags", 4, 2);
        for (std::size_t k = 0; k < n_physical; ++k)
          physical_of_entity_[{dimension, tag}].push_back(value_4("a physical tag", 4));
        if (dimension == 0) continue;
        const std::size_t n_bounding = count_4("a count of bounding entities", 4, 2);
        for (std::size_t k = 0; k < n_bounding; ++k) value_4("a bounding entity", 4);
      }
  }

  void add_node(long long tag, const std::array<double, 3>& x) {
    if (!index_of_tag_.try_emplace(tag, static_cast<int>(nodes_.size())).second)
      cursor_.fail("node number appears twice", std::to_string(tag));
    nodes_.push_back(x);
  }

  void read_nodes_2() {
    const std::size_t n = binary_ ? cursor_.checked_count(ascii_count_line("the node count"), "the node count", 28)
                                  : cursor_.count("the node count", 8);
    for (std::size_t i = 0; i < n; ++i) {
      const long long tag = binary_ ? cursor_.raw<std::int32_t>("a node") : cursor_.integer("a node number");
      std::array<double, 3> x;
      for (double& value : x) value = coordinate("a coordinate");
      add_node(tag, x);
    }
  }

  /// In version 2 the counts are text even in binary files, on a line of their own.
  double ascii_count_line(std::string_view what) {
    const std::string_view line = cursor_.line();
    const auto words = split_words(line);
    long long n = 0;
    if (words.size() != 1 || !parse_integer(words[0], n)) cursor_.fail(std::string(what) + " is not an integer");
    return static_cast<double>(n);
  }

  void read_nodes_4() {
    const std::size_t n_blocks = count_4("the block count", 20, 8);
    count_4("the node count", 32, 8);
    value_4("the least node number", 8);
    value_4("the largest node number", 8);
    std::vector<long long> tags;
    for (std::size_t b = 0; b < n_blocks; ++b) {
      const long long dimension = value_4("a dimension", 4);
      value_4("an entity", 4);
      const long long parametric = value_4("the parametric flag", 4);
      const std::size_t n = count_4("the node count of a block", 32, 8);
      tags.clear();
      for (std::size_t i = 0; i < n; ++i) tags.push_back(value_4("a node number", 8));
      for (std::size_t i = 0; i < n; ++i) {
        std::array<double, 3> x;
        for (double& value : x) value = coordinate("a coordinate");
        if (parametric != 0)
          for (long long k = 0; k < std::clamp(dimension, 0LL, 3LL); ++k) coordinate("a parameter");
        add_node(tags[i], x);
      }
    }
  }

  int node_index(long long tag) {
    const auto it = index_of_tag_.find(tag);
    if (it == index_of_tag_.end())
      cursor_.fail("element " + std::to_string(n_read_) + ": no node has this number", std::to_string(tag));
    return it->second;
  }

  void add_element(long long type, const std::vector<long long>& tags, const std::vector<std::string>& sets) {
    std::array<int, 10> row{};
    const bool tetrahedron = type == 4 || type == 11;
    for (std::size_t c = 0; c < tags.size(); ++c) {
      const int index = node_index(tags[c]);
      if (tetrahedron) row[c] = index;
      for (const std::string& name : sets) sets_[name].insert(index);
    }
    if (tetrahedron) {
      if (columns_ != 0 && columns_ != static_cast<int>(tags.size()))
        cursor_.fail("element " + std::to_string(n_read_) + ": linear and quadratic tetrahedra are mixed");
      columns_ = static_cast<int>(tags.size());
      rows_.push_back(row);
    }
    ++n_read_;
  }

  ElementType checked_type(long long type) {
    const ElementType result = element_type(type);
    if (result.n_nodes == 0)
      cursor_.fail("element " + std::to_string(n_read_) + ": unknown element type", std::to_string(type));
    if (result.dimension == 3 && type != 4 && type != 11)
      cursor_.fail("element " + std::to_string(n_read_) + " is a solid that is not a tetrahedron",
                   "type " + std::to_string(type), "types 4 and 11");
    return result;
  }

  std::vector<std::string> names_of(long long dimension, const std::vector<long long>& physical) const {
    std::vector<std::string> names;
    for (const long long tag : physical) {
      const auto it = physical_names_.find({dimension, tag});
      if (it != physical_names_.end()) names.push_back(it->second);
    }
    return names;
  }

  void read_elements_2() {
    const std::size_t n = binary_ ? cursor_.checked_count(ascii_count_line("the element count"), "the element count", 8)
                                  : cursor_.count("the element count", 8);
    std::vector<long long> tags, nodes;
    const auto read_one = [&](long long type, std::size_t n_tags) {
      const ElementType kind = checked_type(type);
      tags.clear();
      nodes.clear();
      for (std::size_t k = 0; k < n_tags; ++k) tags.push_back(value_4("a tag", 4));
      for (int k = 0; k < kind.n_nodes; ++k) nodes.push_back(value_4("a node of an element", 4));
      tags.resize(std::min<std::size_t>(tags.size(), 1));  // the first tag is the physical group
      add_element(type, nodes, names_of(kind.dimension, tags));
    };
    for (std::size_t i = 0; i < n;) {
      if (!binary_) {
        cursor_.integer("an element number");
        const long long type = cursor_.integer("an element type");
        read_one(type, cursor_.count("the tag count", 2));
        ++i;
        continue;
      }
      const long long type = cursor_.raw<std::int32_t>("an element type");
      const std::size_t n_block = cursor_.checked_count(cursor_.raw<std::int32_t>("a block count"), "a block count", 8);
      const std::size_t n_tags = cursor_.checked_count(cursor_.raw<std::int32_t>("the tag count"), "the tag count", 4);
      if (n_block == 0 || n_block > n - i) cursor_.fail("a block has more elements than the section");
      for (std::size_t k = 0; k < n_block; ++k, ++i) {
        cursor_.raw<std::int32_t>("an element number");
        read_one(type, n_tags);
      }
    }
  }

  void read_elements_4() {
    const std::size_t n_blocks = count_4("the block count", 20, 8);
    count_4("the element count", 16, 4);
    value_4("the least element number", 8);
    value_4("the largest element number", 8);
    std::vector<long long> nodes;
    for (std::size_t b = 0; b < n_blocks; ++b) {
      const long long dimension = value_4("a dimension", 4), entity = value_4("an entity", 4);
      const long long type = value_4("an element type", 4);
      const ElementType kind = checked_type(type);
      const std::size_t n =
          count_4("the element count of a block", 8 * (1 + static_cast<std::size_t>(kind.n_nodes)), 4);
      const auto physical = physical_of_entity_.find({dimension, entity});
      const std::vector<std::string> names =
          physical == physical_of_entity_.end() ? std::vector<std::string>() : names_of(dimension, physical->second);
      for (std::size_t i = 0; i < n; ++i) {
        value_4("an element number", 8);
        nodes.clear();
        for (int k = 0; k < kind.n_nodes; ++k) nodes.push_back(value_4("a node of an element", 8));
        add_element(type, nodes, names);
      }
    }
  }

  TetMesh finish() const {
    TetMesh mesh;
    mesh.nodes_m.resize(static_cast<Eigen::Index>(nodes_.size()), 3);
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (int a = 0; a < 3; ++a) mesh.nodes_m(static_cast<Eigen::Index>(i), a) = nodes_[i][a];
    mesh.elements.resize(static_cast<Eigen::Index>(rows_.size()), columns_ == 10 ? 10 : 4);
    for (std::size_t e = 0; e < rows_.size(); ++e)
      for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c)
        mesh.elements(static_cast<Eigen::Index>(e), c) = rows_[e][kFromGmsh[c]];
    std::set<int> used;
    for (const auto& row : rows_) used.insert(row.begin(), row.begin() + mesh.elements.cols());
    for (const auto& [name, nodes] : sets_)
      if (nodes != used) mesh.node_sets[name].assign(nodes.begin(), nodes.end());  // not the name of the whole body
    return mesh;
  }

  ByteCursor cursor_;
  std::string_view bytes_;
  double version_ = 0.0;
  bool binary_ = false;
  std::map<std::array<long long, 2>, std::string> physical_names_;
  std::map<std::array<long long, 2>, std::vector<long long>> physical_of_entity_;
  std::vector<std::array<double, 3>> nodes_;
  std::unordered_map<long long, int> index_of_tag_;
  std::vector<std::array<int, 10>> rows_;
  int columns_ = 0;
  std::size_t n_read_ = 0;
  std::map<std::string, std::set<int>> sets_;
};

std::string coordinates_text(const TetMesh& mesh, int node) {
  return to_text(mesh.nodes_m(node, 0)) + " " + to_text(mesh.nodes_m(node, 1)) + " " + to_text(mesh.nodes_m(node, 2));
}

std::string nodes_text(const TetMesh& mesh, int element) {
  std::string text;
  for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c)
    text += " " + std::to_string(mesh.elements(element, kFromGmsh[c]) + 1);
  return text + "\n";
}

/// The body is physical volume 1; node sets are physical points 1, 2, ...
std::string physical_names_text(const TetMesh& mesh) {
  std::string text = "$PhysicalNames\n" + std::to_string(mesh.node_sets.size() + 1) + "\n";
  int tag = 0;
  for (const auto& [name, nodes] : mesh.node_sets) text += "0 " + std::to_string(++tag) + " \"" + name + "\"\n";
  return text + "3 1 \"body\"\n$EndPhysicalNames\n";
}

std::size_t n_set_points(const TetMesh& mesh) {
  std::size_t n = 0;
  for (const auto& [name, nodes] : mesh.node_sets) n += nodes.size();
  return n;
}

}  // namespace

TetMesh read_gmsh(std::string_view bytes, const std::string& name) { return GmshReader(bytes, name).read(); }

std::string gmsh22_text(const TetMesh& mesh) {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + physical_names_text(mesh);
  text += "$Nodes\n" + std::to_string(mesh.n_nodes()) + "\n";
  for (int i = 0; i < mesh.n_nodes(); ++i) text += std::to_string(i + 1) + " " + coordinates_text(mesh, i) + "\n";
  text += "$EndNodes\n$Elements\n" + std::to_string(n_set_points(mesh) + mesh.n_elements()) + "\n";
  std::size_t number = 0;
  int tag = 0;
  for (const auto& [name, nodes] : mesh.node_sets) {
    ++tag;
    for (const int node : nodes)
      text += std::to_string(++number) + " 15 2 " + std::to_string(tag) + " " + std::to_string(tag) + " " +
              std::to_string(node + 1) + "\n";
  }
  for (int e = 0; e < mesh.n_elements(); ++e)
    text += std::to_string(++number) + (mesh.order() == 2 ? " 11" : " 4") + " 2 1 1" + nodes_text(mesh, e);
  return text + "$EndElements\n";
}

std::string gmsh41_text(const TetMesh& mesh) {
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + physical_names_text(mesh);
  const std::size_t n_sets = mesh.node_sets.size();
  text += "$Entities\n" + std::to_string(n_sets) + " 0 0 1\n";
  for (std::size_t set = 1; set <= n_sets; ++set) {
    const auto it = std::next(mesh.node_sets.begin(), static_cast<std::ptrdiff_t>(set - 1));
    text += std::to_string(set) + " " + (it->second.empty() ? "0 0 0" : coordinates_text(mesh, it->second.front())) +
            " 1 " + std::to_string(set) + "\n";
  }
  const Eigen::RowVector3d low = mesh.nodes_m.colwise().minCoeff(), high = mesh.nodes_m.colwise().maxCoeff();
  text += "1";
  for (const auto& corner : {low, high})
    for (int a = 0; a < 3; ++a) text += " " + to_text(corner[a]);
  text += " 1 1 0\n$EndEntities\n";
  const std::string n_nodes = std::to_string(mesh.n_nodes());
  text += "$Nodes\n1 " + n_nodes + " 1 " + n_nodes + "\n3 1 0 " + n_nodes + "\n";
  for (int i = 0; i < mesh.n_nodes(); ++i) text += std::to_string(i + 1) + "\n";
  for (int i = 0; i < mesh.n_nodes(); ++i) text += coordinates_text(mesh, i) + "\n";
  const std::string n_elements = std::to_string(n_set_points(mesh) + mesh.n_elements());
  text += "$EndNodes\n$Elements\n" + std::to_string(n_sets + 1) + " " + n_elements + " 1 " + n_elements + "\n";
  std::size_t number = 0;
  int set = 0;
  for (const auto& [name, nodes] : mesh.node_sets) {
    text += "0 " + std::to_string(++set) + " 15 " + std::to_string(nodes.size()) + "\n";
    for (const int node : nodes) text += std::to_string(++number) + " " + std::to_string(node + 1) + "\n";
  }
  text += std::string("3 1 ") + (mesh.order() == 2 ? "11 " : "4 ") + std::to_string(mesh.n_elements()) + "\n";
  for (int e = 0; e < mesh.n_elements(); ++e) text += std::to_string(++number) + nodes_text(mesh, e);
  return text + "$EndElements\n";
}

}  // namespace klang::mesh::detail
