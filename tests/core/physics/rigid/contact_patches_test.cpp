#include "core/physics/rigid/detail/contact_patches.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/random.hpp"

using namespace klang::rigid::detail;
using Eigen::Vector3d;

namespace {

Contact touch(int a, int b, const Vector3d& place, const Vector3d& normal = Vector3d::UnitZ()) {
  Contact c;
  c.a = a;
  c.b = b;
  c.place = place;
  c.normal = normal;
  return c;
}

std::size_t n_at(const std::vector<Contact>& contacts, const Vector3d& place) {
  std::size_t n = 0;
  for (const Contact& c : contacts) n += (c.place - place).norm() <= 1e-9 ? 1 : 0;
  return n;
}

}  // namespace

// A box of eight parts on a box: nine corners, of which four hold all that the others hold, whatever the last digits do.
TEST(ContactPatches, PartsThatMeetInAPlaneTouchAtTheCornersOfTheirUnion) {
  klang::RandomStream random(5, 0);
  const auto noise = [&] { return 1e-15 * (2 * random.uniform() - 1); };
  for (int k = 0; k < 200; ++k) {
    const double turn = random.uniform();
    const Vector3d x(std::cos(turn), std::sin(turn), 0.0), y(-std::sin(turn), std::cos(turn), 0.0);
    std::vector<Contact> contacts;
    for (const int part_x : {0, 1})
      for (const int part_y : {0, 1})
        for (const int i : {0, 1})
          for (const int j : {0, 1})
            contacts.push_back(
                touch(0, 1, (part_x + i - 1) * x + (part_y + j - 1) * y + Vector3d(noise(), noise(), 0.3 + noise()),
                      (Vector3d::UnitZ() + Vector3d(noise(), noise(), 0)).normalized()));
    const std::vector<Contact> kept = patch_corners(contacts, std::vector<BodyState>(3), 2e-5);
    ASSERT_EQ(kept.size(), 4U) << k;
    for (const double i : {-1.0, 1.0})
      for (const double j : {-1.0, 1.0}) EXPECT_EQ(n_at(kept, i * x + j * y + Vector3d(0, 0, 0.3)), 1U) << k;
  }
}

TEST(ContactPatches, OtherPlanesNormalsPairsAndTheFloorStayApart) {
  const Vector3d middle(0.5, 0.5, 0.0);
  std::vector<Contact> contacts;
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 1.0}) contacts.push_back(touch(0, -1, {x, y, 0}));
  contacts.push_back(touch(0, -1, middle));
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 1.0}) contacts.push_back(touch(0, 1, {x, y, 0}));
  contacts.push_back(touch(0, 1, middle));                         // inside: goes
  contacts.push_back(touch(0, 1, middle - Vector3d(0, 0, 1e-3)));  // lower
  contacts.push_back(touch(0, 1, middle, Vector3d(0.6, 0, 0.8)));  // tilted
  contacts.push_back(touch(0, 2, middle));
  const std::vector<Contact> kept = patch_corners(contacts, std::vector<BodyState>(3), 2e-5);
  EXPECT_EQ(kept.size(), contacts.size() - 1);
  EXPECT_EQ(n_at(kept, middle), 3U);
}

// A disk of 64 corners that turns on a plane keeps the same eight, in its own frame.
TEST(ContactPatches, ARoundFaceKeepsTheSameEightCornersAndWhatIsDeeper) {
  klang::RandomStream random(6, 0);
  for (int k = 0; k < 100; ++k) {
    std::vector<BodyState> bodies(2);
    bodies[0].turn = Eigen::AngleAxisd(0.07 * k, Vector3d::UnitZ());
    std::vector<Contact> contacts;
    for (int i = 0; i < 64; ++i) {
      const Vector3d corner(std::cos(i * M_PI / 32), std::sin(i * M_PI / 32), 1e-15 * random.uniform());
      contacts.push_back(touch(0, 1, bodies[0].turn * corner));
      contacts.back().parts = {i, 0};
      contacts.back().gap = i == 11 ? -1.5e-5 : 0.0;
    }
    std::vector<int> corners;
    for (const Contact& c : patch_corners(contacts, bodies, 2e-5)) corners.push_back(c.parts[0]);
    // Directions at 0.1 + k 45 degrees: 5.7 degrees are nearest to corner 1.
    EXPECT_EQ(corners, (std::vector<int>{1, 9, 11, 17, 25, 33, 41, 49, 57})) << k;
  }
}

TEST(ContactPatches, ALineKeepsItsEnds) {
  std::vector<Contact> contacts;
  for (int i = 0; i <= 10; ++i) contacts.push_back(touch(0, 2, {0.1 * i, 0.2 * i, 0}));
  const std::vector<Contact> kept = patch_corners(contacts, std::vector<BodyState>(3), 2e-5);
  EXPECT_EQ(kept.size(), 2U);
  EXPECT_EQ(n_at(kept, {1, 2, 0}), 1U);
}
