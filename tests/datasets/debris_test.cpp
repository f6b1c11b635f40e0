#include "datasets-synthetic/debris.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "datasets-synthetic/ritz_box.hpp"

namespace klang::datasets {
namespace {

/// Largest height of a vertex over the plane of a triangle: <= 0 where the body is convex and its normals point outward.
double largest_height_m(const mesh::SurfaceMesh& surface) {
  double highest = -1.0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const Eigen::Vector3d a = surface.vertices_m.row(surface.triangles(t, 0)),
                          b = surface.vertices_m.row(surface.triangles(t, 1)),
                          c = surface.vertices_m.row(surface.triangles(t, 2));
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    for (Eigen::Index v = 0; v < surface.vertices_m.rows(); ++v)
      highest = std::max(highest, normal.dot(surface.vertices_m.row(v).transpose() - a));
  }
  return highest;
}

TEST(Debris, VolumesOfTheShardsAddUpToTheSlabs) {
  for (const int n : {1, 2, 10, 60}) {
    DebrisOptions options;
    options.n_shards = n;
    const auto shards = slab_shards(options);
    ASSERT_EQ(shards.size(), static_cast<std::size_t>(n));
    double sum = 0.0;
    for (const DebrisPiece& piece : shards) {
      EXPECT_GT(piece.volume_m3, 0.0);
      sum += piece.volume_m3;
    }
    EXPECT_LE(std::abs(sum / options.slab_m.prod() - 1.0), 1e-12) << n;
  }
}

TEST(Debris, EveryPieceIsClosedConvexAndFacesOutward) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    DebrisOptions options;
    options.seed = seed;
    options.n_shards = 15;
    for (const DebrisPiece& piece : debris(options)) {
      const mesh::SurfaceParts parts = mesh::check_closed_surface(piece.surface, piece.name);
      EXPECT_EQ(parts.n_parts, 1) << piece.name;
      EXPECT_LE(std::abs(parts.volume_m3 / piece.volume_m3 - 1.0), 1e-12) << piece.name;
      EXPECT_LE(largest_height_m(piece.surface), 1e-12) << piece.name;
    }
  }
}

TEST(Debris, CracksLeanUnlessTheTiltIsZero) {
  const auto most_leaning = [](const DebrisOptions& options) {
    double most = 0.0;
    for (const DebrisPiece& piece : slab_shards(options))
      for (Eigen::Index t = 0; t < piece.surface.triangles.rows(); ++t) {
        const Eigen::Vector3d a = piece.surface.vertices_m.row(piece.surface.triangles(t, 0)),
                              b = piece.surface.vertices_m.row(piece.surface.triangles(t, 1)),
                              c = piece.surface.vertices_m.row(piece.surface.triangles(t, 2));
        const double z = std::abs((b - a).cross(c - a).normalized().z());
        if (z < 0.9) most = std::max(most, std::asin(z));  // a crack or a side of the slab, not its top or bottom
      }
    return most * 180.0 / 3.14159265358979;
  };
  DebrisOptions options;
  EXPECT_GE(most_leaning(options), 2.0);
  EXPECT_LE(most_leaning(options), 25.0);
  options.largest_tilt_deg = 0.0;
  EXPECT_LE(most_leaning(options), 1e-6);
}

TEST(Debris, SameSeedGivesTheSameBitsAndAnotherSeedOtherShards) {
  DebrisOptions options;
  const auto one = debris(options), again = debris(options);
  options.seed = 2;
  const auto other = debris(options);
  ASSERT_EQ(one.size(), again.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].name, again[i].name);
    ASSERT_EQ(one[i].surface.vertices_m.rows(), again[i].surface.vertices_m.rows());
    EXPECT_TRUE((one[i].surface.vertices_m.array() == again[i].surface.vertices_m.array()).all());
    EXPECT_TRUE((one[i].surface.triangles.array() == again[i].surface.triangles.array()).all());
  }
  EXPECT_NE(one.back().volume_m3, other.back().volume_m3);
}

TEST(Debris, NoShardHasAnEdgeShorterThanATwentiethOfTheThickness) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    DebrisOptions options;
    options.seed = seed;
    double shortest = 1.0;
    for (const DebrisPiece& piece : slab_shards(options))
      for (Eigen::Index t = 0; t < piece.surface.triangles.rows(); ++t)
        for (int c = 0; c < 3; ++c)
          shortest = std::min(shortest, (piece.surface.vertices_m.row(piece.surface.triangles(t, c)) -
                                         piece.surface.vertices_m.row(piece.surface.triangles(t, (c + 1) % 3)))
                                            .norm());
    EXPECT_GE(shortest, 0.05 * options.slab_m[2]) << seed;
  }
}

TEST(Debris, FirstModesOfTheMeshedBoxAgreeWithTheRitzBoxToTheMeshsError) {
  DebrisOptions options;
  options.box_m = {0.06, 0.04, 0.025};
  options.n_shards = 0;
  options.plate_thicknesses_m.clear();
  const auto pieces = debris(options);
  ASSERT_EQ(pieces.size(), 1u);
  mesh::TetgenOptions mesher;
  mesher.max_edge_m = 0.01;
  const mesh::TetMesh mesh = mesh::mesh_surface(pieces[0].surface, mesher, "box");
  const solid::Material glass = solid::from_youngs_modulus(6.2e10, 0.2, 2600.0);
  modal::EigenOptions eigen;
  eigen.count = 8;
  eigen.estimate_mesh_error = true;
  const modal::EigenResult found = modal::solve_modes(mesh, solid::assemble(mesh), glass, {}, eigen);
  ASSERT_TRUE(found.usable());
  RitzBoxOptions wide;
  wide.highest_hz = 1e5;
  const RitzBox exact(options.box_m, glass, wide);
  for (Eigen::Index k = 0; k < 8; ++k) {
    const double error = found.model.angular_frequency_rad_s[k] / exact.angular_frequency_rad_s()[k] - 1.0;
    EXPECT_GE(error, -1e-6) << k;  // an upper bound
    EXPECT_LE(error, 1.3 * (*found.mesh_relative_error)[k] + 1e-6) << k;
    EXPECT_LE(error, 3e-3) << k;
  }
}

TEST(Debris, BadOptionsAreInputErrors) {
  const auto refused = [](auto change) {
    DebrisOptions options;
    change(options);
    EXPECT_THROW(debris(options), InputError);
  };
  refused([](DebrisOptions& o) { o.n_shards = -1; });
  refused([](DebrisOptions& o) { o.n_shards = 501; });
  refused([](DebrisOptions& o) { o.slab_m[2] = 0.5; });
  refused([](DebrisOptions& o) { o.box_m[0] = NAN; });
  refused([](DebrisOptions& o) { o.plate_thicknesses_m = {0.0}; });
  refused([](DebrisOptions& o) { o.largest_tilt_deg = 60.0; });
}

}  // namespace
}  // namespace klang::datasets
