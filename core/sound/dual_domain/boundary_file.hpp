#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/sound/dual_domain/dual_domain.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::bubble {

/// Boundary of a liquid from a file, in its unit times unit_m.
///   .vtp, .vtu  triangles, quads and polygons (cut into fans); the cell array "region" (0 free surface, 1 rigid wall, 2 solid in
///               the liquid, 3 its dry part) is needed
///   .obj        the region is the number at the end of the name of the group, object or material that a face is under
///               ("g region_1"); none: 0
/// Cell or point normals in the file ("Normals") must agree with the order of the corners.
/// @throws InputError naming file, face or array
BoundaryMesh read_boundary(const std::filesystem::path& path, double unit_m = 1.0);
/// The same; .vtp and .vtu without the array give no regions at all.
BoundaryMesh read_boundary_without_regions(const std::filesystem::path& path, double unit_m = 1.0);

/// A time series of boundaries.
struct BoundaryFrames {
  std::vector<double> time_s;  ///< rising
  std::vector<std::filesystem::path> files;
};

/// "drop_####.vtp": every number from the lowest to the highest that is there, frame_step_s apart, the lowest at 0;
/// "drop.pvd": a ParaView collection with its own times.
/// @throws InputError: no frames; a missing one, by name; times that do not rise
BoundaryFrames find_frames(const std::string& pattern, double frame_step_s);

/// Whether a name stands for a series.
bool is_series(const std::string& name);

/// The boundary with the solution on it (.vtp). Point and cell arrays "surface_normal_derivative" (real, imaginary part of dP/dn in the
/// liquid [Pa/m per m of bubble vibration]) and "surface_normal_velocity_m_s" (modulus); cell array "region".
void write_boundary_solution(const std::filesystem::path& path, const BoundaryMesh& mesh,
                             const LiquidBoundary& boundary, const DualDomainResult& result,
                             double liquid_density_kg_m3);

}  // namespace klang::bubble
