#include "core/geometry/shapes/section.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/quadrature.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/shape_registry.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector2d;

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

/// An element whose map turned the square over is read the other way round.
void turn_positive(Section& section, int element, const std::vector<Vector2d>& points) {
  const int p = section.degree, row = p + 1;
  const auto corner = [&](int a, int b) {
    return points[static_cast<std::size_t>(section.elements(element, b * row + a))];
  };
  const Vector2d along = corner(p, 0) - corner(0, 0), across = corner(0, p) - corner(0, 0);
  if (!(along.x() * across.y() - along.y() * across.x() < 0.0)) return;
  for (int b = 0; b < row; ++b)
    for (int a = 0; a < row / 2; ++a)
      std::swap(section.elements(element, b * row + a), section.elements(element, b * row + p - a));
}

/// @throws InputError for a bad spec or a body that is not one of revolution
const ShapeKind& axisymmetric_kind(const ShapeSpec& spec) {
  validate(spec);
  if (!is_axisymmetric(spec)) throw InputError("shape " + spec.kind, "is not a body of revolution");
  return find_shape(spec.kind);
}

}  // namespace

bool is_axisymmetric(const ShapeSpec& spec) { return find_shape(spec.kind).is_axisymmetric(spec); }

double section_thickness_m(const ShapeSpec& spec) { return axisymmetric_kind(spec).section_thickness_m(spec); }

SectionDivisions section_divisions(const ShapeSpec& spec, double edge_m) {
  const ShapeKind& kind = axisymmetric_kind(spec);
  checked_open("section", "edge_m", edge_m, 0.0, 1e6);
  SectionDivisions divisions;
  divisions.counts = kind.section_counts(spec, edge_m);
  return divisions;
}

Section mesh_section(const ShapeSpec& spec, const SectionDivisions& divisions) {
  const ShapeKind& kind = axisymmetric_kind(spec);
  KLANG_CHECK(divisions.degree >= 1 && divisions.degree <= 12, "section degree 1 to 12");
  const int p = divisions.degree, row = p + 1;
  const std::vector<SectionPatch> patches = kind.section_patches(
      spec, {std::max(1, divisions.counts[0]), std::max(1, divisions.counts[1]), std::max(0, divisions.counts[2])});
  double size_m = 0.0;
  int n_elements = 0;
  for (const SectionPatch& patch : patches) {
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
  for (const SectionPatch& patch : patches) {
    for (int j = 0; j < patch.n_v; ++j) {
      for (int i = 0; i < patch.n_u; ++i, ++e) {
        for (int b = 0; b < row; ++b) {
          for (int a = 0; a < row; ++a) {
            Vector2d point = patch.map((i + at[a]) / patch.n_u, (j + at[b]) / patch.n_v);
            if (std::abs(point.x()) <= 1e-9 * size_m) point.x() = 0.0;
            section.elements(e, b * row + a) = nodes.number(point);
          }
        }
        turn_positive(section, e, nodes.points);
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
