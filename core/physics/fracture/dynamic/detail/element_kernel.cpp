#include "core/physics/fracture/dynamic/detail/element_kernel.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "core/foundation/base/vector_clones.hpp"

namespace klang::fracture::detail {
namespace {

// may_alias: blocks are arrays of double.
using Vector = double __attribute__((vector_size(kLanes * sizeof(double)), may_alias));
using Four = double __attribute__((vector_size(4 * sizeof(double)), may_alias));
using Lane = double[kLanes];

struct Work {
  Vector x[12], f[9], strain[6], elastic[6], flow[6], rate[6], slope[9];
};

inline __attribute__((always_inline)) const Vector& as_vector(const Lane& lanes) {
  return *reinterpret_cast<const Vector*>(&lanes);
}
inline __attribute__((always_inline)) Vector& as_vector(Lane& lanes) { return *reinterpret_cast<Vector*>(&lanes); }

inline __attribute__((always_inline)) void root(Vector& values) {
  Eigen::Map<Eigen::Array<double, kLanes, 1>, Eigen::Aligned64> map(reinterpret_cast<double*>(&values));
  map = map.sqrt();
}

inline __attribute__((always_inline)) void gather(const ElementBlock& b, const double* values, Vector* out) {
  for (int k = 0; k < 4; ++k) {
    const int* node = b.node[k];
    for (int axis = 0; axis < 3; ++axis) {
      const double* at = values + axis;
      out[3 * k + axis] = Vector{at[3 * node[0]], at[3 * node[1]], at[3 * node[2]], at[3 * node[3]],
                                 at[3 * node[4]], at[3 * node[5]], at[3 * node[6]], at[3 * node[7]]};
    }
  }
}

/// Differences to corner 0 times the gradients.
inline __attribute__((always_inline)) void gradient(const ElementBlock& b, const Vector* x, Vector* f) {
  for (int r = 0; r < 3; ++r) {
    const Vector one = x[3 + r] - x[r], two = x[6 + r] - x[r], three = x[9 + r] - x[r];
    for (int c = 0; c < 3; ++c)
      f[3 * r + c] = one * as_vector(b.beta[c]) + two * as_vector(b.beta[3 + c]) + three * as_vector(b.beta[6 + c]);
  }
}

inline __attribute__((always_inline)) void square(const Vector* a, Vector& out) {
  out = a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + 2.0 * (a[3] * a[3] + a[4] * a[4] + a[5] * a[5]);
}

/// D02 (3)-(5), as plastic_update(), for all lanes.
inline __attribute__((always_inline)) void flow(ElementBlock& b, const KernelConstants& k, Work& w) {
  for (int i = 0; i < 6; ++i) w.elastic[i] = w.strain[i] - as_vector(b.plastic[i]);
  const Vector zero = {}, mean = (w.elastic[0] + w.elastic[1] + w.elastic[2]) / 3.0;
  for (int i = 0; i < 3; ++i) w.flow[i] = w.elastic[i] - mean;
  for (int i = 3; i < 6; ++i) w.flow[i] = w.elastic[i];
  Vector norm, size;
  square(w.flow, norm);
  root(norm);
  const Vector over = norm > k.gamma1 ? (norm - k.gamma1) / norm : zero;
  for (int i = 0; i < 6; ++i) w.flow[i] = as_vector(b.plastic[i]) + over * w.flow[i];
  square(w.flow, size);
  root(size);
  const Vector cut = size > k.gamma2 ? k.gamma2 / size : zero + 1.0;
  for (int i = 0; i < 6; ++i) {
    const Vector now = cut * w.flow[i];
    w.flow[i] = now - as_vector(b.plastic[i]);
    as_vector(b.plastic[i]) = now;
    w.elastic[i] = w.strain[i] - now;
  }
}

/// Rows x, y, z of all lanes to one four of each, a stride apart.
inline __attribute__((always_inline)) void put(const Vector* rows, double* out, int stride) {
  const Vector zero = {};
  const auto to = [&](int place, const Vector& pair) {
    *reinterpret_cast<Four*>(out + place * stride) = __builtin_shufflevector(pair, pair, 0, 1, 2, 3);
    *reinterpret_cast<Four*>(out + (place + 1) * stride) = __builtin_shufflevector(pair, pair, 4, 5, 6, 7);
  };
  const Vector even_xy = __builtin_shufflevector(rows[0], rows[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Vector even_z = __builtin_shufflevector(rows[2], zero, 0, 8, 2, 10, 4, 12, 6, 14);
  const Vector odd_xy = __builtin_shufflevector(rows[0], rows[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Vector odd_z = __builtin_shufflevector(rows[2], zero, 1, 9, 3, 11, 5, 13, 7, 15);
  to(0, __builtin_shufflevector(even_xy, even_z, 0, 1, 8, 9, 2, 3, 10, 11));
  to(2, __builtin_shufflevector(even_xy, even_z, 4, 5, 12, 13, 6, 7, 14, 15));
  to(4, __builtin_shufflevector(odd_xy, odd_z, 0, 1, 8, 9, 2, 3, 10, 11));
  to(6, __builtin_shufflevector(odd_xy, odd_z, 4, 5, 12, 13, 6, 7, 14, 15));
}

/// -V F S grad N of corners 1 to 3, S = (lambda tr(e) I + 2 mu e)/2.
inline __attribute__((always_inline)) void push(const ElementBlock& b, const Lane& volume_m3, const Vector* f,
                                                const Vector* e, double lambda, double mu, double* out, int stride) {
  const Vector p = 0.5 * lambda * (e[0] + e[1] + e[2]);
  const Vector xx = mu * e[0] + p, yy = mu * e[1] + p, zz = mu * e[2] + p;
  const Vector xy = mu * e[3], yz = mu * e[4], zx = mu * e[5], minus = -as_vector(volume_m3);
  Vector force[9];
  for (int r = 0; r < 3; ++r) {
    const Vector f0 = f[3 * r], f1 = f[3 * r + 1], f2 = f[3 * r + 2];
    const Vector p0 = minus * (f0 * xx + f1 * xy + f2 * zx), p1 = minus * (f0 * xy + f1 * yy + f2 * yz),
                 p2 = minus * (f0 * zx + f1 * yz + f2 * zz);
    for (int c = 0; c < 3; ++c)
      force[3 * c + r] =
          p0 * as_vector(b.beta[3 * c]) + p1 * as_vector(b.beta[3 * c + 1]) + p2 * as_vector(b.beta[3 * c + 2]);
  }
  for (int c = 0; c < 3; ++c) put(force + 3 * c, out + c * kLanes * stride, stride);
}

inline __attribute__((always_inline)) void strain_of(const Vector* f, Vector* strain) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    strain[i] = f[i] * f[i] + f[3 + i] * f[3 + i] + f[6 + i] * f[6 + i] - 1.0;
    strain[3 + i] = f[i] * f[j] + f[3 + i] * f[3 + j] + f[6 + i] * f[6 + j];
  }
}

/// F^T G + G^T F.
inline __attribute__((always_inline)) void rate_of(const Vector* f, const Vector* g, Vector* rate) {
  for (int i = 0; i < 3; ++i)
    for (const int j : {i, (i + 1) % 3}) {
      Vector sum = {};
      for (int r = 0; r < 9; r += 3) sum += f[r + i] * g[r + j] + g[r + i] * f[r + j];
      rate[i == j ? i : 3 + i] = sum;
    }
}

template <bool kFlows, bool kDamped>
inline __attribute__((always_inline)) void one_block(ElementBlock& b, const double* place, const double* velocity,
                                                     const KernelConstants& k, const KernelResults& out, std::size_t i,
                                                     Work& w) {
  BlockSums& sums = out.sums[i];
  const Vector volume_m3 = as_vector(b.volume_m3), zero = {};
  gather(b, place, w.x);
  gradient(b, w.x, w.f);
  strain_of(w.f, w.strain);
  const Vector* f = w.f;
  const Vector det =
      f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) + f[2] * (f[3] * f[7] - f[4] * f[6]);
  const Vector seen = det == det ? det : zero - 1e300;
  as_vector(sums.least_det) = volume_m3 > 0.0 ? seen : zero + 1e300;
  Vector sq;
  square(w.strain, sq);
  as_vector(sums.largest_strain_sq) = volume_m3 > 0.0 && sq > 0.0 ? sq : zero;
  if constexpr (kFlows) {
    flow(b, k, w);
  } else {
    for (int c = 0; c < 6; ++c) w.elastic[c] = w.strain[c];
  }
  const Vector trace = w.elastic[0] + w.elastic[1] + w.elastic[2];
  square(w.elastic, sq);
  as_vector(sums.elastic_j) = volume_m3 * (0.125 * k.lambda_pa * trace * trace + 0.25 * k.mu_pa * sq);
  as_vector(sums.dissipated_j) = zero;
  if constexpr (kFlows) {  // the flow has no trace; mean stress of both ends of the step
    Vector mean[6];
    for (int c = 0; c < 6; ++c) {
      mean[c] = (c < 3 ? 1.0 : 2.0) * (w.elastic[c] + as_vector(b.elastic[c])) * w.flow[c];
      as_vector(b.elastic[c]) = w.elastic[c];
    }
    as_vector(sums.dissipated_j) =
        volume_m3 * 0.25 * k.mu_pa * (mean[0] + mean[1] + mean[2] + mean[3] + mean[4] + mean[5]);
  }
  if (out.stress_sq != nullptr) {
    const Vector stress_sq = k.mu_pa * k.mu_pa * sq + (0.75 * k.lambda_pa + k.mu_pa) * k.lambda_pa * trace * trace;
    std::copy_n(reinterpret_cast<const double*>(&stress_sq), kLanes, out.stress_sq + i * kLanes);
  }
  constexpr int kStride = kDamped ? 8 : 4;
  double* forces = out.forces + i * 3 * kLanes * kStride;
  push(b, b.volume_m3, w.f, w.elastic, k.lambda_pa, k.mu_pa, forces, kStride);
  if constexpr (kDamped) {
    gather(b, velocity, w.x);
    gradient(b, w.x, w.slope);
    rate_of(w.f, w.slope, w.rate);
    push(b, b.damped_m3, w.f, w.rate, k.phi_pa_s, k.psi_pa_s, forces + 4, kStride);
  }
}

#define KLANG_KERNEL_ARGUMENTS                                                                                       \
  ElementBlock *blocks, std::size_t n_blocks, const double *place, const double *velocity, const KernelConstants &k, \
      const KernelResults &out

template <bool kFlows, bool kDamped>
inline __attribute__((always_inline)) void all_blocks(KLANG_KERNEL_ARGUMENTS) {
  Work w;
  for (std::size_t i = 0; i < n_blocks; ++i) one_block<kFlows, kDamped>(blocks[i], place, velocity, k, out, i, w);
}

KLANG_CLONES void plain(KLANG_KERNEL_ARGUMENTS) { all_blocks<false, false>(blocks, n_blocks, place, velocity, k, out); }
KLANG_CLONES void damped(KLANG_KERNEL_ARGUMENTS) { all_blocks<false, true>(blocks, n_blocks, place, velocity, k, out); }
KLANG_CLONES void flowing(KLANG_KERNEL_ARGUMENTS) {
  all_blocks<true, false>(blocks, n_blocks, place, velocity, k, out);
}
KLANG_CLONES void flowing_damped(KLANG_KERNEL_ARGUMENTS) {
  all_blocks<true, true>(blocks, n_blocks, place, velocity, k, out);
}

}  // namespace

void element_forces(KLANG_KERNEL_ARGUMENTS) {
  const bool flows = k.gamma2 > 0.0, is_damped = out.is_damped;
  (flows ? (is_damped ? flowing_damped : flowing) : (is_damped ? damped : plain))(blocks, n_blocks, place, velocity, k,
                                                                                  out);
}

KernelSums sum_of(const std::vector<BlockSums>& blocks) {
  Lane elastic_j = {}, dissipated_j = {};
  KernelSums sums;
  sums.least_det = 1e300;
  for (const BlockSums& block : blocks)
    for (int l = 0; l < kLanes; ++l) {
      elastic_j[l] += block.elastic_j[l];
      dissipated_j[l] += block.dissipated_j[l];
      sums.least_det = std::min(sums.least_det, block.least_det[l]);
      sums.largest_strain_sq = std::max(sums.largest_strain_sq, block.largest_strain_sq[l]);
    }
  for (int l = 0; l < kLanes; ++l) {
    sums.elastic_j += elastic_j[l];
    sums.dissipated_j += dissipated_j[l];
  }
  return sums;
}

void NodeTerms::read(const CrackMesh& mesh) {
  first.assign(1, 0);
  terms.clear();
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    for (const int element : mesh.star(node)) {
      const std::array<int, 4> nodes = mesh.nodes_of(element);
      const auto corner = static_cast<int>(std::find(nodes.begin(), nodes.end(), node) - nodes.begin());
      const int at = 3 * kLanes * (element / kLanes) + CornerForces::place_of(element % kLanes);
      if (corner > 0) {
        terms.push_back(2 * (at + kLanes * (corner - 1)));
      } else {
        for (int c = 0; c < 3; ++c) terms.push_back(2 * (at + kLanes * c) + 1);
      }
    }
    first.push_back(static_cast<int>(terms.size()));
  }
}

namespace {

template <bool kDamped>
inline __attribute__((always_inline)) void gather_nodes(const NodeTerms& nodes, std::size_t begin, std::size_t end,
                                                        const double* forces, double* elastic, double* viscous) {
  constexpr Four kSign[2] = {{1.0, 1.0, 1.0, 1.0}, {-1.0, -1.0, -1.0, -1.0}};
  constexpr int kStride = kDamped ? 2 : 1;
  const auto* values = reinterpret_cast<const Four*>(forces);
  for (std::size_t node = begin; node < end; ++node) {
    Four sum = {}, damping = {};
    for (int k = nodes.first[node]; k < nodes.first[node + 1]; ++k) {
      const int term = nodes.terms[static_cast<std::size_t>(k)];
      const Four* at = values + kStride * (term >> 1);
      sum += kSign[term & 1] * at[0];
      if constexpr (kDamped) damping += kSign[term & 1] * at[1];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      elastic[3 * node + axis] = sum[axis];
      if constexpr (kDamped) viscous[3 * node + axis] = damping[axis];
    }
  }
}

#define KLANG_GATHER_ARGUMENTS \
  const NodeTerms &nodes, std::size_t begin, std::size_t end, const double *forces, double *elastic, double *viscous

KLANG_CLONES void gather_plain(KLANG_GATHER_ARGUMENTS) {
  gather_nodes<false>(nodes, begin, end, forces, elastic, viscous);
}
KLANG_CLONES void gather_damped(KLANG_GATHER_ARGUMENTS) {
  gather_nodes<true>(nodes, begin, end, forces, elastic, viscous);
}

}  // namespace

void gather_forces(const NodeTerms& nodes, std::size_t begin, std::size_t end, const CornerForces& forces,
                   double* elastic, double* viscous) {
  (forces.is_damped() ? gather_damped : gather_plain)(nodes, begin, end, forces.begin(), elastic, viscous);
}

}  // namespace klang::fracture::detail
