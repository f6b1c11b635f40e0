#include "core/physics/rigid/detail/ways_apart.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/random.hpp"

using namespace klang::rigid::detail;
using Eigen::Vector3d;

namespace {

constexpr double kSlop = 2e-5;

BodyState body(double mass) {
  BodyState b;
  b.mass = mass;
  b.inverse_mass = mass > 0 ? 1 / mass : 0.0;
  return b;
}

/// What is pressed together, before bodies are numbered.
struct Press {
  int upper = 0, lower = -1;
  Vector3d normal = Vector3d::UnitZ();
  double depth = 0.0;
};

/// Ways by the bodies' own names, where body i has the number number[i].
std::vector<Vector3d> ways(const std::vector<BodyState>& bodies, const std::vector<Press>& presses,
                           const std::vector<int>& number) {
  std::vector<BodyState> numbered(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) numbered[static_cast<std::size_t>(number[i])] = bodies[i];
  std::vector<Contact> contacts;
  for (const Press& press : presses) {
    Contact c;
    c.a = number[static_cast<std::size_t>(press.upper)];
    c.b = press.lower < 0 ? -1 : number[static_cast<std::size_t>(press.lower)];
    c.normal = press.normal;
    c.gap = -press.depth;
    if (c.b > c.a) {
      std::swap(c.a, c.b);
      c.normal = -c.normal;
    }
    contacts.push_back(c);
  }
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const Contact& x, const Contact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  std::vector<double> gaps;
  for (const Contact& c : contacts) gaps.push_back(c.gap);
  const std::vector<Vector3d> found = ways_apart(contacts, gaps, kSlop, numbered);
  std::vector<Vector3d> own;
  for (const int i : number) own.push_back(found.at(static_cast<std::size_t>(i)));
  return own;
}

std::vector<int> in_order(std::size_t n) {
  std::vector<int> number(n);
  std::iota(number.begin(), number.end(), 0);
  return number;
}

}  // namespace

// On the floor, then each on the one below: i rises by i + 1 fifths, whatever is how heavy.
TEST(WaysApart, AStackRisesByAFifthAtEachTouch) {
  constexpr double kDepth = 1e-3, kFifth = 0.2 * (kDepth - kSlop);
  for (const double ratio : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    const std::vector<BodyState> bodies{body(1.0), body(ratio), body(ratio)};
    const std::vector<Press> presses{
        {0, -1, Vector3d::UnitZ(), kDepth}, {1, 0, Vector3d::UnitZ(), kDepth}, {2, 1, Vector3d::UnitZ(), kDepth}};
    for (const std::vector<int>& number : {std::vector<int>{0, 1, 2}, {2, 1, 0}, {1, 0, 2}, {2, 0, 1}}) {
      const std::vector<Vector3d> found = ways(bodies, presses, number);
      for (int i = 0; i < 3; ++i)
        EXPECT_LE((found[static_cast<std::size_t>(i)] - (i + 1) * kFifth * Vector3d::UnitZ()).norm(), 0.02 * kFifth)
            << ratio << ' ' << i << ' ' << number[0] << number[1] << number[2];
    }
  }
}

// Eight points of a pair in one plane are one touch: the deepest's fifth, as alone, also against what presses from above.
TEST(WaysApart, PointsOfOneSideAskOnce) {
  std::vector<Press> presses;
  for (int i = 0; i < 8; ++i) presses.push_back({0, -1, Vector3d::UnitZ(), 1e-3 - 1e-5 * ((3 * i) % 8)});
  EXPECT_LE((ways({body(0.3)}, presses, {0})[0] - 0.2 * (1e-3 - kSlop) * Vector3d::UnitZ()).norm(), 1e-15);
}

// Bodies that overlap by chance along the line of their centres can all go apart: they do, by the same ways however they are numbered.
TEST(WaysApart, NumbersOfBodiesDoNotMatter) {
  klang::RandomStream random(8, 0);
  for (int k = 0; k < 30; ++k) {
    std::vector<BodyState> bodies;
    std::vector<Vector3d> places;
    for (int i = 0; i < 10; ++i) {
      bodies.push_back(body(i == 3 ? 0.0 : std::exp(3 * random.uniform())));
      places.emplace_back(random.uniform(), random.uniform(), random.uniform());
    }
    std::vector<Press> presses;
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < i; ++j)
        if (random.uniform() < 0.4)
          presses.push_back({i, j,
                             (places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(j)]).normalized(),
                             1e-3 * random.uniform()});
    const std::vector<Vector3d> first = ways(bodies, presses, in_order(10));
    for (const Press& press : presses) {
      const double apart =
          press.normal.dot(first[static_cast<std::size_t>(press.upper)] - first[static_cast<std::size_t>(press.lower)]);
      const double want = press.depth > 2 * kSlop ? 0.2 * (press.depth - kSlop) : std::min(0.0, press.depth - kSlop);
      EXPECT_GE(apart, want - 2e-6) << k;
    }
    std::vector<int> number = in_order(10);
    for (std::size_t i = 9; i > 0; --i)
      std::swap(number[i], number[static_cast<std::size_t>(random.uniform() * static_cast<double>(i + 1))]);
    const std::vector<Vector3d> second = ways(bodies, presses, number);
    for (std::size_t i = 0; i < 10; ++i) EXPECT_LE((first[i] - second[i]).norm(), 1e-9) << k << ' ' << i;
  }
}

// One or two bodies between fixed ones have nowhere to go: no touch gets deeper by more than a
// thousandth of the fifth, or so; what lies beside rises.
TEST(WaysApart, WhatIsPressedFromTwoSidesGoesNoDeeper) {
  const Vector3d up = Vector3d::UnitZ();
  for (const double ratio : {0.01, 1.0, 100.0})
    for (const double upper : {2e-4, 1e-3}) {
      const std::vector<BodyState> bodies{body(1.0), body(ratio), body(0.0), body(1.0)};
      const std::vector<Press> presses{{0, -1, up, 1e-3}, {1, 0, up, 1e-3}, {2, 1, up, upper}, {3, -1, up, 1e-3}};
      for (const std::vector<int>& number : {std::vector<int>{0, 1, 2, 3}, {3, 2, 1, 0}, {1, 0, 3, 2}}) {
        const std::vector<Vector3d> found = ways(bodies, presses, number);
        const double w0 = found[0].z(), w1 = found[1].z();
        for (const double apart : {w0, w1 - w0, -w1}) EXPECT_GE(apart, -2.5e-7) << ratio << ' ' << upper;
        EXPECT_LE(found[2].norm(), 0.0);
        EXPECT_NEAR(found[3].z(), 0.2 * (1e-3 - kSlop), 2e-6);
      }
    }
}

// What lies in the touch of two slops keeps it when another is pushed that way.
TEST(WaysApart, NothingIsPressedIntoWhatItTouches) {
  const Vector3d up = Vector3d::UnitZ();
  const std::vector<Vector3d> found = ways({body(1.0), body(50.0)}, {{0, -1, up, 1e-5}, {1, 0, up, 1e-3}}, {0, 1});
  EXPECT_NEAR(found[0].z(), -1e-5, 2e-6);  // to a slop
  EXPECT_NEAR(found[1].z(), 0.2 * (1e-3 - kSlop) - 1e-5, 2e-6);
}
