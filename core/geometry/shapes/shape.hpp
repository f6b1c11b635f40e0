#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// An analytic body. Kinds and dimensions (all in metres, all > 0):
///   tube        length_m, outer_radius_m, wall_m (< outer_radius_m)         axis z, centred on the origin
///   rod         length_m, radius_m                                         axis z, centred
///   box         length_m (x), width_m (y), height_m (z)                    centred
///   shell_box   edge_m, wall_m (< edge_m / 2): hollow closed cube            centred
///   ellipsoid   a_m, b_m, c_m: semi-axes along x, y, z                      centred
///   sphere      radius_m                                                   centred
///   bowl        outer_radius_m, wall_m, depth_m: spherical cap of even wall, rim up; docs in shape.cpp's
///   table revolution  profile_csv: closed polygon of columns r_m, z_m turned about the z axis
struct ShapeSpec {
  std::string kind;
  std::map<std::string, double> dims;  ///< by name with unit, e.g. {"length_m", 0.505}
  std::filesystem::path profile_csv;   ///< revolution only
};

/// The dimension names of a kind, in the order above; InputError for an unknown kind (lists the known ones).
const std::vector<std::string>& shape_dimensions(std::string_view kind);
const std::vector<std::string>& shape_kinds();

/// Throws InputError naming the first missing, unknown, non-finite or impossible dimension.
void validate(const ShapeSpec& spec);

/// Exact volume and surface area of the analytic body (not of its mesh).
double shape_volume_m3(const ShapeSpec& spec);
double shape_area_m2(const ShapeSpec& spec);

struct ShapeMeshOptions {
  int order = 2;              ///< 1 or 2
  double max_edge_m = 0.0;    ///< > 0: no edge along a sweep longer than this; 0: from the wavelength rule
  double wavelength_m = 0.0;  ///< shortest structural wavelength to resolve; 0: default resolution for the low modes
  double elements_per_wavelength = 4.0;  ///< of quadratic elements (linear ones get twice as many)
  int refinement = 0;                    ///< each level halves every edge: convergence studies
};

/// How often each direction of a sweep is divided. Kept apart from the dimensions so that a body whose
/// dimensions change a little keeps its topology (shape derivatives by differences, nested convergence
/// levels).
struct ShapeDivisions {
  std::array<int, 3> counts{};  ///< meaning by kind: tube (axial, around, through the wall), box (x, y, z), ...
};
ShapeDivisions shape_divisions(const ShapeSpec& spec, const ShapeMeshOptions& options);

/// Meshes the body by a sweep; with order 2 the mid-nodes lie on the true surface. Same topology for the same
/// divisions. Node sets name the natural faces ("x_min", "x_max", ..., "z_min", "z_max", "outer", "inner").
TetMesh mesh_shape(const ShapeSpec& spec, const ShapeDivisions& divisions, int order);
TetMesh mesh_shape(const ShapeSpec& spec, const ShapeMeshOptions& options = {});

}  // namespace klang::mesh
