#include "core/physics/liquid/particles.hpp"

#include <algorithm>

#include "core/foundation/base/parallel.hpp"

namespace klang::liquid {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::size_t kGrain = 4096;
constexpr int kSlab = 4;  // layers of cells

/// The eight faces around a point: lowest index, strides and shares.
struct Corner {
  std::size_t base, dx, dy, dz;
  double fx, fy, fz;
  Corner(const Field& field, int axis, const Vector3d& g) {
    const GridPlace at(field, g.x() - (axis == 0 ? 0.0 : 0.5), g.y() - (axis == 1 ? 0.0 : 0.5),
                       g.z() - (axis == 2 ? 0.0 : 0.5));
    base = field.index(at.i, at.j, at.k);
    dx = field.nx() > 1 ? 1 : 0;
    dy = field.ny() > 1 ? static_cast<std::size_t>(field.nx()) : 0;
    dz = field.nz() > 1 ? static_cast<std::size_t>(field.nx()) * field.ny() : 0;
    fx = at.x;
    fy = at.y;
    fz = at.z;
  }
};

}  // namespace

void Particles::add(const Vector3d& x, const Vector3f& v, const Matrix3f& c) {
  x_m.push_back(x);
  v_m_s.push_back(v);
  affine_per_s.push_back(c);
}

void Particles::sort(const GridShape& shape, const std::vector<std::uint8_t>* keep) {
  const std::size_t n = size(), n_cells = shape.n_cells();
  constexpr std::uint32_t kDropped = 0xffffffffU;
  cell_.resize(n);
  parallel_for(n, kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const Vector3d g = x_m[p] / shape.cell_m;
      const auto held = [](double value, int size) { return std::clamp(static_cast<int>(value), 0, size - 1); };
      cell_[p] = keep != nullptr && (*keep)[p] == 0
                     ? kDropped
                     : static_cast<std::uint32_t>(
                           shape.index(held(g.x(), shape.nx), held(g.y(), shape.ny), held(g.z(), shape.nz)));
    }
  });
  begin.assign(n_cells + 1, 0);
  for (std::size_t p = 0; p < n; ++p)
    if (cell_[p] != kDropped) ++begin[cell_[p] + 1];
  for (std::size_t c = 0; c < n_cells; ++c) begin[c + 1] += begin[c];
  const std::size_t n_kept = begin[n_cells];
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1), source(n_kept);
  for (std::size_t p = 0; p < n; ++p)
    if (cell_[p] != kDropped) source[next[cell_[p]]++] = static_cast<std::uint32_t>(p);
  x_other_.resize(n_kept);
  v_other_.resize(n_kept);
  affine_other_.resize(n_kept);
  parallel_for(n_kept, kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t q = first; q < last; ++q) {
      const std::size_t p = source[q];
      x_other_[q] = x_m[p];
      v_other_[q] = v_m_s[p];
      affine_other_[q] = affine_per_s[p];
    }
  });
  x_m.swap(x_other_);
  v_m_s.swap(v_other_);
  affine_per_s.swap(affine_other_);
}

namespace {

void splat_slab(const GridShape& shape, const Particles& particles, int slab, MacGrid& u, MacGrid& weight) {
  const std::size_t layer = static_cast<std::size_t>(shape.nx) * shape.ny;
  const std::size_t first = particles.begin[layer * static_cast<std::size_t>(slab * kSlab)],
                    last = particles.begin[layer * static_cast<std::size_t>(std::min((slab + 1) * kSlab, shape.nz))];
  const double h = shape.cell_m;
  for (int axis = 0; axis < 3; ++axis) {
    double* const momentum = u[axis].data().data();
    double* const sum = weight[axis].data().data();
    for (std::size_t p = first; p < last; ++p) {
      const Corner c(u[axis], axis, particles.x_m[p] / h);
      const auto row = particles.affine_per_s[p].row(axis);
      const double gx = h * static_cast<double>(row[0]), gy = h * static_cast<double>(row[1]),
                   gz = h * static_cast<double>(row[2]);
      const double at_base = static_cast<double>(particles.v_m_s[p][axis]) - c.fx * gx - c.fy * gy - c.fz * gz;
      const auto put = [&](std::size_t offset, double w, double value) {
        momentum[c.base + offset] += w * value;
        sum[c.base + offset] += w;
      };
      const double x0 = 1.0 - c.fx, y0 = 1.0 - c.fy, z0 = 1.0 - c.fz;
      put(0, x0 * y0 * z0, at_base);
      put(c.dx, c.fx * y0 * z0, at_base + gx);
      put(c.dy, x0 * c.fy * z0, at_base + gy);
      put(c.dx + c.dy, c.fx * c.fy * z0, at_base + gx + gy);
      put(c.dz, x0 * y0 * c.fz, at_base + gz);
      put(c.dx + c.dz, c.fx * y0 * c.fz, at_base + gx + gz);
      put(c.dy + c.dz, x0 * c.fy * c.fz, at_base + gy + gz);
      put(c.dx + c.dy + c.dz, c.fx * c.fy * c.fz, at_base + gx + gy + gz);
    }
  }
}

}  // namespace

void particles_to_faces(const GridShape& shape, const Particles& particles, MacGrid& u, MacGrid& weight) {
  for (int axis = 0; axis < 3; ++axis) {
    std::fill(u[axis].data().begin(), u[axis].data().end(), 0.0);
    std::fill(weight[axis].data().begin(), weight[axis].data().end(), 0.0);
  }
  // A particle reaches one layer of faces beyond its own cell: slabs of one parity share none.
  const int n_slabs = (shape.nz + kSlab - 1) / kSlab;
  for (int parity = 0; parity < 2; ++parity)
    parallel_for(static_cast<std::size_t>((n_slabs - parity + 1) / 2), 1, [&](std::size_t s, std::size_t) {
      splat_slab(shape, particles, 2 * static_cast<int>(s) + parity, u, weight);
    });
  for (int axis = 0; axis < 3; ++axis) {
    Field &momentum = u[axis], &sum = weight[axis];
    parallel_for(momentum.size(), kGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t f = first; f < last; ++f) momentum[f] = sum[f] > 1e-9 ? momentum[f] / sum[f] : 0.0;
    });
  }
}

namespace {

/// Value and slope of one component; with flip_share the particle keeps its own and takes the change.
void take_component(const GridShape& shape, const ParticleUpdate& update, int axis, const Vector3d& g,
                    Particles& particles, std::size_t p) {
  const Corner c(update.u[axis], axis, g);
  const double* const f = update.u[axis].data().data() + c.base;
  const double f000 = f[0], f100 = f[c.dx], f010 = f[c.dy], f110 = f[c.dx + c.dy], f001 = f[c.dz],
               f101 = f[c.dx + c.dz], f011 = f[c.dy + c.dz], f111 = f[c.dx + c.dy + c.dz];
  const double a00 = f000 + c.fx * (f100 - f000), a10 = f010 + c.fx * (f110 - f010), a01 = f001 + c.fx * (f101 - f001),
               a11 = f011 + c.fx * (f111 - f011);
  const double b0 = a00 + c.fy * (a10 - a00), b1 = a01 + c.fy * (a11 - a01);
  const double y0 = 1.0 - c.fy, z0 = 1.0 - c.fz;
  const double slope_x =
      z0 * (y0 * (f100 - f000) + c.fy * (f110 - f010)) + c.fz * (y0 * (f101 - f001) + c.fy * (f111 - f011));
  const double slope_y = z0 * (a10 - a00) + c.fz * (a11 - a01);
  const double slope_z = b1 - b0;
  const double keep = 1.0 - update.flip_share, per = keep / shape.cell_m;
  double value = b0 + c.fz * (b1 - b0);
  if (update.flip_share > 0.0) {
    const double moved = trilinear((*update.change)[axis], g.x() - (axis == 0 ? 0.0 : 0.5),
                                   g.y() - (axis == 1 ? 0.0 : 0.5), g.z() - (axis == 2 ? 0.0 : 0.5));
    value = keep * value + update.flip_share * (static_cast<double>(particles.v_m_s[p][axis]) + moved);
  }
  particles.v_m_s[p][axis] = static_cast<float>(value);
  particles.affine_per_s[p].row(axis) = Eigen::RowVector3f(
      static_cast<float>(per * slope_x), static_cast<float>(per * slope_y), static_cast<float>(per * slope_z));
}

std::size_t cell_of(const GridShape& shape, const Vector3d& g) {
  const auto held = [](double value, int n) { return std::clamp(static_cast<int>(value), 0, n - 1); };
  return shape.index(held(g.x(), shape.nx), held(g.y(), shape.ny), held(g.z(), shape.nz));
}

}  // namespace

void faces_to_particles(const GridShape& shape, const ParticleUpdate& update, Particles& particles) {
  parallel_for(particles.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const Vector3d g = particles.x_m[p] / shape.cell_m;
      if (update.at_liquid[cell_of(shape, g)] == 0) {
        particles.v_m_s[p] += update.kick_m_s;
        continue;
      }
      for (int axis = 0; axis < 3; ++axis) take_component(shape, update, axis, g, particles, p);
    }
  });
}

void advect_particles(const GridShape& shape, const MacGrid& u, const Grid3<std::uint8_t>& at_liquid, double step_s,
                      Particles& particles) {
  const double h = shape.cell_m;
  parallel_for(particles.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      Vector3d& x = particles.x_m[p];
      if (at_liquid[cell_of(shape, x / h)] == 0) {
        x += step_s * particles.v_m_s[p].cast<double>();
        continue;
      }
      const Vector3d k1 = velocity_at(u, x, h);
      const Vector3d k2 = velocity_at(u, x + 0.5 * step_s * k1, h);
      const Vector3d k3 = velocity_at(u, x + 0.75 * step_s * k2, h);
      x += step_s / 9.0 * (2.0 * k1 + 3.0 * k2 + 4.0 * k3);
    }
  });
}

}  // namespace klang::liquid
