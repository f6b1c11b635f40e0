#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh::detail {

/// One side of an edge: the triangle that has it.
struct HalfEdge {
  int low, high, triangle;
  bool forward;  ///< the triangle runs from low to high
};

/// The three half edges of every triangle, those of one edge side by side (by low, high, triangle).
std::vector<HalfEdge> sorted_half_edges(const IndexRows& triangles);

/// Calls visit(first, end) with the half edges of each edge.
template <class Visit>
void for_each_edge(const std::vector<HalfEdge>& edges, Visit visit) {
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    visit(edges.data() + i, edges.data() + end);
    i = end;
  }
}

/// Triangles joined over edges that two of them share. @return the part of each triangle, numbered from 0 by first triangle
std::vector<int> parts_over_edges(const std::vector<HalfEdge>& edges, int n_triangles, int& n_parts);

/// A part of a surface as a body or a hollow.
struct PartGeometry {
  double volume_m3 = 0.0;   ///< enclosed, negative where its normals point into it
  int first_triangle = -1;  ///< its lowest
  int depth = 0;            ///< how many other parts it lies in: even outside, odd bounds a hollow
  int within = -1;          ///< the smallest of these parts, -1 for none
};

/// Of a closed surface: each part's volume, and where it lies by the winding number of its first corner in the others.
std::vector<PartGeometry> part_geometry(const SurfaceMesh& surface, const std::vector<int>& part_of_triangle,
                                        int n_parts);

}  // namespace klang::mesh::detail
