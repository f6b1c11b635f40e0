#include "core/sound/dual_domain/detail/row_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/foundation/base/conventions.hpp"

// Sanitizers cannot run before the resolvers that pick a clone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define KLANG_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KLANG_CLONES
#endif

// Sums run in kLane partial sums whatever the machine's registers: the same bits on every machine.
namespace klang::bubble::detail {
namespace {

using Vector = double __attribute__((vector_size(kLane * sizeof(double))));

double sum(const double* v) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

}  // namespace

// Macros, because GCC lowers the vectors of a helper function to the oldest machine's before it is inlined into a clone.
#define KLANG_LOAD(v, at) \
  Vector v;               \
  std::memcpy(&v, (at), sizeof v)
#define KLANG_STORE(at, v) std::memcpy((at), &(v), sizeof(Vector))

// Two rows a, b against one pair of vectors x: sums to ya, yb (two numbers each).
#define KLANG_DOT2(a, b, n, x, ya, yb)                     \
  do {                                                     \
    const double *const ra_ = (a), *const rb_ = (b);       \
    const double *const x0_ = (x), *const x1_ = x0_ + (n); \
    Vector a0_{}, a1_{}, b0_{}, b1_{};                     \
    for (std::size_t j_ = 0; j_ < (n); j_ += kLane) {      \
      KLANG_LOAD(u0_, x0_ + j_);                           \
      KLANG_LOAD(u1_, x1_ + j_);                           \
      KLANG_LOAD(ma_, ra_ + j_);                           \
      KLANG_LOAD(mb_, rb_ + j_);                           \
      a0_ += ma_ * u0_;                                    \
      a1_ += ma_ * u1_;                                    \
      b0_ += mb_ * u0_;                                    \
      b1_ += mb_ * u1_;                                    \
    }                                                      \
    double sums_[4][kLane];                                \
    KLANG_STORE(sums_[0], a0_);                            \
    KLANG_STORE(sums_[1], a1_);                            \
    KLANG_STORE(sums_[2], b0_);                            \
    KLANG_STORE(sums_[3], b1_);                            \
    (ya)[0] = sum(sums_[0]);                               \
    (ya)[1] = sum(sums_[1]);                               \
    (yb)[0] = sum(sums_[2]);                               \
    (yb)[1] = sum(sums_[3]);                               \
  } while (false)

// w += a ya + b yb for the pair w.
#define KLANG_ADD2(a, b, n, ya, yb, w)                                           \
  do {                                                                           \
    const double *const ra_ = (a), *const rb_ = (b);                             \
    double *const w0_ = (w), *const w1_ = w0_ + (n);                             \
    const double ya0_ = (ya)[0], ya1_ = (ya)[1], yb0_ = (yb)[0], yb1_ = (yb)[1]; \
    for (std::size_t j_ = 0; j_ < (n); j_ += kLane) {                            \
      KLANG_LOAD(ma_, ra_ + j_);                                                 \
      KLANG_LOAD(mb_, rb_ + j_);                                                 \
      KLANG_LOAD(s0_, w0_ + j_);                                                 \
      KLANG_LOAD(s1_, w1_ + j_);                                                 \
      s0_ += ma_ * ya0_ + mb_ * yb0_;                                            \
      s1_ += ma_ * ya1_ + mb_ * yb1_;                                            \
      KLANG_STORE(w0_ + j_, s0_);                                                \
      KLANG_STORE(w1_ + j_, s1_);                                                \
    }                                                                            \
  } while (false)

// An odd last row goes with itself: its second copy counts 0.
KLANG_CLONES void rows_times(const double* m, std::size_t n_rows, std::size_t n, const double* x, std::size_t n_pairs,
                             double* y) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double ya[2], yb[2];
      KLANG_DOT2(m + i * n, m + second * n, n, x + 2 * p * n, ya, yb);
      std::memcpy(y + 2 * (i * n_pairs + p), ya, sizeof ya);
      if (second != i) std::memcpy(y + 2 * (second * n_pairs + p), yb, sizeof yb);
    }
}

KLANG_CLONES void rows_add(const double* m, std::size_t n_rows, std::size_t n, const double* y, std::size_t n_pairs,
                           double* w) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double yb[2] = {0.0, 0.0};
      if (second != i) std::memcpy(yb, y + 2 * (second * n_pairs + p), sizeof yb);
      KLANG_ADD2(m + i * n, m + second * n, n, y + 2 * (i * n_pairs + p), yb, w + 2 * p * n);
    }
}

KLANG_CLONES void rows_residual(const double* m, std::size_t n_rows, std::size_t n, const double* x, const double* y,
                                std::size_t n_pairs, double* w) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double ya[2], yb[2];
      KLANG_DOT2(m + i * n, m + second * n, n, x + 2 * p * n, ya, yb);
      for (int k = 0; k < 2; ++k) {
        ya[k] = y[2 * (i * n_pairs + p) + static_cast<std::size_t>(k)] - ya[k];
        yb[k] = second == i ? 0.0 : y[2 * (second * n_pairs + p) + static_cast<std::size_t>(k)] - yb[k];
      }
      KLANG_ADD2(m + i * n, m + second * n, n, ya, yb, w + 2 * p * n);
    }
}

KLANG_CLONES void rows_normal(const double* m, std::size_t n_rows, std::size_t n, const double* x, std::size_t n_pairs,
                              double* w) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double ya[2], yb[2];
      KLANG_DOT2(m + i * n, m + second * n, n, x + 2 * p * n, ya, yb);
      if (second == i) yb[0] = yb[1] = 0.0;
      KLANG_ADD2(m + i * n, m + second * n, n, ya, yb, w + 2 * p * n);
    }
}

KLANG_CLONES void distances(const double* sources, std::size_t n_padded, double k, const double* at, double* r,
                            double* phase) {
  for (std::size_t s = 0; s < n_padded; ++s) {
    const double x = at[0] - sources[s], y = at[1] - sources[n_padded + s], z = at[2] - sources[2 * n_padded + s];
    r[s] = std::sqrt(x * x + y * y + z * z);
    phase[s] = k * r[s];
  }
}

KLANG_CLONES void singular_slopes(const double* sources, std::size_t n_sources, std::size_t n_padded, double k,
                                  const double* at, const double* normal, const double* r, const double* cosine,
                                  const double* sine, double weight, double* row, double* square) {
  // As quadrupole_slopes of wave_rows.cpp, eight sources at a time. F_l = h_l / u^l; gradient of F_l: -k^2 r F_{l+1}.
  const double mono = 1.0 / std::sqrt(4.0 * kPi), di = std::sqrt(3.0 / (4.0 * kPi)),
               quad = std::sqrt(15.0 / (4.0 * kPi));
  const double root3 = std::numbers::sqrt3, ksq = k * k;
  const double nx = normal[0], ny = normal[1], nz = normal[2];
  for (std::size_t s = 0; s < n_sources; s += kLane) {
    KLANG_LOAD(sx, sources + s);
    KLANG_LOAD(sy, sources + n_padded + s);
    KLANG_LOAD(sz, sources + 2 * n_padded + s);
    KLANG_LOAD(distance, r + s);
    KLANG_LOAD(c, cosine + s);
    KLANG_LOAD(sn, sine + s);
    const Vector x = at[0] - sx, y = at[1] - sy, z = at[2] - sz, inverse = 1.0 / (k * distance);
    const Vector rn = x * nx + y * ny + z * nz;
    Vector re[9], im[9];
    // e^{-iu} = c - i sn; h_{-1} = e^{-iu} / u, h_0 = i e^{-iu} / u = (sn + i c) / u
    Vector br = c * inverse, bi = -sn * inverse, hr = sn * inverse, hi = c * inverse;
    Vector fr[4], fi[4], power = inverse * 0.0 + 1.0;
    for (int l = 0; l < 4; ++l) {
      fr[l] = hr * power;
      fi[l] = hi * power;
      const Vector factor = (2.0 * l + 1.0) * inverse;
      const Vector tr = factor * hr - br, ti = factor * hi - bi;
      br = hr;
      bi = hi;
      hr = tr;
      hi = ti;
      power *= inverse;
    }
    const Vector q4 = x * y, q5 = y * z, q6 = z * x, q7 = 0.5 * (x * x - y * y),
                 q8 = (2.0 * z * z - x * x - y * y) / (2.0 * root3);
    const Vector g4 = x * ny + y * nx, g5 = y * nz + z * ny, g6 = z * nx + x * nz, g7 = x * nx - y * ny,
                 g8 = (2.0 * z * nz - x * nx - y * ny) / root3;
    for (int part = 0; part < 2; ++part) {
      const Vector* const f = part == 0 ? fr : fi;
      Vector* const out = part == 0 ? re : im;
      out[0] = -mono * ksq * rn * f[1];
      const Vector d = di * k * f[1], dd = di * k * ksq * rn * f[2];
      out[1] = d * nx - dd * x;
      out[2] = d * ny - dd * y;
      out[3] = d * nz - dd * z;
      const Vector q = quad * ksq * f[2], qd = quad * ksq * ksq * rn * f[3];
      out[4] = q * g4 - qd * q4;
      out[5] = q * g5 - qd * q5;
      out[6] = q * g6 - qd * q6;
      out[7] = q * g7 - qd * q7;
      out[8] = q * g8 - qd * q8;
    }
    for (std::size_t f = 0; f < 9; ++f) {
      const Vector a = weight * re[f], b = -weight * im[f];
      double* const squares = square + f * n_padded + s;
      KLANG_LOAD(before, squares);
      before += a * a + b * b;
      KLANG_STORE(squares, before);
      double* const out = row + 2 * (f * n_sources + s);
      const Vector low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11),
                   high = __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
      if (s + kLane <= n_sources) {
        KLANG_STORE(out, low);
        KLANG_STORE(out + kLane, high);
      } else {
        double both[2 * kLane];
        KLANG_STORE(both, low);
        KLANG_STORE(both + kLane, high);
        std::memcpy(out, both, 2 * (n_sources - s) * sizeof(double));
      }
    }
  }
}

}  // namespace klang::bubble::detail
