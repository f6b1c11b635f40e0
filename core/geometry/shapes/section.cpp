#include "core/geometry/shapes/section.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/quadrature.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/detail/revolution.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector2d;
using Map = std::function<Vector2d(double u, double v)>;

/// The image of the unit square, divided n_u x n_v times.
struct Patch {
  int n_u = 1, n_v = 1;
  Map map;
};

/// Borders of n even cells of [0, length] between layers that double in length from the ends on, the first thick_m long:
/// at a free end of a thin wall the plate's edge layer is as wide as the wall.
std::vector<double> borders(double length_m, double thick_m, int n, int layers_low, int layers_high) {
  const auto total = [&](int layers) { return thick_m * (std::ldexp(1.0, layers) - 1.0); };
  // However the dimensions change, the layers leave half of the length to the even cells.
  const double scale = std::min(1.0, 0.5 * length_m / std::max(total(layers_low) + total(layers_high), 1e-300));
  std::vector<double> border = {0.0};
  for (int k = 0; k < layers_low; ++k) border.push_back(border.back() + scale * std::ldexp(thick_m, k));
  const double from = border.back(), to = length_m - scale * total(layers_high);
  for (int i = 1; i <= n; ++i) border.push_back(from + (to - from) * i / n);
  for (int k = layers_high - 1; k >= 0; --k) border.push_back(border.back() + scale * std::ldexp(thick_m, k));
  border.back() = length_m;
  return border;
}

/// Piecewise linear through the borders, s on [0, 1] with a cell to each 1 / n.
double along(const std::vector<double>& border, double s) {
  const auto n = static_cast<double>(border.size() - 1);
  const double cell = std::clamp(std::floor(s * n + 1e-9), 0.0, n - 1.0), t = s * n - cell;
  const auto i = static_cast<std::size_t>(cell);
  return border[i] + t * (border[i + 1] - border[i]);
}

/// Half a unit disk (x >= 0) as five patches of a square and its surroundings; the point's polar map is smooth in each.
std::vector<Patch> half_disk(int n, const std::function<Vector2d(const Vector2d&)>& place) {
  constexpr double h = 0.45;  // half the inner square's side
  std::vector<Patch> patches;
  const auto inner = [=](double u, double v) { return place({h * u, h * (2.0 * v - 1.0)}); };
  patches.push_back({n, 2 * n, inner});
  // A straight line from the square's side to the circle, sides being split evenly in angle on the circle.
  const auto outer = [=](Vector2d a, Vector2d b, double angle_a, double angle_b) {
    return [=](double u, double v) {
      const double angle = angle_a + (angle_b - angle_a) * v;
      const Vector2d circle(std::cos(angle), std::sin(angle));
      return place((1.0 - u) * (a + v * (b - a)) + u * circle);
    };
  };
  patches.push_back({n, n, outer({0.0, -h}, {h, -h}, -0.5 * kPi, -0.25 * kPi)});
  patches.push_back({n, 2 * n, outer({h, -h}, {h, h}, -0.25 * kPi, 0.25 * kPi)});
  patches.push_back({n, n, outer({h, h}, {0.0, h}, 0.25 * kPi, 0.5 * kPi)});
  return patches;
}

std::vector<Patch> profile_patches(const detail::Profile& profile, double edge_m) {
  const detail::FlatMesh flat = detail::mesh_profile(profile, edge_m);
  std::vector<Patch> patches;
  for (const auto& triangle : flat.triangles) {
    std::array<Vector2d, 3> p;
    for (int c = 0; c < 3; ++c) p[c] = flat.points_m[static_cast<std::size_t>(triangle[c])];
    const Vector2d middle = (p[0] + p[1] + p[2]) / 3.0;
    for (int c = 0; c < 3; ++c) {
      const Vector2d a = p[c], b = 0.5 * (p[c] + p[(c + 1) % 3]), d = 0.5 * (p[c] + p[(c + 2) % 3]);
      patches.push_back({1, 1, [=](double u, double v) -> Vector2d {
                           return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * middle + (1 - u) * v * d;
                         }});
    }
  }
  return patches;
}

double profile_extent_m(const detail::Profile& profile) {
  Vector2d low = profile.points_m[0], high = low;
  for (const Vector2d& point : profile.points_m) low = low.cwiseMin(point), high = high.cwiseMax(point);
  return (high - low).maxCoeff();
}

std::vector<Patch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) {
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  if (spec.kind == "tube" || spec.kind == "rod") {
    const double length_m = dim("length_m");
    const double outer_m = spec.kind == "tube" ? dim("outer_radius_m") : dim("radius_m");
    const double inner_m = spec.kind == "tube" ? outer_m - dim("wall_m") : 0.0;
    const auto border = borders(length_m, outer_m - inner_m, n[0], n[2], n[2]);
    return {{n[1], n[0] + 2 * n[2], [=](double u, double v) -> Vector2d {
               return {inner_m + u * (outer_m - inner_m), along(border, v) - 0.5 * length_m};
             }}};
  }
  if (spec.kind == "bowl") {
    const double outer_m = dim("outer_radius_m"), wall_m = dim("wall_m"), depth_m = dim("depth_m");
    const auto border = borders(1.0, wall_m / (outer_m * std::acos(1.0 - depth_m / outer_m)), n[0], 0, n[2]);
    return {{n[0] + n[2], n[1], [=](double u, double v) -> Vector2d {
               const double radius_m = outer_m - v * wall_m;
               const double angle = along(border, u) * std::acos((outer_m - depth_m) / radius_m);
               return {radius_m * std::sin(angle), outer_m - radius_m * std::cos(angle)};
             }}};
  }
  if (spec.kind == "revolution") {
    const detail::Profile profile = detail::read_profile(spec.profile_csv);
    return profile_patches(profile, profile_extent_m(profile) / n[0]);
  }
  const double a_m = spec.kind == "sphere" ? dim("radius_m") : dim("a_m");
  const double c_m = spec.kind == "sphere" ? dim("radius_m") : dim("c_m");
  return half_disk(n[0], [=](const Vector2d& p) -> Vector2d { return {a_m * p.x(), c_m * p.y()}; });
}

/// Points closer than the glue length become one node.
class GluedNodes {
 public:
  explicit GluedNodes(double glue_m) : glue_m_(glue_m) {}
  int number(const Vector2d& p) {
    const long x = std::lround(p.x() / glue_m_), y = std::lround(p.y() / glue_m_);
    for (long dx = -1; dx <= 1; ++dx) {
      for (long dy = -1; dy <= 1; ++dy) {
        const auto found = index_.find({x + dx, y + dy});
        if (found != index_.end()) return found->second;
      }
    }
    index_[{x, y}] = static_cast<int>(points.size());
    points.push_back(p);
    return static_cast<int>(points.size()) - 1;
  }
  std::vector<Vector2d> points;

 private:
  double glue_m_;
  std::map<std::array<long, 2>, int> index_;
};

}  // namespace

bool is_axisymmetric(const ShapeSpec& spec) {
  if (spec.kind == "ellipsoid") return spec.dims.at("a_m") == spec.dims.at("b_m");
  return spec.kind == "tube" || spec.kind == "rod" || spec.kind == "sphere" || spec.kind == "bowl" ||
         spec.kind == "revolution";
}

double section_thickness_m(const ShapeSpec& spec) {
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  if (spec.kind == "tube" || spec.kind == "bowl") return dim("wall_m");
  if (spec.kind == "rod") return 2.0 * dim("radius_m");
  if (spec.kind == "sphere") return 2.0 * dim("radius_m");
  if (spec.kind == "ellipsoid") return 2.0 * std::min(dim("a_m"), dim("c_m"));
  const detail::Profile profile = detail::read_profile(spec.profile_csv);
  double perimeter_m = 0.0, twice_area_m2 = 0.0;
  for (std::size_t i = 0; i < profile.points_m.size(); ++i) {
    const Vector2d &a = profile.points_m[i], &b = profile.points_m[(i + 1) % profile.points_m.size()];
    perimeter_m += (b - a).norm();
    twice_area_m2 += a.x() * b.y() - a.y() * b.x();
  }
  return twice_area_m2 / perimeter_m;
}

SectionDivisions section_divisions(const ShapeSpec& spec, double edge_m) {
  validate(spec);
  if (!is_axisymmetric(spec)) throw InputError("shape " + spec.kind, "is not a body of revolution");
  checked_open("section", "edge_m", edge_m, 0.0, 1e6);
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  const auto divided = [&](double length_m, int at_least = 1) {
    const double count = std::ceil(length_m / edge_m - 1e-9);
    detail::check_element_count(count * count);
    return std::max(at_least, static_cast<int>(count));
  };
  const auto layers = [&](double thick_m, double length_m) {
    int n = 0;
    while (n < 20 && std::ldexp(thick_m, n) < edge_m && std::ldexp(thick_m, n + 1) < 0.25 * length_m) ++n;
    return n;
  };
  SectionDivisions divisions;
  auto& n = divisions.counts;
  if (spec.kind == "tube") {
    n = {divided(dim("length_m"), 4), divided(dim("wall_m")), layers(dim("wall_m"), dim("length_m"))};
  } else if (spec.kind == "rod") {
    n = {divided(dim("length_m"), 4), divided(dim("radius_m"), 2), layers(0.5 * dim("radius_m"), dim("length_m"))};
  } else if (spec.kind == "bowl") {
    const double arc_m = dim("outer_radius_m") * std::acos(1.0 - dim("depth_m") / dim("outer_radius_m"));
    n = {divided(arc_m, 4), divided(dim("wall_m")), layers(dim("wall_m"), arc_m)};
  } else if (spec.kind == "revolution") {
    const double extent_m = profile_extent_m(detail::read_profile(spec.profile_csv));
    // Thin walls get triangles about as long as the wall is thick, which three quadrilaterals each divide further.
    const double wanted_m = std::min(edge_m, 4.0 * section_thickness_m(spec));
    n = {std::clamp(static_cast<int>(std::ceil(extent_m / wanted_m)), 4, 4000), 1, 0};
  } else {
    const double largest_m = spec.kind == "sphere" ? dim("radius_m") : std::max(dim("a_m"), dim("c_m"));
    n = {divided(0.6 * largest_m, 2), 1, 0};
  }
  return divisions;
}

Section mesh_section(const ShapeSpec& spec, const SectionDivisions& divisions) {
  validate(spec);
  if (!is_axisymmetric(spec)) throw InputError("shape " + spec.kind, "is not a body of revolution");
  KLANG_CHECK(divisions.degree >= 1 && divisions.degree <= 12, "section degree 1 to 12");
  const int p = divisions.degree, row = p + 1;
  const std::vector<Patch> patches = section_patches(
      spec, {std::max(1, divisions.counts[0]), std::max(1, divisions.counts[1]), std::max(0, divisions.counts[2])});
  double size_m = 0.0;
  int n_elements = 0;
  for (const Patch& patch : patches) {
    n_elements += patch.n_u * patch.n_v;
    for (const double u : {0.0, 1.0})
      for (const double v : {0.0, 0.5, 1.0}) size_m = std::max(size_m, patch.map(u, v).cwiseAbs().maxCoeff());
  }
  detail::check_element_count(static_cast<double>(n_elements) * row * row);
  Section section;
  section.degree = p;
  section.elements.resize(n_elements, row * row);
  const Eigen::VectorXd at = 0.5 * (lobatto_rule(row).points.array() + 1.0);
  GluedNodes nodes(1e-9 * size_m);
  int e = 0;
  for (const Patch& patch : patches) {
    for (int j = 0; j < patch.n_v; ++j) {
      for (int i = 0; i < patch.n_u; ++i, ++e) {
        for (int b = 0; b < row; ++b) {
          for (int a = 0; a < row; ++a) {
            Vector2d point = patch.map((i + at[a]) / patch.n_u, (j + at[b]) / patch.n_v);
            if (std::abs(point.x()) <= 1e-9 * size_m) point.x() = 0.0;
            section.elements(e, b * row + a) = nodes.number(point);
          }
        }
        // A map that turns the square over is read the other way round.
        const auto corner = [&](int a, int b) {
          return nodes.points[static_cast<std::size_t>(section.elements(e, b * row + a))];
        };
        const Vector2d along = corner(p, 0) - corner(0, 0), across = corner(0, p) - corner(0, 0);
        if (along.x() * across.y() - along.y() * across.x() < 0.0) {
          for (int b = 0; b < row; ++b)
            for (int a = 0; a < row / 2; ++a)
              std::swap(section.elements(e, b * row + a), section.elements(e, b * row + p - a));
        }
      }
    }
  }
  section.nodes_m.resize(static_cast<Eigen::Index>(nodes.points.size()), 2);
  for (std::size_t i = 0; i < nodes.points.size(); ++i)
    section.nodes_m.row(static_cast<Eigen::Index>(i)) = nodes.points[i];
  return section;
}

SectionLocator::SectionLocator(const Section& section)
    : section_(section), nodes_(lobatto_rule(section.degree + 1).points) {
  for (int e = 0; e < section.n_elements(); ++e) {
    Vector2d low = section.nodes_m.row(section.elements(e, 0)), high = low;
    for (Eigen::Index c = 1; c < section.elements.cols(); ++c) {
      const Vector2d p = section.nodes_m.row(section.elements(e, c));
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Vector2d margin = Vector2d::Constant(0.02 * (high - low).maxCoeff());
    low_.push_back(low - margin);
    high_.push_back(high + margin);
  }
}

SectionLocator::Place SectionLocator::find(double r_m, double z_m) const {
  const Vector2d target(r_m, z_m);
  const int row = section_.degree + 1;
  Place best;
  double best_outside = HUGE_VAL;
  for (int e = 0; e < section_.n_elements() && best_outside > 1e-9; ++e) {
    if ((target.array() < low_[static_cast<std::size_t>(e)].array()).any() ||
        (target.array() > high_[static_cast<std::size_t>(e)].array()).any())
      continue;
    Vector2d at = Vector2d::Zero();
    LagrangeTable x, y;
    for (int step = 0; step < 20; ++step) {
      x = lagrange_table(nodes_, at.segment<1>(0));
      y = lagrange_table(nodes_, at.segment<1>(1));
      Vector2d here = Vector2d::Zero();
      Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
      for (int b = 0; b < row; ++b) {
        for (int a = 0; a < row; ++a) {
          const Vector2d node = section_.nodes_m.row(section_.elements(e, b * row + a));
          here += x.value(0, a) * y.value(0, b) * node;
          jacobian.col(0) += x.slope(0, a) * y.value(0, b) * node;
          jacobian.col(1) += x.value(0, a) * y.slope(0, b) * node;
        }
      }
      const Vector2d move = jacobian.inverse() * (target - here);
      at = (at + move).cwiseMax(-1.3).cwiseMin(1.3);
      if (!(move.norm() > 1e-12)) break;
    }
    const double outside = std::max(0.0, at.cwiseAbs().maxCoeff() - 1.0);
    if (outside < best_outside) {
      best_outside = outside;
      best.element = e;
      at = at.cwiseMax(-1.0 - 1e-3).cwiseMin(1.0 + 1e-3);
      x = lagrange_table(nodes_, at.segment<1>(0));
      y = lagrange_table(nodes_, at.segment<1>(1));
      best.weight.resize(row * row);
      for (int b = 0; b < row; ++b)
        for (int a = 0; a < row; ++a) best.weight[b * row + a] = x.value(0, a) * y.value(0, b);
    }
  }
  return best;
}

}  // namespace klang::mesh
