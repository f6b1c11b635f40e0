#include "core/physics/liquid/detail/particle_kernels.hpp"

#include <cstring>

#include "core/foundation/base/vector_clones.hpp"

namespace klang::liquid::kernels {
namespace {

struct Strides {
  int x, y, z;
  explicit Strides(const FaceView& f) : x(f.nx > 1 ? 1 : 0), y(f.ny > 1 ? f.nx : 0), z(f.nz > 1 ? f.nx * f.ny : 0) {}
};

/// The lower of two neighbours along an axis; g becomes the share of the upper.
inline int split(double& g, double highest, int last_low) {
  g = g > 0.0 ? g : 0.0;
  g = g < highest ? g : highest;
  int low = static_cast<int>(g);
  low = low < last_low ? low : last_low;
  g -= low;
  return low;
}

}  // namespace

KLANG_CLONES void interpolate(const FaceView& face, const Block3& at, double* __restrict value) {
  const double* const __restrict f = face.values;
  const Strides d(face);
  const int nx = face.nx, layer = face.nx * face.ny;
  const int low_x = nx > 1 ? nx - 2 : 0, low_y = face.ny > 1 ? face.ny - 2 : 0, low_z = face.nz > 1 ? face.nz - 2 : 0;
  const double top_x = nx - 1, top_y = face.ny - 1, top_z = face.nz - 1;
  const double shift_x = face.shift_x, shift_y = face.shift_y, shift_z = face.shift_z;
  for (int p = 0; p < kBlock; ++p) {
    double x = at.x[p] - shift_x, y = at.y[p] - shift_y, z = at.z[p] - shift_z;
    const int i = split(x, top_x, low_x), j = split(y, top_y, low_y), k = split(z, top_z, low_z);
    const double* const __restrict c = f + (i + nx * j + layer * k);
    const double a00 = c[0] + x * (c[d.x] - c[0]), a10 = c[d.y] + x * (c[d.y + d.x] - c[d.y]),
                 a01 = c[d.z] + x * (c[d.z + d.x] - c[d.z]),
                 a11 = c[d.z + d.y] + x * (c[d.z + d.y + d.x] - c[d.z + d.y]);
    const double b0 = a00 + y * (a10 - a00), b1 = a01 + y * (a11 - a01);
    value[p] = b0 + z * (b1 - b0);
  }
}

KLANG_CLONES void interpolate_with_slope(const FaceView& face, const Block3& at, double* __restrict value,
                                         Block3& __restrict slope) {
  const double* const __restrict f = face.values;
  const Strides d(face);
  const int nx = face.nx, layer = face.nx * face.ny;
  const int low_x = nx > 1 ? nx - 2 : 0, low_y = face.ny > 1 ? face.ny - 2 : 0, low_z = face.nz > 1 ? face.nz - 2 : 0;
  const double top_x = nx - 1, top_y = face.ny - 1, top_z = face.nz - 1;
  const double shift_x = face.shift_x, shift_y = face.shift_y, shift_z = face.shift_z;
  for (int p = 0; p < kBlock; ++p) {
    double x = at.x[p] - shift_x, y = at.y[p] - shift_y, z = at.z[p] - shift_z;
    const int i = split(x, top_x, low_x), j = split(y, top_y, low_y), k = split(z, top_z, low_z);
    const double* const __restrict c = f + (i + nx * j + layer * k);
    const double r00 = c[d.x] - c[0], r10 = c[d.y + d.x] - c[d.y], r01 = c[d.z + d.x] - c[d.z],
                 r11 = c[d.z + d.y + d.x] - c[d.z + d.y];
    const double a00 = c[0] + x * r00, a10 = c[d.y] + x * r10, a01 = c[d.z] + x * r01, a11 = c[d.z + d.y] + x * r11;
    const double b0 = a00 + y * (a10 - a00), b1 = a01 + y * (a11 - a01);
    value[p] = b0 + z * (b1 - b0);
    slope.x[p] = (1.0 - z) * ((1.0 - y) * r00 + y * r10) + z * ((1.0 - y) * r01 + y * r11);
    slope.y[p] = (1.0 - z) * (a10 - a00) + z * (a11 - a01);
    slope.z[p] = b1 - b0;
  }
}

namespace {

/// Where the particles of a block are among the faces, and what they bring to the lowest of their eight.
struct Placed {
  int base[kBlock];
  double x[kBlock], y[kBlock], z[kBlock], corner[kBlock];
};

KLANG_CLONES void place(const FaceView& face, const Block3& at, const Brought& brought, Placed& __restrict to) {
  const int nx = face.nx, layer = face.nx * face.ny;
  const int low_x = nx > 1 ? nx - 2 : 0, low_y = face.ny > 1 ? face.ny - 2 : 0, low_z = face.nz > 1 ? face.nz - 2 : 0;
  const double top_x = nx - 1, top_y = face.ny - 1, top_z = face.nz - 1;
  const double shift_x = face.shift_x, shift_y = face.shift_y, shift_z = face.shift_z;
  for (int p = 0; p < kBlock; ++p) {
    double x = at.x[p] - shift_x, y = at.y[p] - shift_y, z = at.z[p] - shift_z;
    const int i = split(x, top_x, low_x), j = split(y, top_y, low_y), k = split(z, top_z, low_z);
    to.base[p] = i + nx * j + layer * k;
    to.x[p] = x;
    to.y[p] = y;
    to.z[p] = z;
    to.corner[p] = brought.value[p] - x * brought.slope.x[p] - y * brought.slope.y[p] - z * brought.slope.z[p];
  }
}

}  // namespace

void splat(const FaceView& face, const Block3& at, int n, const Brought& brought, double* sums) {
  typedef double Pair __attribute__((vector_size(16)));
  Placed placed;
  place(face, at, brought, placed);
  const Strides d(face);
  const auto put = [](double* to, Pair value) {
    Pair sum;
    std::memcpy(&sum, to, sizeof sum);
    sum += value;
    std::memcpy(to, &sum, sizeof sum);
  };
  for (int p = 0; p < n; ++p) {
    double* const base = sums + 2 * static_cast<std::ptrdiff_t>(placed.base[p]);
    const double x = placed.x[p], y = placed.y[p], z = placed.z[p], corner = placed.corner[p];
    const Pair along_y{brought.slope.y[p], 0.0}, along_z{brought.slope.z[p], 0.0};
    const Pair low{corner, 1.0}, high{corner + brought.slope.x[p], 1.0};
    const Pair x0{1.0 - x, 1.0 - x}, x1{x, x};
    const auto row = [&](double weight, Pair low_value, Pair high_value, int offset) {
      const Pair w{weight, weight};
      put(base + 2 * offset, x0 * w * low_value);
      put(base + 2 * (offset + d.x), x1 * w * high_value);
    };
    row((1.0 - y) * (1.0 - z), low, high, 0);
    row(y * (1.0 - z), low + along_y, high + along_y, d.y);
    row((1.0 - y) * z, low + along_z, high + along_z, d.z);
    row(y * z, low + along_y + along_z, high + along_y + along_z, d.y + d.z);
  }
}

}  // namespace klang::liquid::kernels
