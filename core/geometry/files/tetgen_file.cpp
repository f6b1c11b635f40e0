#include <array>
#include <map>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/detail/mesh_formats.hpp"

namespace klang::mesh::detail {
namespace {

// Where TetGen keeps the mid-nodes of edges 01, 12, 02, 03, 13, 23 among its ten nodes (edges 23, 03, 01, 12,
// 13, 02).
constexpr std::array<int, 10> kFromTetgen{0, 1, 2, 3, 6, 7, 9, 5, 8, 4};

}  // namespace

TetMesh read_tetgen(std::string_view node_bytes, std::string_view ele_bytes, const std::string& name) {
  ByteCursor nodes(node_bytes, name + " (nodes)");
  nodes.set_comment('#');
  const std::size_t n_nodes = nodes.count("the node count", 8);
  if (nodes.integer("the dimension") != 3) nodes.fail("the dimension is not 3");
  const std::size_t n_attributes = nodes.count("the attribute count", 1);
  const long long n_markers = nodes.integer("the marker count");
  if (n_markers != 0 && n_markers != 1) nodes.fail("marker count", std::to_string(n_markers), "0 or 1");
  TetMesh mesh;
  mesh.nodes_m.resize(static_cast<Eigen::Index>(n_nodes), 3);
  std::map<long long, std::vector<int>> by_marker;
  long long first = 0;
  for (std::size_t i = 0; i < n_nodes; ++i) {
    const long long number = nodes.integer("a node number");
    if (i == 0) first = number;
    if ((first != 0 && first != 1) || number != first + static_cast<long long>(i))
      nodes.fail("node numbers do not run on", std::to_string(number), "from 0 or 1, in steps of 1");
    for (int a = 0; a < 3; ++a) mesh.nodes_m(static_cast<Eigen::Index>(i), a) = nodes.number("a coordinate");
    for (std::size_t k = 0; k < n_attributes; ++k) nodes.number("an attribute");
    if (n_markers == 0) continue;
    const long long marker = nodes.integer("a marker");
    if (marker != 0) by_marker[marker].push_back(static_cast<int>(i));
    if (by_marker.size() > 10000) nodes.fail("too many different markers", "", "up to 10000");
  }

  ByteCursor elements(ele_bytes, name + " (elements)");
  elements.set_comment('#');
  const std::size_t n_elements = elements.count("the element count", 10);
  const long long n_corners = elements.integer("the nodes per element");
  if (n_corners != 4 && n_corners != 10) elements.fail("nodes per element", std::to_string(n_corners), "4 or 10");
  const std::size_t n_regions = elements.count("the attribute count", 1);
  mesh.elements.resize(static_cast<Eigen::Index>(n_elements), n_corners);
  std::array<int, 10> row{};
  for (std::size_t e = 0; e < n_elements; ++e) {
    elements.integer("an element number");
    for (long long c = 0; c < n_corners; ++c) {
      const long long node = elements.integer("a node of an element") - first;
      if (node < 0 || node >= static_cast<long long>(n_nodes))
        elements.fail("element " + std::to_string(e) + ": node out of range", std::to_string(node + first),
                      std::to_string(first) + " to " + std::to_string(first + static_cast<long long>(n_nodes) - 1));
      row[c] = static_cast<int>(node);
    }
    for (std::size_t k = 0; k < n_regions; ++k) elements.number("an attribute");
    for (long long c = 0; c < n_corners; ++c)
      mesh.elements(static_cast<Eigen::Index>(e), c) = row[n_corners == 10 ? kFromTetgen[c] : c];
  }
  for (auto& [marker, in_set] : by_marker) mesh.node_sets["boundary_" + std::to_string(marker)] = std::move(in_set);
  return mesh;
}

}  // namespace klang::mesh::detail
