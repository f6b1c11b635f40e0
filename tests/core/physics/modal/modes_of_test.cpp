#include "core/physics/modal/modes_of.hpp"

#include <gtest/gtest.h>

#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/expected_modes.hpp"
#include "core/physics/modal/revolution_modes.hpp"

using namespace klang;
using namespace klang::modal;

namespace {

const mesh::ShapeSpec kTube{"tube", {{"length_m", 0.2}, {"outer_radius_m", 0.02}, {"wall_m", 0.004}}, {}};
const mesh::ShapeSpec kBox{"box", {{"length_m", 0.1}, {"width_m", 0.02}, {"height_m", 0.01}}, {}};
const solid::Material kSteel = solid::from_youngs_modulus(200e9, 0.29, 7850);

ModesOptions with(ModesMethod method) {
  ModesOptions options;
  options.method = method;
  return options;
}

}  // namespace

TEST(ModesOf, HarmonicsArePickedForAFreeBodyOfRevolutionOfQuadraticElements) {
  EXPECT_EQ(chosen_method({kTube, {}}, {}), ModesMethod::kHarmonics);
  const mesh::ShapeSpec round{"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.05}, {"c_m", 0.03}}, {}};
  EXPECT_EQ(chosen_method({round, {}}, {}), ModesMethod::kHarmonics);
}

TEST(ModesOf, PolynomialsArePickedForABoxThatIsFreeOrHeldAtAFace) {
  EXPECT_EQ(chosen_method({kBox, {}}, {}), ModesMethod::kPolynomial);
  EXPECT_EQ(chosen_method({kBox, {solid::SupportKind::kClamped, "x=min"}}, {}), ModesMethod::kPolynomial);
  EXPECT_EQ(chosen_method({kBox, {solid::SupportKind::kClamped, "x<-0.01"}}, {}), ModesMethod::kTetrahedra);
  EXPECT_THROW(chosen_method({kTube, {}}, with(ModesMethod::kPolynomial)), InputError);
}

const mesh::ShapeSpec kFlat{"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.04}, {"c_m", 0.03}}, {}};

TEST(ModesOf, PolynomialsArePickedForAFreeEllipsoidOfThreeAxes) {
  EXPECT_EQ(chosen_method({kFlat, {}}, {}), ModesMethod::kPolynomial);
  const mesh::ShapeSpec round{"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.05}, {"c_m", 0.03}}, {}};
  EXPECT_EQ(chosen_method({round, {}}, {}), ModesMethod::kHarmonics);
}

TEST(ModesOf, TetrahedraArePickedForEverythingElse) {
  EXPECT_EQ(chosen_method({kFlat, {solid::SupportKind::kClamped, "z<-0.02"}}, {}), ModesMethod::kTetrahedra);
  EXPECT_EQ(chosen_method({std::nullopt, {}}, {}), ModesMethod::kTetrahedra) << "known by its mesh alone";
  EXPECT_EQ(chosen_method({kTube, {solid::SupportKind::kClamped, "z<-0.09"}}, {}), ModesMethod::kTetrahedra);
  EXPECT_EQ(chosen_method({kTube, {}, 1}, {}), ModesMethod::kTetrahedra);
  ModesOptions lumped;
  lumped.mass = solid::MassKind::kLumped;
  EXPECT_EQ(chosen_method({kTube, {}}, lumped), ModesMethod::kTetrahedra);
}

TEST(ModesOf, AWantedMeshOrMethodOverrulesTheDefault) {
  EXPECT_EQ(chosen_method({kTube, {}}, with(ModesMethod::kTetrahedra)), ModesMethod::kTetrahedra);
  ModesOptions wanted;
  wanted.mesh_is_wanted = true;
  EXPECT_EQ(chosen_method({kTube, {}}, wanted), ModesMethod::kTetrahedra);
  wanted.method = ModesMethod::kHarmonics;
  EXPECT_EQ(chosen_method({kTube, {}}, wanted), ModesMethod::kHarmonics);
}

TEST(ModesOf, HarmonicsOfABoxAreRefusedWithTheBodiesThatHaveThem) {
  try {
    chosen_method({kBox, {}}, with(ModesMethod::kHarmonics));
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    for (const char* word : {"box", "tube, rod", "ellipsoid with a_m = b_m", "revolution"})
      EXPECT_NE(message.find(word), std::string::npos) << message;
    EXPECT_EQ(message.find("shell_box"), std::string::npos) << message;
  }
}

TEST(ModesOf, BothMethodsGiveTheBitsOfTheirSolvers) {
  const mesh::TetMesh mesh = mesh::mesh_shape(kTube);
  ModesOptions options;
  options.eigen.count = 4;
  options.eigen.prove_none_missing = false;
  const EigenResult harmonics = modes_of({kTube, {}}, mesh, kSteel, options);
  EXPECT_EQ(harmonics.method_used, EigenMethod::kHarmonics);
  EXPECT_TRUE(harmonics.model.angular_frequency_rad_s ==
              solve_revolution_modes(kTube, mesh, kSteel, options.eigen).model.angular_frequency_rad_s);
  options.method = ModesMethod::kTetrahedra;
  const EigenResult tetrahedra = modes_of({kTube, {}}, mesh, kSteel, options);
  EXPECT_EQ(tetrahedra.method_used, EigenMethod::kShiftInvert);
  EXPECT_EQ(tetrahedra.wall_time_s.count("assembly"), 1u);
  EXPECT_TRUE(tetrahedra.model.angular_frequency_rad_s ==
              solve_modes(mesh, solid::assemble(mesh), kSteel, {}, options.eigen).model.angular_frequency_rad_s);
}

TEST(ModesOf, ExpectedModesCountABlockAndAPlateWithinAFactorOfTwo) {
  const std::vector<std::pair<mesh::ShapeSpec, double>> bodies = {
      {{"box", {{"length_m", 0.1}, {"width_m", 0.09}, {"height_m", 0.08}}, {}}, 90e3},
      {{"box", {{"length_m", 0.1}, {"width_m", 0.08}, {"height_m", 0.002}}, {}}, 60e3}};
  for (const auto& [shape, high_hz] : bodies) {
    const mesh::TetMesh mesh = mesh::mesh_shape(shape);
    ModesOptions options;
    options.eigen.band = {0.0, high_hz};
    options.eigen.prove_none_missing = false;
    const EigenResult result = modes_of({shape, {}}, mesh, kSteel, options);
    ASSERT_TRUE(result.usable()) << result.message;
    ASSERT_GT(result.model.n_modes(), 50);
    const double ratio = expected_modes(size_of(mesh), kSteel, high_hz) / static_cast<double>(result.model.n_modes());
    EXPECT_GE(ratio, 0.5);
    EXPECT_LE(ratio, 2.0);
  }
}

TEST(ModesOf, AModulusInGigapascalsWherePascalsAreMeantIsRefusedByEveryMethod) {
  const solid::Material soft = solid::from_youngs_modulus(65536, 0.29, 7850);
  for (const mesh::ShapeSpec& shape : {kTube, kBox, kFlat}) {
    const mesh::TetMesh mesh = mesh::mesh_shape(shape);
    EXPECT_THROW(modes_of({shape, {}}, mesh, soft, {}), InputError) << shape.kind;
    EXPECT_THROW(modes_of({shape, {}}, mesh, soft, with(ModesMethod::kTetrahedra)), InputError) << shape.kind;
    ModesOptions lowest;
    lowest.eigen.count = 1;
    EXPECT_TRUE(modes_of({shape, {}}, mesh, soft, lowest).usable()) << shape.kind;
  }
}
