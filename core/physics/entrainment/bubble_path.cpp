#include "core/physics/entrainment/bubble_path.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"

namespace klang::entrainment {
namespace {

using bubble::BubbleMedium;
using Eigen::Vector3d;

constexpr double kLongestStep_s = 5e-4, kSlowest_m_s = 1e-7;
constexpr int kDragTurns = 4;

/// 3/8 C_d rho |w| / r: drag per volume over the speed.
double drag_rate(const RiseSettings& settings, double radius_m, double speed_m_s) {
  const double speed = std::max(speed_m_s, kSlowest_m_s);
  return 0.375 * drag_coefficient(settings, radius_m, speed) * settings.medium.liquid_density_kg_m3 * speed / radius_m;
}

Vector3d flow_at(const liquid::LiquidFrames& frames, double time_s, const Vector3d& x) {
  return liquid::velocity_m_s(frames, time_s, x).value_or(Vector3d::Zero());
}

/// Du/Dt: the change that a part of the liquid sees, by differences along its way over a frame.
Vector3d flow_acceleration(const liquid::LiquidFrames& frames, double time_s, const Vector3d& x, const Vector3d& u) {
  const std::span<const double> times = frames.time_s();
  if (times.size() < 2) return Vector3d::Zero();
  const double step = times[1] - times[0];
  const double later = std::min(time_s + 0.5 * step, times.back()), earlier = std::max(later - step, times.front());
  if (!(later > earlier)) return Vector3d::Zero();
  return (flow_at(frames, later, x + (later - time_s) * u) - flow_at(frames, earlier, x + (earlier - time_s) * u)) /
         (later - earlier);
}

}  // namespace

double drag_coefficient(const RiseSettings& settings, double radius_m, double speed_m_s) {
  const Drag drag = settings.drag;
  const BubbleMedium& medium = settings.medium;
  constexpr double kPaperOnSection = 0.8;  // 0.2 on 4 pi r^2
  if (drag == Drag::kPaper) return kPaperOnSection;
  const double rho = medium.liquid_density_kg_m3;
  const double reynolds = 2.0 * radius_m * speed_m_s * rho / std::max(medium.liquid_viscosity_pa_s, 1e-12);
  const double viscous = (drag == Drag::kClean ? 16.0 : 24.0) / reynolds * (1.0 + 0.15 * std::pow(reynolds, 0.687));
  const double limit = drag == Drag::kClean          ? 48.0 / reynolds
                       : drag == Drag::kContaminated ? 72.0 / reynolds
                                                     : HUGE_VAL;
  const double weight = 4.0 * settings.gravity_m_s2 * (rho - medium.gas_density_kg_m3) * radius_m * radius_m;
  const double deformed = 8.0 / 3.0 * weight / (weight + 4.0 * medium.surface_tension_n_m);
  return std::max(std::min(viscous, limit), deformed);
}

double terminal_speed_m_s(const RiseSettings& settings, double radius_m) {
  const BubbleMedium& medium = settings.medium;
  const double buoyancy = (medium.liquid_density_kg_m3 - medium.gas_density_kg_m3) * settings.gravity_m_s2;
  double low = kSlowest_m_s, high = 1e3;
  for (int turn = 0; turn < 200; ++turn) {  // drag rises with speed
    const double middle = std::sqrt(low * high);
    (drag_rate(settings, radius_m, middle) * middle < buoyancy ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

namespace {

/// A bubble on its way.
struct Walk {
  BubblePath path;
  Vector3d x, v;
  bool ended = false;
};

Walk begun(const liquid::LiquidFrames& frames, const Birth& birth) {
  Walk walk{{}, birth.position_m, birth.velocity_m_s};
  walk.path.radius_m = birth.radius_m;
  walk.path.time_s = {birth.time_s};
  walk.path.position_m = {walk.x};
  walk.path.phi_m = {liquid::phi_m(frames, birth.time_s, walk.x)};
  return walk;
}

/// On to a time, or to its end.
void advance(const liquid::LiquidFrames& frames, const RiseSettings& settings, double until_s, Walk& walk) {
  const double end_s = frames.time_s().back(), rho = settings.medium.liquid_density_kg_m3,
               gas = settings.medium.gas_density_kg_m3, inertia = gas + 0.5 * rho;
  const Vector3d gravity(0.0, 0.0, -settings.gravity_m_s2);
  BubblePath& path = walk.path;
  while (!walk.ended && (path.time_s.back() < until_s || until_s >= end_s)) {
    const double time = path.time_s.back(), step = std::min(kLongestStep_s, end_s - time);
    path.end = !(path.phi_m.back() <= -path.radius_m) ? EndKind::kSurface
               : frames.in_outlet(walk.x)             ? EndKind::kOutlet
                                                      : EndKind::kEnd;
    walk.ended = path.end != EndKind::kEnd || !(step > 1e-9);
    if (walk.ended) return;
    const Vector3d u = flow_at(frames, time, walk.x);
    const Vector3d u_end = flow_at(frames, time + step, walk.x + step * u);
    const Vector3d force = (gas - rho) * gravity + 1.5 * rho * flow_acceleration(frames, time, walk.x, u);
    Vector3d next = walk.v;
    for (int turn = 0; turn < kDragTurns; ++turn) {
      const double rate = drag_rate(settings, path.radius_m, (next - u_end).norm());
      next = (inertia * walk.v + step * (force + rate * u_end)) / (inertia + step * rate);
    }
    walk.x += 0.5 * step * (walk.v + next);
    walk.v = next;
    path.time_s.push_back(end_s - time - step > 1e-9 ? time + step : end_s);
    path.position_m.push_back(walk.x);
    path.phi_m.push_back(liquid::phi_m(frames, path.time_s.back(), walk.x));
  }
}

}  // namespace

BubblePath bubble_path(const liquid::LiquidFrames& frames, const Birth& birth, const RiseSettings& settings) {
  Walk walk = begun(frames, birth);
  advance(frames, settings, frames.time_s().back(), walk);
  return std::move(walk.path);
}

std::vector<BubblePath> paths_of(const liquid::LiquidFrames& frames, const std::vector<Birth>& births,
                                 const RiseSettings& settings, Monitor& monitor) {
  const std::span<const double> times = frames.time_s();
  std::vector<Walk> walks(births.size());
  std::vector<char> is_begun(births.size(), 0);
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    monitor.throw_if_stopped();
    monitor.progress("bubbles", static_cast<double>(frame) / static_cast<double>(times.size()));
    const bool last = frame + 1 >= times.size();
    const double until = last ? times.back() : times[frame + 1];
    // A frame's acceleration reaches half a frame to both sides.
    const liquid::HeldFrames held(frames, frame > 0 ? frame - 1 : 0, std::min(frame + 2, times.size() - 1));
    parallel_for(births.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (births[i].time_s >= until && !last) continue;
        if (is_begun[i] == 0) walks[i] = begun(*held, births[i]);
        is_begun[i] = 1;
        advance(*held, settings, until, walks[i]);
      }
    });
  }
  std::vector<BubblePath> paths;
  for (Walk& walk : walks) {
    paths.push_back(std::move(walk.path));
    paths.back().id = static_cast<std::int64_t>(paths.size());
  }
  return paths;
}

}  // namespace klang::entrainment
