#include "core/sound/transfer/modal_surface.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/triangle_rules.hpp"
#include "core/geometry/mesh/slits.hpp"
#include "core/geometry/mesh/triangle_distance.hpp"

namespace klang::acoustics {

using Eigen::Vector3d;

namespace {

/// Shape functions of a 6-node triangle (3-node: the first three entries, hats) at barycentric coordinates.
Eigen::Matrix<double, 6, 1> shape_values(const Vector3d& at, bool quadratic) {
  Eigen::Matrix<double, 6, 1> n = Eigen::Matrix<double, 6, 1>::Zero();
  if (!quadratic) {
    n.head<3>() = at;
    return n;
  }
  for (int c = 0; c < 3; ++c) {
    n[c] = at[c] * (2.0 * at[c] - 1.0);
    n[3 + c] = 4.0 * at[c] * at[(c + 1) % 3];
  }
  return n;
}

/// Derivatives by the second and third barycentric coordinate, the first being 1 - their sum.
Eigen::Matrix<double, 6, 2> shape_slopes(const Vector3d& at, bool quadratic) {
  Eigen::Matrix<double, 6, 3> by = Eigen::Matrix<double, 6, 3>::Zero();
  for (int c = 0; c < 3; ++c) {
    if (!quadratic) {
      by(c, c) = 1.0;
      continue;
    }
    by(c, c) = 4.0 * at[c] - 1.0;
    by(3 + c, c) = 4.0 * at[(c + 1) % 3];
    by(3 + c, (c + 1) % 3) = 4.0 * at[c];
  }
  Eigen::Matrix<double, 6, 2> slopes;
  slopes.col(0) = by.col(1) - by.col(0);
  slopes.col(1) = by.col(2) - by.col(0);
  return slopes;
}

/// Lists of elements by cubic cell.
class CellGrid {
 public:
  using Cell = std::array<long, 3>;
  explicit CellGrid(double cell_m) : cell_m_(cell_m) {}
  Cell cell(const Vector3d& p) const {
    return {static_cast<long>(std::floor(p[0] / cell_m_)), static_cast<long>(std::floor(p[1] / cell_m_)),
            static_cast<long>(std::floor(p[2] / cell_m_))};
  }
  void add(const Cell& at, int element) { lists_[at].push_back(element); }
  const std::vector<int>* find(const Cell& at) const {
    const auto found = lists_.find(at);
    return found == lists_.end() ? nullptr : &found->second;
  }

 private:
  struct Hash {
    std::size_t operator()(const Cell& c) const {
      std::size_t h = 0;
      for (const long x : c) h = (h ^ static_cast<std::size_t>(x)) * 0x9e3779b97f4a7c15ULL;
      return h ^ (h >> 29);
    }
  };
  double cell_m_;
  std::unordered_map<Cell, std::vector<int>, Hash> lists_;
};

/// What faces the fluid outside: without slits, whose lips touch.
mesh::SurfaceMesh outer_boundary(const mesh::SurfaceMesh& boundary, const mesh::ShutSlits& slits) {
  mesh::SurfaceMesh shut{boundary.vertices_m, mesh::IndexRows(static_cast<Eigen::Index>(slits.kept.size()), 3)};
  for (Eigen::Index row = 0; row < shut.triangles.rows(); ++row)
    for (int c = 0; c < 3; ++c) shut.triangles(row, c) = slits.vertex_of[boundary.triangles(slits.kept[row], c)];
  const std::vector<bool> outer = faces_outer_fluid(shut);
  mesh::SurfaceMesh kept{boundary.vertices_m,
                         mesh::IndexRows(std::count(outer.begin(), outer.end(), true), boundary.triangles.cols())};
  Eigen::Index row = 0;
  for (std::size_t t = 0; t < outer.size(); ++t)
    if (outer[t]) kept.triangles.row(row++) = boundary.triangles.row(slits.kept[t]);
  return kept;
}

}  // namespace

ModalSurface::ModalSurface(const modal::ModalModel& model, double element_m, int max_triangles) : model_(model) {
  const mesh::SurfaceMesh boundary = mesh::boundary_surface(model.mesh);
  const mesh::ShutSlits slits = mesh::shut_slits(boundary);
  faces_ = outer_boundary(boundary, slits).triangles;
  const bool quadratic = faces_.cols() == 6;
  const auto n_faces = static_cast<int>(faces_.rows());
  double longest = 0.0;
  for (int f = 0; f < n_faces; ++f)
    for (int c = 0; c < 3; ++c)
      longest = std::max(
          longest, (model.mesh.nodes_m.row(faces_(f, c)) - model.mesh.nodes_m.row(faces_(f, (c + 1) % 3))).norm());
  int cuts = quadratic ? 2 : 1;
  while (longest / cuts > element_m && n_faces * 4.0 * cuts * cuts <= max_triangles) cuts *= 2;

  // Points are named by the nodes and weights they come from: the same on both faces of an edge.
  std::map<std::array<int, 6>, int> numbers;
  std::vector<Vector3d> points;
  triangles_.triangles.resize(static_cast<Eigen::Index>(n_faces) * cuts * cuts, 3);
  Eigen::Index row = 0;
  for (int f = 0; f < n_faces; ++f) {
    const auto position = [&](const Vector3d& at) {
      const auto shape = shape_values(at, quadratic);
      Vector3d x = Vector3d::Zero();
      for (int node = 0; node < faces_.cols(); ++node)
        x += shape[node] * model.mesh.nodes_m.row(faces_(f, node)).transpose();
      return x;
    };
    const auto vertex = [&](int i, int j) {
      const std::array<int, 3> weights{cuts - i - j, i, j};
      std::array<std::array<int, 2>, 3> terms;
      for (int c = 0; c < 3; ++c) terms[c] = {weights[c] > 0 ? slits.vertex_of[faces_(f, c)] : -1, weights[c]};
      std::sort(terms.begin(), terms.end());
      const std::array<int, 6> key{terms[0][0], terms[0][1], terms[1][0], terms[1][1], terms[2][0], terms[2][1]};
      const auto [found, fresh] = numbers.try_emplace(key, static_cast<int>(points.size()));
      if (fresh) points.push_back(position(Vector3d(weights[0], weights[1], weights[2]) / cuts));
      return found->second;
    };
    const auto add = [&](const std::array<std::array<int, 2>, 3>& at) {
      for (int c = 0; c < 3; ++c) triangles_.triangles(row, c) = vertex(at[c][0], at[c][1]);
      ++row;
      for (const TrianglePoint& point : seven_points()) {
        Vector3d where = Vector3d::Zero();
        for (int c = 0; c < 3; ++c)
          where += point.at[c] / cuts * Vector3d(cuts - at[c][0] - at[c][1], at[c][0], at[c][1]);
        Sample sample{f, Vector3d::Zero(), Vector3d::Zero(), shape_values(where, quadratic)};
        const auto slopes = shape_slopes(where, quadratic);
        Eigen::Matrix<double, 3, 2> tangents = Eigen::Matrix<double, 3, 2>::Zero();
        for (int node = 0; node < faces_.cols(); ++node) {
          const Vector3d x = model.mesh.nodes_m.row(faces_(f, node)).transpose();
          sample.at_m += sample.shape[node] * x;
          tangents += x * slopes.row(node);
        }
        sample.area_m2 = tangents.col(0).cross(tangents.col(1)) * (0.5 * point.weight / (cuts * cuts));
        area_m2_ += sample.area_m2.norm();
        samples_.push_back(sample);
      }
    };
    for (int i = 0; i < cuts; ++i)
      for (int j = 0; i + j < cuts; ++j) {
        add({{{i, j}, {i + 1, j}, {i, j + 1}}});
        if (i + j + 1 < cuts) add({{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}});
      }
  }
  triangles_.vertices_m.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    triangles_.vertices_m.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
}

double ModalSurface::flow_of(const Sample& sample, int mode) const {
  double flow = 0.0;
  for (int node = 0; node < faces_.cols(); ++node)
    flow += sample.shape[node] * sample.area_m2.dot(model_.shapes.col(mode).segment<3>(3 * faces_(sample.face, node)));
  return flow;
}

double ModalSurface::volume_flow_m3_s(int mode) const {
  double flow = 0.0;
  for (const Sample& sample : samples_) flow += flow_of(sample, mode);
  return flow;
}

double ModalSurface::pattern_wavelength_m(int mode) const {
  // Normal velocity at the nodes of a face along the face's own mean normal: a face knows nothing of its neighbours.
  const bool quadratic = faces_.cols() == 6;
  double value_sq = 0.0, slope_sq = 0.0;
  for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
    const auto node = [&](int c) -> Vector3d { return model_.mesh.nodes_m.row(faces_(f, c)).transpose(); };
    const Vector3d e1 = node(1) - node(0), e2 = node(2) - node(0), doubled = e1.cross(e2);
    const Vector3d normal = doubled.normalized();
    Eigen::Matrix<double, 6, 1> v = Eigen::Matrix<double, 6, 1>::Zero();
    for (int c = 0; c < faces_.cols(); ++c) v[c] = normal.dot(model_.shapes.col(mode).segment<3>(3 * faces_(f, c)));
    Eigen::Matrix2d metric;
    metric << e1.dot(e1), e1.dot(e2), e1.dot(e2), e2.dot(e2);
    const double det = metric.determinant();
    for (const TrianglePoint& point : seven_points()) {
      const Vector3d at = Eigen::Map<const Vector3d>(point.at.data());
      const double weight = 0.5 * doubled.norm() * point.weight;
      const double value = v.dot(shape_values(at, quadratic));
      const Eigen::Vector2d slope = shape_slopes(at, quadratic).transpose() * v;
      value_sq += weight * value * value;
      slope_sq += weight *
                  (slope[0] * slope[0] * metric(1, 1) - 2.0 * slope[0] * slope[1] * metric(0, 1) +
                   slope[1] * slope[1] * metric(0, 0)) /
                  det;
    }
  }
  return slope_sq > 0.0 ? 2.0 * kPi * std::sqrt(value_sq / slope_sq) : HUGE_VAL;
}

ModalSurface::Carrier ModalSurface::carrier(const RadiatingSurface& elements) const {
  const int n = elements.n_triangles();
  std::vector<std::array<Vector3d, 3>> corners(static_cast<std::size_t>(n));
  for (int t = 0; t < n; ++t) corners[t] = {elements.corner(t, 0), elements.corner(t, 1), elements.corner(t, 2)};
  // Every element is entered in all cells its box touches, and a sample looks at its own cell and those around.
  const double cell_m = std::max(elements.radii_m.mean(), 1e-12);
  CellGrid cells(cell_m);
  const auto cell = [&](const Vector3d& p) { return cells.cell(p); };
  for (int t = 0; t < n; ++t) {
    const auto low = cell(corners[t][0].cwiseMin(corners[t][1]).cwiseMin(corners[t][2]));
    const auto high = cell(corners[t][0].cwiseMax(corners[t][1]).cwiseMax(corners[t][2]));
    for (long x = low[0]; x <= high[0]; ++x)
      for (long y = low[1]; y <= high[1]; ++y)
        for (long z = low[2]; z <= high[2]; ++z) cells.add({x, y, z}, t);
  }
  Carrier result;
  result.element_of_sample.resize(samples_.size());
  parallel_for(samples_.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Sample& sample = samples_[i];
      const auto middle = cell(sample.at_m);
      int best = -1;
      // Rings of cells outwards, one more after the first hit: a nearer element may lie beyond a corner of the cell. An
      // element that faces away is taken only where there is no other.
      double best_sq = HUGE_VAL;
      const auto look = [&](int t) {
        const double facing = elements.normals.col(t).dot(sample.area_m2) / sample.area_m2.norm();
        double d = mesh::distance_sq(sample.at_m, corners[t]);
        if (facing < 0.3) d += 1e6 * cell_m * cell_m * (1.0 - facing);
        if (d < best_sq || (d == best_sq && t < best)) best_sq = d, best = t;
      };
      int rings_left = 1;
      for (long ring = 0; ring < 64 && rings_left >= 0; ++ring) {
        for (long x = -ring; x <= ring; ++x)
          for (long y = -ring; y <= ring; ++y)
            for (long z = -ring; z <= ring; ++z) {
              if (std::max({std::abs(x), std::abs(y), std::abs(z)}) != ring) continue;
              const std::vector<int>* found = cells.find({middle[0] + x, middle[1] + y, middle[2] + z});
              if (found != nullptr) std::for_each(found->begin(), found->end(), look);
            }
        if (best_sq < 1e5 * cell_m * cell_m || (best >= 0 && ring > 4)) --rings_left;
      }
      if (best < 0)
        for (int t = 0; t < n; ++t) look(t);
      result.element_of_sample[i] = best;
    }
  });
  result.area_of_element_m2 = Eigen::VectorXd::Zero(n);
  result.height_of_element_m = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const int t = result.element_of_sample[i];
    const double area = samples_[i].area_m2.norm();
    result.area_of_element_m2[t] += area;
    result.height_of_element_m[t] += area * elements.normals.col(t).dot(samples_[i].at_m - elements.centroids_m.col(t));
  }
  for (int t = 0; t < n; ++t)
    if (result.area_of_element_m2[t] > 0.0) result.height_of_element_m[t] /= result.area_of_element_m2[t];
  result.hats_of_sample.resize(3, static_cast<Eigen::Index>(samples_.size()));
  result.inverse.assign(static_cast<std::size_t>(n), Eigen::Matrix3d::Zero());
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const int t = result.element_of_sample[i];
    const Vector3d d = samples_[i].at_m - corners[t][0], e1 = corners[t][1] - corners[t][0],
                   e2 = corners[t][2] - corners[t][0];
    const double g11 = e1.dot(e1), g12 = e1.dot(e2), g22 = e2.dot(e2), det = g11 * g22 - g12 * g12;
    const double u = (g22 * d.dot(e1) - g12 * d.dot(e2)) / det, v = (g11 * d.dot(e2) - g12 * d.dot(e1)) / det;
    const Vector3d hats(1.0 - u - v, u, v);
    result.hats_of_sample.col(static_cast<Eigen::Index>(i)) = hats;
    result.inverse[t] += samples_[i].area_m2.norm() * hats * hats.transpose();
  }
  for (int t = 0; t < n; ++t) {
    // Samples spread evenly give eigenvalues of 1/3, 1/12 and 1/12 of the area.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(result.inverse[t]);
    const bool fixed = eigen.eigenvalues()[0] > 0.02 * result.area_of_element_m2[t];
    result.inverse[t] = fixed ? result.inverse[t].inverse().eval() : Eigen::Matrix3d::Zero().eval();
  }
  return result;
}

RadiatingSurface ModalSurface::settled(const RadiatingSurface& elements) const {
  const Carrier now = carrier(elements);
  Eigen::Matrix3Xd move = Eigen::Matrix3Xd::Zero(3, elements.n_vertices());
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(elements.n_vertices());
  for (int t = 0; t < elements.n_triangles(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int v = elements.triangles(c, t);
      move.col(v) += elements.areas_m2[t] * now.height_of_element_m[t] * elements.normals.col(t);
      weight[v] += elements.areas_m2[t];
    }
  Eigen::Matrix3Xd places_m = elements.vertices_m;
  for (int v = 0; v < elements.n_vertices(); ++v) places_m.col(v) += move.col(v) / weight[v];
  return moved(elements, places_m);
}

Eigen::VectorXd ModalSurface::corner_velocity_m_s(int mode, const Carrier& carrier,
                                                  const RadiatingSurface& elements) const {
  const int n = elements.n_triangles();
  Eigen::Matrix3Xd moments = Eigen::Matrix3Xd::Zero(3, n);
  Eigen::VectorXd flows = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const double flow = flow_of(samples_[i], mode);
    const int t = carrier.element_of_sample[i];
    flows[t] += flow;
    moments.col(t) += flow * carrier.hats_of_sample.col(static_cast<Eigen::Index>(i));
  }
  Eigen::Matrix3Xd velocity(3, n);
  std::vector<double> around(static_cast<std::size_t>(elements.n_vertices()), 0.0), weight(around.size(), 0.0);
  for (int t = 0; t < n; ++t) {
    if (!(carrier.area_of_element_m2[t] > 0.0)) continue;
    const double mean = flows[t] / carrier.area_of_element_m2[t];
    if (carrier.inverse[t].isZero(0.0))
      velocity.col(t).setConstant(mean);
    else
      velocity.col(t) = carrier.inverse[t] * moments.col(t);
    for (int c = 0; c < 3; ++c) {
      around[elements.triangles(c, t)] += elements.areas_m2[t] * mean;
      weight[elements.triangles(c, t)] += elements.areas_m2[t];
    }
  }
  for (int t = 0; t < n; ++t) {
    if (carrier.area_of_element_m2[t] > 0.0) continue;
    double sum = 0.0, weights = 0.0;
    for (int c = 0; c < 3; ++c) sum += around[elements.triangles(c, t)], weights += weight[elements.triangles(c, t)];
    velocity.col(t).setConstant(weights > 0.0 ? sum / weights : 0.0);
  }
  const Eigen::RowVectorXd corner_areas_m2 = elements.areas_m2.transpose() / 3.0;
  const double scale = corner_areas_m2.dot(velocity.cwiseAbs().colwise().sum());
  const double missing = flows.sum() - corner_areas_m2.dot(velocity.colwise().sum());
  if (scale > 0.0) velocity += velocity.cwiseAbs() * (missing / scale);
  return velocity.reshaped();
}

}  // namespace klang::acoustics
