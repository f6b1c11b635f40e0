// Which corners of a modal body are looked at where only the floor is near.
#include <gtest/gtest.h>

#include "core/geometry/shapes/shape.hpp"
#include "core/sound/scene/detail/rigid_push.hpp"
#include "tests/core/sound/scene/modal_corners.hpp"

namespace klang::scene::detail {
namespace {

TEST(ModalCorners, AllThatAreBelowTheFloorAreLookedAtAndStandWhereTheyAre) {
  std::size_t most = 0;
  int below = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ModalBody all = test::ball_of_corners(2000, 12, seed);
    all.centre_m.z() -= 2e-4 * seed;
    ModalBody low = all;
    all.refresh();
    low.refresh_where([](const Eigen::Vector3d& x, double radius_m) { return x.z() <= radius_m; });
    EXPECT_EQ(all.looked_at.size(), 2000u);
    EXPECT_GE(low.swell_m, all.swell_m);
    most = std::max(most, low.looked_at.size());
    for (const int i : all.looked_at) {
      const bool looked = std::binary_search(low.looked_at.begin(), low.looked_at.end(), i);
      if (all.corners_m(2, i) <= 0.0) {
        ++below;
        EXPECT_TRUE(looked);
      }
      if (looked) {
        EXPECT_LE((all.corners_m.col(i) - low.corners_m.col(i)).norm(), 1e-15);
      }
    }
  }
  EXPECT_GT(below, 100);
  EXPECT_LT(most, 600u);
}

TEST(ModalCorners, AllThatAreInABoxBesideThemAreLookedAt) {
  rigid::RigidWorld world({});
  rigid::RigidBodySpec box;
  box.name = "box";
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i)
    corners.col(i) = Eigen::Vector3d((i & 1) ? 0.05 : -0.05, (i & 2) ? 0.04 : -0.04, (i & 4) ? 0.03 : -0.03);
  box.parts.push_back({corners});
  box.mass_kg = 1.0;
  box.inertia_kg_m2 = 1e-3 * Eigen::Matrix3d::Identity();
  box.position_m = {0.12, 0.02, 0.1};
  box.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1.0, 1.0, 0.3).normalized()));
  world.add(box);
  PressedBody other(world, 0, PressedBody::Way::kStruck);
  other.begin(world, 1e-4, Eigen::Vector3d::Zero());
  int inside = 0;
  std::size_t most = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ModalBody all = test::ball_of_corners(2000, 12, seed);
    ModalBody near = all;
    all.refresh();
    near.refresh_where([&](const Eigen::Vector3d& x, double radius_m) { return other.may_hold(x, radius_m); });
    most = std::max(most, near.looked_at.size());
    for (const int i : all.looked_at) {
      const auto depth = other.depth_of(all.corners_m.col(i));
      if (!depth || !(depth->depth_m > 0.0)) continue;
      ++inside;
      EXPECT_TRUE(std::binary_search(near.looked_at.begin(), near.looked_at.end(), i));
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_LT(most, 1200u);
}

TEST(ModalCorners, TheNearestPointByGroupsIsThatOfTheWholeSurface) {
  const mesh::SurfaceMesh surface =
      mesh::boundary_surface(mesh::mesh_shape({"ellipsoid", {{"a_m", 0.09}, {"b_m", 0.07}, {"c_m", 0.06}}, {}}, {}));
  const SurfaceGroups groups(surface);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(-0.12, 0.12);
  for (int n = 0; n < 300; ++n) {
    const Eigen::Vector3d x(part(random), part(random), part(random));
    const mesh::SurfacePoint whole = mesh::nearest_surface_point(surface, x), found = groups.nearest(x);
    EXPECT_LE(std::abs(whole.distance_m - found.distance_m), 1e-15);
    Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      a += whole.barycentric[c] * surface.vertices_m.row(whole.nodes[k]).transpose();
      b += found.barycentric[c] * surface.vertices_m.row(found.nodes[k]).transpose();
    }
    EXPECT_LE((a - b).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace klang::scene::detail
