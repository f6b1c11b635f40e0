#include "core/sound/stage/listener.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::stage {
namespace {

TEST(Listener, WalksStraightBetweenTimesAndIsExactlyThereAtThem) {
  Eigen::Matrix3Xd places(3, 3);
  places << 0.1, 0.7, 0.3, 0, 0, 1, 2, 2, 2;
  const Listener listener = Listener::ears({0.0, 1.0, 3.0}, places);
  EXPECT_EQ(listener.ear_m(0, 1.0), Eigen::Vector3d(0.7, 0, 2));
  EXPECT_LE((listener.ear_m(0, 2.0) - Eigen::Vector3d(0.5, 0.5, 2)).norm(), 1e-15);
  EXPECT_EQ(listener.ear_m(0, -5.0), Eigen::Vector3d(0.1, 0, 2));
  EXPECT_EQ(listener.ear_m(0, 9.0), Eigen::Vector3d(0.3, 1, 2));
  EXPECT_TRUE(listener.moves());
  EXPECT_FALSE(listener.stereo());
}

TEST(Listener, HeadTurnsItsNoseOnTheWay) {
  Eigen::Matrix3Xd centres(3, 2), facings(3, 2);
  centres << 0, 2, 0, 0, 1, 1;
  facings << 0, 5, 3, 0, 0, 0;  // from +y to +x, lengths do not matter
  const Listener listener = Listener::head({0.0, 1.0}, centres, facings, {});
  const Eigen::Vector3d nose = listener.head_at(0.5).facing.normalized();
  EXPECT_LE((nose - Eigen::Vector3d(std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 1e-12);
  EXPECT_EQ(listener.centre_m(0.5), Eigen::Vector3d(1, 0, 1));
  EXPECT_EQ(listener.n_channels(), 2);
}

TEST(Listener, WayIsTheDistanceWithDelayAndAgainstTheCentreWithout) {
  const double c = 343.0;
  const Eigen::Vector3d source(0.0, 3.0, 0.0);
  Listener one = Listener::ears({0.0}, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(one.way_s(0, 0.0, source, c), 0.0);
  one.propagation_delay = true;
  EXPECT_LE(std::abs(one.way_s(0, 0.0, source, c) - 3.0 / c), 1e-15);
  Listener two = Listener::ears({0.0}, Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0));
  EXPECT_LE(std::abs(two.way_s(0, 0.0, source, c) + 1.0 / c), 1e-15);
  EXPECT_GE(two.way_s(0, 0.0, source, c), -two.lead_s(c) * (1.0 + 1e-15));
  two.propagation_delay = true;
  EXPECT_LE(std::abs(two.way_s(1, 0.0, source, c) - 4.0 / c), 1e-15);
  SphericalHead head;
  head.centre_m.setZero();
  const Listener listener = Listener::head({0.0}, head.centre_m, {}, head);
  EXPECT_EQ(listener.way_s(0, 0.0, source, c), head.delay_s(head.angle_rad(0, source)));
  EXPECT_EQ(listener.shadow(0, 0.0, source, 5000.0), head.shadow(head.angle_rad(0, source), 5000.0));
  EXPECT_EQ(one.shadow(0, 0.0, source, 5000.0), std::complex<double>(1.0));
}

TEST(Listener, RefusesPlacesAndTimesThatCannotBe) {
  Eigen::Matrix3Xd two(3, 2);
  two << 0, 1, 0, 0, 0, 0;
  EXPECT_NO_THROW(Listener::ears({0.0, 1.0}, two).validate());
  EXPECT_THROW(Listener::ears({1.0, 1.0}, two).validate(), InputError);
  EXPECT_THROW(Listener::ears({0.0}, two).validate(), InputError);
  EXPECT_THROW(Listener::ears({0.0, 1.0}, two, Eigen::Vector3d(0, 0, 0)).validate(), InputError);
  two(1, 1) = std::nan("");
  EXPECT_THROW(Listener::ears({0.0, 1.0}, two).validate(), InputError);
  EXPECT_THROW(Listener::without_place(0).validate(), InputError);
  SphericalHead flat;
  flat.radius_m = 0.0;
  EXPECT_THROW(Listener::head({0.0}, flat.centre_m, {}, flat).validate(), InputError);
}

}  // namespace
}  // namespace klang::stage
