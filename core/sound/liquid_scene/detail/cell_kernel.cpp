#include "core/sound/liquid_scene/detail/cell_kernel.hpp"

#include <algorithm>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define KLANG_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define KLANG_CLONES
#endif

namespace klang::liquid_scene::detail {
namespace {

constexpr std::size_t kBlock = 256;  // summed in single precision before it goes into the double

}  // namespace

void CellMatrix::factor() {
  constexpr float kModified = 0.97F, kSafe = 0.25F;
  const int none = static_cast<int>(n());
  inverse.assign(n(), 0.0F);
  for (std::size_t i = 0; i < n(); ++i) {
    float e = diagonal[i];
    for (std::size_t a = 0; a < 3; ++a) {
      if (before[a][i] == none) continue;
      const auto d = static_cast<std::size_t>(before[a][i]);
      float others = 0.0F;
      for (std::size_t b = 0; b < 3; ++b)
        if (b != a && next[b][d] != none) others += 1.0F;
      e -= (1.0F + kModified * others) * inverse[d];
    }
    if (!(e >= kSafe * diagonal[i])) e = diagonal[i];
    inverse[i] = 1.0F / e;
  }
}

KLANG_CLONES void multiply(const CellMatrix& m, const LaneNumbers& give, const LaneNumbers& shift, const LaneValues& x,
                           LaneValues& a) {
  const std::size_t n = m.n();
  const float* const v = x.data();
  const LaneNumbers g = give,
                    k2 = shift;  // copies: what is written could else be these, and nothing be put into vectors
  for (std::size_t i = 0; i < n; ++i) {
    const float *const here = v + kWide * i, *const x0 = v + kWide * static_cast<std::size_t>(m.before[0][i]),
                       *const x1 = v + kWide * static_cast<std::size_t>(m.next[0][i]),
                       *const y0 = v + kWide * static_cast<std::size_t>(m.before[1][i]),
                       *const y1 = v + kWide * static_cast<std::size_t>(m.next[1][i]),
                       *const z0 = v + kWide * static_cast<std::size_t>(m.before[2][i]),
                       *const z1 = v + kWide * static_cast<std::size_t>(m.next[2][i]);
    const float diagonal = m.diagonal[i], wall = m.n_wall[i];
    float sum[kWide];
    for (std::size_t l = 0; l < kWide; ++l)
      sum[l] = diagonal * here[l] - (x0[l] + x1[l] + (y0[l] + y1[l]) + (z0[l] + z1[l]));
    float re[kLanes], im[kLanes], value[kWide];
    for (std::size_t l = 0; l < kLanes; ++l) re[l] = wall * g.re[l] - k2.re[l];
    for (std::size_t l = 0; l < kLanes; ++l) im[l] = wall * g.im[l] - k2.im[l];
    for (std::size_t l = 0; l < kLanes; ++l) value[l] = sum[l] + re[l] * here[l] - im[l] * here[l + kLanes];
    for (std::size_t l = 0; l < kLanes; ++l)
      value[l + kLanes] = sum[l + kLanes] + re[l] * here[l + kLanes] + im[l] * here[l];
    float* const to = a.data() + kWide * i;
    for (std::size_t l = 0; l < kWide; ++l) to[l] = value[l];
  }
  std::fill(a.end() - kWide, a.end(), 0.0F);
}

KLANG_CLONES void precondition(const CellMatrix& m, const LaneValues& r, LaneValues& z) {
  const std::size_t n = m.n();
  float* const v = z.data();
  std::fill(z.end() - kWide, z.end(), 0.0F);
  for (std::size_t i = 0; i < n; ++i) {
    const float *const x = v + kWide * static_cast<std::size_t>(m.before[0][i]),
                       *const y = v + kWide * static_cast<std::size_t>(m.before[1][i]),
                       *const w = v + kWide * static_cast<std::size_t>(m.before[2][i]);
    const float* const right = r.data() + kWide * i;
    float* const to = v + kWide * i;
    const float inverse = m.inverse[i];
    float value[kWide];
    for (std::size_t l = 0; l < kWide; ++l) value[l] = inverse * ((right[l] + y[l] + w[l]) + x[l]);
    for (std::size_t l = 0; l < kWide; ++l) to[l] = value[l];
  }
  for (std::size_t i = n; i-- > 0;) {
    const float *const x = v + kWide * static_cast<std::size_t>(m.next[0][i]),
                       *const y = v + kWide * static_cast<std::size_t>(m.next[1][i]),
                       *const w = v + kWide * static_cast<std::size_t>(m.next[2][i]);
    float* const to = v + kWide * i;
    const float inverse = m.inverse[i];
    float value[kWide];
    for (std::size_t l = 0; l < kWide; ++l) value[l] = to[l] + inverse * ((y[l] + w[l]) + x[l]);
    for (std::size_t l = 0; l < kWide; ++l) to[l] = value[l];
  }
}

KLANG_CLONES void sums(const LaneValues& a, const LaneValues& b, std::array<double, kWide>& result) {
  const std::size_t n = a.size() / kWide;
  result.fill(0.0);
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    float re[kLanes] = {}, im[kLanes] = {};
    for (std::size_t i = begin; i < std::min(n, begin + kBlock); ++i) {
      const float *const x = a.data() + kWide * i, *const y = b.data() + kWide * i;
      for (std::size_t l = 0; l < kLanes; ++l) {
        re[l] += x[l] * y[l] - x[l + kLanes] * y[l + kLanes];
        im[l] += x[l] * y[l + kLanes] + x[l + kLanes] * y[l];
      }
    }
    for (std::size_t l = 0; l < kLanes; ++l) {
      result[l] += re[l];
      result[l + kLanes] += im[l];
    }
  }
}

std::array<double, kLanes> norms_sq(const LaneValues& a) {
  const std::size_t n = a.size() / kWide;
  std::array<double, kLanes> result{};
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    float sum[kWide] = {};
    for (std::size_t i = begin; i < std::min(n, begin + kBlock); ++i)
      for (std::size_t l = 0; l < kWide; ++l) sum[l] += a[kWide * i + l] * a[kWide * i + l];
    for (std::size_t l = 0; l < kLanes; ++l) result[l] += static_cast<double>(sum[l]) + sum[l + kLanes];
  }
  return result;
}

KLANG_CLONES void add(const LaneNumbers& times, const LaneValues& x, LaneValues& y) {
  const std::size_t n = x.size() / kWide;
  const LaneNumbers s = times;
  for (std::size_t i = 0; i < n; ++i) {
    const float* const from = x.data() + kWide * i;
    float* const to = y.data() + kWide * i;
    float value[kWide];
    for (std::size_t l = 0; l < kLanes; ++l) value[l] = to[l] + (s.re[l] * from[l] - s.im[l] * from[l + kLanes]);
    for (std::size_t l = 0; l < kLanes; ++l)
      value[l + kLanes] = to[l + kLanes] + (s.re[l] * from[l + kLanes] + s.im[l] * from[l]);
    for (std::size_t l = 0; l < kWide; ++l) to[l] = value[l];
  }
}

KLANG_CLONES void add_to(const LaneValues& x, const LaneNumbers& times, LaneValues& y) {
  const std::size_t n = x.size() / kWide;
  const LaneNumbers s = times;
  for (std::size_t i = 0; i < n; ++i) {
    const float* const from = x.data() + kWide * i;
    float* const to = y.data() + kWide * i;
    float value[kWide];
    for (std::size_t l = 0; l < kLanes; ++l) value[l] = from[l] + (s.re[l] * to[l] - s.im[l] * to[l + kLanes]);
    for (std::size_t l = 0; l < kLanes; ++l)
      value[l + kLanes] = from[l + kLanes] + (s.re[l] * to[l + kLanes] + s.im[l] * to[l]);
    for (std::size_t l = 0; l < kWide; ++l) to[l] = value[l];
  }
}

}  // namespace klang::liquid_scene::detail
