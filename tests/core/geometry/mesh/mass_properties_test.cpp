#include "core/geometry/mesh/mass_properties.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/shape.hpp"

using namespace klang;
using namespace klang::mesh;

namespace {

const ShapeSpec kBox{"box", {{"length_m", 0.05}, {"width_m", 0.03}, {"height_m", 0.01}}, {}};
const ShapeSpec kEllipsoid{"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.03}, {"c_m", 0.04}}, {}};

/// I = V / 5 diag(b^2 + c^2, ...) of an ellipsoid.
Eigen::Vector3d exact_ellipsoid_moments() {
  const double volume = 4.0 / 3.0 * kPi * 0.05 * 0.03 * 0.04;
  return volume / 5.0 *
         Eigen::Vector3d(0.03 * 0.03 + 0.04 * 0.04, 0.05 * 0.05 + 0.04 * 0.04, 0.05 * 0.05 + 0.03 * 0.03);
}

double ellipsoid_error(int order, int refinement) {
  ShapeMeshOptions options;
  options.order = order;
  options.refinement = refinement;
  const MassProperties mass = mass_properties(mesh_shape(kEllipsoid, options));
  const Eigen::Vector3d exact = exact_ellipsoid_moments();
  return (mass.inertia_m5 - Eigen::Matrix3d(exact.asDiagonal())).norm() / exact.norm();
}

}  // namespace

TEST(Inertia, BoxHasItsClosedForm) {
  for (const int order : {1, 2}) {
    ShapeMeshOptions options;
    options.order = order;
    const MassProperties mass = mass_properties(mesh_shape(kBox, options));
    const double v = 0.05 * 0.03 * 0.01;
    const Eigen::Vector3d exact(v / 12 * (0.03 * 0.03 + 0.01 * 0.01), v / 12 * (0.05 * 0.05 + 0.01 * 0.01),
                                v / 12 * (0.05 * 0.05 + 0.03 * 0.03));
    EXPECT_LE(std::abs(mass.volume_m3 / v - 1.0), 1e-13);
    EXPECT_LE(mass.centre_m.norm(), 1e-15);
    EXPECT_LE((mass.inertia_m5 - Eigen::Matrix3d(exact.asDiagonal())).norm(), 1e-13 * exact.norm());
    EXPECT_LE((principal_moments(mass) - exact).norm(), 1e-13 * exact.norm());
  }
}

// Curved sides taken as straight would leave the order at 2.
TEST(Inertia, EllipsoidOfCurvedElementsConvergesAtOrderFour) {
  const double coarse = ellipsoid_error(2, 0), fine = ellipsoid_error(2, 1);
  const double order = std::log2(coarse / fine);
  EXPECT_LE(fine, 1e-4);
  EXPECT_GE(order, 3.6);
  EXPECT_LE(order, 4.6);
  const double linear_order = std::log2(ellipsoid_error(1, 0) / ellipsoid_error(1, 1));
  EXPECT_GE(linear_order, 1.7);
  EXPECT_LE(linear_order, 2.3);
}

// One curved element: its boundary's integrals against a sum over the volume by brute force.
TEST(Inertia, CurvedElementEqualsItsVolumeIntegral) {
  TetMesh mesh;
  mesh.nodes_m.resize(10, 3);
  mesh.nodes_m << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, -0.04, 0.03, 0.55, 0.52, 0.02, -0.03, 0.5, 0.05, 0.02, 0.04,
      0.48, 0.5, 0.06, 0.55, -0.02, 0.5, 0.53;
  mesh.elements.resize(1, 10);
  for (int i = 0; i < 10; ++i) mesh.elements(0, i) = i;
  const auto place = [&](double a, double b, double c) {
    const std::array<double, 4> l{1.0 - a - b - c, a, b, c};
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i) x += l[i] * (2.0 * l[i] - 1.0) * mesh.nodes_m.row(i).transpose();
    for (int e = 0; e < 6; ++e)
      x += 4.0 * l[kTetEdges[e][0]] * l[kTetEdges[e][1]] * mesh.nodes_m.row(4 + e).transpose();
    return x;
  };
  // Eight Gauss points per direction in collapsed coordinates; slopes by central differences, exact for quadratics.
  const std::array<double, 8> node{0.019855071751231884, 0.10166676129318663, 0.2372337950418355, 0.4082826787521751,
                                   0.5917173212478249,   0.7627662049581645,  0.8983332387068134, 0.9801449282487681};
  const std::array<double, 8> weight{0.05061426814518813, 0.11119051722668724, 0.15685332293894363,
                                     0.18134189168918100, 0.18134189168918100, 0.15685332293894363,
                                     0.11119051722668724, 0.05061426814518813};
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      for (int k = 0; k < 8; ++k) {
        const double a = node[i], b = node[j] * (1.0 - a), c = node[k] * (1.0 - a - b), h = 0.25;
        Eigen::Matrix3d slope;
        slope << (place(a + h, b, c) - place(a - h, b, c)) / (2.0 * h),
            (place(a, b + h, c) - place(a, b - h, c)) / (2.0 * h),
            (place(a, b, c + h) - place(a, b, c - h)) / (2.0 * h);
        const double dv = weight[i] * weight[j] * weight[k] * (1.0 - a) * (1.0 - a - b) * slope.determinant();
        const Eigen::Vector3d x = place(a, b, c);
        volume += dv;
        first += dv * x;
        second += dv * x * x.transpose();
      }
  second -= first * first.transpose() / volume;
  const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  const MassProperties mass = mass_properties(mesh);
  EXPECT_LE(std::abs(mass.volume_m3 / volume - 1.0), 1e-13);
  EXPECT_LE((mass.centre_m - first / volume).norm(), 1e-13);
  EXPECT_LE((mass.inertia_m5 - inertia).norm(), 1e-13 * inertia.norm());
}

TEST(Inertia, TurnsWithTheBodyAndDoesNotDependOnItsPlace) {
  for (const ShapeSpec& spec : {kBox, kEllipsoid}) {
    TetMesh mesh = mesh_shape(spec);
    const MassProperties at_home = mass_properties(mesh);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, -1.0, 0.5).normalized()).toRotationMatrix();
    const Eigen::Vector3d shift(1.5, -2.0, 0.7);  // some 50 times its size
    mesh.nodes_m = ((mesh.nodes_m * turn.transpose()).rowwise() + shift.transpose()).eval();
    const MassProperties moved = mass_properties(mesh);
    EXPECT_LE(std::abs(moved.volume_m3 / at_home.volume_m3 - 1.0), 1e-12);
    EXPECT_LE((moved.centre_m - (turn * at_home.centre_m + shift)).norm(), 1e-13 * shift.norm());
    EXPECT_LE((moved.inertia_m5 - turn * at_home.inertia_m5 * turn.transpose()).norm(),
              1e-12 * at_home.inertia_m5.norm());
    EXPECT_LE((principal_moments(moved) - principal_moments(at_home)).norm(), 1e-12 * at_home.inertia_m5.norm());
  }
}

TEST(Inertia, SurfaceTurnedInsideOutIsRefused) {
  SurfaceMesh surface = boundary_surface(to_linear(mesh_shape(kBox)));
  surface.triangles.col(0).swap(surface.triangles.col(1));
  EXPECT_THROW(mass_properties(surface), InputError);
  EXPECT_THROW(mass_properties(SurfaceMesh{}), InputError);
}
