#include <gtest/gtest.h>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/bem/detail/assembly.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"

namespace klang::acoustics {
namespace {

using opencl::Precision;

// An ellipsoid in pieces that no symmetry hides.
RadiatingSurface body(int n) {
  mesh::SurfaceMesh surface = geodesic_sphere(0.1, n);
  surface.vertices_m.col(1) *= 0.7;
  surface.vertices_m.col(2) *= 1.3;
  surface.vertices_m.rowwise() += Eigen::RowVector3d(0.4, -0.2, 0.1);
  return radiating_surface(surface);
}

Eigen::MatrixXcd random_columns(Eigen::Index rows, Eigen::Index columns) {
  std::srand(7);
  return Eigen::MatrixXcd::Random(rows, columns);
}

struct Both {
  explicit Both(Precision precision, Eigen::Index n_columns = 5)
      : geometry(body(5)),
        derivative(random_columns(3 * geometry.surface.n_triangles(), n_columns)),
        assembly(geometry, 31.0, derivative),
        matrix(la::RowMatrixXcd::Zero(geometry.surface.n_vertices(), geometry.surface.n_vertices())),
        right(Eigen::MatrixXcd::Zero(matrix.rows(), n_columns)),
        device_right(right),
        near(assembly.near_rows(device_right)),
        device({.used = true, .precision = precision}, assembly.far_problem(), near) {
    assembly.rows(0, static_cast<std::size_t>(matrix.rows()), matrix, right);
    device_right += device.far_right(assembly.at_points());
  }
  detail::BemGeometry geometry;
  Eigen::MatrixXcd derivative;
  detail::Assembly assembly;
  la::RowMatrixXcd matrix;
  Eigen::MatrixXcd right, device_right;
  detail::NearRows near;
  detail::DeviceSystem device;
};

double largest(const Eigen::MatrixXcd& a) { return a.cwiseAbs().maxCoeff(); }

class BemOnDevice : public testing::TestWithParam<Precision> {
 protected:
  double tolerance() const { return GetParam() == Precision::kDouble ? 1e-12 : 1e-5; }
};
INSTANTIATE_TEST_SUITE_P(Precisions, BemOnDevice, testing::Values(Precision::kDouble, Precision::kSingle));

TEST_P(BemOnDevice, MatrixRightHandSideAndProductAreTheProcessors) {
  Both both(GetParam());
  const la::RowMatrixXcd found = both.device.matrix();
  for (Eigen::Index row = 0; row < found.rows(); ++row)
    EXPECT_LE(largest(found.row(row) - both.matrix.row(row)), tolerance() * largest(both.matrix.row(row))) << row;
  EXPECT_LE(largest(both.device_right - both.right), tolerance() * largest(both.right));
  const Eigen::MatrixXcd x = random_columns(found.rows(), 5);
  const Eigen::MatrixXcd expected = both.matrix * x;
  EXPECT_LE(largest(both.device.times(x) - expected), tolerance() * largest(expected));
  EXPECT_EQ(both.device.block(20, 30), found.block(20, 20, 30, 30));
}

TEST_P(BemOnDevice, SolutionIsTheProcessors) {
  const HelmholtzBem solver(body(4));
  const Eigen::MatrixXcd velocity = solver.from_triangles(random_columns(solver.surface().n_triangles(), 2));
  BemOptions options;
  options.allow_coarse = true;
  for (const double hz : {20.0, 1700.0}) {
    options.device = {};
    const BemResult expected = solver.solve(hz, velocity, options);
    options.device = {.used = true, .precision = GetParam()};
    const BemResult found = solver.solve(hz, velocity, options);
    ASSERT_TRUE(found.usable()) << found.message;
    EXPECT_EQ(found.device_message, "");
    EXPECT_NE(found.device, "processor");
    EXPECT_EQ(expected.device, "processor");
    EXPECT_LE(*found.relative_residual, GetParam() == Precision::kDouble ? 1e-9 : 3e-6);
    EXPECT_LE(largest(found.pressure_pa - expected.pressure_pa),
              (GetParam() == Precision::kDouble ? 1e-7 : 2e-4) * largest(expected.pressure_pa));
    EXPECT_LE(found.n_products, 60) << hz;
  }
}

TEST(BemOnDeviceBits, SameOnOneAndTwoCalls) {
  const HelmholtzBem solver(body(4));
  const Eigen::MatrixXcd velocity = solver.from_triangles(random_columns(solver.surface().n_triangles(), 1));
  BemOptions options;
  options.allow_coarse = true;
  options.device.used = true;
  EXPECT_EQ(solver.solve(900.0, velocity, options).pressure_pa, solver.solve(900.0, velocity, options).pressure_pa);
}

TEST(BemOnDeviceMemory, WhereThereIsNoneTheProcessorDoesItAndOneLineSaysSo) {
  const HelmholtzBem solver(body(3));
  const Eigen::MatrixXcd velocity = solver.from_triangles(random_columns(solver.surface().n_triangles(), 1));
  BemOptions options;
  options.allow_coarse = true;
  const BemResult expected = solver.solve(900.0, velocity, options);
  options.device = {.used = true, .memory_bytes = 100000};
  const BemResult found = solver.solve(900.0, velocity, options);
  EXPECT_EQ(found.device, "processor");
  EXPECT_NE(found.device_message.find("the boundary-element matrix of 92 unknowns needs"), std::string::npos)
      << found.device_message;
  EXPECT_EQ(found.device_message.find('\n'), std::string::npos);
  EXPECT_EQ(found.pressure_pa, expected.pressure_pa);
}

}  // namespace
}  // namespace klang::acoustics
