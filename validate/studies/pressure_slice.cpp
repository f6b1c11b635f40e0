#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "validate/studies/detail/pressure_slice.hpp"

namespace klang::validate::detail {

SliceField pressure_slice(double half_m, int n_pixels, const std::function<PointValue()>& factory) {
  SliceField slice;
  slice.corner_m = {-half_m, 0.0, -half_m};
  slice.side_u_m = {2.0 * half_m, 0.0, 0.0};
  slice.side_v_m = {0.0, 0.0, 2.0 * half_m};
  slice.quantity = "pressure_magnitude_pa";
  slice.values.resize(n_pixels, n_pixels);
  parallel_for(static_cast<std::size_t>(n_pixels), 8, [&](std::size_t begin, std::size_t end) {
    const PointValue value = factory();
    for (std::size_t row = begin; row < end; ++row) {
      for (int column = 0; column < n_pixels; ++column) {
        const Eigen::Vector3d x = slice.corner_m + slice.side_u_m * (column / (n_pixels - 1.0)) +
                                  slice.side_v_m * (static_cast<double>(row) / (n_pixels - 1.0));
        slice.values(static_cast<Eigen::Index>(row), column) = value(x);
      }
    }
  });
  return slice;
}

BalloonField balloon(const std::function<double(const Eigen::Vector3d& direction)>& magnitude) {
  constexpr int kPolar = 60, kAzimuth = 120;
  BalloonField field;
  field.magnitude.resize(kPolar + 1, kAzimuth);
  for (int i = 0; i <= kPolar; ++i) {
    for (int k = 0; k < kAzimuth; ++k) {
      const double theta = kPi * i / kPolar, phi = 2.0 * kPi * k / kAzimuth;
      field.magnitude(i, k) =
          magnitude({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
  }
  return field;
}

}  // namespace klang::validate::detail
