#include "core/geometry/shapes/shape_registry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/shapes/section.hpp"
#include "tests/core/geometry/shapes/shape_examples.hpp"
#include "tests/places.hpp"

using namespace klang;
using namespace klang::mesh;
using namespace klang::mesh::test;

namespace {

/// The section turned about z: V = 2 pi sum of r dA over each element, by its corners' quadrilateral (degree 1).
double turned_volume_m3(const Section& section) {
  double volume = 0.0;
  for (int e = 0; e < section.n_elements(); ++e) {
    const std::array<int, 4> ring{0, 1, 3, 2};
    for (std::size_t c = 0; c < 4; ++c) {
      const Eigen::Vector2d a = section.nodes_m.row(section.elements(e, ring[c]));
      const Eigen::Vector2d b = section.nodes_m.row(section.elements(e, ring[(c + 1) % 4]));
      volume += M_PI / 3.0 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x()) * (b.y() - a.y());
    }
  }
  return volume;
}

}  // namespace

TEST(ShapeRegistry, HoldsTheNineKindsInTheOrderOfEveryList) {
  const std::vector<std::string> expected{"tube",   "rod",  "box",        "shell_box",   "ellipsoid",
                                          "sphere", "bowl", "revolution", "undercut_bar"};
  EXPECT_EQ(shape_kinds(), expected);
  std::vector<std::string> shown;
  for (const ShapeSpec& spec : examples_and_profile()) shown.push_back(spec.kind);
  EXPECT_EQ(shown, expected) << "an example of every kind";
  for (const std::string& kind : expected) EXPECT_EQ(find_shape(kind).facts().name, kind);
}

TEST(ShapeRegistry, UnknownKindIsRefusedWithTheKnownOnes) {
  try {
    find_shape("cone");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "shape: unknown kind (cone; allowed: tube, rod, box, shell_box, ellipsoid, sphere, bowl, revolution, "
                 "undercut_bar)");
  }
}

TEST(ShapeRegistry, EverySectionTurnedHasTheBodysVolume) {
  int n_sections = 0;
  for (const ShapeSpec& spec : examples_and_profile()) {
    const ShapeKind& kind = find_shape(spec.kind);
    EXPECT_EQ(kind.is_axisymmetric(spec), !kind.axisymmetric_words().empty()) << spec.kind;
    if (!kind.is_axisymmetric(spec)) continue;
    ++n_sections;
    SectionDivisions divisions = section_divisions(spec, 0.0005);
    divisions.degree = 1;
    EXPECT_LE(std::abs(turned_volume_m3(mesh_section(spec, divisions)) / shape_volume_m3(spec) - 1.0), 1e-3)
        << spec.kind;
  }
  EXPECT_EQ(n_sections, 6);
}

TEST(ShapeRegistry, EveryDimensionIsNeededAndRefusedOutsideItsRange) {
  for (const ShapeSpec& spec : examples()) {
    EXPECT_NO_THROW(validate(spec)) << spec.kind;
    EXPECT_EQ(spec.dims.size(), find_shape(spec.kind).facts().dimensions.size());
    for (const ShapeDimension& dimension : find_shape(spec.kind).facts().dimensions) {
      EXPECT_FALSE(dimension.meaning.empty());
      for (const double value : {dimension.low_m, -1.0, dimension.high_m, std::nan(""), HUGE_VAL}) {
        ShapeSpec bad = spec;
        bad.dims[dimension.name] = value;
        EXPECT_THROW(validate(bad), InputError) << spec.kind << " " << dimension.name << " = " << value;
      }
      ShapeSpec without = spec;
      without.dims.erase(dimension.name);
      EXPECT_THROW(validate(without), InputError) << spec.kind << " without " << dimension.name;
    }
    ShapeSpec more = spec;
    more.dims["more_m"] = 0.01;
    EXPECT_THROW(validate(more), InputError) << spec.kind;
  }
}

TEST(ShapeRegistry, ABodyOfEveryKindIsDividedForItsResonancesAndFinerForReference) {
  for (const ShapeSpec& spec : examples_and_profile()) {
    EXPECT_NO_THROW(mesh_shape(spec, resonance_divisions(spec, 5000.0, 10000.0), 1)) << spec.kind;
    const int by_default = mesh_shape(spec).n_elements();
    EXPECT_GE(mesh_shape(spec, reference_divisions(spec), 2).n_elements(), by_default) << spec.kind;
  }
}

TEST(ShapeRegistry, LongAxisIsThatOfTheSweepOrTheLongestSide) {
  const auto axis = [](const ShapeSpec& spec) { return find_shape(spec.kind).long_axis(spec); };
  const auto all = examples();
  EXPECT_EQ(axis(all[0])->axis, 2);
  EXPECT_TRUE(axis(all[0])->round);
  EXPECT_EQ(axis({"box", {{"length_m", 0.01}, {"width_m", 0.2}, {"height_m", 0.02}}, {}})->axis, 1);
  EXPECT_FALSE(axis(all[2])->round);
  EXPECT_FALSE(axis(all[5]).has_value());
}

TEST(ShapeRegistry, DocsHoldTheRegistrysTable) {
  std::ifstream file(klang::test::source_dir() + "/docs/shapes.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find(shapes_table()), std::string::npos) << "docs/shapes.md should hold:\n" << shapes_table();
}
