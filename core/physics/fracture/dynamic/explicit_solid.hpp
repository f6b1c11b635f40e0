#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"
#include "core/physics/fracture/dynamic/element_contact.hpp"
#include "core/physics/fracture/dynamic/hold_path.hpp"
#include "core/physics/fracture/dynamic/step_limit.hpp"

namespace klang::fracture {

struct SolidOptions {
  solid::Material material;
  double viscosity_lambda_pa_s = 0.0, viscosity_mu_pa_s = 0.0;  ///< phi, psi of B99
  Plasticity plasticity;
  Integrator integrator = Integrator::kLeapfrog;
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  double safety = 0.7;  ///< share of the step limit that is used
  /// Elements that cuts have made have no larger damping ratio than this and than the largest of the uncut mesh; 0: no such limit, as B99. The
  /// ratio grows as 1/h, so that slivers would else set a step of order h^2.
  double damping_cap = 1.0;
  bool self_contact = false;   ///< of the solid with itself and of its pieces with one another
  double self_friction = 0.0;  ///< Coulomb's, there
};

/// Of the largest rate of contacts of elements times the step, squared; leapfrog stands 4 of all forces together, elements take 2 at most.
/// What does not close in the ledger grows with it, how deep things go in falls.
inline constexpr double kElementContactRate = 0.25;

/// What presses on a node.
struct NodePush {
  int node = 0;
  Eigen::Vector3d normal_n = Eigen::Vector3d::Zero(), friction_n = Eigen::Vector3d::Zero();
};

/// Where the solid's energy is and where it went since the start [J]: kinetic + potential + elastic + viscous + plastic + contact +
/// friction + lost - work = const but for what the steps' size costs in large strains and in contact, of order dt^2 (the work of
/// conservative forces is taken from their potentials, that of all others from the mean force times the way over each step).
/// The kinetic energy of the leapfrog is m v- . v+ / 2, of the velocities half a step before and after: with it a linear solid's energy is
/// constant to round-off at any step. Where a cut or another step changes v+ alone the difference, of order dt^2, is booked as lost.
struct SolidEnergies {
  double kinetic_j = 0.0, potential_j = 0.0, elastic_j = 0.0;
  double viscous_j = 0.0, plastic_j = 0.0;
  double
      contact_j = 0.0,
      friction_j =
          0.0;  ///< given to what presses on it, by normal forces and by friction; what contact with itself stores and rubs off
  double lost_j =
      0.0;  ///< by lumped masses of cut elements (CrackMesh::lost_j()), by changes of the step, by contacts whose elements were cut
  double work_j = 0.0;  ///< by what holds it
  double sum_j() const {
    return kinetic_j + potential_j + elastic_j + viscous_j + plastic_j + contact_j + friction_j + lost_j - work_j;
  }
};

/// A solid of linear tetrahedra that is stepped explicitly (B99 section 3): St Venant-Kirchhoff, viscous stress, additive plasticity,
/// nodes that are held.
class ExplicitSolid {
 public:
  /// Pushes at a time, from places and velocities.
  using Pushes = std::function<void(const CrackMesh& mesh, double time_s, std::vector<NodePush>& pushes)>;

  /// @param holds  paths that mesh.held refers to
  /// @throws InputError: a material or viscosity without positive energy, an integrator that grows at any step without damping
  ExplicitSolid(CrackMesh mesh, const SolidOptions& options, std::vector<HoldPath> holds = {}, Pushes pushes = {});

  ~ExplicitSolid();
  ExplicitSolid(ExplicitSolid&& other) noexcept;
  ExplicitSolid& operator=(ExplicitSolid&& other) noexcept;

  /// One step of dt, at most step_limit_s(). @throws NumericalError where an element inverts, with its number and the time
  void step(double dt_s);
  /// A step in two halves, for solids that press on one another: all go to their new places, then all arrive there with the forces of then.
  void go(double dt_s);
  void arrive();
  /// Forces that solids have on one another, asked for whenever this one's are computed; as long as its nodes are. Their friction is in
  /// energies(), what they store is not.
  using MutualForces = std::function<const NodeForces&()>;
  void set_mutual_forces(MutualForces forces) { mutual_ = std::move(forces); }
  /// Largest step now: of all elements, less where they are stretched.
  double step_limit_s() const;
  double time_s() const { return time_s_; }

  CrackMesh& mesh() { return mesh_; }
  const CrackMesh& mesh() const { return mesh_; }
  /// After places, velocities or elements were changed from outside.
  void refresh();
  SolidEnergies energies() const;
  double largest_plastic_strain() const;  ///< norm, Green's measure
  const SolidOptions& options() const { return options_; }
  const std::vector<NodePush>& pushes() const { return pushes_now_; }
  /// What its elements do to one another now; none without self-contact.
  const ElementContact* self_contact() const { return contact_ ? &*contact_ : nullptr; }
  /// Squared Frobenius norm of the elastic second Piola-Kirchhoff stress of each element.
  const std::vector<double>& stress_sq() const { return stress_sq_; }
  double mean_step_mass_kg() const { return mean_mass_kg_; }

 private:
  void compute_element_forces();
  void compute_forces();
  void add_contact(const NodeForces& forces);
  void move_held(double dt_s, bool places);
  void book(double dt_s);
  void update_limits();

  CrackMesh mesh_;
  SolidOptions options_;
  std::vector<HoldPath> holds_;
  Pushes make_pushes_;
  double time_s_ = 0.0, stretch_ = 1.0, rest_limit_s_ = 0.0, largest_ratio_ = HUGE_VAL, mean_mass_kg_ = 0.0;
  double last_dt_s_ = 0.0, acceleration_term_ = 0.0, stepping_lost_j_ = 0.0;  ///< term: sum m a^2/8 of free nodes
  int changes_seen_ = -1;
  std::size_t elements_seen_ = 0;
  std::vector<double> limit_of_;  ///< of elements
  struct ElementForces;
  std::unique_ptr<ElementForces> elements_;  ///< of this moment
  std::vector<std::size_t> held_;            ///< nodes
  std::vector<double> elastic_, viscous_, viscous_before_, stress_sq_, node_terms_;
  std::vector<NodePush> pushes_now_, pushes_before_, rub_now_, rub_before_;  ///< rub: friction with itself
  std::optional<ElementContact> contact_;
  MutualForces mutual_;
  std::vector<Eigen::Vector3d> acceleration_, velocity_before_, hold_origin_m_, place_before_, total_before_;
  SolidEnergies energies_;
};

}  // namespace klang::fracture
