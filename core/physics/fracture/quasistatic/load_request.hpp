#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/physics/events/impulse.hpp"
#include "core/physics/fracture/quasistatic/contact_responses.hpp"
#include "core/physics/fracture/quasistatic/surface_places.hpp"

/// How impulses of a rigid-body step become forces that strain a body, and how much energy they may put into it. SB does not
/// say (docs/errata.md): force = impulse / step makes the strain energy grow as 1 / step^2, above the kinetic energy that there was.
namespace klang::fracture {

/// Peak over mean force of Hertz' pulse: B(2/5, 1/2) / 2 = 1.839547 (tests/reference/contact.json: hertz.peak_over_mean_force).
double hertz_peak_over_mean();

/// A contact of a body as its stress sees it; places and vectors in the body's frame.
struct ContactLoad {
  double time_s = 0.0;      ///< first touch; a lasting contact: the step's begin
  double duration_s = 0.0;  ///< Hertz' contact time; a lasting contact: the step
  bool lasting = false;
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();
  double compression_energy_j =
      0.0;  ///< J_c v / 2: normal energy that is gone at largest compression; a lasting one: 0
};

/// @param normal        unit, out of the other body, in the body's frame
/// @param approach_m_s  normal speed at touch, >= 0
/// @param restitution   of the pair, 0 to 1: J_c = J . n / (1 + e) is the impulse up to largest compression
/// @throws InputError for a duration that is not positive, numbers that are not finite or out of range
ContactLoad contact_load(const events::Impulse& impulse, const Eigen::Vector3d& normal, double approach_m_s,
                         double restitution);

/// Impact: 1.839547 J / T sin(pi (t - t0) / T)^1.5 (Hertz' pulse within 2.4 % of its area, its peak exact). Lasting: J / T from t0 up
/// to t0 + T. 0 at other times.
Eigen::Vector3d force_n(const ContactLoad& load, double time_s);

/// What acts at one moment.
struct LoadRequest {
  double time_s = 0.0;
  std::vector<PointForce> impacts, lasting;
  double budget_j = 0.0;  ///< energy that compresses the impacts in it then
};

/// A request at the peak of each impact, with what every other contact exerts then (impacts that peak together are one request; one
/// with less than 1e-4 of the compression energy of the hardest is only heard at the others' peaks: it can change a stress by a
/// hundredth), and one for each moment at which lasting contacts begin and no impact peaks during them. Ascending in time. The largest
/// load of two pulses that overlap is at one of the two peaks or between them; both are asked for.
std::vector<LoadRequest> load_requests(const std::vector<ContactLoad>& loads);

/// Largest s in 0 to 1 with s^2 impact_j + s cross_j <= budget_j: strain energy E(s) = s^2 impact_j + s cross_j + lasting_j of impacts
/// times s beside lasting forces, of which only what the impacts add must be paid for. Without lasting forces
/// min(1, sqrt(budget_j / impact_j)).
double impact_scale(double impact_j, double cross_j, double budget_j);

/// Forces that the energy allows.
struct AllowedLoad {
  std::vector<NodeForce> forces;
  double scale = 1.0;               ///< of the impacts
  double strain_energy_j = 0.0;     ///< of these forces
  double unlimited_energy_j = 0.0;  ///< of the forces before they were scaled
};

/// @throws InputError for a place off the surface
AllowedLoad allowed_load(ContactResponses& responses, const SurfacePlaces& surface, const LoadRequest& request);

}  // namespace klang::fracture
