#pragma once
#include <Eigen/Core>
#include <optional>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"

namespace klang::modal {

/// Semi-axes along x, y, z of a solid ellipsoid or ball; empty for another shape.
std::optional<Eigen::Vector3d> ellipsoid_axes_m(const mesh::ShapeSpec& shape);

/// What solve_modes gives, for a free ellipsoid, by EllipsoidModes: the shapes are sampled to the nodes of the mesh. The degree rises
/// by twos until twice what the last rise took off every frequency asked for is below 1e-5 of it (errors fall geometrically, by more than half with each
/// rise), or 24. That is the mode's mesh_relative_error. Of the options count, band, most, prove_none_missing and estimate_mesh_error are used;
/// none is missing of the polynomials' own modes, which a dense eigensolver finds all.
/// kNotConverged where a mode asked for is not known within 2 % by the highest degree (hundreds of modes).
/// @throws InputError for another shape
EigenResult solve_ellipsoid_modes(const mesh::ShapeSpec& shape, const mesh::TetMesh& mesh,
                                  const solid::Material& material, const EigenOptions& options = {},
                                  Monitor& monitor = silent_monitor());

}  // namespace klang::modal
