#include "core/sound/transfer/detail/transfer_kernel.hpp"

#include <algorithm>
#include <cstring>
#include "core/foundation/base/vector_clones.hpp"

namespace klang::acoustics::detail {
namespace {

using Modes = double __attribute__((vector_size(kModeLanes * sizeof(double))));
using Four = double __attribute__((vector_size(kListeners * sizeof(double))));

// By memcpy: the arrays need no alignment, and passing vectors by value would depend on the processor.
#define KLANG_LOAD(variable, address) std::memcpy(&(variable), (address), sizeof(variable))
#define KLANG_STORE(address, variable) std::memcpy((address), &(variable), sizeof(variable))

template <int kCount>
inline __attribute__((always_inline)) void group_body(int order, const ModeLanes* coefficients, const double* harmonics,
                                                      const double* start, double* out) {
  Modes inverse[kCount], h_re[kCount], h_im[kCount], before_re[kCount], before_im[kCount], p_re[kCount], p_im[kCount];
  for (int l = 0; l < kCount; ++l) {
    KLANG_LOAD(inverse[l], start + 3 * kModeLanes * l);
    KLANG_LOAD(h_re[l], start + 3 * kModeLanes * l + kModeLanes);
    KLANG_LOAD(h_im[l], start + 3 * kModeLanes * l + 2 * kModeLanes);
    // h_{-1} = -i h_0: h_1 = h_0 / x - h_{-1} = h_0 (1 / x + i)
    before_re[l] = h_im[l];
    before_im[l] = -h_re[l];
    p_re[l] = Modes{};
    p_im[l] = Modes{};
  }
  for (int n = 0; n <= order; ++n) {
    Modes sum_re[kCount] = {}, sum_im[kCount] = {};
    for (int j = 0; j < 2 * n + 1; ++j) {
      Modes re, im;
      KLANG_LOAD(re, coefficients);
      KLANG_LOAD(im, coefficients + 1);
      for (int l = 0; l < kCount; ++l) {
        sum_re[l] += re * harmonics[l];
        sum_im[l] += im * harmonics[l];
      }
      coefficients += 2;
      harmonics += kCount == 1 ? 1 : kListeners;
    }
    const double factor = 2 * n + 1;
    for (int l = 0; l < kCount; ++l) {
      p_re[l] += h_re[l] * sum_re[l] - h_im[l] * sum_im[l];
      p_im[l] += h_re[l] * sum_im[l] + h_im[l] * sum_re[l];
      const Modes step = factor * inverse[l];
      const Modes next_re = step * h_re[l] - before_re[l], next_im = step * h_im[l] - before_im[l];
      before_re[l] = h_re[l];
      before_im[l] = h_im[l];
      h_re[l] = next_re;
      h_im[l] = next_im;
    }
  }
  for (int l = 0; l < kCount; ++l) {
    KLANG_STORE(out + 2 * kModeLanes * l, p_re[l]);
    KLANG_STORE(out + 2 * kModeLanes * l + kModeLanes, p_im[l]);
  }
}

// Directions: double or Four.
template <typename Directions>
inline __attribute__((always_inline)) void harmonics_body(int order, const double* diagonal, const double* by_z,
                                                          const double* by_previous, const double* directions,
                                                          double* rows, double* out) {
  constexpr std::ptrdiff_t kWidth = sizeof(Directions) / sizeof(double);
  Directions x, y, z;
  KLANG_LOAD(x, directions);
  KLANG_LOAD(y, directions + kWidth);
  KLANG_LOAD(z, directions + 2 * kWidth);
  const std::ptrdiff_t row_size = (order + 1) * kWidth;
  double* const cosines = rows;  // Re and Im (s_x + i s_y)^m
  double* const sines = rows + row_size;
  double* now = rows + 2 * row_size;  // q_{n-1}^m, becomes q_n^m in place of q_{n-2}^m
  double* before = rows + 3 * row_size;
  Directions c = Directions{} + 1.0, s = {};
  for (int m = 0; m <= order; ++m) {
    KLANG_STORE(cosines + kWidth * m, c);
    KLANG_STORE(sines + kWidth * m, s);
    const Directions next = c * x - s * y;
    s = c * y + s * x;
    c = next;
  }
  std::fill(now, now + row_size, 0.0);
  std::fill(before, before + row_size, 0.0);
  for (int n = 0; n <= order; ++n) {
    const std::ptrdiff_t table = std::ptrdiff_t{n} * (n + 1) / 2;
    double* const centre = out + std::ptrdiff_t{n} * (n + 1) * kWidth;
    const Directions last = Directions{} + diagonal[n];
    for (int m = 0; m < n; ++m) {
      Directions q, q_before;
      KLANG_LOAD(q, now + kWidth * m);
      KLANG_LOAD(q_before, before + kWidth * m);
      q = by_z[table + m] * z * q - by_previous[table + m] * q_before;
      KLANG_STORE(before + kWidth * m, q);
    }
    KLANG_STORE(before + kWidth * n, last);
    for (int m = n; m >= 0; --m) {  // m = 0 last: its sine is 0 and its place is the cosine's
      Directions q, cosine, sine;
      KLANG_LOAD(q, before + kWidth * m);
      KLANG_LOAD(cosine, cosines + kWidth * m);
      KLANG_LOAD(sine, sines + kWidth * m);
      cosine *= q;
      sine *= q;
      KLANG_STORE(centre - kWidth * m, sine);
      KLANG_STORE(centre + kWidth * m, cosine);
    }
    std::swap(now, before);
  }
}

}  // namespace

KLANG_CLONES void real_harmonics(int order, int width, const double* diagonal, const double* by_z,
                                 const double* by_previous, const double* directions, double* rows, double* out) {
  if (width == 1) {
    harmonics_body<double>(order, diagonal, by_z, by_previous, directions, rows, out);
  } else {
    harmonics_body<Four>(order, diagonal, by_z, by_previous, directions, rows, out);
  }
}

KLANG_CLONES void group_pressures(int order, int n_listeners, const ModeLanes* coefficients, const double* harmonics,
                                  const double* start, double* out) {
  switch (n_listeners) {
    case 1:
      group_body<1>(order, coefficients, harmonics, start, out);
      break;
    case 2:
      group_body<2>(order, coefficients, harmonics, start, out);
      break;
    case 3:
      group_body<3>(order, coefficients, harmonics, start, out);
      break;
    default:
      group_body<kListeners>(order, coefficients, harmonics, start, out);
      break;
  }
}

}  // namespace klang::acoustics::detail
