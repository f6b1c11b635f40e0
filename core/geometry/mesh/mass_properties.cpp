#include "core/geometry/mesh/mass_properties.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>

#include "core/foundation/base/errors.hpp"

namespace klang::mesh {
namespace {

/// Gauss-Legendre on [0, 1], exact to degree 9.
constexpr std::array<double, 5> kNodes{0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155,
                                       0.95308992296933200};
constexpr std::array<double, 5> kWeights{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                         0.23931433524968324, 0.11846344252809454};

/// Functions of a quadratic triangle and their slopes at (a, b): corners, then middles of 01, 12, 20.
struct TriangleFunctions {
  Eigen::Matrix<double, 6, 1> value, by_a, by_b;
};
TriangleFunctions quadratic_functions(double a, double b) {
  const double c = 1.0 - a - b;
  TriangleFunctions f;
  f.value << c * (2.0 * c - 1.0), a * (2.0 * a - 1.0), b * (2.0 * b - 1.0), 4.0 * c * a, 4.0 * a * b, 4.0 * b * c;
  f.by_a << 1.0 - 4.0 * c, 4.0 * a - 1.0, 0.0, 4.0 * (c - a), 4.0 * b, -4.0 * b;
  f.by_b << 1.0 - 4.0 * c, 0.0, 4.0 * b - 1.0, -4.0 * a, 4.0 * a, 4.0 * (c - b);
  return f;
}

struct Moments {
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

}  // namespace

MassProperties mass_properties(const SurfaceMesh& surface) {
  // The square is collapsed to the triangle: one degree more, 9, which five points still take.
  std::array<TriangleFunctions, 25> functions;
  std::array<double, 25> weights{};
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 5; ++j) {
      functions[5 * i + j] = quadratic_functions(kNodes[i], kNodes[j] * (1.0 - kNodes[i]));
      weights[5 * i + j] = kWeights[i] * kWeights[j] * (1.0 - kNodes[i]);
    }
  if (surface.triangles.rows() == 0) throw InputError("inertia", "the surface has no triangles");
  // About a point of the body itself: far from the origin the moments would cancel.
  const Eigen::Vector3d origin = surface.vertices_m.row(surface.triangles(0, 0)).transpose();
  Moments sum;
  Eigen::Matrix<double, 3, 6> x;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) x.col(c) = surface.vertices_m.row(surface.triangles(t, c)).transpose() - origin;
    for (int c = 0; c < 3; ++c)
      x.col(3 + c) = surface.triangles.cols() == 6
                         ? Eigen::Vector3d(surface.vertices_m.row(surface.triangles(t, 3 + c)).transpose() - origin)
                         : Eigen::Vector3d(0.5 * (x.col(c) + x.col((c + 1) % 3)));
    for (std::size_t q = 0; q < functions.size(); ++q) {
      const Eigen::Vector3d at = x * functions[q].value, by_a = x * functions[q].by_a, by_b = x * functions[q].by_b;
      const double flux = weights[q] * at.dot(by_a.cross(by_b));
      sum.volume += flux / 3.0;
      sum.first += (flux / 4.0) * at;
      sum.second += (flux / 5.0) * at * at.transpose();
    }
  }
  if (!(sum.volume > 0.0))
    throw InputError("inertia", "the surface encloses no positive volume", to_text(sum.volume) + " m^3",
                     "outward normals");
  MassProperties mass;
  mass.volume_m3 = sum.volume;
  mass.centre_m = origin + sum.first / sum.volume;
  const Eigen::Matrix3d second = sum.second - sum.first * sum.first.transpose() / sum.volume;
  mass.inertia_m5 = second.trace() * Eigen::Matrix3d::Identity() - second;
  return mass;
}

MassProperties mass_properties(const TetMesh& mesh) { return mass_properties(boundary_surface(mesh)); }

Eigen::Vector3d principal_moments(const MassProperties& mass) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(mass.inertia_m5, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace klang::mesh
