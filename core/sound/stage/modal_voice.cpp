#include "core/sound/stage/modal_voice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/stage/held_force.hpp"
#include "core/sound/stage/surface_coupling.hpp"

namespace klang::stage {
namespace {

// The nodes of a body's surface, so that the nearest one is found without making the surface for each place. Nodes at one place, on both
// lips of a slit, are looked for a little inside their own lip: so is what is pushed there.
class SurfaceNodes {
 public:
  explicit SurfaceNodes(const mesh::TetMesh& mesh) {
    const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
    std::vector<Eigen::Vector3d> outward(static_cast<std::size_t>(mesh.n_nodes()), Eigen::Vector3d::Zero());
    std::vector<char> on_surface(outward.size(), 0);
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      const auto corner = [&](int c) -> Eigen::Vector3d {
        return surface.vertices_m.row(surface.triangles(t, c)).transpose();
      };
      const Eigen::Vector3d area = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0));
      for (Eigen::Index c = 0; c < surface.triangles.cols(); ++c) {
        const auto node = static_cast<std::size_t>(surface.triangles(t, c));
        on_surface[node] = 1;
        outward[node] += area;
      }
    }
    std::map<std::array<double, 3>, int> at_place;
    for (int i = 0; i < mesh.n_nodes(); ++i) {
      if (on_surface[static_cast<std::size_t>(i)] == 0) continue;
      nodes_.push_back(i);
      ++at_place[{mesh.nodes_m(i, 0), mesh.nodes_m(i, 1), mesh.nodes_m(i, 2)}];
    }
    places_.nodes_m = mesh.nodes_m(nodes_, Eigen::all);
    constexpr double kInside = 1e-3;  // of the root of the faces' area
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      auto place = places_.nodes_m.row(static_cast<Eigen::Index>(i));
      const Eigen::Vector3d& area = outward[static_cast<std::size_t>(nodes_[i])];
      if (at_place[{place[0], place[1], place[2]}] > 1 && area.norm() > 0.0)
        place -= kInside / std::sqrt(area.norm()) * area.transpose();
    }
  }
  int nearest(const Eigen::Vector3d& point_m) const {
    return nodes_[static_cast<std::size_t>(mesh::nearest_node(places_, point_m))];
  }

 private:
  std::vector<int> nodes_;
  mesh::TetMesh places_;  // without elements
};

}  // namespace

ModalPush push_at_nearest_node(const modal::ModalModel& model) {
  return [&model, nodes = std::make_shared<const SurfaceNodes>(model.mesh)](const Eigen::Vector3d& point_m,
                                                                            const Eigen::Vector3d& impulse_n_s) {
    const int node = nodes->nearest(point_m);
    Eigen::VectorXd push(model.n_modes());
    for (Eigen::Index m = 0; m < push.size(); ++m) push[m] = model.shapes.block<3, 1>(3 * node, m).dot(impulse_n_s);
    return push;
  };
}

double RingingBody::damped_rad_s(Eigen::Index mode) const {
  const double omega = angular_frequency_rad_s[mode], decay = decay_per_s[mode];
  return std::sqrt(std::max(0.0, (omega - decay) * (omega + decay)));
}

std::vector<ModalImpulse> modal_impulses(const events::EventLog& log, int body, const ModalPush& push,
                                         const PushedModes& modes, const ImpactPulses* pulses) {
  std::vector<ModalImpulse> impulses;
  for (std::size_t row = 0; row < log.impulses.size(); ++row) {
    const events::Impulse& impulse = log.impulses[row];
    if (impulse.body != body || (impulse.shape == events::PulseShape::kHeld && impulse.duration_s > 0.0)) continue;
    const events::GaussianPulse pulse = events::gaussian_pulse(impulse);
    impulses.push_back(
        {pulse.centre_s, push(impulse.point_m, impulse.impulse_n_s)(modes.numbers), pulse.standard_deviation_s, {}});
    const auto other = pulses ? pulses->find(row) : ImpactPulses::const_iterator();
    if (pulses && other != pulses->end()) {
      impulses.back().pulse = other->second.force;
      impulses.back().impulse *= other->second.share;
    } else if (impulse.shape == events::PulseShape::kHertz && impulse.duration_s > 0.0) {
      impulses.back().pulse = sampled(hertz_history(impulse.time_s, impulse.duration_s), modes.sample_rate_hz);
    }
  }
  const std::vector<ModalImpulse> held = held_impulses(log, body, push, modes);
  impulses.insert(impulses.end(), held.begin(), held.end());
  return impulses;
}

ModalVoice::ModalVoice(int body, RingingBody ringing, const ImpactPulses* pulses)
    : body_(body), ringing_(std::move(ringing)), pulses_(pulses) {
  const Eigen::Index n = ringing_.angular_frequency_rad_s.size();
  if (ringing_.decay_per_s.size() != n) {
    throw InputError("synthesis", "needs one decay per mode", std::to_string(ringing_.decay_per_s.size()),
                     std::to_string(n));
  }
  if (ringing_.gain.rows() != n) {
    throw InputError("synthesis", "needs one gain per mode", std::to_string(ringing_.gain.rows()), std::to_string(n));
  }
}

void ModalVoice::add_to(Mix& mix, const events::EventLog& log, const Listener&, Monitor&) {
  if (ringing_.gain.cols() != 1 && ringing_.gain.cols() != mix.n_channels()) {
    throw InputError("synthesis", "needs one gain per channel", std::to_string(ringing_.gain.cols()),
                     std::to_string(mix.n_channels()));
  }
  const Eigen::Index n_frames = mix.known_frames();
  std::vector<Eigen::Index> kept;
  for (Eigen::Index m = 0; m < ringing_.angular_frequency_rad_s.size(); ++m) {
    if (ringing_.damped_rad_s(m) / (2.0 * kPi) < audio::highest_rendered_hz(mix.sample_rate_hz())) kept.push_back(m);
  }
  const std::vector<ModalImpulse> impulses = modal_impulses(
      log, body_, ringing_.push,
      {kept, ringing_.angular_frequency_rad_s(kept), ringing_.decay_per_s(kept), mix.sample_rate_hz()}, pulses_);
  Eigen::VectorXd sound;
  for (int c = 0; c < mix.n_channels(); ++c) {
    if (c == 0 || ringing_.gain.cols() > 1) {
      std::vector<Oscillator> oscillators;
      for (const Eigen::Index m : kept)
        oscillators.push_back({ringing_.angular_frequency_rad_s[m], ringing_.decay_per_s[m], ringing_.gain(m, c)});
      sound = oscillation(oscillators, impulses, mix.sample_rate_hz(), n_frames, ringing_.heard);
    }
    mix.add(c, 0, {sound.data(), static_cast<std::size_t>(sound.size())});
  }
}

events::EventLog log_of(std::vector<events::Strike> strikes) {
  events::EventLog log;
  log.bodies = {{"body", -1}};
  log.impulses = std::move(strikes);
  return log;
}

audio::Signal synthesise(const modal::ModalModel& model, const Eigen::VectorXd& decay_per_s,
                         const std::vector<events::Strike>& strikes, const SynthesisOptions& options) {
  RingingBody ringing;
  ringing.angular_frequency_rad_s = model.angular_frequency_rad_s;
  ringing.decay_per_s = decay_per_s;
  ringing.push = push_at_nearest_node(model);
  if (options.pickup) {
    ringing.heard = Heard::kMotion;
    const int node = SurfaceNodes(model.mesh).nearest(options.pickup->point_m);
    ringing.gain = model.shapes.middleRows<3>(3 * node).transpose() * options.pickup->direction.normalized();
  } else {
    Eigen::MatrixXd push(model.n_modes(), static_cast<Eigen::Index>(strikes.size()));
    for (std::size_t k = 0; k < strikes.size(); ++k)
      push.col(static_cast<Eigen::Index>(k)) = ringing.push(strikes[k].point_m, strikes[k].impulse_n_s);
    ringing.gain = heard_coupling(model, decay_per_s, push);
  }
  ModalVoice voice(0, std::move(ringing));
  Voice* const voices[] = {&voice};
  return render(log_of(strikes), voices, Listener::without_place(), {options.sample_rate_hz, options.duration_s});
}

}  // namespace klang::stage
