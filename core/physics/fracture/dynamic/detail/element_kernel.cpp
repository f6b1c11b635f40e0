#include "core/physics/fracture/dynamic/detail/element_kernel.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "core/foundation/base/vector_clones.hpp"

#define KLANG_LANES for (int l = 0; l < kLanes; ++l)

namespace klang::fracture::detail {
namespace {

using Lane = double[kLanes];

struct alignas(64) Work {
  Lane x[12], v[12], f[9], strain[6], elastic[6], flow[6], norm, size, mean[6], stress_sq, force[9], damping[9];
  Lane energy, dissipated, least_det, largest;
};

inline __attribute__((always_inline)) void root(Lane& values) {
  Eigen::Map<Eigen::Array<double, kLanes, 1>, Eigen::Aligned64> map(values);
  map = map.sqrt();
}

inline __attribute__((always_inline)) void gather(const ElementBlock& b, const double* values, Lane* out) {
  for (int k = 0; k < 4; ++k) KLANG_LANES {
      const double* at = values + 3 * b.node[k][l];
      out[3 * k][l] = at[0];
      out[3 * k + 1][l] = at[1];
      out[3 * k + 2][l] = at[2];
    }
}

/// Differences to corner 0 times the gradients.
inline __attribute__((always_inline)) void gradient(const ElementBlock& b, const Lane* x, Lane* f) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) KLANG_LANES {
        f[3 * r + c][l] = (x[3 + r][l] - x[r][l]) * b.beta[c][l] + (x[6 + r][l] - x[r][l]) * b.beta[3 + c][l] +
                          (x[9 + r][l] - x[r][l]) * b.beta[6 + c][l];
      }
}

inline __attribute__((always_inline)) double square(const Lane* a, int l) {
  return a[0][l] * a[0][l] + a[1][l] * a[1][l] + a[2][l] * a[2][l] +
         2.0 * (a[3][l] * a[3][l] + a[4][l] * a[4][l] + a[5][l] * a[5][l]);
}

/// D02 (3)-(5), as plastic_update(), for all lanes.
inline __attribute__((always_inline)) void flow(ElementBlock& b, const KernelConstants& k, Work& w) {
  for (int i = 0; i < 6; ++i) KLANG_LANES w.elastic[i][l] = w.strain[i][l] - b.plastic[i][l];
  KLANG_LANES {
    const double mean = (w.elastic[0][l] + w.elastic[1][l] + w.elastic[2][l]) / 3.0;
    for (int i = 0; i < 3; ++i) w.flow[i][l] = w.elastic[i][l] - mean;
    for (int i = 3; i < 6; ++i) w.flow[i][l] = w.elastic[i][l];
    w.norm[l] = square(w.flow, l);
  }
  root(w.norm);
  KLANG_LANES {
    const double over = w.norm[l] > k.gamma1 ? (w.norm[l] - k.gamma1) / w.norm[l] : 0.0;
    for (int i = 0; i < 6; ++i) w.flow[i][l] = b.plastic[i][l] + over * w.flow[i][l];
    w.size[l] = square(w.flow, l);
  }
  root(w.size);
  KLANG_LANES {
    const double cut = w.size[l] > k.gamma2 ? k.gamma2 / w.size[l] : 1.0;
    for (int i = 0; i < 6; ++i) {
      const double now = cut * w.flow[i][l];
      w.flow[i][l] = now - b.plastic[i][l];
      b.plastic[i][l] = now;
      w.elastic[i][l] = w.strain[i][l] - now;
    }
  }
}

/// -V F S grad N of corners 1 to 3, S = (lambda tr(e) I + 2 mu e)/2.
inline __attribute__((always_inline)) void push(const ElementBlock& b, const Lane& volume_m3, const Lane* f,
                                                const Lane* e, double lambda, double mu, Lane* out) {
  KLANG_LANES {
    const double p = 0.5 * lambda * (e[0][l] + e[1][l] + e[2][l]);
    const double xx = mu * e[0][l] + p, yy = mu * e[1][l] + p, zz = mu * e[2][l] + p;
    const double xy = mu * e[3][l], yz = mu * e[4][l], zx = mu * e[5][l], minus = -volume_m3[l];
    for (int r = 0; r < 3; ++r) {
      const double f0 = f[3 * r][l], f1 = f[3 * r + 1][l], f2 = f[3 * r + 2][l];
      const double p0 = minus * (f0 * xx + f1 * xy + f2 * zx), p1 = minus * (f0 * xy + f1 * yy + f2 * yz),
                   p2 = minus * (f0 * zx + f1 * yz + f2 * zz);
      for (int c = 0; c < 3; ++c)
        out[3 * c + r][l] = p0 * b.beta[3 * c][l] + p1 * b.beta[3 * c + 1][l] + p2 * b.beta[3 * c + 2][l];
    }
  }
}

inline __attribute__((always_inline)) void scatter(const ElementBlock& b, const Lane* force, double* out) {
  KLANG_LANES {
    double* at0 = out + 3 * b.node[0][l];
    for (int c = 0; c < 3; ++c) {
      double* at = out + 3 * b.node[c + 1][l];
      for (int r = 0; r < 3; ++r) {
        at[r] += force[3 * c + r][l];
        at0[r] -= force[3 * c + r][l];
      }
    }
  }
}

template <bool kFlows, bool kDamped>
inline __attribute__((always_inline)) void one_block(ElementBlock& b, const double* place, const double* velocity,
                                                     const KernelConstants& k, double* elastic, double* viscous,
                                                     double* stress_sq, Work& w) {
  gather(b, place, w.x);
  gradient(b, w.x, w.f);
  KLANG_LANES {
    const double a = w.f[0][l], c = w.f[1][l], d = w.f[2][l], g = w.f[3][l], h = w.f[4][l], i = w.f[5][l],
                 m = w.f[6][l], n = w.f[7][l], o = w.f[8][l];
    w.strain[0][l] = a * a + g * g + m * m - 1.0;
    w.strain[1][l] = c * c + h * h + n * n - 1.0;
    w.strain[2][l] = d * d + i * i + o * o - 1.0;
    w.strain[3][l] = a * c + g * h + m * n;
    w.strain[4][l] = c * d + h * i + n * o;
    w.strain[5][l] = d * a + i * g + o * m;
    w.norm[l] = a * (h * o - i * n) - c * (g * o - i * m) + d * (g * n - h * m);
  }
  KLANG_LANES {
    const double det = w.norm[l], seen = det == det ? det : -1e300;
    w.least_det[l] = b.volume_m3[l] > 0.0 && seen < w.least_det[l] ? seen : w.least_det[l];
    const double sq = square(w.strain, l);
    w.largest[l] = b.volume_m3[l] > 0.0 && sq > w.largest[l] ? sq : w.largest[l];
  }
  if constexpr (kFlows) {
    flow(b, k, w);
  } else {
    for (int i = 0; i < 6; ++i) KLANG_LANES w.elastic[i][l] = w.strain[i][l];
  }
  // One short loop each: what is longer, or writes through a bare pointer, the compiler leaves scalar.
  KLANG_LANES {
    w.size[l] = w.elastic[0][l] + w.elastic[1][l] + w.elastic[2][l];
    w.norm[l] = square(w.elastic, l);
  }
  KLANG_LANES w.energy[l] +=
      b.volume_m3[l] * (0.125 * k.lambda_pa * w.size[l] * w.size[l] + 0.25 * k.mu_pa * w.norm[l]);
  if constexpr (kFlows) {  // the flow has no trace; mean stress of both ends of the step
    for (int i = 0; i < 6; ++i)
      KLANG_LANES w.mean[i][l] = (i < 3 ? 1.0 : 2.0) * (w.elastic[i][l] + b.elastic[i][l]) * w.flow[i][l];
    for (int i = 0; i < 6; ++i) KLANG_LANES b.elastic[i][l] = w.elastic[i][l];
    KLANG_LANES w.dissipated[l] +=
        b.volume_m3[l] * 0.25 * k.mu_pa *
        (w.mean[0][l] + w.mean[1][l] + w.mean[2][l] + w.mean[3][l] + w.mean[4][l] + w.mean[5][l]);
  }
  if (stress_sq != nullptr) {
    KLANG_LANES w.stress_sq[l] =
        k.mu_pa * k.mu_pa * w.norm[l] + (0.75 * k.lambda_pa + k.mu_pa) * k.lambda_pa * w.size[l] * w.size[l];
    std::copy(w.stress_sq, w.stress_sq + kLanes, stress_sq);
  }
  push(b, b.volume_m3, w.f, w.elastic, k.lambda_pa, k.mu_pa, w.force);
  scatter(b, w.force, elastic);
  if constexpr (kDamped) {
    gather(b, velocity, w.v);
    gradient(b, w.v, w.damping);
    KLANG_LANES {
      const auto rate = [&](int i, int j) {
        double sum = 0.0;
        for (int r = 0; r < 9; r += 3) sum += w.f[r + i][l] * w.damping[r + j][l] + w.damping[r + i][l] * w.f[r + j][l];
        return sum;
      };
      w.flow[0][l] = rate(0, 0);
      w.flow[1][l] = rate(1, 1);
      w.flow[2][l] = rate(2, 2);
      w.flow[3][l] = rate(0, 1);
      w.flow[4][l] = rate(1, 2);
      w.flow[5][l] = rate(2, 0);
    }
    push(b, b.damped_m3, w.f, w.flow, k.phi_pa_s, k.psi_pa_s, w.damping);
    scatter(b, w.damping, viscous);
  }
}

template <bool kFlows, bool kDamped>
inline __attribute__((always_inline)) void all_blocks(std::vector<ElementBlock>& blocks, const double* place,
                                                      const double* velocity, const KernelConstants& k, double* elastic,
                                                      double* viscous, double* stress_sq, Work& w) {
  for (std::size_t i = 0; i < blocks.size(); ++i)
    one_block<kFlows, kDamped>(blocks[i], place, velocity, k, elastic, viscous,
                               stress_sq != nullptr ? stress_sq + i * kLanes : nullptr, w);
}

#define KLANG_KERNEL_ARGUMENTS                                                                             \
  std::vector<ElementBlock>&blocks, const double *place, const double *velocity, const KernelConstants &k, \
      double *elastic, double *viscous, double *stress_sq, Work &w

KLANG_CLONES void plain(KLANG_KERNEL_ARGUMENTS) {
  all_blocks<false, false>(blocks, place, velocity, k, elastic, viscous, stress_sq, w);
}
KLANG_CLONES void damped(KLANG_KERNEL_ARGUMENTS) {
  all_blocks<false, true>(blocks, place, velocity, k, elastic, viscous, stress_sq, w);
}
KLANG_CLONES void flowing(KLANG_KERNEL_ARGUMENTS) {
  all_blocks<true, false>(blocks, place, velocity, k, elastic, viscous, stress_sq, w);
}
KLANG_CLONES void flowing_damped(KLANG_KERNEL_ARGUMENTS) {
  all_blocks<true, true>(blocks, place, velocity, k, elastic, viscous, stress_sq, w);
}

}  // namespace

KernelSums element_forces(std::vector<ElementBlock>& blocks, const double* place, const double* velocity,
                          const KernelConstants& k, double* elastic, double* viscous, double* stress_sq) {
  Work w{};
  std::fill(w.least_det, w.least_det + kLanes, 1e300);
  const bool flows = k.gamma2 > 0.0, is_damped = viscous != nullptr;
  (flows ? (is_damped ? flowing_damped : flowing) : (is_damped ? damped : plain))(blocks, place, velocity, k, elastic,
                                                                                  viscous, stress_sq, w);
  KernelSums sums;
  sums.least_det = *std::min_element(w.least_det, w.least_det + kLanes);
  sums.largest_strain_sq = *std::max_element(w.largest, w.largest + kLanes);
  for (int l = 0; l < kLanes; ++l) {
    sums.elastic_j += w.energy[l];
    sums.dissipated_j += w.dissipated[l];
  }
  return sums;
}

}  // namespace klang::fracture::detail
