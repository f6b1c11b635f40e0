#include "core/physics/liquid/level_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector3d;

constexpr double kLeastStep =
    0.57;  // [cells] no distance is less than this beyond its nearest neighbour's (1 / sqrt(3))

template <class Body>
void for_layers(int nz, const Body& body) {
  parallel_for(static_cast<std::size_t>(nz), 1, [&](std::size_t k, std::size_t) { body(static_cast<int>(k)); });
}

/// Catmull-Rom along an axis.
double cubic(double a, double b, double c, double d, double t) {
  const double slope_b = 0.5 * (c - a), slope_c = 0.5 * (d - b), rise = c - b;
  return b + t * (slope_b + t * (3.0 * rise - 2.0 * slope_b - slope_c + t * (slope_b + slope_c - 2.0 * rise)));
}

double tricubic(const Field& f, double gx, double gy, double gz) {
  const GridPlace at(f, gx, gy, gz);
  double planes[4];
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (int c = -1; c <= 2; ++c) {
    double rows[4];
    for (int b = -1; b <= 2; ++b) {
      double v[4];
      for (int a = -1; a <= 2; ++a) v[a + 1] = f.clamped(at.i + a, at.j + b, at.k + c);
      if ((b == 0 || b == 1) && (c == 0 || c == 1)) {
        low = std::min({low, v[1], v[2]});
        high = std::max({high, v[1], v[2]});
      }
      rows[b + 1] = cubic(v[0], v[1], v[2], v[3], at.x);
    }
    planes[c + 1] = cubic(rows[0], rows[1], rows[2], rows[3], at.y);
  }
  return std::clamp(cubic(planes[0], planes[1], planes[2], planes[3], at.z), low, high);
}

bool changes_sign(const Field& phi, int i, int j, int k) {
  const bool wet = phi(i, j, k) < 0.0;
  return (phi.clamped(i - 1, j, k) < 0.0) != wet || (phi.clamped(i + 1, j, k) < 0.0) != wet ||
         (phi.clamped(i, j - 1, k) < 0.0) != wet || (phi.clamped(i, j + 1, k) < 0.0) != wet ||
         (phi.clamped(i, j, k - 1) < 0.0) != wet || (phi.clamped(i, j, k + 1) < 0.0) != wet;
}

/// |grad phi| by differences towards the surface (Godunov), which kinks behind the cell do not blur.
double slope_from_surface(const Field& phi, double h, int i, int j, int k) {
  const double here = phi(i, j, k), sign = here < 0.0 ? -1.0 : 1.0;
  const auto fall = [&](double low, double high) { return std::max({sign * (here - low), sign * (here - high), 0.0}); };
  const double x = fall(phi.clamped(i - 1, j, k), phi.clamped(i + 1, j, k)),
               y = fall(phi.clamped(i, j - 1, k), phi.clamped(i, j + 1, k)),
               z = fall(phi.clamped(i, j, k - 1), phi.clamped(i, j, k + 1));
  return std::sqrt(x * x + y * y + z * z) / h;
}

/// |grad u| = 1 from the smallest neighbours along the axes.
double eikonal(double a, double b, double c, double h) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  double d = a + h;
  if (d <= b) return d;
  d = 0.5 * (a + b + std::sqrt(std::max(0.0, 2.0 * h * h - (a - b) * (a - b))));
  if (d <= c) return d;
  const double sum = a + b + c, squares = a * a + b * b + c * c;
  return (sum + std::sqrt(std::max(0.0, sum * sum - 3.0 * (squares - h * h)))) / 3.0;
}

/// For each row of cells along x, first and last that are within so many cells of a marked one.
std::vector<std::array<int, 2>> rows_near(const Grid3<std::uint8_t>& marked, int cells) {
  const int nx = marked.nx(), ny = marked.ny(), nz = marked.nz();
  const std::array<int, 2> none{nx, -1};
  std::vector<std::array<int, 2>> rows(static_cast<std::size_t>(ny) * nz, none), wide = rows;
  const auto row = [&](auto& list, int j, int k) -> std::array<int, 2>& {
    return list[static_cast<std::size_t>(j) + static_cast<std::size_t>(ny) * k];
  };
  const auto join = [](std::array<int, 2>& a, const std::array<int, 2>& b) {
    a = {std::min(a[0], b[0]), std::max(a[1], b[1])};
  };
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        if (marked(i, j, k) != 0) join(row(rows, j, k), {std::max(i - cells, 0), std::min(i + cells, nx - 1)});
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int b = std::max(j - cells, 0); b <= std::min(j + cells, ny - 1); ++b)
        join(row(wide, j, k), row(rows, b, k));
  rows.assign(rows.size(), none);
  for (int k = 0; k < nz; ++k)
    for (int c = std::max(k - cells, 0); c <= std::min(k + cells, nz - 1); ++c)
      for (int j = 0; j < ny; ++j) join(row(rows, j, k), row(wide, j, c));
  return rows;
}

/// Fast sweeping (Zhao 2005) from the cells that are frozen out to reach_m.
void sweep_distance(const GridShape& shape, const Grid3<std::uint8_t>& frozen, double reach_m, Field& distance) {
  const int nx = shape.nx, ny = shape.ny, nz = shape.nz;
  const double h = shape.cell_m;
  const auto cells = static_cast<int>(std::min(std::ceil(reach_m / h) + 1.0, 1.0 * std::max({nx, ny, nz})));
  const std::vector<std::array<int, 2>> rows = rows_near(frozen, cells);
  const std::ptrdiff_t sy = nx, sz = static_cast<std::ptrdiff_t>(nx) * ny;
  for (int sweep = 0; sweep < 8; ++sweep) {
    const bool fx = (sweep & 1) != 0, fy = (sweep & 2) != 0, fz = (sweep & 4) != 0;
    for (int c = 0; c < nz; ++c) {
      const int k = fz ? nz - 1 - c : c;
      for (int b = 0; b < ny; ++b) {
        const int j = fy ? ny - 1 - b : b;
        const auto [first, last] = rows[static_cast<std::size_t>(j) + static_cast<std::size_t>(ny) * k];
        const std::uint8_t* const held = frozen.data().data() + frozen.index(0, j, k);
        double* const d = distance.data().data() + distance.index(0, j, k);
        // Outside the box lies nothing nearer: the cell itself stands for it.
        const std::ptrdiff_t y0 = j > 0 ? -sy : 0, y1 = j + 1 < ny ? sy : 0, z0 = k > 0 ? -sz : 0,
                             z1 = k + 1 < nz ? sz : 0;
        for (int a = first; a <= last; ++a) {
          const int i = fx ? first + last - a : a;
          if (held[i] != 0) continue;
          const double x = std::min(d[i > 0 ? i - 1 : i], d[i + 1 < nx ? i + 1 : i]),
                       y = std::min(d[i + y0], d[i + y1]), z = std::min(d[i + z0], d[i + z1]);
          const double least = std::min(x, std::min(y, z));
          if (!(least < reach_m) || !(least + kLeastStep * h < d[i])) continue;
          d[i] = std::min(d[i], eikonal(x, y, z, h));
        }
      }
    }
  }
}

}  // namespace

Vector3d slope_at(const Field& phi, double h, int i, int j, int k) {
  return Vector3d(phi.clamped(i + 1, j, k) - phi.clamped(i - 1, j, k),
                  phi.clamped(i, j + 1, k) - phi.clamped(i, j - 1, k),
                  phi.clamped(i, j, k + 1) - phi.clamped(i, j, k - 1)) /
         (2.0 * h);
}

double curvature_per_m(const Field& phi, double h, int i, int j, int k) {
  const auto at = [&](int a, int b, int c) { return phi.clamped(i + a, j + b, k + c); };
  const Vector3d g = slope_at(phi, h, i, j, k);
  const double centre = at(0, 0, 0), hh = h * h;
  const double xx = (at(1, 0, 0) - 2.0 * centre + at(-1, 0, 0)) / hh,
               yy = (at(0, 1, 0) - 2.0 * centre + at(0, -1, 0)) / hh,
               zz = (at(0, 0, 1) - 2.0 * centre + at(0, 0, -1)) / hh;
  const double xy = (at(1, 1, 0) - at(1, -1, 0) - at(-1, 1, 0) + at(-1, -1, 0)) / (4.0 * hh),
               xz = (at(1, 0, 1) - at(1, 0, -1) - at(-1, 0, 1) + at(-1, 0, -1)) / (4.0 * hh),
               yz = (at(0, 1, 1) - at(0, 1, -1) - at(0, -1, 1) + at(0, -1, -1)) / (4.0 * hh);
  const double gg = g.squaredNorm();
  if (!(gg > 1e-12)) return 0.0;
  const double x = g.x(), y = g.y(), z = g.z();
  return (x * x * (yy + zz) + y * y * (xx + zz) + z * z * (xx + yy) - 2.0 * (x * y * xy + x * z * xz + y * z * yz)) /
         (gg * std::sqrt(gg));
}

void advect_level_set(const GridShape& shape, const MacGrid& u, double step_s, double band_m, Field& phi) {
  const Field before = phi;
  const double h = shape.cell_m;
  const Vector3d low = Vector3d::Constant(0.5 * h), high = shape.size_m() - low;
  for_layers(shape.nz, [&](int k) {
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        if (!(std::abs(before(i, j, k)) < band_m)) continue;
        const Vector3d x = shape.centre_m(i, j, k);
        const Vector3d k1 = velocity_at(u, x, h);
        const Vector3d k2 = velocity_at(u, x - 0.5 * step_s * k1, h);
        const Vector3d k3 = velocity_at(u, x - 0.75 * step_s * k2, h);
        const Vector3d from = x - step_s / 9.0 * (2.0 * k1 + 3.0 * k2 + 4.0 * k3);
        const Vector3d g = from.cwiseMax(low).cwiseMin(high) / h - Vector3d::Constant(0.5);
        phi(i, j, k) = tricubic(before, g.x(), g.y(), g.z());
      }
  });
}

void redistance(const GridShape& shape, double keep_m, double reach_m, Field& phi) {
  const double h = shape.cell_m;
  Grid3<std::uint8_t> frozen(shape.nx, shape.ny, shape.nz, 0);
  Field distance(shape.nx, shape.ny, shape.nz, reach_m);
  for_layers(shape.nz, [&](int k) {
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        const double value = std::abs(phi(i, j, k));
        if (!(value < keep_m) && !(value < 2.0 * h)) continue;
        const bool near = value < 2.0 * h && changes_sign(phi, i, j, k);
        if (!near && !(value < keep_m)) continue;
        const double slope = slope_from_surface(phi, h, i, j, k);
        const bool even = slope > 0.7 && slope < 1.4;
        if (!near && !even) continue;
        frozen(i, j, k) = 1;
        distance(i, j, k) = even || !(slope > 0.0) ? value : std::min(value / std::clamp(slope, 0.2, 5.0), 1.5 * h);
      }
  });
  sweep_distance(shape, frozen, reach_m, distance);
  for (std::size_t c = 0; c < phi.size(); ++c) phi[c] = phi[c] < 0.0 ? -distance[c] : distance[c];
}

double plane_fraction(double value, const Vector3d& slope) {
  std::array<double, 3> m{std::abs(slope.x()), std::abs(slope.y()), std::abs(slope.z())};
  const double sum = m[0] + m[1] + m[2];
  if (!(sum > 1e-12)) return value < 0.0 ? 1.0 : 0.0;
  double alpha = 0.5 - value / sum;
  if (alpha <= 0.0) return 0.0;
  if (alpha >= 1.0) return 1.0;
  std::sort(m.begin(), m.end());
  const double m1 = m[0] / sum, m2 = m[1] / sum, m3 = m[2] / sum, m12 = m1 + m2;
  const bool upper = alpha > 0.5;
  if (upper) alpha = 1.0 - alpha;
  double volume;
  if (alpha < m1) {
    volume = alpha * alpha * alpha / (6.0 * m1 * m2 * m3);
  } else if (alpha < m2) {
    volume = 0.5 * alpha * (alpha - m1) / (m2 * m3) + m1 * m1 / std::max(6.0 * m2 * m3, 1e-300);
  } else if (alpha < std::min(m12, m3)) {
    volume = m1 < 1e-9
                 ? (alpha - 0.5 * m2) / m3
                 : (alpha * alpha * (3.0 * m12 - alpha) + m1 * m1 * (m1 - 3.0 * alpha) + m2 * m2 * (m2 - 3.0 * alpha)) /
                       (6.0 * m1 * m2 * m3);
  } else if (m3 < m12) {
    volume = (alpha * alpha * (3.0 - 2.0 * alpha) + m1 * m1 * (m1 - 3.0 * alpha) + m2 * m2 * (m2 - 3.0 * alpha) +
              m3 * m3 * (m3 - 3.0 * alpha)) /
             (6.0 * m1 * m2 * m3);
  } else {
    volume = 0.5 * (2.0 * alpha - m12) / m3;
  }
  return upper ? 1.0 - volume : volume;
}

namespace {

/// Of a cell that a solid cuts.
double cut_fraction(const SolidField& solid, double h, const Vector3d& cell, double value, const Vector3d& slope) {
  constexpr int kSub = 4;
  double sum = 0.0;
  for (int c = 0; c < kSub; ++c)
    for (int b = 0; b < kSub; ++b)
      for (int a = 0; a < kSub; ++a) {
        const Vector3d at((a + 0.5) / kSub, (b + 0.5) / kSub, (c + 0.5) / kSub);
        const double open = trilinear(solid.distance_m, cell.x() + at.x(), cell.y() + at.y(), cell.z() + at.z()) / h;
        const double wet = value + slope.dot(at - Vector3d::Constant(0.5));
        sum += std::clamp(0.5 + kSub * open, 0.0, 1.0) * std::clamp(0.5 - kSub * wet, 0.0, 1.0);
      }
  return sum / (kSub * kSub * kSub);
}

/// A curved surface bends away from the plane: by the mean over a cell of what it bends, a 24th of its curvature. Where phi has a ridge
/// (in films, which planes take 10 % too thick in the mean) there is no curvature to be had.
double cut_share(const Field& phi, double h, double shift_m, int i, int j, int k) {
  constexpr double kRidge = 0.5, kMostCurved = 2.0;
  const Vector3d slope = slope_at(phi, h, i, j, k);
  const double curved = slope.squaredNorm() < kRidge ? 0.0 : h * curvature_per_m(phi, h, i, j, k);
  return plane_fraction((phi(i, j, k) + shift_m) / h + std::clamp(curved, -kMostCurved, kMostCurved) / 24.0, slope);
}

}  // namespace

double wet_share(const Field& phi, const SolidField& solid, double h, const std::array<int, 3>& cell, double shift_m) {
  const auto [i, j, k] = cell;
  const double open = solid.open_volume(i, j, k), value = (phi(i, j, k) + shift_m) / h;
  if (!(open > 0.0) || value > 1.0) return 0.0;
  if (value < -1.0) return open;
  if (!solid.whole(i, j, k))
    return cut_fraction(solid, h, {1.0 * i, 1.0 * j, 1.0 * k}, value, slope_at(phi, h, i, j, k));
  return open * cut_share(phi, h, shift_m, i, j, k);
}

double liquid_volume_m3(const GridShape& shape, const Field& phi, const SolidField& solid, double shift_m) {
  const double h = shape.cell_m;
  std::vector<double> layers(static_cast<std::size_t>(shape.nz), 0.0);
  for_layers(shape.nz, [&](int k) {
    double sum = 0.0;
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) sum += wet_share(phi, solid, h, {i, j, k}, shift_m);
    layers[static_cast<std::size_t>(k)] = sum;
  });
  double sum = 0.0;
  for (const double layer : layers) sum += layer;
  return sum * h * h * h;
}

VolumeShift shift_to_volume(const GridShape& shape, const SolidField& solid, double wanted, double most_m, Field& phi) {
  const double before = liquid_volume_m3(shape, phi, solid);
  double volume = before, sum = 0.0;
  for (int turn = 0; turn < 3 && std::abs(volume - wanted) > 1e-12 * wanted; ++turn) {
    const double step = 0.02 * shape.cell_m;
    const double area = (volume - liquid_volume_m3(shape, phi, solid, step)) / step;
    if (!(area > 0.0)) break;
    const double shift = std::clamp((volume - wanted) / area, -most_m, most_m);
    for (double& value : phi.data()) value += shift;
    sum += shift;
    volume = liquid_volume_m3(shape, phi, solid);
  }
  return {before, volume, sum};
}

namespace {

double minmod(double a, double b) { return a * b > 0.0 ? (std::abs(a) < std::abs(b) ? a : b) : 0.0; }

/// One component: layer after layer of the faces next to known ones. The first layer of a tangential component goes on with its slope.
void extrapolate_component(int axis, int layers, bool slopes, Field& field, Grid3<std::uint8_t>& known) {
  const int nx = field.nx(), ny = field.ny(), nz = field.nz();
  const std::size_t layer_stride = static_cast<std::size_t>(nx) * ny;
  constexpr std::uint8_t kAsked = 2;  // in the list of the next layer
  std::vector<std::size_t> now, next;
  const auto for_neighbours = [&](std::size_t f, const auto& body) {
    const int i = static_cast<int>(f % nx), j = static_cast<int>(f % layer_stride / nx),
              k = static_cast<int>(f / layer_stride);
    if (i > 0) body(f - 1);
    if (i + 1 < nx) body(f + 1);
    if (j > 0) body(f - nx);
    if (j + 1 < ny) body(f + nx);
    if (k > 0) body(f - layer_stride);
    if (k + 1 < nz) body(f + layer_stride);
  };
  for (std::size_t f = 0; f < known.size(); ++f) {
    if (known[f] != 0) continue;
    bool beside = false;
    for_neighbours(f, [&](std::size_t g) { beside = beside || known[g] == 1; });
    if (!beside) continue;
    known[f] = kAsked;
    now.push_back(f);
  }
  const std::array<std::ptrdiff_t, 3> strides{1, nx, static_cast<std::ptrdiff_t>(layer_stride)};
  const std::array<int, 3> sizes{nx, ny, nz};
  /// From two known faces behind g, as seen from f; 0 where there are none or they disagree.
  const auto rise = [&](std::size_t f, std::size_t g) {
    const std::ptrdiff_t back = static_cast<std::ptrdiff_t>(g) - static_cast<std::ptrdiff_t>(f);
    for (std::size_t a = 0; a < 3; ++a) {
      if (std::abs(back) != strides[a] || sizes[a] == 1) continue;
      if (static_cast<int>(a) == axis) return 0.0;
      const auto place =
          static_cast<int>(g / static_cast<std::size_t>(strides[a]) % static_cast<std::size_t>(sizes[a]));
      if (back > 0 ? place + 2 >= sizes[a] : place < 2) return 0.0;
      const std::size_t first = g + static_cast<std::size_t>(back), second = first + static_cast<std::size_t>(back);
      if (known[first] != 1 || known[second] != 1) return 0.0;
      return minmod(field[g] - field[first], field[first] - field[second]);
    }
    return 0.0;
  };
  std::vector<double> values;
  for (int layer = 0; layer < layers && !now.empty(); ++layer) {
    values.clear();
    for (const std::size_t f : now) {
      double sum = 0.0;
      int count = 0;
      for_neighbours(f, [&](std::size_t g) {
        if (known[g] != 1) return;
        sum += field[g] + (slopes && layer == 0 ? rise(f, g) : 0.0);
        ++count;
      });
      values.push_back(sum / count);
    }
    next.clear();
    for (std::size_t n = 0; n < now.size(); ++n) {
      field[now[n]] = values[n];
      known[now[n]] = 1;
    }
    for (const std::size_t f : now)
      for_neighbours(f, [&](std::size_t g) {
        if (known[g] != 0) return;
        known[g] = kAsked;
        next.push_back(g);
      });
    now.swap(next);
  }
  for (const std::size_t f : now) known[f] = 0;
}

}  // namespace

void extrapolate(const GridShape& shape, int layers, bool slopes, MacGrid& u, FaceMask& known) {
  parallel_for(3, 1, [&](std::size_t component, std::size_t) {
    const auto axis = static_cast<int>(component);
    extrapolate_component(axis, layers, slopes, u[axis], known[axis]);
  });
  for (int axis = 0; axis < 3; ++axis) {  // no flow through the box's walls
    Field& field = u[axis];
    for_layers(field.nz(), [&](int k) {
      for (int j = 0; j < field.ny(); ++j)
        for (int i = 0; i < field.nx(); ++i) {
          const int along = axis == 0 ? i : axis == 1 ? j : k;
          if (along == 0 || along == shape.n(axis)) field(i, j, k) = 0.0;
        }
    });
  }
}

void continue_into_air(const GridShape& shape, const Field& phi, const Grid3<std::uint8_t>& liquid,
                       const FaceMask& valid, bool round, MacGrid& u) {
  const double h = shape.cell_m;
  // In the round, faces across x are wider than the cell's middle (sector_field).
  const auto width = [&](int face, int i) { return round ? face / (i + 0.5) : 1.0; };
  struct Change {
    int axis;
    std::size_t face;
    double value;
  };
  std::vector<std::vector<Change>> changes(static_cast<std::size_t>(shape.nz));
  for_layers(shape.nz, [&](int k) {
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        if (liquid(i, j, k) != 0 || phi(i, j, k) < 0.0 || !(phi(i, j, k) < 1.5 * h)) continue;
        const auto wet = [&](int a, int b, int c) { return liquid.contains(a, b, c) && liquid(a, b, c) != 0; };
        if (!wet(i - 1, j, k) && !wet(i + 1, j, k) && !wet(i, j - 1, k) && !wet(i, j + 1, k) && !wet(i, j, k - 1) &&
            !wet(i, j, k + 1))
          continue;
        const double flux = width(i + 1, i) * u[0](i + 1, j, k) - width(i, i) * u[0](i, j, k) + u[1](i, j + 1, k) -
                            u[1](i, j, k) + u[2](i, j, k + 1) - u[2](i, j, k);
        const Vector3d away = slope_at(phi, h, i, j, k);
        std::array<double, 3> weight{};
        double sum = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
          const int up = away[axis] > 0.0 ? 1 : 0;
          const int a = i + (axis == 0 ? up : 0), b = j + (axis == 1 ? up : 0), c = k + (axis == 2 ? up : 0);
          const int along = axis == 0 ? a : axis == 1 ? b : c;
          if (along == 0 || along == shape.n(axis) || valid[axis](a, b, c) != 0) continue;
          weight[static_cast<std::size_t>(axis)] = away[axis] * away[axis];
          sum += weight[static_cast<std::size_t>(axis)];
        }
        if (!(sum > 0.25)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const int up = away[axis] > 0.0 ? 1 : 0;
          const double share = weight[static_cast<std::size_t>(axis)] / sum;
          if (share > 0.0)
            changes[static_cast<std::size_t>(k)].push_back(
                {axis, u[axis].index(i + (axis == 0 ? up : 0), j + (axis == 1 ? up : 0), k + (axis == 2 ? up : 0)),
                 (up == 1 ? -flux : flux) * share / (axis == 0 ? width(i + up, i) : 1.0)});
        }
      }
  });
  for (const auto& layer : changes)
    for (const Change& change : layer) u[change.axis][change.face] += change.value;
}

std::size_t correct_by_particles(const GridShape& shape, const Particles& particles, const SolidField& solid,
                                 const ParticleCorrection& correction, Field& phi) {
  const double h = shape.cell_m, outside_m = correction.outside_cells * h;
  const double radius_m = correction.radius_cells * h, reach_m = correction.reach_cells * h;
  const Field before = phi;
  std::vector<std::size_t> changed(static_cast<std::size_t>(shape.nz), 0);
  std::vector<std::uint8_t> outside(particles.size(), 0);
  parallel_for(shape.n_cells(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (before[c] < -h) continue;
      for (std::size_t p = particles.begin[c]; p < particles.begin[c + 1]; ++p)
        outside[p] = at_centres(before, particles.x_m[p], h) > outside_m ? 1 : 0;
    }
  });
  for_layers(shape.nz, [&](int k) {
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        const double value = before(i, j, k);
        const bool bound = value < 0.0 && value > -1.5 * h && solid.whole(i, j, k) &&
                           (!solid.any || at_nodes(solid.distance_m, shape.centre_m(i, j, k), h) > h);
        if (!bound && !(value > 0.0)) continue;
        const Vector3d x = shape.centre_m(i, j, k);
        double nearest = HUGE_VAL, nearest_outside = HUGE_VAL;
        for (int c = std::max(k - 1, 0); c <= std::min(k + 1, shape.nz - 1); ++c)
          for (int b = std::max(j - 1, 0); b <= std::min(j + 1, shape.ny - 1); ++b)
            for (int a = std::max(i - 1, 0); a <= std::min(i + 1, shape.nx - 1); ++a) {
              const std::size_t cell = shape.index(a, b, c);
              for (std::size_t p = particles.begin[cell]; p < particles.begin[cell + 1]; ++p) {
                const double sq = (particles.x_m[p] - x).squaredNorm();
                nearest = std::min(nearest, sq);
                if (outside[p] != 0) nearest_outside = std::min(nearest_outside, sq);
              }
            }
        double now = value;
        if (nearest_outside < HUGE_VAL) now = std::min(now, std::sqrt(nearest_outside) - radius_m);
        if (bound && nearest > reach_m * reach_m) now = std::max(now, std::min(std::sqrt(nearest), 1.5 * h) - reach_m);
        if ((now < 0.0) != (value < 0.0)) ++changed[static_cast<std::size_t>(k)];
        phi(i, j, k) = now;
      }
  });
  std::size_t sum = 0;
  for (const std::size_t count : changed) sum += count;
  return sum;
}

}  // namespace klang::liquid
