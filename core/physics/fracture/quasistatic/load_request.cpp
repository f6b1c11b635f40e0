#include "core/physics/fracture/quasistatic/load_request.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

constexpr double kSameMoment = 1e-9;  // of the contact time
constexpr double kSmall = 1e-4;       // of the largest compression energy: the root of it is 1 % of the stress

double peak_s(const ContactLoad& load) { return load.time_s + 0.5 * load.duration_s; }
double end_s(const ContactLoad& load) { return load.time_s + load.duration_s; }

/// Of the largest compression: Hertz' energy goes with the force to the 5/3.
double compressed_share(const ContactLoad& load, double time_s) {
  const double sine = std::sin(kPi * (time_s - load.time_s) / load.duration_s);
  return std::pow(std::max(0.0, sine), 2.5);
}

LoadRequest request_at(double time_s, const std::vector<ContactLoad>& sorted, std::size_t first) {
  LoadRequest request;
  request.time_s = time_s;
  for (std::size_t i = first; i < sorted.size() && sorted[i].time_s <= time_s; ++i) {
    const Eigen::Vector3d force = force_n(sorted[i], time_s);
    if (force.isZero(0.0)) continue;
    (sorted[i].lasting ? request.lasting : request.impacts).push_back({sorted[i].place_m, force});
    if (!sorted[i].lasting) request.budget_j += compressed_share(sorted[i], time_s) * sorted[i].compression_energy_j;
  }
  return request;
}

}  // namespace

double hertz_peak_over_mean() {
  static const double constant = 0.5 * std::beta(0.4, 0.5);
  return constant;
}

ContactLoad contact_load(const events::Impulse& impulse, const Eigen::Vector3d& normal, double approach_m_s,
                         double restitution) {
  if (!(impulse.duration_s > 0.0) || !std::isfinite(impulse.duration_s) || !std::isfinite(impulse.time_s))
    throw InputError("contact", "needs a time and a duration", to_text(impulse.duration_s), "above 0 s");
  if (!impulse.point_m.allFinite() || !impulse.impulse_n_s.allFinite() || !normal.allFinite())
    throw InputError("contact", "is not finite");
  checked("contact", "approach_m_s", approach_m_s, 0.0, 1e6);
  checked("contact", "restitution", restitution, 0.0, 1.0);
  ContactLoad load;
  load.time_s = impulse.time_s;
  load.duration_s = impulse.duration_s;
  load.lasting = impulse.kind == events::ImpulseKind::kLasting;
  load.place_m = impulse.point_m;
  load.impulse_n_s = impulse.impulse_n_s;
  if (!load.lasting)
    load.compression_energy_j =
        std::max(0.0, impulse.impulse_n_s.dot(normal)) / (1.0 + restitution) * approach_m_s / 2.0;
  return load;
}

Eigen::Vector3d force_n(const ContactLoad& load, double time_s) {
  if (!(time_s >= load.time_s && time_s < end_s(load))) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d mean = load.impulse_n_s / load.duration_s;
  if (load.lasting) return mean;
  const double sine = std::sin(kPi * (time_s - load.time_s) / load.duration_s);
  return hertz_peak_over_mean() * std::pow(std::max(0.0, sine), 1.5) * mean;
}

std::vector<LoadRequest> load_requests(const std::vector<ContactLoad>& loads) {
  std::vector<ContactLoad> sorted = loads;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ContactLoad& a, const ContactLoad& b) { return a.time_s < b.time_s; });
  double longest_s = 0.0, largest_j = 0.0;
  for (const ContactLoad& load : sorted) largest_j = std::max(largest_j, load.compression_energy_j);
  std::vector<std::pair<double, double>> moments;  // peak of an impact, its contact time
  for (const ContactLoad& load : sorted) {
    longest_s = std::max(longest_s, load.duration_s);
    if (!load.lasting && load.compression_energy_j >= kSmall * largest_j)
      moments.emplace_back(peak_s(load), load.duration_s);
  }
  std::sort(moments.begin(), moments.end());
  std::vector<double> times;
  for (const auto& [time, duration] : moments)
    if (times.empty() || time - times.back() > kSameMoment * duration) times.push_back(time);
  const std::vector<double> peaks = times;
  for (const ContactLoad& load : sorted) {
    if (!load.lasting) continue;
    const auto next = std::lower_bound(peaks.begin(), peaks.end(), load.time_s);
    if (next == peaks.end() || *next >= end_s(load)) times.push_back(load.time_s);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());

  std::vector<LoadRequest> requests;
  std::size_t first = 0;
  for (const double time : times) {
    while (first < sorted.size() && sorted[first].time_s + longest_s < time) ++first;
    requests.push_back(request_at(time, sorted, first));
  }
  return requests;
}

double impact_scale(double impact_j, double cross_j, double budget_j) {
  if (impact_j + cross_j <= budget_j) return 1.0;
  if (!(impact_j > 0.0)) return 0.0;
  // The larger root of s^2 a + s b = L, in the form that does not cancel.
  const double root = std::sqrt(cross_j * cross_j + 4.0 * impact_j * budget_j);
  const double scale = cross_j > 0.0 ? 2.0 * budget_j / (cross_j + root) : (root - cross_j) / (2.0 * impact_j);
  return std::clamp(scale, 0.0, 1.0);
}

AllowedLoad allowed_load(ContactResponses& responses, const SurfacePlaces& surface, const LoadRequest& request) {
  const std::vector<NodeForce> impacts = surface.at_nodes(request.impacts), lasting = surface.at_nodes(request.lasting);
  AllowedLoad allowed;
  allowed.forces = lasting;
  allowed.forces.insert(allowed.forces.end(), impacts.begin(), impacts.end());
  allowed.unlimited_energy_j = responses.strain_energy_j(allowed.forces);
  const double impact_j = responses.strain_energy_j(impacts), lasting_j = responses.strain_energy_j(lasting);
  const double cross_j = lasting.empty() ? 0.0 : allowed.unlimited_energy_j - impact_j - lasting_j;
  allowed.scale = impact_scale(impact_j, cross_j, request.budget_j);
  for (std::size_t i = lasting.size(); i < allowed.forces.size(); ++i) allowed.forces[i].force_n *= allowed.scale;
  allowed.strain_energy_j = allowed.scale * (allowed.scale * impact_j + cross_j) + lasting_j;
  return allowed;
}

}  // namespace klang::fracture
