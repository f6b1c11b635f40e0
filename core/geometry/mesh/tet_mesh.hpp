#pragma once
#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

namespace klang::mesh {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using IndexRows = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Tetrahedra, straight (4 nodes) or quadratic (10 nodes, curved where mid-nodes lie on a curved surface).
/// Node order of a row is VTK's: corners 0-3 with positive volume det(p1-p0, p2-p0, p3-p0) > 0, then the
/// mid-nodes of edges 01, 12, 02, 03, 13, 23.
struct TetMesh {
  Points nodes_m;                                     ///< n_nodes x 3
  IndexRows elements;                                 ///< n_elements x 4 or n_elements x 10, 0-based
  std::map<std::string, std::vector<int>> node_sets;  ///< named nodes (physical groups, "x_min", ...)

  int n_nodes() const { return static_cast<int>(nodes_m.rows()); }
  int n_elements() const { return static_cast<int>(elements.rows()); }
  int order() const { return elements.cols() == 10 ? 2 : 1; }
};

/// Corner pairs of the mid-nodes 4 to 9 of an element row.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// Corners of the faces of an element row, counter-clockwise seen from outside; face f lies opposite to
/// corner f.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// The column (4 to 9) of the mid-node between corners a and b of an element row, a != b in 0..3.
constexpr int tet_mid_column(int a, int b) {
  for (int e = 0; e < 6; ++e)
    if ((kTetEdges[e][0] == a && kTetEdges[e][1] == b) || (kTetEdges[e][0] == b && kTetEdges[e][1] == a)) return 4 + e;
  return -1;
}

/// Triangles of a closed or open surface; vertices counter-clockwise seen from outside. Rows of 3 or 6
/// (quadratic: corners, then mid-nodes of 01, 12, 20).
struct SurfaceMesh {
  Points vertices_m;    ///< n_vertices x 3
  IndexRows triangles;  ///< n_triangles x 3 or x 6, 0-based
};

/// The boundary of the body, with outward normals. vertex_of_surface maps nothing: vertices_m repeats
/// nodes_m, so that surface vertex i is mesh node i.
SurfaceMesh boundary_surface(const TetMesh& mesh);

/// The same body with straight 4-node elements on the corner nodes (unused nodes dropped), or with mid-nodes
/// added half-way along each edge.
TetMesh to_linear(const TetMesh& mesh);
TetMesh to_quadratic(const TetMesh& mesh);

}  // namespace klang::mesh
