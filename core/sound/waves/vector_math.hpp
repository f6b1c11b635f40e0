#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/vector_clones.hpp"

#define KLANG_INLINE inline __attribute__((always_inline))

namespace klang::acoustics::simd {

inline constexpr std::size_t kLanes = 8;

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
      1.0 + r2 * (-0.5 + r2 * (1.0 / 24 + r2 * (-1.0 / 720 +
                                                r2 * (1.0 / 40320 + r2 * (-1.0 / 3628800 + r2 * (1.0 / 479001600))))));
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

}  // namespace klang::acoustics::simd
