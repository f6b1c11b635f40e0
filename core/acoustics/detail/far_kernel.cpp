#include "core/acoustics/detail/far_kernel.hpp"

#include <cstdint>
#include <cstring>

#include "core/base/conventions.hpp"

// Sanitizers cannot run before the resolvers that pick a clone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define KLANG_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KLANG_CLONES
#endif
#define KLANG_INLINE inline __attribute__((always_inline))

namespace klang::acoustics::detail {
namespace {

using Vector = double __attribute__((vector_size(kLanes * sizeof(double))));
using Integers = std::int64_t __attribute__((vector_size(kLanes * sizeof(double))));

KLANG_INLINE void load(Vector& value, const double* from) { std::memcpy(&value, from, sizeof value); }
KLANG_INLINE void store(double* to, const Vector& value) { std::memcpy(to, &value, sizeof value); }

/// 1 / sqrt(x) for normal x > 0: a guess from the exponent (3 %) and three Newton steps, 3e-11.
KLANG_INLINE void inverse_root(const Vector& x, Vector& y) {
  Integers bits;
  std::memcpy(&bits, &x, sizeof bits);
  bits = 0x5fe6eb50c7b537a9LL - (bits >> 1);
  std::memcpy(&y, &bits, sizeof y);
  const Vector half = 0.5 * x;
  y *= 1.5 - half * y * y;
  y *= 1.5 - half * y * y;
  y *= 1.5 - half * y * y;
}

/// sin and cos for 0 <= x < 1e6, absolute error 1e-11: reduction by multiples of pi/2, Taylor series beyond.
KLANG_INLINE void sine_cosine(const Vector& x, Vector& sine, Vector& cosine) {
  constexpr double kMagic = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer in the low bits
  const Vector shifted = x * (2.0 / kPi) + kMagic;
  Integers quadrant;
  std::memcpy(&quadrant, &shifted, sizeof quadrant);
  const Vector turns = shifted - kMagic;
  const Vector r = (x - turns * 1.5707963267341256) - turns * 6.077100506506192e-11;
  const Vector r2 = r * r;
  const Vector s =
      r * (1.0 + r2 * (-1.0 / 6 + r2 * (1.0 / 120 + r2 * (-1.0 / 5040 + r2 * (1.0 / 362880 - r2 * (1.0 / 39916800))))));
  const Vector c =
      1.0 + r2 * (-0.5 + r2 * (1.0 / 24 + r2 * (-1.0 / 720 + r2 * (1.0 / 40320 + r2 * (-1.0 / 3628800 + r2 * (1.0 / 479001600))))));
  const Integers odd = -(quadrant & 1);
  Integers sine_bits, cosine_bits;
  std::memcpy(&sine_bits, &s, sizeof s);
  std::memcpy(&cosine_bits, &c, sizeof c);
  const Integers a = (sine_bits & ~odd) | (cosine_bits & odd);
  const Integers b = (cosine_bits & ~odd) | (sine_bits & odd);
  const Integers sine_sign = (quadrant & 2) << 62, cosine_sign = ((quadrant + 1) & 2) << 62;
  const Integers sine_out = a ^ sine_sign, cosine_out = b ^ cosine_sign;
  std::memcpy(&sine, &sine_out, sizeof sine);
  std::memcpy(&cosine, &cosine_out, sizeof cosine);
}

}  // namespace

KLANG_CLONES void far_block(const TriangleColumns& columns, const double* keep, std::size_t first, std::size_t count,
                            const TestTriangle& test, double wavenumber_per_m, double eta_m, FarBlock& block) {
  const double k = wavenumber_per_m;
  const double k_sq = k * k;
  for (std::size_t lane = 0; lane < count; lane += kLanes) {
    const std::size_t j = first + lane;
    Vector kept, weight, n[3];
    load(kept, keep + j);
    load(weight, columns.weights_m2.data() + j);
    weight *= kept * (test.weight_m2 / (4.0 * kPi));
    for (int axis = 0; axis < 3; ++axis) load(n[axis], columns.normals[axis].data() + j);
    const Vector n_n = test.normal[0] * n[0] + test.normal[1] * n[1] + test.normal[2] * n[2];
    const Vector mass = eta_m * k_sq * n_n;
    const Vector aside = 1.0 - kept;  // keeps the distance of a skipped column away from 0
    // Sums over the points: per test point i the values at the column's points are folded into hats at once
    // (hat b at point q is 1/6, plus 1/2 where q = b), then the same over i.
    Vector system_re[3][3], system_im[3][3], source_re[3][3], source_im[3][3];
    Vector all_re{}, all_im{};
    for (int i = 0; i < 3; ++i) {
      for (int q = 0; q < 3; ++q) {
        Vector d[3];
        for (int axis = 0; axis < 3; ++axis) {
          load(d[axis], columns.points_m[q][axis].data() + j);
          d[axis] = test.points_m[i][axis] - d[axis];
        }
        const Vector r_sq = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * kept + aside;
        Vector inverse;
        inverse_root(r_sq, inverse);
        const Vector kr = k * (r_sq * inverse);
        Vector sine, cosine;
        sine_cosine(kr, sine, cosine);
        const Vector scale = weight * inverse;
        const Vector g_re = scale * cosine, g_im = -(scale * sine);  // G
        const Vector inverse_sq = inverse * inverse;
        // (1 + ikR) G / R^2, which n_y.(x - y) makes dG/dn_y and -n_x.(x - y) makes dG/dn_x
        const Vector h_re = (g_re - kr * g_im) * inverse_sq, h_im = (g_im + kr * g_re) * inverse_sq;
        const Vector ny_d = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        const Vector nx_d = test.normal[0] * d[0] + test.normal[1] * d[1] + test.normal[2] * d[2];
        // -dG/dn_y + i eta k^2 n.n G
        system_re[i][q] = -(h_re * ny_d) - mass * g_im;
        system_im[i][q] = -(h_im * ny_d) + mass * g_re;
        // -G + i eta dG/dn_x
        source_re[i][q] = -g_re + eta_m * (h_im * nx_d);
        source_im[i][q] = -g_im - eta_m * (h_re * nx_d);
        all_re += g_re;
        all_im += g_im;
      }
    }
    for (int i = 0; i < 3; ++i) {
      const Vector sum_re = (system_re[i][0] + system_re[i][1] + system_re[i][2]) * (1.0 / 6);
      const Vector sum_im = (system_im[i][0] + system_im[i][1] + system_im[i][2]) * (1.0 / 6);
      for (int q = 0; q < 3; ++q) {
        system_re[i][q] = 0.5 * system_re[i][q] + sum_re;
        system_im[i][q] = 0.5 * system_im[i][q] + sum_im;
      }
    }
    Vector curl[3][3];
    for (int b = 0; b < 3; ++b) {
      for (int axis = 0; axis < 3; ++axis) load(curl[b][axis], columns.curls[b][axis].data() + j);
    }
    for (int b = 0; b < 3; ++b) {
      const Vector system_sum_re = (system_re[0][b] + system_re[1][b] + system_re[2][b]) * (1.0 / 6);
      const Vector system_sum_im = (system_im[0][b] + system_im[1][b] + system_im[2][b]) * (1.0 / 6);
      const Vector source_sum_re = (source_re[0][b] + source_re[1][b] + source_re[2][b]) * (1.0 / 6);
      const Vector source_sum_im = (source_im[0][b] + source_im[1][b] + source_im[2][b]) * (1.0 / 6);
      for (int a = 0; a < 3; ++a) {
        const Vector stiff = eta_m * (test.curls[a][0] * curl[b][0] + test.curls[a][1] * curl[b][1] +
                                      test.curls[a][2] * curl[b][2]);
        // -i eta curl.curl G
        store(&block.system[a][b][0][lane], 0.5 * system_re[a][b] + system_sum_re + stiff * all_im);
        store(&block.system[a][b][1][lane], 0.5 * system_im[a][b] + system_sum_im - stiff * all_re);
        store(&block.source[a][b][0][lane], 0.5 * source_re[a][b] + source_sum_re);
        store(&block.source[a][b][1][lane], 0.5 * source_im[a][b] + source_sum_im);
      }
    }
  }
}

}  // namespace klang::acoustics::detail
