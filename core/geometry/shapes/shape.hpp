#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// An analytic body as files and commands give it. Kinds, their dimensions (all in metres, all > 0) and where the body
/// lies: docs/shapes.md, made from the registry (shape_registry.hpp).
struct ShapeSpec {
  std::string kind;
  std::map<std::string, double> dims;  ///< by name with unit, e.g. {"length_m", 0.505}
  std::filesystem::path profile_csv;   ///< revolution only
};

/// The dimension names of a kind, in the order of its table; InputError for an unknown kind (lists the known ones).
const std::vector<std::string>& shape_dimensions(std::string_view kind);
const std::vector<std::string>& shape_kinds();

/// Throws InputError naming the first missing, unknown, non-finite or impossible dimension.
void validate(const ShapeSpec& spec);

/// Exact volume and surface area of the analytic body (not of its mesh).
double shape_volume_m3(const ShapeSpec& spec);
double shape_area_m2(const ShapeSpec& spec);

/// Convex pieces that fill the body as others can touch it, for collisions: the hull of each
/// piece's corners [m], one corner per column. Pieces touch and do not overlap. Where the surface is round they leave out, or add in hollows, up to 1 % of the body's largest extent.
/// A body that is convex is one piece. @throws InputError for a bad spec
std::vector<Eigen::Matrix3Xd> convex_parts(const ShapeSpec& spec);

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
  std::array<int, 3> counts{};  ///< by kind: tube (axial, around, through the wall), box (x, y, z), ...
};
ShapeDivisions shape_divisions(const ShapeSpec& spec, const ShapeMeshOptions& options);

/// Divisions that keep the mesh's own error of the frequencies up to highest_hz near 0.1 % (one tenth of what the
/// dimensions of a real body leave open) at some ten thousand nodes. Found by refinement studies of each kind: the
/// sweep's own default resolves the lowest bending only.
/// @param bar_speed_m_s  sqrt(E / rho) of the material [m/s]
ShapeDivisions resonance_divisions(const ShapeSpec& spec, double bar_speed_m_s, double highest_hz);

/// Finer than what resonance_divisions() gives, for a solution to compare with.
ShapeDivisions reference_divisions(const ShapeSpec& spec);

/// Meshes the body by a sweep; with order 2 the mid-nodes lie on the true surface. Same topology for the same
/// divisions. Node sets name the natural faces ("x_min", "x_max", ..., "z_min", "z_max", "outer", "inner").
TetMesh mesh_shape(const ShapeSpec& spec, const ShapeDivisions& divisions, int order);
TetMesh mesh_shape(const ShapeSpec& spec, const ShapeMeshOptions& options = {});

}  // namespace klang::mesh
