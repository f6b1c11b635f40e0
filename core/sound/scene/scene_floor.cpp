#include "core/sound/scene/scene_floor.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/scene/scene_sound.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/stage/one_pitch.hpp"
#include "core/sound/waves/medium.hpp"

namespace klang::scene {
namespace {

using Eigen::Vector3d;
constexpr double kStruckX = 0.37, kStruckY = 0.43;  // of the sides
constexpr double kSamePlaceM = 0.3;
constexpr double kFloorReachM = 0.01;  ///< a contact this near to z = 0 is the floor's
constexpr std::size_t kMostPlaces = 12;

double sine_at(const SlabMode& mode, double x_over_a, double y_over_b) {
  return mode.amplitude * std::sin(mode.m * kPi * x_over_a) * std::sin(mode.n * kPi * y_over_b);
}

/// Contacts with the floor by place: bodies of the log are places, impulses are along z.
struct FloorContacts {
  events::EventLog log;
  stage::ImpactPulses pulses;
  std::vector<Vector3d> places_m;

  int place_of(const Vector3d& at) {
    std::size_t nearest = 0;
    double distance = HUGE_VAL;
    for (std::size_t i = 0; i < places_m.size(); ++i)
      if (const double d = (places_m[i] - at).norm(); d < distance) {
        distance = d;
        nearest = i;
      }
    if (distance <= kSamePlaceM || places_m.size() >= kMostPlaces) return static_cast<int>(nearest);
    log.bodies.push_back({"floor " + std::to_string(places_m.size() + 1), -1});
    places_m.push_back(at);
    return static_cast<int>(places_m.size()) - 1;
  }
};

FloorContacts floor_contacts(const events::EventLog& log, const stage::ImpactPulses& pulses) {
  FloorContacts contacts;
  std::map<int, events::Motion> motions;
  for (std::size_t i = 0; i < log.impulses.size(); ++i) {
    const events::Impulse& impulse = log.impulses[i];
    if (impulse.other >= 0 || impulse.kind == events::ImpulseKind::kFracture) continue;
    const auto [motion, is_new] = motions.try_emplace(impulse.body);
    if (is_new) motion->second = log.motion_of(impulse.body);
    const events::Pose pose = motion->second.at(impulse.time_s);
    Vector3d place = pose.to_world(impulse.point_m);
    if (!(std::abs(place.z()) <= kFloorReachM))
      continue;  // somebody strikes the body: the log has no name for it either
    place.z() = 0.0;
    events::Impulse row = impulse;
    row.body = contacts.place_of(place);
    row.other = impulse.body;  // whose contact it is
    row.point_m.setZero();
    row.impulse_n_s = {0.0, 0.0, -(pose.orientation() * impulse.impulse_n_s).z()};
    if (const auto pulse = pulses.find(i); pulse != pulses.end())
      contacts.pulses[contacts.log.impulses.size()] = {pulse->second.force, 1.0};
    contacts.log.impulses.push_back(row);
  }
  const auto first = static_cast<int>(contacts.log.bodies.size());
  for (const events::Body& body : log.bodies) contacts.log.bodies.push_back({"from " + body.name, -1});
  for (events::Impulse& row : contacts.log.impulses) row.other += first;
  return contacts;
}

}  // namespace

std::vector<SlabMode> slab_modes(const FloorSound& floor, const solid::Material& material) {
  const double a = floor.slab_m.x(), b = floor.slab_m.y(), h = floor.slab_m.z();
  const double e = material.youngs_modulus_pa(), nu = material.poissons_ratio(), rho = material.density_kg_m3;
  const double stiffness = e * h * h * h / (12.0 * (1.0 - nu * nu)), shear = 5.0 / 6.0 * material.lame_mu_pa * h;
  const double rotary = rho * h * h * h / 12.0;
  std::vector<SlabMode> modes;
  const double high = 2.0 * kPi * floor.high_hz, low = 2.0 * kPi * floor.low_hz;
  for (int m = 1;; ++m) {
    bool any = false;
    for (int n = 1;; ++n) {
      const double s = std::pow(m * kPi / a, 2) + std::pow(n * kPi / b, 2);
      // (D s + S - R w^2) (S s - rho h w^2) = S^2 s, the smaller w^2, in the form that does not cancel.
      const double p = rotary * rho * h, q = (stiffness * s + shear) * rho * h + rotary * shear * s,
                   r = stiffness * s * shear * s;
      const double omega = std::sqrt(2.0 * r / (q + std::sqrt(std::max(0.0, q * q - 4.0 * p * r))));
      if (omega > high) break;
      any = true;
      if (omega < low) continue;
      const double turn = 1.0 - rho * h * omega * omega / (shear * s);  // of the cross-section over the slope
      const double mass = 0.25 * a * b * (rho * h + rotary * s * turn * turn);
      modes.push_back({m, n, omega, 1.0 / std::sqrt(mass)});
    }
    if (!any) break;
  }
  std::stable_sort(modes.begin(), modes.end(), [](const SlabMode& x, const SlabMode& y) {
    return x.angular_frequency_rad_s < y.angular_frequency_rad_s;
  });
  if (modes.size() > static_cast<std::size_t>(floor.n_modes)) modes.resize(static_cast<std::size_t>(floor.n_modes));
  return modes;
}

std::complex<double> slab_pressure_pa(const SlabMode& mode, const FloorSound& floor, const Vector3d& place_m) {
  const acoustics::Medium air;
  const double a = floor.slab_m.x(), b = floor.slab_m.y(), k = mode.angular_frequency_rad_s / air.sound_speed_m_s;
  const double height = std::max(std::abs(place_m.z()), 1e-3);
  const auto points = [&](double side, int half_waves) {
    const double finest =
        std::min({2.0 * kPi / k / 8.0, side / (8.0 * half_waves), std::max(height / 4.0, side / 2000.0)});
    return static_cast<Eigen::Index>(std::ceil(side / finest));
  };
  const Eigen::Index nx = points(a, mode.m), ny = points(b, mode.n);
  Eigen::ArrayXd y = (Eigen::ArrayXd::LinSpaced(ny, 0.5, static_cast<double>(ny) - 0.5)) / static_cast<double>(ny);
  const Eigen::ArrayXd shape_y = (mode.n * kPi * y).sin(), away_y = (b * y - place_m.y()).square() + height * height;
  std::complex<double> sum = 0.0;
  for (Eigen::Index i = 0; i < nx; ++i) {
    const double x = (static_cast<double>(i) + 0.5) / static_cast<double>(nx);
    const Eigen::ArrayXd r = (away_y + std::pow(a * x - place_m.x(), 2)).sqrt();
    const Eigen::ArrayXd weight = shape_y / r;
    const double shape_x = std::sin(mode.m * kPi * x);
    sum += shape_x * std::complex<double>((weight * (k * r).cos()).sum(), -(weight * (k * r).sin()).sum());
  }
  // What a cell's middle stands for: the mean of the sines over it.
  const auto mean = [](int half_waves, Eigen::Index n) {
    const double angle = half_waves * kPi / (2.0 * static_cast<double>(n));
    return std::sin(angle) / angle;
  };
  sum *= mode.amplitude * a * b / static_cast<double>(nx * ny) * mean(mode.m, nx) * mean(mode.n, ny);
  return std::complex<double>(0.0, mode.angular_frequency_rad_s * air.density_kg_m3 / (2.0 * kPi)) * sum;
}

namespace {

/// Modes of one pitch are heard with their signs against each other (RadiatingVoice).
void give_signs(const std::vector<std::size_t>& group, const Eigen::MatrixXcd& pressure, Eigen::MatrixXd& gain) {
  for (Eigen::Index ear = 0; ear < pressure.cols(); ++ear) {
    std::vector<std::complex<double>> heard;
    for (const std::size_t k : group) heard.push_back(pressure(static_cast<Eigen::Index>(k), ear));
    const std::complex<double> unturned = std::conj(stage::common_phase(heard));
    for (std::size_t j = 0; j < group.size(); ++j)
      if ((heard[j] * unturned).real() < 0.0) gain(static_cast<Eigen::Index>(group[j]), ear) *= -1.0;
  }
}

}  // namespace

double floor_ring_time_s(const Scene& scene) {
  if (!scene.floor_sound) return 0.0;
  const SceneMaterial& material = scene.materials[static_cast<std::size_t>(*scene.floor_material)];
  const std::vector<SlabMode> modes = slab_modes(*scene.floor_sound, material.elastic);
  if (modes.empty()) return 0.0;
  Eigen::VectorXd omega(static_cast<Eigen::Index>(modes.size()));
  for (std::size_t k = 0; k < modes.size(); ++k) omega[static_cast<Eigen::Index>(k)] = modes[k].angular_frequency_rad_s;
  const damping::LawValue damping = material.damping_heard();
  const double slowest = damping.law->decay_per_s(omega, damping.parameters.data()).minCoeff();
  return slowest > 0.0 ? std::log(1000.0) / slowest : HUGE_VAL;
}

FloorHeard floor_sound_of(const Scene& scene, const events::EventLog& log, const stage::ImpactPulses& pulses,
                          double duration_s, Monitor& monitor) {
  const FloorSound& floor = *scene.floor_sound;
  const SceneMaterial& material = scene.materials[static_cast<std::size_t>(*scene.floor_material)];
  const std::vector<SlabMode> modes = slab_modes(floor, material.elastic);
  FloorContacts contacts = floor_contacts(log, pulses);
  const stage::Listener listener = listener_of(scene.sound.listener);
  const auto n_modes = static_cast<Eigen::Index>(modes.size());
  FloorHeard heard;
  heard.n_modes = static_cast<int>(n_modes);
  heard.n_places = static_cast<int>(contacts.places_m.size());
  stage::RingingBody slab;
  slab.angular_frequency_rad_s.resize(n_modes);
  Eigen::VectorXd at_blow(n_modes);
  for (Eigen::Index k = 0; k < n_modes; ++k) {
    const SlabMode& mode = modes[static_cast<std::size_t>(k)];
    slab.angular_frequency_rad_s[k] = mode.angular_frequency_rad_s;
    at_blow[k] = sine_at(mode, kStruckX, kStruckY);
  }
  const damping::LawValue damping = material.damping_heard();
  slab.decay_per_s = damping.law->decay_per_s(slab.angular_frequency_rad_s, damping.parameters.data());
  slab.push = [at_blow](const Vector3d&, const Vector3d& impulse) -> Eigen::VectorXd { return at_blow * impulse.z(); };
  const std::vector<std::vector<std::size_t>> pairs =
      stage::modes_of_one_pitch(slab.angular_frequency_rad_s, slab.decay_per_s);
  std::vector<std::unique_ptr<stage::ModalVoice>> voices;
  std::vector<stage::Voice*> list;
  for (std::size_t place = 0; place < contacts.places_m.size() && n_modes > 0; ++place) {
    monitor.throw_if_stopped();
    stage::RingingBody here = slab;
    here.gain.resize(n_modes, listener.n_channels());
    const Vector3d corner(kStruckX * floor.slab_m.x(), kStruckY * floor.slab_m.y(), 0.0);
    Eigen::MatrixXcd pressure(n_modes, listener.n_channels());
    for_each_job(static_cast<std::size_t>(n_modes), [&](std::size_t k) {
      for (int ear = 0; ear < listener.n_channels(); ++ear)
        pressure(static_cast<Eigen::Index>(k), ear) =
            slab_pressure_pa(modes[k], floor, listener.ear_m(ear, 0.0) - contacts.places_m[place] + corner);
    });
    here.gain = slab.angular_frequency_rad_s.asDiagonal() * pressure.cwiseAbs();
    for (const std::vector<std::size_t>& pair : pairs) give_signs(pair, pressure, here.gain);
    voices.push_back(std::make_unique<stage::ModalVoice>(static_cast<int>(place), std::move(here), &contacts.pulses));
    list.push_back(voices.back().get());
  }
  heard.sound_pa = stage::render(contacts.log, list, listener, {scene.sound.sample_rate_hz, duration_s}, monitor);
  return heard;
}

}  // namespace klang::scene
