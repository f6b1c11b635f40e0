#include "core/sound/dual_domain/detail/slope_kernel.hpp"

#include <cmath>
#include <cstring>
#include <numbers>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/vector_clones.hpp"

namespace klang::bubble::detail {
namespace {

using Vector = double __attribute__((vector_size(kLane * sizeof(double))));

}  // namespace

// Macros, because GCC lowers the vectors of a helper function to the oldest machine's before it is inlined into a clone.
#define KLANG_LOAD(v, at) \
  Vector v;               \
  std::memcpy(&v, (at), sizeof v)
#define KLANG_STORE(at, v) std::memcpy((at), &(v), sizeof(Vector))

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
