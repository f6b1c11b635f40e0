#include "core/physics/liquid/carried_level.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/liquid/level_set.hpp"

namespace klang::liquid {

using Eigen::Vector3d;

void correct_by_carried(const GridShape& shape, const Particles& particles, const CarriedLevel& options, Field& phi) {
  const double h = shape.cell_m, near = options.near_cells * h, most = options.most_cells * h,
               least = options.least_cells * h;
  std::vector<std::array<double, 2>> sums(phi.size(), {0.0, 0.0});  // weight, weight times difference
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const double carried = particles.phi_m[p];
    if (!(std::abs(carried) < near)) continue;
    const Vector3d g = particles.x_m[p] / h - Vector3d::Constant(0.5);
    const double difference = carried - trilinear(phi, g.x(), g.y(), g.z());
    const double off = std::abs(difference) > least ? std::clamp(difference, -most, most) : 0.0;
    const GridPlace at(phi, g.x(), g.y(), g.z());
    for (int corner = 0; corner < 8; ++corner) {
      const int a = corner & 1, b = (corner >> 1) & 1, c = corner >> 2;
      const double weight = (a != 0 ? at.x : 1.0 - at.x) * (b != 0 ? at.y : 1.0 - at.y) * (c != 0 ? at.z : 1.0 - at.z);
      if (!(weight > 0.0)) continue;
      std::array<double, 2>& sum = sums[phi.index(at.i + a, at.j + b, at.k + c)];
      sum[0] += weight;
      sum[1] += weight * off;
    }
  }
  for (std::size_t c = 0; c < phi.size(); ++c)
    if (sums[c][0] > 0.0 && std::abs(phi[c]) < options.band_cells * h)
      phi[c] += sums[c][1] / std::max(sums[c][0], options.full_weight);
}

namespace {

/// n . (n . grad) u, n the normal of phi.
double stretch_per_s(const Field& phi, const MacGrid& u, const Vector3d& x, double h) {
  Vector3d n;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d half = 0.5 * h * Vector3d::Unit(axis);
    n[axis] = at_centres(phi, x + half, h) - at_centres(phi, x - half, h);
  }
  const double length = n.norm();
  if (!(length > 1e-6 * h)) return 0.0;
  const Vector3d way = 0.25 * h / length * n;
  return (velocity_at(u, x + way, h) - velocity_at(u, x - way, h)).dot(n) / (0.5 * h * length);
}

/// Marks what is within so many cells of a mark along an axis.
void widen(Grid3<std::uint8_t>& marked, int axis, int cells) {
  const std::array<int, 3> size{marked.nx(), marked.ny(), marked.nz()};
  const auto length = size[static_cast<std::size_t>(axis)];
  const int across = axis == 2 ? 1 : 2,
            other = axis == 0 ? 1 : 0;  // lines are spread over threads by their index across
  parallel_for(static_cast<std::size_t>(size[static_cast<std::size_t>(across)]), 1, [&](std::size_t c, std::size_t) {
    std::array<int, 3> at{};
    at[static_cast<std::size_t>(across)] = static_cast<int>(c);
    for (int line = 0; line < size[static_cast<std::size_t>(other)]; ++line) {
      at[static_cast<std::size_t>(other)] = line;
      const auto mark = [&](int along) -> std::uint8_t& {
        at[static_cast<std::size_t>(axis)] = along;
        return marked(at[0], at[1], at[2]);
      };
      int until = -1, begin = 0;  // marked up to here; cells before begin are done
      for (int i = 0; i < length; ++i) {
        if (mark(i) != 0) {
          for (int before = std::max(begin, i - cells); before < i; ++before) mark(before) = 1;
          until = i + cells;
          begin = i + 1;
        } else if (i <= until) {
          mark(i) = 1;
          begin = i + 1;
        }
      }
    }
  });
}

/// Cells near the surface that are within reach of one where the grid does not resolve phi.
Grid3<std::uint8_t> poorly_resolved(const GridShape& shape, const Field& phi, const CarriedLevel& options) {
  const double h = shape.cell_m, near = (options.near_cells + 1.0) * h;
  Grid3<std::uint8_t> poor(shape.nx, shape.ny, shape.nz, 0);
  parallel_for(static_cast<std::size_t>(shape.nz), 1, [&](std::size_t layer, std::size_t) {
    const int k = static_cast<int>(layer);
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        if (!(std::abs(phi(i, j, k)) < near)) continue;
        const double off = std::abs(slope_at(phi, h, i, j, k).norm() - 1.0);
        const bool resolved =
            off <= options.resolved_slope && h * std::abs(curvature_per_m(phi, h, i, j, k)) <= options.resolved_bend;
        poor(i, j, k) = resolved ? 0 : 1;
      }
  });
  for (int axis = 0; axis < 3; ++axis) widen(poor, axis, options.poor_reach_cells);
  return poor;
}

}  // namespace

void update_carried(const GridShape& shape, const Field& phi, const CarriedStep& step, const CarriedLevel& options,
                    Particles& particles) {
  const double h = shape.cell_m, near = options.near_cells * h;
  const Grid3<std::uint8_t> poor = poorly_resolved(shape, phi, options);
  const auto cell = [h](double x) { return static_cast<int>(x / h); };
  parallel_for(particles.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const Vector3d& x = particles.x_m[p];
      double& carried = particles.phi_m[p];
      const double there = at_centres(phi, x, h);
      if (!(std::abs(carried) < near) || poor.clamped(cell(x.x()), cell(x.y()), cell(x.z())) == 0) {
        carried = there;
        continue;
      }
      if (step.step_s > 0.0) carried *= 1.0 + std::clamp(step.step_s * stretch_per_s(phi, step.u, x, h), -0.5, 0.5);
      carried = std::clamp(carried, there - h, there + h);
    }
  });
}

}  // namespace klang::liquid
