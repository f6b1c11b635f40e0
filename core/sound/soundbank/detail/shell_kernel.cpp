#include "core/sound/soundbank/detail/shell_kernel.hpp"

#include "core/sound/waves/vector_math.hpp"

namespace klang::soundbank::detail {
namespace {

using acoustics::simd::inverse_root;
using acoustics::simd::kLanes;
using acoustics::simd::load;
using acoustics::simd::sine_cosine;
using acoustics::simd::store;
using acoustics::simd::Vector;

}  // namespace

KLANG_CLONES void mirrored_normal_derivative(const SourceColumns& sources, const TargetPoint& target, int mode_class,
                                             double wavenumber_per_m, double eta_per_m, double* re, double* im) {
  const double k = wavenumber_per_m, k_sq = k * k;
  for (std::size_t j = 0; j < sources.n_padded; j += kLanes) {
    Vector y[3], nu[3];
    for (int axis = 0; axis < 3; ++axis) {
      load(y[axis], sources.points_m[axis].data() + j);
      load(nu[axis], sources.normals[axis].data() + j);
    }
    Vector sum_re{}, sum_im{};
    for (int image = 0; image < 8; ++image) {  // the target is mirrored instead of the source: the same distances
      double x[3], n[3], sign = 1.0 / (4.0 * kPi);
      for (int axis = 0; axis < 3; ++axis) {
        const bool flip = (image >> axis & 1) != 0;
        x[axis] = flip ? -target.point_m[axis] : target.point_m[axis];
        n[axis] = flip ? -target.normal[axis] : target.normal[axis];
        if (flip && (mode_class >> axis & 1) != 0) sign = -sign;
      }
      const Vector dx = x[0] - y[0], dy = x[1] - y[1], dz = x[2] - y[2];
      Vector inverse, sine, cosine;
      inverse_root(dx * dx + dy * dy + dz * dz, inverse);
      const Vector inverse_sq = inverse * inverse;
      const Vector kr = k * (dx * dx + dy * dy + dz * dz) * inverse;
      sine_cosine(kr, sine, cosine);
      const Vector g_re = sign * inverse * cosine, g_im = -(sign * inverse * sine);
      // h = (1 + ikR) G / R^2
      const Vector h_re = (g_re - kr * g_im) * inverse_sq, h_im = (g_im + kr * g_re) * inverse_sq;
      const Vector r_n = dx * n[0] + dy * n[1] + dz * n[2];
      const Vector r_nu = dx * nu[0] + dy * nu[1] + dz * nu[2];
      const Vector n_nu = nu[0] * n[0] + nu[1] * n[1] + nu[2] * n[2];
      // n.grad_x of h (r.nu) + i eta G
      const Vector both = r_n * r_nu * inverse_sq;
      sum_re += h_re * n_nu - both * (3.0 * h_re - k_sq * g_re) + eta_per_m * (h_im * r_n);
      sum_im += h_im * n_nu - both * (3.0 * h_im - k_sq * g_im) - eta_per_m * (h_re * r_n);
    }
    store(re + j, sum_re);
    store(im + j, sum_im);
  }
}

KLANG_CLONES std::array<double, 2> mirrored_far_field(const SourceColumns& sources,
                                                      const std::array<double, 3>& direction, int mode_class,
                                                      double wavenumber_per_m, double eta_per_m, const double* q_re,
                                                      const double* q_im) {
  Vector sum_re{}, sum_im{};
  const double k[3] = {wavenumber_per_m * direction[0], wavenumber_per_m * direction[1],
                       wavenumber_per_m * direction[2]};
  for (std::size_t j = 0; j < sources.n_padded; j += kLanes) {
    Vector value[3], slope[3];  // cos(k_a y_a), or sin where odd; and k_a nu_a times its derivative
    for (int axis = 0; axis < 3; ++axis) {
      Vector y, nu, sine, cosine;
      load(y, sources.points_m[axis].data() + j);
      load(nu, sources.normals[axis].data() + j);
      sine_cosine(k[axis] * y, sine, cosine);
      nu *= k[axis];
      if ((mode_class >> axis & 1) != 0) {
        value[axis] = sine;
        slope[axis] = nu * cosine;
      } else {
        value[axis] = cosine;
        slope[axis] = -(nu * sine);
      }
    }
    const Vector monopole = eta_per_m * (value[0] * value[1] * value[2]);
    const Vector dipole = slope[0] * value[1] * value[2] + value[0] * (slope[1] * value[2] + value[1] * slope[2]);
    Vector re, im;
    load(re, q_re + j);
    load(im, q_im + j);
    sum_re += re * dipole - im * monopole;
    sum_im += im * dipole + re * monopole;
  }
  std::array<double, 2> out{0.0, 0.0};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    out[0] += sum_re[lane];
    out[1] += sum_im[lane];
  }
  return out;
}

}  // namespace klang::soundbank::detail
