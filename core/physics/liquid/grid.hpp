#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace klang::liquid {

/// A box [0, n h] of cubic cells, cell (0, 0, 0) at the origin, z up; x runs fastest in arrays.
struct GridShape {
  int nx = 0, ny = 0, nz = 0;
  double cell_m = 0.0;

  int n(int axis) const { return axis == 0 ? nx : axis == 1 ? ny : nz; }
  std::size_t n_cells() const { return static_cast<std::size_t>(nx) * ny * nz; }
  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(nx) * (j + static_cast<std::size_t>(ny) * k);
  }
  Eigen::Vector3d size_m() const { return cell_m * Eigen::Vector3d(nx, ny, nz); }
  Eigen::Vector3d centre_m(int i, int j, int k) const { return cell_m * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5); }
};

/// A dense array over a grid's cells, faces or nodes.
template <class T>
class Grid3 {
 public:
  Grid3() = default;
  Grid3(int nx, int ny, int nz, T value = {})
      : nx_(nx), ny_(ny), nz_(nz), data_(static_cast<std::size_t>(nx) * ny * nz, value) {}
  int nx() const { return nx_; }
  int ny() const { return ny_; }
  int nz() const { return nz_; }
  std::size_t size() const { return data_.size(); }
  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(nx_) * (j + static_cast<std::size_t>(ny_) * k);
  }
  T& operator()(int i, int j, int k) { return data_[index(i, j, k)]; }
  const T& operator()(int i, int j, int k) const { return data_[index(i, j, k)]; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  /// The nearest entry for indices outside.
  const T& clamped(int i, int j, int k) const {
    return data_[index(std::clamp(i, 0, nx_ - 1), std::clamp(j, 0, ny_ - 1), std::clamp(k, 0, nz_ - 1))];
  }
  bool contains(int i, int j, int k) const { return i >= 0 && j >= 0 && k >= 0 && i < nx_ && j < ny_ && k < nz_; }
  std::vector<T>& data() { return data_; }
  const std::vector<T>& data() const { return data_; }

 private:
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<T> data_;
};

using Field = Grid3<double>;

/// Place in a dense array: the lower of two neighbours and the share of the upper, held inside the array.
struct GridPlace {
  int i, j, k;
  double x, y, z;
  GridPlace(const Field& field, double gx, double gy, double gz) {
    const auto split = [](double g, int n, int& low, double& share) {
      g = std::clamp(g, 0.0, static_cast<double>(n - 1));
      low = std::min(static_cast<int>(g), std::max(n - 2, 0));
      share = g - low;
    };
    split(gx, field.nx(), i, x);
    split(gy, field.ny(), j, y);
    split(gz, field.nz(), k, z);
  }
};

/// Trilinear, in units of the array's indices; constant outside.
inline double trilinear(const Field& field, double gx, double gy, double gz) {
  const GridPlace at(field, gx, gy, gz);
  const std::size_t dx = field.nx() > 1 ? 1 : 0, dy = field.ny() > 1 ? static_cast<std::size_t>(field.nx()) : 0,
                    dz = field.nz() > 1 ? static_cast<std::size_t>(field.nx()) * field.ny() : 0;
  const double* const f = field.data().data() + field.index(at.i, at.j, at.k);
  const auto along_x = [&](std::size_t o) { return f[o] + at.x * (f[o + dx] - f[o]); };
  const double low = along_x(0) + at.y * (along_x(dy) - along_x(0));
  const double high = along_x(dz) + at.y * (along_x(dz + dy) - along_x(dz));
  return low + at.z * (high - low);
}

/// Trilinear of a field at cell centres.
inline double at_centres(const Field& field, const Eigen::Vector3d& x_m, double cell_m) {
  const Eigen::Vector3d g = x_m / cell_m;
  return trilinear(field, g.x() - 0.5, g.y() - 0.5, g.z() - 0.5);
}

/// Trilinear of a field at cell corners.
inline double at_nodes(const Field& field, const Eigen::Vector3d& x_m, double cell_m) {
  const Eigen::Vector3d g = x_m / cell_m;
  return trilinear(field, g.x(), g.y(), g.z());
}

/// A staggered vector field: component a stands in the middle of the faces across axis a.
struct MacGrid {
  std::array<Field, 3> faces;
  MacGrid() = default;
  explicit MacGrid(const GridShape& shape)
      : faces{Field(shape.nx + 1, shape.ny, shape.nz), Field(shape.nx, shape.ny + 1, shape.nz),
              Field(shape.nx, shape.ny, shape.nz + 1)} {}
  Field& operator[](int axis) { return faces[static_cast<std::size_t>(axis)]; }
  const Field& operator[](int axis) const { return faces[static_cast<std::size_t>(axis)]; }
};

/// Place along one axis among n entries: the lower of two neighbours and the share of the upper, held inside.
struct AxisPlace {
  int low;
  double share;
  AxisPlace(double g, int n) {
    g = g > 0.0 ? g : 0.0;
    g = g < n - 1 ? g : n - 1;
    low = static_cast<int>(g);
    low = low < n - 2 ? low : (n > 1 ? n - 2 : 0);
    share = g - low;
  }
};

/// Trilinear at a place that is known along each axis.
inline double trilinear(const Field& field, const AxisPlace& x, const AxisPlace& y, const AxisPlace& z) {
  const std::size_t dx = field.nx() > 1 ? 1 : 0, dy = field.ny() > 1 ? static_cast<std::size_t>(field.nx()) : 0,
                    dz = field.nz() > 1 ? static_cast<std::size_t>(field.nx()) * field.ny() : 0;
  const double* const f = field.data().data() + field.index(x.low, y.low, z.low);
  const auto along_x = [&](std::size_t o) { return f[o] + x.share * (f[o + dx] - f[o]); };
  const double low = along_x(0) + y.share * (along_x(dy) - along_x(0));
  const double high = along_x(dz) + y.share * (along_x(dz + dy) - along_x(dz));
  return low + z.share * (high - low);
}

/// Trilinear of each component; the places along the axes are shared by the three.
inline Eigen::Vector3d velocity_at(const MacGrid& u, const Eigen::Vector3d& x_m, double cell_m) {
  const int nx = u[1].nx(), ny = u[0].ny(), nz = u[0].nz();
  const double gx = x_m.x() / cell_m, gy = x_m.y() / cell_m, gz = x_m.z() / cell_m;
  const AxisPlace x(gx, nx + 1), y(gy, ny + 1), z(gz, nz + 1);
  const AxisPlace x_half(gx - 0.5, nx), y_half(gy - 0.5, ny), z_half(gz - 0.5, nz);
  return {trilinear(u[0], x, y_half, z_half), trilinear(u[1], x_half, y, z_half), trilinear(u[2], x_half, y_half, z)};
}

/// Where an axis' face (i, j, k) stands.
inline Eigen::Vector3d face_m(const GridShape& shape, int axis, int i, int j, int k) {
  Eigen::Vector3d x(i + 0.5, j + 0.5, k + 0.5);
  x[axis] -= 0.5;
  return shape.cell_m * x;
}

}  // namespace klang::liquid
