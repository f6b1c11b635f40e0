#include "core/sound/stage/surface_coupling.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/stage/one_pitch.hpp"

namespace klang::stage {
namespace {

// Radon's rule of 7 points and degree 5 on the reference triangle (Radon 1948); weights sum to the area 1/2.
struct TrianglePoint {
  double xi, eta, weight;
};
std::array<TrianglePoint, 7> triangle_rule() {
  const double root = std::sqrt(15.0);
  const double a = (6.0 - root) / 21.0, b = (6.0 + root) / 21.0;
  const double wa = (155.0 - root) / 2400.0, wb = (155.0 + root) / 2400.0;
  return {{{1.0 / 3, 1.0 / 3, 9.0 / 80},
           {a, a, wa},
           {1 - 2 * a, a, wa},
           {a, 1 - 2 * a, wa},
           {b, b, wb},
           {1 - 2 * b, b, wb},
           {b, 1 - 2 * b, wb}}};
}

struct TriangleShape {
  std::array<double, 6> value{}, by_xi{}, by_eta{};
  int n = 3;
};

// Order of nodes: corners, then the middles of 01, 12, 20.
TriangleShape triangle_shape(double xi, double eta, bool quadratic) {
  const double zeta = 1.0 - xi - eta;
  if (!quadratic) return {{zeta, xi, eta}, {-1, 1, 0}, {-1, 0, 1}, 3};
  return {{zeta * (2 * zeta - 1), xi * (2 * xi - 1), eta * (2 * eta - 1), 4 * zeta * xi, 4 * xi * eta, 4 * eta * zeta},
          {1 - 4 * zeta, 4 * xi - 1, 0, 4 * (zeta - xi), 4 * eta, -4 * eta},
          {1 - 4 * zeta, 0, 4 * eta - 1, -4 * xi, 4 * xi, 4 * (zeta - eta)},
          6};
}

// Sum over the surface of |normal displacement| times area, for each column of shapes.
Eigen::VectorXd moved_volume_m3(const mesh::TetMesh& mesh, const Eigen::MatrixXd& displacement) {
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
  const bool quadratic = surface.triangles.cols() == 6;
  std::vector<TriangleShape> shapes;
  const auto rule = triangle_rule();
  for (const TrianglePoint& p : rule) shapes.push_back(triangle_shape(p.xi, p.eta, quadratic));

  const Eigen::Index n_modes = displacement.cols(), n_triangles = surface.triangles.rows();
  Eigen::VectorXd volume = Eigen::VectorXd::Zero(n_modes);
  std::vector<Eigen::Vector3d> area_vectors(static_cast<std::size_t>(n_triangles) * rule.size());
  for (Eigen::Index t = 0; t < n_triangles; ++t) {
    for (std::size_t q = 0; q < rule.size(); ++q) {
      Eigen::Vector3d by_xi = Eigen::Vector3d::Zero(), by_eta = Eigen::Vector3d::Zero();
      for (int i = 0; i < shapes[q].n; ++i) {
        const Eigen::Vector3d x = surface.vertices_m.row(surface.triangles(t, i));
        by_xi += shapes[q].by_xi[static_cast<std::size_t>(i)] * x;
        by_eta += shapes[q].by_eta[static_cast<std::size_t>(i)] * x;
      }
      area_vectors[static_cast<std::size_t>(t) * rule.size() + q] = rule[q].weight * by_xi.cross(by_eta);
    }
  }
  parallel_for(static_cast<std::size_t>(n_modes), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t m = begin; m < end; ++m) {
      const auto mode = static_cast<Eigen::Index>(m);
      double sum = 0.0;
      for (Eigen::Index t = 0; t < n_triangles; ++t) {
        for (std::size_t q = 0; q < rule.size(); ++q) {
          Eigen::Vector3d u = Eigen::Vector3d::Zero();
          for (int i = 0; i < shapes[q].n; ++i) {
            u += shapes[q].value[static_cast<std::size_t>(i)] *
                 displacement.block<3, 1>(3 * surface.triangles(t, i), mode);
          }
          sum += std::abs(u.dot(area_vectors[static_cast<std::size_t>(t) * rule.size() + q]));
        }
      }
      volume[mode] = sum;
    }
  });
  return volume;
}

}  // namespace

Eigen::VectorXd surface_coupling(const modal::ModalModel& model) {
  return moved_volume_m3(model.mesh, model.shapes).cwiseProduct(model.angular_frequency_rad_s) / (2.0 * kPi);
}

Eigen::VectorXd heard_coupling(const modal::ModalModel& model, const Eigen::VectorXd& decay_per_s,
                               const Eigen::MatrixXd& push) {
  Eigen::VectorXd gain = surface_coupling(model);
  if (push.cols() == 0) return gain;
  for (const std::vector<std::size_t>& group : modes_of_one_pitch(model.angular_frequency_rad_s, decay_per_s)) {
    const std::vector<Eigen::Index> modes(group.begin(), group.end());
    const Eigen::MatrixXd pushes = push(modes, Eigen::all);
    Eigen::Index hardest = 0, most = 0;
    const double strength = std::sqrt(pushes.colwise().squaredNorm().maxCoeff(&hardest));
    if (!(strength > 0.0)) continue;
    Eigen::VectorXd share = pushes.col(hardest) / strength;
    share.cwiseAbs().maxCoeff(&most);
    if (share[most] < 0.0) share = -share;
    const Eigen::MatrixXd shape = model.shapes(Eigen::all, modes) * share;
    const double volume = moved_volume_m3(model.mesh, shape)[0];
    for (std::size_t k = 0; k < modes.size(); ++k)
      gain[modes[k]] =
          volume * share[static_cast<Eigen::Index>(k)] * model.angular_frequency_rad_s[modes[k]] / (2.0 * kPi);
  }
  return gain;
}

}  // namespace klang::stage
