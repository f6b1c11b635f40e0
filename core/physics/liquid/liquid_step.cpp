#include "core/physics/liquid/liquid_step.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/physics/liquid/carried_level.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kBandCells = 5.0, kKeepCells = 3.0;  // phi is carried, and kept, this far from the surface
constexpr double kReachCells = 8.0;                   // and a distance this far
constexpr int kAirLayers = 5;
constexpr double kMostShiftCells = 0.25;  // per step, to keep the volume where drops merge
constexpr double kSmallShiftCells = 0.02, kSourceTime_s = 0.1, kMostSource = 0.05;  // see keep_volume()

}  // namespace

Liquid::Liquid(LiquidSetup setup) : setup_(std::move(setup)), solids_(setup_.all_solids()) {
  const GridShape& shape = setup_.shape;
  emitted_.assign(setup_.inlets.size(), 0.0);
  solid_ = setup_.round ? liquid::sector_field(shape) : liquid::solid_field(shape, solids_);
  phi_ = Field(shape.nx, shape.ny, shape.nz);
  pressure_ = phi_;
  u_ = MacGrid(shape);
  at_liquid_ = Grid3<std::uint8_t>(shape.nx, shape.ny, shape.nz, 0);
  parallel_for(static_cast<std::size_t>(shape.nz), 1, [&](std::size_t layer, std::size_t) {
    const int k = static_cast<int>(layer);
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        phi_(i, j, k) = setup_.phi_m(shape.centre_m(i, j, k));
        pressure_(i, j, k) = std::max(0.0, -setup_.options.gravity_m_s2 * phi_(i, j, k));
      }
  });
  drain();
  outflow_ = 0.0;
  seed_particles();
  volume_ = start_volume_ = liquid_volume_m3(shape, phi_, solid_);
}

void Liquid::seed_particles() {
  const GridShape& shape = setup_.shape;
  const int n = setup_.options.particles_per_axis;
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        if (phi_(i, j, k) > shape.cell_m) continue;
        for (int s = 0; s < n * n * n; ++s) {
          const Vector3d x =
              shape.cell_m * Vector3d(i + (s % n + 0.5) / n, j + (s / n % n + 0.5) / n, k + (s / (n * n) + 0.5) / n);
          if (!(setup_.phi_m(x) < 0.0) || !(at_centres(phi_, x, shape.cell_m) < 0.1 * shape.cell_m)) continue;
          if (solid_.any && !(at_nodes(solid_.distance_m, x, shape.cell_m) > 0.0)) continue;
          Vector3f v = Vector3f::Zero();
          for (const Drop& drop : setup_.drops)
            if ((x - drop.position_m).norm() < drop.radius_m) v = drop.velocity_m_s.cast<float>();
          particles_.add(x, v);
        }
      }
  particles_.sort(shape);
  update_carried(shape, phi_, {u_}, {}, particles_);
  MacGrid weight(shape);
  particles_to_faces(shape, particles_, u_, weight);  // the first frame tells how drops fly
}

bool Liquid::streams(const Inlet& inlet) const { return time_s_ >= inlet.start_s - 1e-12; }

double Liquid::max_speed() const {
  const std::size_t n = particles_.size();
  std::vector<float> most((n + 4095) / 4096 + 1, 0.0F);
  parallel_for(n, 4096, [&](std::size_t begin, std::size_t end) {
    float largest = 0.0F;
    for (std::size_t p = begin; p < end; ++p) largest = std::max(largest, particles_.v_m_s[p].squaredNorm());
    most[begin / 4096] = largest;
  });
  return std::sqrt(static_cast<double>(*std::max_element(most.begin(), most.end())));
}

double Liquid::step_limit_s() const {
  const LiquidOptions& o = setup_.options;
  double speed = max_speed() + o.gravity_m_s2 * o.longest_step_s;
  for (const Inlet& inlet : setup_.inlets)
    if (time_s_ + o.longest_step_s >= inlet.start_s) speed = std::max(speed, inlet.speed_m_s);
  for (const Solid& solid : solids_) speed = std::max(speed, solid.velocity_m_s.norm());
  double limit = std::min(o.longest_step_s, o.cfl * setup_.shape.cell_m / speed);
  if (o.tension)  // capillary waves of two cells (Brackbill 1992, one fluid)
    limit = std::min(
        limit, std::sqrt(o.density_kg_m3 * std::pow(setup_.shape.cell_m, 3) / (2.0 * kPi * o.surface_tension_n_m)));
  return limit;
}

namespace {

struct IndexBox {
  std::array<int, 3> low, high;
};

/// Cells within so many cells of a solid, and some more.
IndexBox cells_around(const Solid& solid, const GridShape& shape, double cells) {
  IndexBox box;
  const double reach = solid.outer_radius_m() / shape.cell_m + cells;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double centre = solid.position_m[axis] / shape.cell_m, last = shape.n(axis) - 1.0;
    box.low[a] = static_cast<int>(std::clamp(std::floor(centre - reach - 1.0), 0.0, last));
    box.high[a] = static_cast<int>(std::clamp(std::ceil(centre + reach + 1.0), 0.0, last));
  }
  return box;
}

}  // namespace

void Liquid::set_solid_faces(FaceMask& known) {
  const GridShape& shape = setup_.shape;
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    const Solid& solid = solids_[s];
    if (!solid.moves() && !solid.streams) continue;
    const IndexBox box = cells_around(solid, shape, 1.0);
    for (int axis = 0; axis < 3; ++axis) {
      Field& field = u_[axis];
      const auto end = [&](int a, int n) { return std::min(box.high[static_cast<std::size_t>(a)] + 2, n); };
      for (int k = box.low[2]; k < end(2, field.nz()); ++k)
        for (int j = box.low[1]; j < end(1, field.ny()); ++j)
          for (int i = box.low[0]; i < end(0, field.nx()); ++i)
            if (solid_.open[axis](i, j, k) <= 0.0 && solid.distance_m(face_m(shape, axis, i, j, k)) < 0.0) {
              field(i, j, k) = solid.velocity_m_s[axis];
              known[axis](i, j, k) = 1;
            }
    }
  }
}

void Liquid::find_near_liquid(const Grid3<std::uint8_t>& liquid) {
  const GridShape& shape = setup_.shape;
  parallel_for(static_cast<std::size_t>(shape.nz), 1, [&](std::size_t layer, std::size_t) {
    const int k = static_cast<int>(layer);
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i)
        at_liquid_(i, j, k) = liquid(i, j, k) | liquid.clamped(i - 1, j, k) | liquid.clamped(i + 1, j, k) |
                              liquid.clamped(i, j - 1, k) | liquid.clamped(i, j + 1, k) | liquid.clamped(i, j, k - 1) |
                              liquid.clamped(i, j, k + 1);
  });
}

namespace {

/// Faces that the projection made: open, with a cell of liquid on a side; in free flight: what particles brought.
FaceMask valid_faces(const GridShape& shape, const SolidField& solid, const Grid3<std::uint8_t>& liquid,
                     const Grid3<std::uint8_t>& at_liquid, const MacGrid& weight) {
  FaceMask valid;
  for (int axis = 0; axis < 3; ++axis) {
    const Field& open = solid.open[axis];
    valid[axis] = Grid3<std::uint8_t>(open.nx(), open.ny(), open.nz(), 0);
    parallel_for(static_cast<std::size_t>(open.nz()), 1, [&](std::size_t layer, std::size_t) {
      const int k = static_cast<int>(layer);
      for (int j = 0; j < open.ny(); ++j)
        for (int i = 0; i < open.nx(); ++i) {
          const int a = i - (axis == 0 ? 1 : 0), b = j - (axis == 1 ? 1 : 0), c = k - (axis == 2 ? 1 : 0);
          const int along = axis == 0 ? i : axis == 1 ? j : k;
          if (along == 0 || along == shape.n(axis) || !(open(i, j, k) > 0.0)) continue;
          const bool wet = liquid(i, j, k) != 0 || liquid(a, b, c) != 0;
          const bool flies = at_liquid(i, j, k) == 0 && at_liquid(a, b, c) == 0 && weight[axis](i, j, k) > 1e-9;
          valid[axis](i, j, k) = wet || flies ? 1 : 0;
        }
    });
  }
  return valid;
}

void add_gravity(double kick_m_s, MacGrid& u) {
  Field& w = u[2];
  parallel_for(w.size(), 65536, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) w[f] -= kick_m_s;
  });
}

double fastest(const MacGrid& u, const FaceMask& valid) {
  double most = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t f = 0; f < u[axis].size(); ++f)
      if (valid[axis][f] != 0) most = std::max(most, std::abs(u[axis][f]));
  return most;
}

}  // namespace

LiquidStep Liquid::step(double step_s) {
  const GridShape& shape = setup_.shape;
  const LiquidOptions& o = setup_.options;
  const double h = shape.cell_m, kick_s = pending_kick_s_ + 0.5 * step_s;
  LiquidStep report;
  report.step_s = step_s;

  MacGrid weight(shape);
  particles_to_faces(shape, particles_, u_, weight);
  FaceMask known;
  for (int axis = 0; axis < 3; ++axis) {
    known[axis] = Grid3<std::uint8_t>(u_[axis].nx(), u_[axis].ny(), u_[axis].nz(), 0);
    for (std::size_t f = 0; f < u_[axis].size(); ++f) known[axis][f] = weight[axis][f] > 1e-9 ? 1 : 0;
  }
  extrapolate(shape, 2, false, u_, known);
  MacGrid before;
  if (o.flip_share > 0.0) before = u_;
  add_gravity(o.gravity_m_s2 * kick_s, u_);
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    if (solids_[s].motion == SolidMotion::kFree) solids_[s].velocity_m_s.z() -= o.gravity_m_s2 * kick_s;
    if (solids_[s].motion == SolidMotion::kKeys)
      solids_[s].velocity_m_s =
          (solids_[s].keys.position_at(time_s_ + step_s) - solids_[s].keys.position_at(time_s_)) / step_s;
  }
  for (std::size_t i = 0; i < setup_.inlets.size(); ++i) {
    const Inlet& inlet = setup_.inlets[i];
    solids_[setup_.solids.size() + i].velocity_m_s =
        streams(inlet) ? Vector3d(inlet.speed_m_s * inlet.direction) : Vector3d(Vector3d::Zero());
  }

  PressureOptions options;
  options.kick_s = kick_s;
  options.density_kg_m3 = o.density_kg_m3;
  options.tension_m3_s2 = o.tension ? o.surface_tension_n_m / o.density_kg_m3 : 0.0;
  options.tolerance = o.pressure_tolerance;
  options.source_per_s = source_per_s_;
  report.pressure = project(shape, phi_, solid_, solids_, {u_, pressure_}, options);

  const Grid3<std::uint8_t> liquid = liquid_cells(shape, phi_, solid_);
  find_near_liquid(liquid);
  const FaceMask valid = valid_faces(shape, solid_, liquid, at_liquid_, weight);
  report.max_speed_m_s = fastest(u_, valid);
  known = valid;
  set_solid_faces(known);
  extrapolate(shape, kAirLayers, true, u_, known);
  continue_into_air(shape, phi_, liquid, valid, solid_.round, u_);
  if (o.flip_share > 0.0)
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t f = 0; f < u_[axis].size(); ++f) before[axis][f] = u_[axis][f] - before[axis][f];
  const std::size_t n_before = particles_.size();
  keep_density();
  ParticleUpdate update{u_, o.flip_share > 0.0 ? &before : nullptr, o.flip_share, at_liquid_,
                        Vector3f(0.0F, 0.0F, static_cast<float>(-o.gravity_m_s2 * kick_s))};
  move_particles(shape, update, step_s, 0, n_before, particles_);
  update.flip_share = 0.0;  // particles that were added have no velocity of their own
  move_particles(shape, update, step_s, n_before, particles_.size(), particles_);
  advect_level_set(shape, u_, step_s, kBandCells * h, phi_);
  correct_by_carried(shape, particles_, {}, phi_);
  move_solids(step_s);
  emit(step_s);
  push_out();
  keep_.resize(particles_.size(), 1);
  for (const Outlet& outlet : setup_.outlets)
    for (std::size_t p = 0; p < particles_.size(); ++p)
      if (outlet.distance_m(particles_.x_m[p]) < 0.0) keep_[p] = 0;
  particles_.sort(shape, &keep_);
  correct_by_particles(shape, particles_, solid_, {}, phi_);
  drain();
  redistance(shape, kKeepCells * h, kReachCells * h, phi_);
  keep_volume();
  update_carried(shape, phi_, {u_, step_s}, {}, particles_);
  open_carried();

  time_s_ += step_s;
  pending_kick_s_ = 0.5 * step_s;
  ++n_steps_;
  report.time_s = time_s_;
  report.volume_m3 = volume_;
  report.inflow_m3 = inflow_;
  report.outflow_m3 = outflow_;
  const double expected = start_volume_ + inflow_ - outflow_;
  report.drift_relative = std::abs(volume_ - expected) / std::max(expected, 64.0 * h * h * h);
  report.n_particles = particles_.size();
  return report;
}

void Liquid::move_solids(double step_s) {
  bool moved = false;
  const Vector3d size = setup_.shape.size_m();
  for (Solid& solid : solids_) {
    if (!solid.moves()) continue;
    moved = true;
    if (solid.motion == SolidMotion::kKeys) {
      solid.position_m = solid.keys.position_at(time_s_ + step_s);
      continue;
    }
    solid.position_m += step_s * solid.velocity_m_s;
    const double r = solid.radius_m;
    for (int axis = 0; axis < 3; ++axis) {  // walls stop it
      const double low = r, high = size[axis] - r;
      if (solid.position_m[axis] < low || (axis < 2 && solid.position_m[axis] > high)) {
        solid.position_m[axis] = std::clamp(solid.position_m[axis], low, std::max(low, high));
        solid.velocity_m_s[axis] = 0.0;
      }
    }
  }
  if (moved) solid_ = liquid::solid_field(setup_.shape, solids_);
}

void Liquid::emit(double step_s) {
  const double h = setup_.shape.cell_m;
  const int n = setup_.options.particles_per_axis;
  for (std::size_t s = 0; s < setup_.inlets.size(); ++s) {
    const Inlet& inlet = setup_.inlets[s];
    if (!streams(inlet)) continue;
    const double volume = inlet.area_m2() * inlet.speed_m_s * step_s;
    inflow_ += volume;
    emitted_[s] += volume * n * n * n / (h * h * h);
    const auto count = static_cast<std::size_t>(emitted_[s]);
    emitted_[s] -= static_cast<double>(count);
    RandomStream random(setup_.options.seed + 1 + s, n_steps_);
    const Vector3d along = inlet.direction;
    const Vector3d across = (std::abs(along.z()) > 0.5 ? Vector3d::UnitX() : Vector3d::UnitZ()).eval();
    const Vector3d other = along.cross(across);
    for (std::size_t p = 0; p < count; ++p) {
      Vector3d x = inlet.position_m + random.uniform() * step_s * inlet.speed_m_s * along;
      if (inlet.radius_m) {
        const double r = *inlet.radius_m * std::sqrt(random.uniform()), angle = 2.0 * kPi * random.uniform();
        x += r * (std::cos(angle) * across + std::sin(angle) * other);
      } else {
        for (int axis = 0; axis < 3; ++axis)
          if (std::abs(along[axis]) < 0.5) x[axis] += (random.uniform() - 0.5) * inlet.size_m[axis];
      }
      particles_.add(x, (inlet.speed_m_s * along).cast<float>());
    }
    // The mouthpiece is full: what leaves it carries the surface with it.
    const Solid& mouth = solids_[setup_.solids.size() + s];
    const IndexBox box = cells_around(mouth, setup_.shape, kReachCells);
    for (int k = box.low[2]; k <= box.high[2]; ++k)
      for (int j = box.low[1]; j <= box.high[1]; ++j)
        for (int i = box.low[0]; i <= box.high[0]; ++i)
          phi_(i, j, k) = std::min(phi_(i, j, k), mouth.distance_m(setup_.shape.centre_m(i, j, k)));
  }
}

void Liquid::drain() {
  if (setup_.outlets.empty()) return;
  const double before = liquid_volume_m3(setup_.shape, phi_, solid_);
  for (const Outlet& outlet : setup_.outlets)
    for (int k = 0; k < setup_.shape.nz; ++k)
      for (int j = 0; j < setup_.shape.ny; ++j)
        for (int i = 0; i < setup_.shape.nx; ++i)
          phi_(i, j, k) = std::max(phi_(i, j, k), -outlet.distance_m(setup_.shape.centre_m(i, j, k)));
  outflow_ += before - liquid_volume_m3(setup_.shape, phi_, solid_);
}

void Liquid::push_out() {
  const GridShape& shape = setup_.shape;
  const double h = shape.cell_m, margin = 1e-3 * h;
  const Vector3d low = Vector3d::Constant(margin), high = shape.size_m() - low;
  parallel_for(particles_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      Vector3d& x = particles_.x_m[p];
      for (int turn = 0; solid_.any && turn < 2; ++turn) {
        const auto cell = [&](double along, int n) { return std::clamp(static_cast<int>(along / h), 0, n - 1); };
        if (solid_.open_volume(cell(x.x(), shape.nx), cell(x.y(), shape.ny), cell(x.z(), shape.nz)) >= 1.0) break;
        const double distance = at_nodes(solid_.distance_m, x, h);
        if (!(distance < 0.0)) break;
        Vector3d slope;
        for (int axis = 0; axis < 3; ++axis) {
          const Vector3d d = 0.5 * h * Vector3d::Unit(axis);
          slope[axis] = at_nodes(solid_.distance_m, x + d, h) - at_nodes(solid_.distance_m, x - d, h);
        }
        const double length = slope.norm();
        if (length > 0.0) x += (margin - distance) / length * slope;
      }
      for (int axis = 0; axis < 3; ++axis) {
        if (x[axis] >= low[axis] && x[axis] <= high[axis]) continue;
        x[axis] = std::clamp(x[axis], low[axis], high[axis]);
        particles_.v_m_s[p][axis] = 0.0F;
      }
    }
  });
}

void Liquid::keep_density() {
  const GridShape& shape = setup_.shape;
  const double h = shape.cell_m;
  const int n = setup_.options.particles_per_axis, full = n * n * n;
  keep_.assign(particles_.size(), 1);
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        const std::size_t c = shape.index(i, j, k);
        const auto count = static_cast<int>(particles_.begin[c + 1] - particles_.begin[c]);
        for (int extra = 2 * full; extra < count; ++extra)
          keep_[particles_.begin[c] + static_cast<std::size_t>(extra)] = 0;
        if (count >= (3 * full) / 8 || !(phi_(i, j, k) < -h) || !solid_.whole(i, j, k)) continue;
        RandomStream random(setup_.options.seed ^ 0x9d1f00dULL, n_steps_ * shape.n_cells() + c);
        for (int add = count; add < full / 2; ++add) {
          const Vector3d x = h * Vector3d(i + random.uniform(), j + random.uniform(), k + random.uniform());
          particles_.add(x, velocity_at(u_, x, h).cast<float>());
        }
      }
}

/// The surface is shifted so that the volume is right now. Particles are not told and bring back what they hold too much (pockets of air that filled up). Where
/// that makes more than small shifts, the flow is given a little divergence: it takes from particles too, and from thick and thin in proportion (Kim et al. 2007).
void Liquid::keep_volume() {
  const GridShape& shape = setup_.shape;
  const double expected = start_volume_ + inflow_ - outflow_, most = kMostShiftCells * shape.cell_m;
  source_per_s_ = 0.0;
  if (!setup_.options.keep_volume || !(expected > 0.0)) {
    volume_ = liquid_volume_m3(shape, phi_, solid_);
    return;
  }
  const VolumeShift done = shift_to_volume(shape, solid_, expected, most, phi_);
  volume_ = done.volume_m3;
  const double small_m = kSmallShiftCells * shape.cell_m, shift_m = std::abs(done.shift_m);
  const double share = shift_m > small_m ? (1.0 - small_m / shift_m) * (done.before_m3 / expected - 1.0) : 0.0;
  source_per_s_ = -std::clamp(share, -kMostSource, kMostSource) / kSourceTime_s;
}

void Liquid::open_carried() {
  if (setup_.outlets.empty() && setup_.inlets.empty()) return;
  const double near = 2.0 * setup_.shape.cell_m;
  parallel_for(particles_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      double& carried = particles_.phi_m[p];
      if (!(std::abs(carried) < near)) continue;
      for (const Outlet& outlet : setup_.outlets) carried = std::max(carried, -outlet.distance_m(particles_.x_m[p]));
      for (std::size_t s = 0; s < setup_.inlets.size(); ++s)
        if (streams(setup_.inlets[s]))
          carried = std::min(carried, solids_[setup_.solids.size() + s].distance_m(particles_.x_m[p]));
    }
  });
}

Field Liquid::distance_m() const {
  Field distance = phi_;
  redistance(setup_.shape, kKeepCells * setup_.shape.cell_m, 2.0 * setup_.shape.size_m().norm(), distance);
  return distance;
}

}  // namespace klang::liquid
