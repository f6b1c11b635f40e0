#include "core/physics/liquid/particles.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/liquid/detail/particle_kernels.hpp"

namespace klang::liquid {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::size_t kGrain = 4096;
constexpr int kSlab = 4;  // layers of cells

}  // namespace

void Particles::add(const Vector3d& x, const Vector3f& v, const Matrix3f& c) {
  x_m.push_back(x);
  v_m_s.push_back(v);
  affine_per_s.push_back(c);
  phi_m.push_back(std::numeric_limits<double>::quiet_NaN());
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
  phi_other_.resize(n_kept);
  parallel_for(n_kept, kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t q = first; q < last; ++q) {
      const std::size_t p = source[q];
      x_other_[q] = x_m[p];
      v_other_[q] = v_m_s[p];
      affine_other_[q] = affine_per_s[p];
      phi_other_[q] = phi_m[p];
    }
  });
  x_m.swap(x_other_);
  v_m_s.swap(v_other_);
  affine_per_s.swap(affine_other_);
  phi_m.swap(phi_other_);
}

namespace {

using Sums = std::array<std::vector<double>, 3>;  // per face: momentum and weight

void splat_slab(const GridShape& shape, const Particles& particles, int slab, const MacGrid& u, Sums& sums) {
  const std::size_t layer = static_cast<std::size_t>(shape.nx) * shape.ny;
  const std::size_t first = particles.begin[layer * static_cast<std::size_t>(slab * kSlab)],
                    last = particles.begin[layer * static_cast<std::size_t>(std::min((slab + 1) * kSlab, shape.nz))];
  const double h = shape.cell_m;
  kernels::Block3 at{};
  kernels::Brought brought{};
  for (std::size_t begin = first; begin < last; begin += kernels::kBlock) {
    const int n = static_cast<int>(std::min<std::size_t>(last - begin, kernels::kBlock));
    for (int b = 0; b < n; ++b) {
      const Vector3d g = particles.x_m[begin + static_cast<std::size_t>(b)] / h;
      at.x[b] = g.x();
      at.y[b] = g.y();
      at.z[b] = g.z();
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int b = 0; b < n; ++b) {
        const std::size_t p = begin + static_cast<std::size_t>(b);
        const Matrix3f& affine = particles.affine_per_s[p];
        brought.value[b] = static_cast<double>(particles.v_m_s[p][axis]);
        brought.slope.x[b] = h * static_cast<double>(affine(axis, 0));
        brought.slope.y[b] = h * static_cast<double>(affine(axis, 1));
        brought.slope.z[b] = h * static_cast<double>(affine(axis, 2));
      }
      kernels::splat(kernels::FaceView(u, axis), at, n, brought, sums[static_cast<std::size_t>(axis)].data());
    }
  }
}

}  // namespace

void particles_to_faces(const GridShape& shape, const Particles& particles, MacGrid& u, MacGrid& weight) {
  Sums sums;
  for (int axis = 0; axis < 3; ++axis) sums[static_cast<std::size_t>(axis)].assign(2 * u[axis].size(), 0.0);
  // A particle reaches one layer of faces beyond its own cell: slabs of one parity share none.
  const int n_slabs = (shape.nz + kSlab - 1) / kSlab;
  for (int parity = 0; parity < 2; ++parity)
    parallel_for(static_cast<std::size_t>((n_slabs - parity + 1) / 2), 1, [&](std::size_t s, std::size_t) {
      splat_slab(shape, particles, 2 * static_cast<int>(s) + parity, u, sums);
    });
  for (int axis = 0; axis < 3; ++axis) {
    const double* const sum = sums[static_cast<std::size_t>(axis)].data();
    parallel_for(u[axis].size(), kGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t f = first; f < last; ++f) {
        weight[axis][f] = sum[2 * f + 1];
        u[axis][f] = sum[2 * f + 1] > 1e-9 ? sum[2 * f] / sum[2 * f + 1] : 0.0;
      }
    });
  }
}

namespace {

using kernels::Block3;
using kernels::kBlock;

std::size_t cell_of(const GridShape& shape, const Vector3d& g) {
  const auto held = [](double value, int n) { return std::clamp(static_cast<int>(value), 0, n - 1); };
  return shape.index(held(g.x(), shape.nx), held(g.y(), shape.ny), held(g.z(), shape.nz));
}

/// Particles first, first + 1, ... of a block, and which of them are at the liquid.
struct Gathered {
  Block3 at;  // [cells]
  std::array<bool, kBlock> wet{};
  std::size_t first;
  int n;
  bool any_wet = false;
  Gathered(const GridShape& shape, const Grid3<std::uint8_t>& at_liquid, const Particles& particles, std::size_t begin,
           std::size_t end)
      : first(begin), n(static_cast<int>(std::min<std::size_t>(end - begin, kBlock))) {
    for (int b = 0; b < kBlock; ++b) {
      const Vector3d g = particles.x_m[first + static_cast<std::size_t>(std::min(b, n - 1))] / shape.cell_m;
      at.x[b] = g.x();
      at.y[b] = g.y();
      at.z[b] = g.z();
      if (b >= n) continue;
      wet[static_cast<std::size_t>(b)] = at_liquid[cell_of(shape, g)] != 0;
      any_wet = any_wet || wet[static_cast<std::size_t>(b)];
    }
  }
};

void velocities(const MacGrid& u, const Block3& at, Block3& velocity) {
  for (int axis = 0; axis < 3; ++axis) kernels::interpolate(kernels::FaceView(u, axis), at, velocity[axis]);
}

/// Moves a block's particles; k1 is their velocity, of those off the liquid nothing.
void move_block(const GridShape& shape, const MacGrid& u, double step_s, const Gathered& block, const Block3& k1,
                Particles& particles) {
  Block3 k2{}, k3{}, way;
  if (block.any_wet) {
    const double half = 0.5 * step_s / shape.cell_m, three_quarters = 0.75 * step_s / shape.cell_m;
    for (int axis = 0; axis < 3; ++axis)
      for (int b = 0; b < kBlock; ++b) way[axis][b] = block.at[axis][b] + half * k1[axis][b];
    velocities(u, way, k2);
    for (int axis = 0; axis < 3; ++axis)
      for (int b = 0; b < kBlock; ++b) way[axis][b] = block.at[axis][b] + three_quarters * k2[axis][b];
    velocities(u, way, k3);
  }
  for (int b = 0; b < block.n; ++b) {
    const std::size_t p = block.first + static_cast<std::size_t>(b);
    Vector3d& x = particles.x_m[p];
    if (!block.wet[static_cast<std::size_t>(b)]) {
      x += step_s * particles.v_m_s[p].cast<double>();
      continue;
    }
    for (int axis = 0; axis < 3; ++axis)
      x[axis] += step_s / 9.0 * (2.0 * k1[axis][b] + 3.0 * k2[axis][b] + 4.0 * k3[axis][b]);
  }
}

/// Velocity and slopes of a block's particles from the faces. @param velocity  becomes that of the faces
void update_block(const GridShape& shape, const ParticleUpdate& update, const Gathered& block, Block3& velocity,
                  Particles& particles) {
  Block3 slope, moved{};
  const double keep = 1.0 - update.flip_share, per = keep / shape.cell_m;
  if (block.any_wet && update.flip_share > 0.0) velocities(*update.change, block.at, moved);
  for (int axis = 0; axis < 3; ++axis) {
    if (block.any_wet)
      kernels::interpolate_with_slope(kernels::FaceView(update.u, axis), block.at, velocity[axis], slope);
    for (int b = 0; b < block.n; ++b) {
      if (!block.wet[static_cast<std::size_t>(b)]) continue;
      const std::size_t p = block.first + static_cast<std::size_t>(b);
      double value = velocity[axis][b];
      if (update.flip_share > 0.0)
        value = keep * value + update.flip_share * (static_cast<double>(particles.v_m_s[p][axis]) + moved[axis][b]);
      particles.v_m_s[p][axis] = static_cast<float>(value);
      Matrix3f& affine = particles.affine_per_s[p];
      affine(axis, 0) = static_cast<float>(per * slope.x[b]);
      affine(axis, 1) = static_cast<float>(per * slope.y[b]);
      affine(axis, 2) = static_cast<float>(per * slope.z[b]);
    }
  }
  for (int b = 0; b < block.n; ++b)
    if (!block.wet[static_cast<std::size_t>(b)])
      particles.v_m_s[block.first + static_cast<std::size_t>(b)] += update.kick_m_s;
}

template <class Body>
void for_blocks(std::size_t begin, std::size_t end, const Body& body) {
  parallel_for(end - begin, kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = begin + first; p < begin + last; p += kBlock) body(p, begin + last);
  });
}

}  // namespace

void faces_to_particles(const GridShape& shape, const ParticleUpdate& update, Particles& particles) {
  for_blocks(0, particles.size(), [&](std::size_t first, std::size_t last) {
    const Gathered block(shape, update.at_liquid, particles, first, last);
    Block3 velocity;
    update_block(shape, update, block, velocity, particles);
  });
}

void move_particles(const GridShape& shape, const ParticleUpdate& update, double step_s, std::size_t begin,
                    std::size_t end, Particles& particles) {
  for_blocks(begin, end, [&](std::size_t first, std::size_t last) {
    const Gathered block(shape, update.at_liquid, particles, first, last);
    Block3 velocity{};
    update_block(shape, update, block, velocity, particles);
    move_block(shape, update.u, step_s, block, velocity, particles);
  });
}

void advect_particles(const GridShape& shape, const MacGrid& u, const Grid3<std::uint8_t>& at_liquid, double step_s,
                      Particles& particles) {
  for_blocks(0, particles.size(), [&](std::size_t first, std::size_t last) {
    const Gathered block(shape, at_liquid, particles, first, last);
    Block3 velocity{};
    if (block.any_wet) velocities(u, block.at, velocity);
    move_block(shape, u, step_s, block, velocity, particles);
  });
}

}  // namespace klang::liquid
