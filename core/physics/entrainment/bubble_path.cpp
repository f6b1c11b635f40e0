#include "core/physics/entrainment/bubble_path.hpp"

#include <algorithm>
#include <cmath>

#include "core/physics/bubble/rise_formulas.hpp"

namespace klang::entrainment {
namespace {

using bubble::BubbleMedium;
using bubble::kGravityMS2;
using Eigen::Vector3d;

constexpr double kLongestStep_s = 5e-4, kSlowest_m_s = 1e-7;
constexpr int kDragTurns = 4;

/// 3/8 C_d rho |w| / r: drag per volume over the speed.
double drag_rate(Drag drag, double radius_m, double speed_m_s, const BubbleMedium& medium) {
  const double speed = std::max(speed_m_s, kSlowest_m_s);
  return 0.375 * drag_coefficient(drag, radius_m, speed, medium) * medium.liquid_density_kg_m3 * speed / radius_m;
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

double drag_coefficient(Drag drag, double radius_m, double speed_m_s, const BubbleMedium& medium) {
  constexpr double kPaperOnSection = 0.8;  // 0.2 on 4 pi r^2
  if (drag == Drag::kPaper) return kPaperOnSection;
  const double rho = medium.liquid_density_kg_m3;
  const double reynolds = 2.0 * radius_m * speed_m_s * rho / std::max(medium.liquid_viscosity_pa_s, 1e-12);
  const double viscous = (drag == Drag::kClean ? 16.0 : 24.0) / reynolds * (1.0 + 0.15 * std::pow(reynolds, 0.687));
  const double limit = drag == Drag::kClean          ? 48.0 / reynolds
                       : drag == Drag::kContaminated ? 72.0 / reynolds
                                                     : HUGE_VAL;
  const double weight = 4.0 * kGravityMS2 * (rho - medium.gas_density_kg_m3) * radius_m * radius_m;
  const double deformed = 8.0 / 3.0 * weight / (weight + 4.0 * medium.surface_tension_n_m);
  return std::max(std::min(viscous, limit), deformed);
}

double terminal_speed_m_s(Drag drag, double radius_m, const BubbleMedium& medium) {
  const double buoyancy = (medium.liquid_density_kg_m3 - medium.gas_density_kg_m3) * kGravityMS2;
  double low = kSlowest_m_s, high = 1e3;
  for (int turn = 0; turn < 200; ++turn) {  // drag rises with speed
    const double middle = std::sqrt(low * high);
    (drag_rate(drag, radius_m, middle, medium) * middle < buoyancy ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

BubblePath bubble_path(const liquid::LiquidFrames& frames, const Birth& birth, Drag drag, const BubbleMedium& medium) {
  BubblePath path;
  path.radius_m = birth.radius_m;
  const double end_s = frames.time_s().back(), rho = medium.liquid_density_kg_m3, gas = medium.gas_density_kg_m3;
  const double inertia = gas + 0.5 * rho;
  const Vector3d gravity(0.0, 0.0, -kGravityMS2);
  double time = birth.time_s;
  Vector3d x = birth.position_m, v = birth.velocity_m_s;
  for (;;) {
    const double phi = liquid::phi_m(frames, time, x);
    path.time_s.push_back(time);
    path.position_m.push_back(x);
    path.phi_m.push_back(phi);
    path.end = !(phi <= -birth.radius_m) ? EndKind::kSurface : frames.in_outlet(x) ? EndKind::kOutlet : EndKind::kEnd;
    const double step = std::min(kLongestStep_s, end_s - time);
    if (path.end != EndKind::kEnd || !(step > 1e-9)) return path;
    const Vector3d u = flow_at(frames, time, x);
    const Vector3d u_end = flow_at(frames, time + step, x + step * u);
    const Vector3d force = (gas - rho) * gravity + 1.5 * rho * flow_acceleration(frames, time, x, u);
    Vector3d next = v;
    for (int turn = 0; turn < kDragTurns; ++turn) {
      const double rate = drag_rate(drag, birth.radius_m, (next - u_end).norm(), medium);
      next = (inertia * v + step * (force + rate * u_end)) / (inertia + step * rate);
    }
    x += 0.5 * step * (v + next);
    v = next;
    time = end_s - time - step > 1e-9 ? time + step : end_s;
  }
}

}  // namespace klang::entrainment
