#include "core/sound/stage/detail/ring_kernel.hpp"

#include <cstring>

// Sanitizers cannot run before the resolvers that pick a clone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define KLANG_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KLANG_CLONES
#endif

namespace klang::stage::detail {

KLANG_CLONES void ring_samples(const RingLanes& lanes, std::size_t n, double* output) {
  using Vector = double __attribute__((vector_size(kRingLanes * sizeof(double))));
  Vector z_re, z_im, r_re[4], r_im[4], g_re, g_im, s_re, s_im;
  std::memcpy(&z_re, lanes.z_re, sizeof z_re);
  std::memcpy(&z_im, lanes.z_im, sizeof z_im);
  for (int k = 0; k < 4; ++k) {
    std::memcpy(&r_re[k], lanes.ratio_re[k], sizeof z_re);
    std::memcpy(&r_im[k], lanes.ratio_im[k], sizeof z_re);
  }
  std::memcpy(&g_re, lanes.gain_re, sizeof g_re);
  std::memcpy(&g_im, lanes.gain_im, sizeof g_im);
  std::memcpy(&s_re, lanes.gain_step_re, sizeof s_re);
  std::memcpy(&s_im, lanes.gain_step_im, sizeof s_im);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector value = g_re * z_re - g_im * z_im;
    std::memcpy(output + i * kRingLanes, &value, sizeof value);
    g_re += s_re;
    g_im += s_im;
    const Vector next = z_re * r_re[0] - z_im * r_im[0];
    z_im = z_re * r_im[0] + z_im * r_re[0];
    z_re = next;
    for (int k = 0; k < 3; ++k) {
      const Vector ratio = r_re[k] * r_re[k + 1] - r_im[k] * r_im[k + 1];
      r_im[k] = r_re[k] * r_im[k + 1] + r_im[k] * r_re[k + 1];
      r_re[k] = ratio;
    }
  }
}

}  // namespace klang::stage::detail
