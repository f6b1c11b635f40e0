#include "core/physics/fracture/quasistatic/stress_document.hpp"

namespace klang::fracture {
namespace {

Triple triple(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

ExtremeRecord record(const StressExtreme& extreme) {
  ExtremeRecord result{extreme.stress_pa, triple(extreme.place_m), {}};
  if (!extreme.direction.isZero(0.0)) result.direction = triple(extreme.direction);
  return result;
}

}  // namespace

StressDocument stress_document(const FreeBodySolver& solver, Relief relief, const std::vector<PointForce>& forces,
                               const BodyStress& stress, const std::optional<double>& tensile_strength_pa) {
  StressDocument document;
  const mesh::TetMesh& mesh = solver.mesh();
  document.n_nodes = mesh.n_nodes();
  document.n_elements = mesh.n_elements();
  document.element = mesh.order() == 2 ? "p2" : "p1";
  document.relief = relief;
  document.strain_energy_j = stress.field.strain_energy_j;
  document.max_principal_stress_pa = stress.tension.stress_pa;
  document.place_m = triple(stress.tension.place_m);
  document.direction = triple(stress.tension.direction);
  document.max_is_at_a_load = stress.tension_is_at_a_load;
  if (stress.tension_elsewhere) document.away_from_loads = record(*stress.tension_elsewhere);
  document.min_principal_stress = record(stress.compression);
  document.max_von_mises_stress = record(stress.von_mises);
  document.tensile_strength_pa = tensile_strength_pa;
  if (tensile_strength_pa) {
    document.would_break = breaks(stress.tension, *tensile_strength_pa);
    document.would_break_away_from_loads =
        stress.tension_elsewhere && breaks(*stress.tension_elsewhere, *tensile_strength_pa);
    if (document.would_break != document.would_break_away_from_loads)
      document.header.warnings.push_back(
          "it would break by the stress at a point force alone, which is the mesh's as much as the body's: not "
          "decided");
  }
  document.mass_kg = stress.mass_kg;
  document.centre_m = triple(stress.centre_m);
  document.net_force_n = triple(stress.acceleration.net_force_n);
  document.net_moment_n_m = triple(stress.acceleration.net_moment_n_m);
  if (relief != Relief::kEuclidean) {
    document.acceleration_m_s2 = triple(stress.acceleration.acceleration_m_s2);
    document.angular_acceleration_rad_s2 = triple(stress.acceleration.spin_rad_s2);
  }
  document.max_displacement_m = stress.max_displacement_m;
  document.relative_residual = stress.relative_residual;
  document.energy_share_at_loads = stress.energy_share_at_loads;
  document.energy_share_missing = stress.energy_share_missing;
  for (std::size_t i = 0; i < forces.size(); ++i)
    document.forces.push_back(
        {triple(stress.places[i].place_m), triple(forces[i].force_n), stress.places[i].distance_m});
  return document;
}

}  // namespace klang::fracture
