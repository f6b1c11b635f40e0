// Bodies whose outside field is known: a point source within the solid gives the normal velocity of their surface.
#include "core/sound/bem/helmholtz_bem.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/sound/waves/multipole.hpp"

namespace {

using namespace klang::acoustics;
namespace mesh = klang::mesh;
using Complex = std::complex<double>;
using Eigen::Vector3d;

const Medium kAir;

mesh::SurfaceMesh surface_of(const mesh::ShapeSpec& spec, const mesh::ShapeDivisions& divisions) {
  return mesh::boundary_surface(mesh::mesh_shape(spec, divisions, 1));
}

/// e^{-ikR} / R at 1 Pa m, and its gradient by x.
Complex source_pressure(double k, const Vector3d& x, const Vector3d& source, Eigen::Vector3cd* gradient = nullptr) {
  const Vector3d d = x - source;
  const double r = d.norm();
  const Complex p = std::polar(1.0 / r, -k * r);
  if (gradient != nullptr) *gradient = -(Complex(1.0, k * r) * p / (r * r)) * d.cast<Complex>();
  return p;
}

/// Normal velocity of the source's field at the middle of each triangle.
Eigen::VectorXcd source_velocity(const RadiatingSurface& surface, double k, const Vector3d& source) {
  Eigen::VectorXcd velocity(surface.n_triangles());
  for (int t = 0; t < surface.n_triangles(); ++t) {
    Eigen::Vector3cd gradient;
    source_pressure(k, surface.centroids_m.col(t), source, &gradient);
    const Complex slope = surface.normals.col(t).cast<Complex>().dot(gradient);
    velocity[t] = slope / Complex(0.0, -k * kAir.sound_speed_m_s * kAir.density_kg_m3);
  }
  return velocity;
}

double frequency_of(double k) { return k * kAir.sound_speed_m_s / (2.0 * klang::kPi); }

/// Largest relative error at points on a sphere of 1.5 times the body's radius, and the power's against 2 pi / (rho c).
struct Errors {
  double field = 0.0, power = 0.0;
};

Errors source_errors(const HelmholtzBem& solver, double k, const Vector3d& source) {
  const RadiatingSurface& surface = solver.surface();
  const BemResult result = solver.solve(frequency_of(k), solver.from_triangles(source_velocity(surface, k, source)));
  EXPECT_TRUE(result.usable()) << result.message;
  Eigen::Matrix3Xd points(3, 24);
  for (int i = 0; i < 24; ++i) {
    const double z = -1.0 + (i + 0.5) / 12.0, phi = 2.4 * i;
    points.col(i) = 1.5 * surface.radius_m *
                    Vector3d(std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi), z);
  }
  const Vector3d low = surface.vertices_m.rowwise().minCoeff(), high = surface.vertices_m.rowwise().maxCoeff();
  points.colwise() += 0.5 * (low + high);
  const Eigen::VectorXcd pressure = solver.pressure_at(result, points);
  Errors errors;
  for (int i = 0; i < 24; ++i) {
    const Complex exact = source_pressure(k, points.col(i), source);
    errors.field = std::max(errors.field, std::abs(pressure[i] - exact) / std::abs(exact));
  }
  const double exact_power = 2.0 * klang::kPi / (kAir.density_kg_m3 * kAir.sound_speed_m_s);
  errors.power = std::abs(result.radiated_power_w[0] / exact_power - 1.0);
  return errors;
}

const mesh::ShapeSpec kCube{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.1}}, {}};
const mesh::ShapeSpec kThickBowl{"bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.02}, {"depth_m", 0.08}}, {}};

}  // namespace

TEST(ExteriorSource, OffCentreInACubeIsWithinOnePercent) {
  const HelmholtzBem solver(radiating_surface(surface_of(kCube, {{10, 10, 10}})));
  for (const double k : {2.0, 20.0, 60.0}) {
    const Errors errors = source_errors(solver, k, {0.012, -0.015, 0.02});
    EXPECT_LE(errors.field, 0.01) << "k " << k;
    EXPECT_LE(errors.power, 0.01) << "k " << k;
  }
}

TEST(ExteriorSource, InTheWallOfABowlIsWithinOnePercent) {
  const HelmholtzBem solver(radiating_surface(surface_of(kThickBowl, {{8, 8, 4}})));
  const RadiatingSurface& s = solver.surface();
  // In the middle of the wall at the bottom of the bowl.
  const Vector3d source(0.0, 0.0, s.vertices_m.row(2).minCoeff() + 0.01);
  for (const double k : {5.0, 25.0}) {
    const Errors errors = source_errors(solver, k, source);
    EXPECT_LE(errors.field, 0.01) << "k " << k << ", " << s.n_triangles() << " triangles";
  }
}

// A plate a thirtieth of its elements thick, top and bottom cut differently: the field of two opposite sources in it is
// that of a plate ten times as thick to first order, so compare with the limit instead: reciprocity of two motions.
TEST(ThinPlate, ReciprocityHoldsToHalfAPercent) {
  const mesh::ShapeSpec plate{"box", {{"length_m", 0.2}, {"width_m", 0.15}, {"height_m", 0.0005}}, {}};
  const HelmholtzBem solver(radiating_surface(surface_of(plate, {{12, 10, 1}})));
  const RadiatingSurface& s = solver.surface();
  // Two motions of the surface: the work of the pressure of one on the velocity of the other does not mind which is which.
  Eigen::MatrixXcd velocity = Eigen::MatrixXcd::Zero(3 * s.n_triangles(), 2);
  for (int t = 0; t < s.n_triangles(); ++t)
    for (int c = 0; c < 3; ++c) {
      const Vector3d x = s.corner(t, c);
      velocity(3 * t + c, 0) = s.normals(2, t) * std::cos(20.0 * x[0]);
      velocity(3 * t + c, 1) = s.normals(2, t) * (1.0 + 8.0 * x[0] - 5.0 * x[1]);
    }
  for (const double frequency_hz : {300.0, 3000.0}) {
    const BemResult result = solver.solve(frequency_hz, velocity);
    ASSERT_TRUE(result.usable());
    const SurfaceField a = solver.field(result, 0), b = solver.field(result, 1);
    Complex ab = 0.0, ba = 0.0;
    for (Eigen::Index i = 0; i < a.weights_m2.size(); ++i) {
      ab += a.weights_m2[i] * a.pressure_pa[i] * b.normal_velocity_m_s[i];
      ba += a.weights_m2[i] * b.pressure_pa[i] * a.normal_velocity_m_s[i];
    }
    EXPECT_LE(std::abs(ab - ba), 0.005 * std::abs(ab)) << frequency_hz << " Hz";
  }
}

// A rigid disc that moves along its axis in an infinite fluid, added mass 8/3 rho a^3 (Lamb 1932, section 102); the plate
// is a thin cylinder, approached from above as its wall gets thinner.
TEST(ThinPlate, AddedMassOfADiscIsLambs) {
  const double a = 0.05;
  const mesh::ShapeSpec disc{"rod", {{"length_m", 0.0004}, {"radius_m", a}}, {}};
  const HelmholtzBem solver(radiating_surface(surface_of(disc, {{1, 5, 5}})));
  const RadiatingSurface& s = solver.surface();
  Eigen::VectorXcd velocity(s.n_triangles());
  for (int t = 0; t < s.n_triangles(); ++t) velocity[t] = s.normals(2, t);
  const double frequency_hz = 5.0;  // ka = 0.005
  const BemResult result = solver.solve(frequency_hz, solver.from_triangles(velocity));
  ASSERT_TRUE(result.usable());
  const SurfaceField field = solver.field(result);
  Complex force = 0.0;
  for (Eigen::Index i = 0; i < field.weights_m2.size(); ++i)
    force += field.weights_m2[i] * field.pressure_pa[i] * field.normals(2, i);
  const double mass_kg = force.imag() / (2.0 * klang::kPi * frequency_hz);
  const double lamb_kg = 8.0 / 3.0 * kAir.density_kg_m3 * a * a * a;
  EXPECT_LE(std::abs(mass_kg / lamb_kg - 1.0), 0.03) << s.n_triangles() << " triangles: " << mass_kg / lamb_kg;
}

TEST(HelmholtzBem, VelocityByVerticesAndByTrianglesAgreeWhereItIsConstant) {
  const HelmholtzBem solver(radiating_surface(geodesic_sphere(0.1, 3)));
  const RadiatingSurface& s = solver.surface();
  EXPECT_EQ(solver.from_triangles(Eigen::VectorXcd::Ones(s.n_triangles())),
            solver.from_vertices(Eigen::VectorXcd::Ones(s.n_vertices())));
}

TEST(HelmholtzBem, PressureNearTheSurfaceGoesOverIntoThatOnIt) {
  const HelmholtzBem solver(radiating_surface(geodesic_sphere(0.1, 6)));
  const RadiatingSurface& s = solver.surface();
  const BemResult result = solver.solve(500.0, solver.from_triangles(Eigen::VectorXcd::Ones(s.n_triangles())));
  const Vector3d above = s.centroids_m.col(7) + 1e-6 * s.normals.col(7);
  Complex on = 0.0;
  for (int c = 0; c < 3; ++c) on += result.pressure_pa(s.triangles(c, 7), 0) / 3.0;
  EXPECT_LE(std::abs(solver.pressure_at(result, above)[0] - on), 0.005 * std::abs(on));
}

TEST(HelmholtzBem, ThreadsDoNotChangeTheAssembledBits) {
  const auto solve = [](int n_threads) {
    klang::set_thread_count(n_threads);
    const HelmholtzBem solver(radiating_surface(geodesic_sphere(0.1, 4)));
    BemOptions options;
    options.n_blas_threads = 1;
    return solver.solve(500.0, solver.from_triangles(Eigen::VectorXcd::Ones(solver.surface().n_triangles())), options)
        .pressure_pa;
  };
  const Eigen::MatrixXcd one = solve(1), two = solve(2);
  klang::set_thread_count(0);
  EXPECT_EQ(one, two);
}

TEST(OuterSurface, LeavesOutAHollowAndTakesValuesOfTrianglesOrVertices) {
  mesh::SurfaceMesh surface = geodesic_sphere(0.1, 1);
  const mesh::SurfaceMesh inner = geodesic_sphere(0.05, 1);
  const Eigen::Index n_triangles = inner.triangles.rows(), n_vertices = inner.vertices_m.rows();
  surface.vertices_m.conservativeResize(2 * n_vertices, 3);
  surface.vertices_m.bottomRows(n_vertices) = inner.vertices_m;
  surface.triangles.conservativeResize(2 * n_triangles, 3);
  for (Eigen::Index t = 0; t < n_triangles; ++t)  // turned round: its normals point into the hollow
    for (int c = 0; c < 3; ++c)
      surface.triangles(n_triangles + t, c) = inner.triangles(t, 2 - c) + static_cast<int>(n_vertices);
  const OuterSurface outer = outer_surface(surface);
  ASSERT_EQ(outer.mesh.triangles.rows(), n_triangles);
  EXPECT_EQ(outer.mesh.triangles, surface.triangles.topRows(n_triangles));
  const auto counting = [](Eigen::Index n) {
    Eigen::VectorXcd values(n);
    for (Eigen::Index i = 0; i < n; ++i) values[i] = Complex(static_cast<double>(i), -1.0);
    return values;
  };
  const Eigen::VectorXcd by_triangle = corner_values(surface, outer, counting(2 * n_triangles)),
                         by_vertex = corner_values(surface, outer, counting(2 * n_vertices));
  for (Eigen::Index t = 0; t < n_triangles; ++t)
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(by_triangle[3 * t + c], Complex(static_cast<double>(t), -1.0));
      EXPECT_EQ(by_vertex[3 * t + c], Complex(static_cast<double>(surface.triangles(t, c)), -1.0));
    }
}

TEST(HelmholtzBem, BadInputIsNamed) {
  const HelmholtzBem solver(radiating_surface(geodesic_sphere(0.1, 3)));
  const auto velocity = solver.from_triangles(Eigen::VectorXcd::Ones(180));
  EXPECT_THROW(solver.solve(0.0, velocity), klang::InputError);
  EXPECT_THROW(solver.solve(NAN, velocity), klang::InputError);
  EXPECT_THROW(solver.solve(20000.0, velocity), klang::InputError);  // too coarse
  EXPECT_THROW(solver.check_outside(Vector3d(0.0, 0.0, 0.05)), klang::InputError);
  EXPECT_NO_THROW(solver.check_outside(Vector3d(0.0, 0.0, 0.15)));
  Eigen::MatrixXcd bad = velocity;
  bad(5, 0) = NAN;
  EXPECT_THROW(solver.solve(500.0, bad), klang::InputError);
}
