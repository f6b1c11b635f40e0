#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "core/geometry/mesh/surface_repair.hpp"
#include "core/physics/fracture/quasistatic/body_stress.hpp"

/// The result of `klang stress`.
namespace klang::fracture {

using Triple = std::array<double, 3>;

struct ForceRecord {
  Triple place_m{}, force_n{};
  double distance_m = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"place_m", "point of the meshed surface where it acts"}, self.place_m);
    visit({"force_n", "on the body"}, self.force_n);
    visit({"distance_m", "of the place that was asked for from it"}, self.distance_m);
  }
};

struct ExtremeRecord {
  double stress_pa = 0.0;
  Triple place_m{};
  std::optional<Triple> direction;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"stress_pa", "tension positive"}, self.stress_pa);
    visit({"place_m", "the element's centre"}, self.place_m);
    visit(absent_if_empty({"direction", "unit, of that principal stress"}), self.direction);
  }
};

struct StressDocument {
  ResultHeader header;
  std::optional<int> n_nodes, n_elements;
  std::string element;
  Relief relief = Relief::kConsistentMass;
  double strain_energy_j = 0.0, max_principal_stress_pa = 0.0;
  Triple place_m{}, direction{};
  bool max_is_at_a_load = false;
  std::optional<ExtremeRecord> away_from_loads;
  std::optional<ExtremeRecord> min_principal_stress, max_von_mises_stress;
  std::optional<double> tensile_strength_pa;
  std::optional<bool> would_break, would_break_away_from_loads;
  double mass_kg = 0.0;
  Triple centre_m{}, net_force_n{}, net_moment_n_m{};
  std::optional<Triple> acceleration_m_s2, angular_acceleration_rad_s2;
  double max_displacement_m = 0.0, relative_residual = 0.0;
  double energy_share_at_loads = 0.0, energy_share_missing = 0.0;
  std::vector<ForceRecord> forces;
  std::optional<mesh::SurfaceRepairs> repairs;
  std::optional<mesh::SurfaceDecimation> decimation;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_nodes", "of the mesh"}, self.n_nodes);
    visit({"n_elements", "of the mesh"}, self.n_elements);
    visit({"element", "p1 or p2"}, self.element);
    visit({"relief", "mass by which the load is balanced"}, self.relief);
    visit({"strain_energy_j", "u . K u / 2"}, self.strain_energy_j);
    visit({"max_principal_stress_pa", "largest of all elements; of quadratic ones at their corners"},
          self.max_principal_stress_pa);
    visit({"place_m", "centre of that element"}, self.place_m);
    visit({"direction", "unit, of that stress: a crack opens across it"}, self.direction);
    visit({"max_is_at_a_load", "its element holds a pushed node, or |F|/(2 pi r^2) there is more than half of it"},
          self.max_is_at_a_load);
    visit(absent_if_empty({"away_from_loads", "largest principal stress where that is not so"}), self.away_from_loads);
    visit({"min_principal_stress", "compressive extreme"}, self.min_principal_stress);
    visit({"max_von_mises_stress", "of all elements"}, self.max_von_mises_stress);
    visit(absent_if_empty({"tensile_strength_pa", "as it was given"}), self.tensile_strength_pa);
    visit(absent_if_empty({"would_break", "max_principal_stress_pa >= tensile_strength_pa (Rankine)"}),
          self.would_break);
    visit(absent_if_empty({"would_break_away_from_loads", "the same of away_from_loads"}),
          self.would_break_away_from_loads);
    visit({"mass_kg", "of the body"}, self.mass_kg);
    visit({"centre_m", "of mass"}, self.centre_m);
    visit({"net_force_n", "sum of the forces"}, self.net_force_n);
    visit({"net_moment_n_m", "about centre_m"}, self.net_moment_n_m);
    visit({"acceleration_m_s2", "of the centre; null without inertia relief"}, self.acceleration_m_s2);
    visit({"angular_acceleration_rad_s2", "from rest; null without inertia relief"}, self.angular_acceleration_rad_s2);
    visit({"max_displacement_m", "without the rigid motion"}, self.max_displacement_m);
    visit({"relative_residual", "||K u - f'|| / ||f'||, f' the balanced load"}, self.relative_residual);
    visit({"energy_share_at_loads", "strain energy of elements that hold a pushed node, over all of it"},
          self.energy_share_at_loads);
    visit({"energy_share_missing", "estimate: (E - strain_energy_j) / E for an infinitely fine mesh"},
          self.energy_share_missing);
    visit({"forces", "as they act"}, self.forces);
    visit(absent_if_empty({"repairs", "of a surface file: what was mended"}), self.repairs);
    visit(absent_if_empty({"decimation", "of a surface file that was made coarser"}), self.decimation);
  }
};

/// All but the header, repairs and decimation. @throws InputError for a strength that is not positive
StressDocument stress_document(const FreeBodySolver& solver, Relief relief, const std::vector<PointForce>& forces,
                               const BodyStress& stress, const std::optional<double>& tensile_strength_pa);

}  // namespace klang::fracture
