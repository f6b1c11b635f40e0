#include "core/physics/modal/polynomial_modes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "datasets-synthetic/debris.hpp"
#include "datasets-synthetic/ritz_box.hpp"

namespace klang::modal {
namespace {

const solid::Material kGlass = solid::from_youngs_modulus(6.2e10, 0.2, 2600.0);

datasets::DebrisPiece box_of(const Eigen::Vector3d& size_m) {
  datasets::DebrisOptions options;
  options.box_m = size_m;
  options.n_shards = 0;
  options.plate_thicknesses_m.clear();
  return datasets::debris(options).front();
}

double error(const mesh::SurfaceMesh& surface, int degree, double exact_hz) {
  return lowest_frequency_hz(surface, kGlass, {degree}) / exact_hz - 1.0;
}

TEST(PolynomialModes, LowestFrequencyOfABoxFallsTowardsTheRitzBoxs) {
  for (const Eigen::Vector3d& size : {Eigen::Vector3d(0.12, 0.08, 0.05), Eigen::Vector3d(0.08, 0.06, 0.004)}) {
    const auto box = box_of(size);
    const double exact = datasets::RitzBox(size, kGlass).angular_frequency_rad_s()[0] / (2.0 * kPi);
    double before = 1.0;
    for (const int degree : {4, 6, 8}) {  // odd ones add nothing to its lowest mode, a twist
      const double now = error(box.surface, degree, exact);
      EXPECT_GE(now, -1e-7) << "an upper bound";
      EXPECT_LE(now, 0.5 * before) << degree;
      before = now;
    }
    EXPECT_LE(error(box.surface, 6, exact), 0.01);
  }
}

TEST(PolynomialModes, LowestFrequencyDoesNotDependOnPlaceOrDirection) {
  const auto shard = datasets::slab_shards().front();
  mesh::SurfaceMesh turned = shard.surface;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  turned.vertices_m = (turned.vertices_m * turn.transpose()).eval();
  turned.vertices_m.rowwise() += Eigen::RowVector3d(3.0, -2.0, 1.0);
  const double one = lowest_frequency_hz(shard.surface, kGlass), other = lowest_frequency_hz(turned, kGlass);
  EXPECT_LE(std::abs(other / one - 1.0), 1e-8);
}

TEST(PolynomialModes, LowestFrequencyOfShardsLiesWithinOnePercentOfFiniteElements) {
  const auto shards = datasets::slab_shards();
  for (std::size_t i = 0; i < 3; ++i) {
    mesh::TetgenOptions mesher;
    mesher.max_edge_m = 0.012;
    const mesh::TetMesh mesh = mesh::mesh_surface(shards[i].surface, mesher, shards[i].name);
    EigenOptions eigen;
    eigen.count = 1;
    eigen.estimate_mesh_error = true;
    const EigenResult found = solve_modes(mesh, solid::assemble(mesh), kGlass, {}, eigen);
    ASSERT_TRUE(found.usable());
    const double exact = found.model.frequency_hz()[0] / (1.0 + (*found.mesh_relative_error)[0]);
    const double off = error(shards[i].surface, 6, exact);
    EXPECT_GE(off, -1e-3) << shards[i].name;
    EXPECT_LE(off, 0.01) << shards[i].name;
  }
}

TEST(PolynomialModes, BadInputIsAnInputError) {
  auto box = box_of({0.1, 0.1, 0.1});
  EXPECT_THROW(lowest_frequency_hz(box.surface, kGlass, {1}), InputError);
  EXPECT_THROW(lowest_frequency_hz(box.surface, kGlass, {11}), InputError);
  box.surface.triangles.col(0).swap(box.surface.triangles.col(1));
  EXPECT_THROW(lowest_frequency_hz(box.surface, kGlass), InputError);
}

}  // namespace
}  // namespace klang::modal
