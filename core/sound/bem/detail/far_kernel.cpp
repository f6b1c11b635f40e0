#include "core/sound/bem/detail/far_kernel.hpp"

#include "core/sound/waves/vector_math.hpp"

namespace klang::acoustics::detail {

using simd::inverse_root;
using simd::kLanes;
using simd::load;
using simd::sine_cosine;
using simd::store;
using simd::Vector;

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
        const Vector stiff =
            eta_m * (test.curls[a][0] * curl[b][0] + test.curls[a][1] * curl[b][1] + test.curls[a][2] * curl[b][2]);
        // -i eta curl.curl G
        store(&block.system[a][b][0][lane], 0.5 * system_re[a][b] + system_sum_re + stiff * all_im);
        store(&block.system[a][b][1][lane], 0.5 * system_im[a][b] + system_sum_im - stiff * all_re);
        store(&block.source[a][b][0][lane], 0.5 * source_re[a][b] + source_sum_re);
        store(&block.source[a][b][1][lane], 0.5 * source_im[a][b] + source_sum_im);
      }
    }
  }
}

KLANG_CLONES void far_sums(const FarBlock& block, std::size_t count, const double* const values[3][2],
                           double sums[3][2]) {
  Vector re[3] = {}, im[3] = {};
  for (std::size_t lane = 0; lane < count; lane += kLanes)
    for (int q = 0; q < 3; ++q) {
      Vector v_re, v_im;
      load(v_re, values[q][0] + lane);
      load(v_im, values[q][1] + lane);
      for (int a = 0; a < 3; ++a) {
        Vector k_re, k_im;
        load(k_re, &block.source[a][q][0][lane]);
        load(k_im, &block.source[a][q][1][lane]);
        re[a] += k_re * v_re - k_im * v_im;
        im[a] += k_re * v_im + k_im * v_re;
      }
    }
  for (int a = 0; a < 3; ++a) {
    sums[a][0] = sums[a][1] = 0.0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      sums[a][0] += re[a][lane];
      sums[a][1] += im[a][lane];
    }
  }
}

}  // namespace klang::acoustics::detail
