#pragma once
#include <cstddef>
#include <vector>

#include "core/physics/liquid/grid.hpp"

namespace klang::liquid::kernels {

constexpr int kBlock = 64;  ///< particles that go through a kernel together; unused places repeat the last one

/// Numbers of a block, one array for each axis.
struct Block3 {
  double x[kBlock], y[kBlock], z[kBlock];
  double* operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  const double* operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

/// Component `axis` of a staggered field as kernels see it; place (0, 0, 0) in cells is the box's corner.
struct FaceView {
  const double* values;
  int nx, ny, nz;
  double shift_x, shift_y, shift_z;  ///< where entry (0, 0, 0) stands [cells]
  FaceView(const MacGrid& u, int axis)
      : values(u[axis].data().data()),
        nx(u[axis].nx()),
        ny(u[axis].ny()),
        nz(u[axis].nz()),
        shift_x(axis == 0 ? 0.0 : 0.5),
        shift_y(axis == 1 ? 0.0 : 0.5),
        shift_z(axis == 2 ? 0.0 : 0.5) {}
};

/// Trilinear at places in cells, constant outside.
void interpolate(const FaceView& face, const Block3& at, double* value);
/// The same with its slope per cell.
void interpolate_with_slope(const FaceView& face, const Block3& at, double* value, Block3& slope);

/// What particles bring to the faces of one axis: velocity where they are and its change per cell.
struct Brought {
  double value[kBlock];
  Block3 slope;
};
/// Adds (w velocity, w) of the first n particles to the eight faces around each; sums are pairs, one for each face.
void splat(const FaceView& face, const Block3& at, int n, const Brought& brought, double* sums);

}  // namespace klang::liquid::kernels
