#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/mesh/mirrored_surface.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::acoustics {

/// How a surface is made of images of its first vertices and triangles, as mesh::MirroredSurface says; no planes: of itself.
struct SurfaceMirrors {
  mesh::MirrorPlanes planes;
  int n_own_vertices = 0;
  std::vector<std::vector<int>> vertex_image;
};

/// Flat triangles of a closed surface, counter-clockwise seen from the fluid, with what every frequency needs.
struct RadiatingSurface {
  Eigen::Matrix3Xd vertices_m;   ///< 3 x n_vertices, each used by a triangle
  Eigen::Matrix3Xi triangles;    ///< 3 x n_triangles
  Eigen::Matrix3Xd normals;      ///< 3 x n_triangles, unit, out of the solid
  Eigen::VectorXd areas_m2;      ///< n_triangles
  Eigen::Matrix3Xd centroids_m;  ///< 3 x n_triangles
  Eigen::VectorXd radii_m;       ///< n_triangles: centroid to the farthest corner
  double largest_edge_m = 0.0;   ///< the element size that decides about resolution, see element_size_m
  double radius_m = 0.0;         ///< of the ball around the middle of the bounding box
  SurfaceMirrors mirrors;

  int n_vertices() const { return static_cast<int>(vertices_m.cols()); }
  int n_triangles() const { return static_cast<int>(triangles.cols()); }
  Eigen::Vector3d corner(int triangle, int c) const { return vertices_m.col(triangles(c, triangle)); }
};

/// Size of a triangle against a wavelength: the edge of the equilateral triangle of its area, but at least half its
/// longest edge (slivers).
double element_size_m(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Geometry of corner triangles that are known to close (mid-nodes are left out, unused vertices dropped).
/// @param vertex_of  when given: the index in the given surface of each vertex that was kept
RadiatingSurface radiating_surface(const mesh::SurfaceMesh& surface, std::vector<int>* vertex_of = nullptr);

/// A surface with its mirrors: boundary elements then take a fraction 1 / n_images of the time or less.
RadiatingSurface radiating_surface(const mesh::MirroredSurface& mirrored);

/// The surface with other places of its vertices (3 x n_vertices); where it has mirrors, with the means of what the images say.
RadiatingSurface moved(const RadiatingSurface& surface, const Eigen::Matrix3Xd& vertices_m);

/// As radiating_surface, after mesh::check_closed_surface.
/// @param name  the file, for the message
/// @throws InputError for an open surface, normals pointing in, triangles that cut each other or have no area
RadiatingSurface checked_radiating_surface(const mesh::SurfaceMesh& surface, const std::string& name);

/// Triangles that bound the fluid outside: false for hollows closed off inside the solid and for what floats in them.
/// Parts come from mesh::check_closed_surface.
std::vector<bool> faces_outer_fluid(const mesh::SurfaceMesh& surface);

/// The part of a surface that faces the fluid outside.
struct OuterSurface {
  mesh::SurfaceMesh mesh;               ///< vertices of the whole
  std::vector<Eigen::Index> triangles;  ///< its rows in the whole
};
OuterSurface outer_surface(const mesh::SurfaceMesh& surface);

/// Values of the triangles or of the vertices of the whole surface at the corners of the outer triangles, 3 per triangle.
/// values: as many as the whole has triangles (taken where both are as many), or as it has vertices
Eigen::VectorXcd corner_values(const mesh::SurfaceMesh& surface, const OuterSurface& outer,
                               const Eigen::VectorXcd& values);

/// A geodesic sphere around the origin: each face of an icosahedron cut into n^2 triangles and pushed out, 20 n^2
/// triangles in all. The vertices lie on a sphere slightly larger than radius_m, so that the polyhedron encloses
/// exactly the volume of the ball.
mesh::SurfaceMesh geodesic_sphere(double radius_m, int n);

}  // namespace klang::acoustics
