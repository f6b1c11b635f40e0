#include "core/physics/solid/support.hpp"

#include <gtest/gtest.h>

#include <tuple>

#include "core/foundation/base/errors.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::InputError;
using namespace klang::solid;

TEST(Support, PlanesBoxesAndSetsHoldTheirNodes) {
  auto mesh = klang::test::box_mesh(1, 1, 1, 2, 2, 2, 1);
  mesh.node_sets["corner"] = {26, 0, 26};
  EXPECT_TRUE(held_nodes(parse_support("free"), mesh).empty());
  EXPECT_EQ(held_nodes(parse_support("clamped:x=0"), mesh).size(), 9u);
  EXPECT_EQ(held_nodes(parse_support("clamped:y<0.6"), mesh).size(), 18u);
  EXPECT_EQ(held_nodes(parse_support("pinned:z>0.6"), mesh).size(), 9u);
  EXPECT_EQ(held_nodes(parse_support("pinned:box:0,0,0:1,0.5,0"), mesh).size(), 6u);
  EXPECT_EQ(held_nodes(parse_support("clamped:set:corner"), mesh), (std::vector<int>{0, 26}));
}

TEST(Support, EndsAreFoundWhereverTheBodyStands) {
  auto mesh = klang::test::box_mesh(1, 1, 1, 2, 2, 2, 1);
  mesh.nodes_m.col(1).array() -= 7.3;
  for (const auto& [place, coordinate, value] : {std::tuple{"clamped:x=min", 0, 0.0},
                                                 {"clamped:x=max", 0, 1.0},
                                                 {"pinned:y=min", 1, -7.3},
                                                 {"pinned:y=max", 1, -6.3},
                                                 {"clamped:z=max", 2, 1.0}}) {
    const std::vector<int> held = held_nodes(parse_support(place), mesh);
    EXPECT_EQ(held.size(), 9u) << place;
    for (const int node : held) EXPECT_NEAR(mesh.nodes_m(node, coordinate), value, 1e-12) << place;
  }
}

TEST(Support, PlaneHasASlackOfAMillionthOfTheBody) {
  auto mesh = klang::test::box_mesh(1, 1, 1, 1, 1, 1, 1);
  mesh.nodes_m(0, 0) = 1e-7;
  EXPECT_EQ(held_nodes(parse_support("clamped:x=0"), mesh).size(), 4u);
  mesh.nodes_m(0, 0) = 1e-5;
  EXPECT_EQ(held_nodes(parse_support("clamped:x=0"), mesh).size(), 3u);
}

TEST(Support, RefusesWhatItDoesNotUnderstand) {
  for (const char* text : {"", "glued:x=0", "clamped", "clamped:", "clamped:w=0", "clamped:x=", "clamped:x=1e",
                           "clamped:x=nan", "clamped:box:0,0:1,1,1", "clamped:box:0,0,0:1,1", "clamped:box:1,0,0:0,1,1",
                           "clamped:box:0,0,0,0:1,1,1", "clamped:set:", "clamped:x~1", "free:x=0"}) {
    EXPECT_THROW(parse_support(text), InputError) << text;
  }
  const auto mesh = klang::test::box_mesh(1, 1, 1, 1, 1, 1, 1);
  EXPECT_THROW(held_nodes(parse_support("clamped:x=0.5"), mesh), InputError);
  EXPECT_THROW(held_nodes(parse_support("clamped:set:rim"), mesh), InputError);
}

}  // namespace
