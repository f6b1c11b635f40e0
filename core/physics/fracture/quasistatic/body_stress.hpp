#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/fracture/quasistatic/stress_field.hpp"
#include "core/physics/fracture/quasistatic/surface_places.hpp"

/// What forces do to a free body: everything that `klang stress` tells.
namespace klang::fracture {

constexpr auto words_of(Relief) {
  return std::array{Word{Relief::kConsistentMass, "consistent"}, Word{Relief::kLumpedMass, "lumped"},
                    Word{Relief::kEuclidean, "euclidean"}};
}

struct BodyStress {
  enum class Status { kNotRun, kSolved, kFailed };
  Status status = Status::kNotRun;
  std::string message;

  Eigen::VectorXd displacement_m;  ///< 3 n_nodes, without rigid part
  Eigen::VectorXd nodal_force_n;
  StressField field;
  std::vector<SurfacePlace> places;  ///< of the forces, in their order
  RigidAcceleration acceleration;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double relative_residual = 0.0;
  double max_displacement_m = 0.0;

  StressExtreme tension, compression, von_mises;
  /// The tension's element holds a node that is pushed, or a force's own stress in a half-space, |F| / (2 pi r^2), is more than half
  /// of it: it is the mesh's rather than the body's.
  bool tension_is_at_a_load = false;
  std::optional<StressExtreme> tension_elsewhere;  ///< the largest for which that is not so
  double energy_share_at_loads = 0.0;              ///< of elements that hold a node that is pushed
  double energy_share_missing = 0.0;               ///< mesh_energy_error.hpp
  std::vector<std::string> warnings;

  bool usable() const { return status == Status::kSolved; }
};

/// Solves and judges. @throws InputError as SurfacePlaces and FreeBodySolver, and where no force is given or all are zero
BodyStress body_stress(FreeBodySolver& solver, const solid::Material& material, const std::vector<PointForce>& forces);

}  // namespace klang::fracture
