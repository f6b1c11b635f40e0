#include "core/physics/modal/modal_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::InputError;
using klang::test::box_mesh;
using namespace klang::modal;
namespace solid = klang::solid;

ModalModel model_of(const klang::mesh::TetMesh& mesh, const solid::Material& material) {
  EigenOptions options;
  options.count = 8;
  options.band.low_hz = 0;
  EigenResult result = solve_modes(mesh, solid::assemble(mesh), material, {}, options);
  EXPECT_TRUE(result.usable()) << result.message;
  return result.model;
}

std::filesystem::path scratch(const char* name) { return std::filesystem::path(testing::TempDir()) / name; }

class ModalModelFile : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, ModalModelFile, testing::Values(1, 2));

TEST_P(ModalModelFile, ReadsBackEveryBit) {
  auto mesh = box_mesh(0.1, 0.08, 0.02, 3, 2, 1, GetParam());
  mesh.node_sets["rim"] = {5, 3, 0};
  mesh.node_sets["none at all"] = {};
  ModalModel model = model_of(mesh, {4.98e10, 2.57e10, 2700.0000000000005, "alloy \"x\" <y>", "two\nlines"});
  model.support = solid::parse_support("clamped:x<0.001");
  model.shapes(3, 1) = 5e-324;  // the smallest number there is
  const auto path = scratch("model.vtu");
  write_modal_model(path, model, R"({"command": "test"})");
  const ModalModel back = read_modal_model(path);
  EXPECT_EQ(back.angular_frequency_rad_s, model.angular_frequency_rad_s);
  EXPECT_EQ(back.shapes, model.shapes);
  EXPECT_EQ(back.mesh.nodes_m, model.mesh.nodes_m);
  EXPECT_EQ(back.mesh.elements, model.mesh.elements);
  EXPECT_EQ(back.mesh.node_sets, model.mesh.node_sets);
  EXPECT_EQ(back.material.lame_lambda_pa, model.material.lame_lambda_pa);
  EXPECT_EQ(back.material.lame_mu_pa, model.material.lame_mu_pa);
  EXPECT_EQ(back.material.density_kg_m3, model.material.density_kg_m3);
  EXPECT_EQ(back.material.name, model.material.name);
  EXPECT_EQ(back.material.source, model.material.source);
  EXPECT_EQ(solid::to_text(back.support), "clamped:x<0.001");
  const auto again = scratch("again.vtu");
  write_modal_model(again, back, R"({"command": "test"})");
  EXPECT_EQ(klang::read_file(path), klang::read_file(again));
}

TEST(ModalModelFileErrors, AreInputErrorsAndLeaveNothingBehind) {
  const ModalModel model = model_of(box_mesh(0.1, 0.08, 0.02, 2, 2, 1, 1), {4.98e10, 2.57e10, 2700, "", ""});
  EXPECT_THROW(write_modal_model(scratch("no such folder") / "m.vtu", model), InputError);
  EXPECT_THROW(read_modal_model(scratch("not there.vtu")), InputError);
  const auto path = scratch("whole.vtu");
  write_modal_model(path, model);
  const std::string bytes = klang::read_file(path);
  const auto broken = scratch("broken.vtu");
  for (const double share : {0.0, 0.1, 0.5, 0.9}) {
    klang::write_file(broken, std::string_view(bytes).substr(0, static_cast<std::size_t>(share * bytes.size())));
    EXPECT_THROW(read_modal_model(broken), InputError) << share;
  }
  std::string other_header = bytes;
  const std::size_t at = other_header.find("header_type=\"UInt32\"");
  ASSERT_NE(at, std::string::npos);
  klang::write_file(broken, other_header.replace(at, 20, "header_type=\"UInt64\""));
  EXPECT_THROW(read_modal_model(broken), InputError) << "counts of another width";
  for (const double value : {1e300, HUGE_VAL}) {
    ModalModel absurd = model;
    absurd.shapes(0, 0) = value;
    write_modal_model(broken, absurd);
    EXPECT_THROW(read_modal_model(broken), InputError) << value;
  }
  ModalModel turned = model;
  std::swap(turned.mesh.elements(0, 0), turned.mesh.elements(0, 1));
  write_modal_model(broken, turned);
  EXPECT_THROW(read_modal_model(broken), InputError) << "an element inside out";
  klang::write_file(broken, "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid/></VTKFile>");
  EXPECT_THROW(read_modal_model(broken), InputError);
}

void expect_same(const ModalModel& scaled, const ModalModel& solved) {
  ASSERT_EQ(scaled.n_modes(), solved.n_modes());
  for (Eigen::Index k = 0; k < solved.n_modes(); ++k) {
    EXPECT_NEAR(scaled.angular_frequency_rad_s[k] / solved.angular_frequency_rad_s[k], 1, 1e-9) << k;
    const double sign = scaled.shapes.col(k).dot(solved.shapes.col(k)) < 0 ? -1 : 1;
    EXPECT_LE((scaled.shapes.col(k) - sign * solved.shapes.col(k)).norm(), 1e-6 * solved.shapes.col(k).norm()) << k;
  }
}

// Three different edges, so that no two modes coincide.
const auto kBody = box_mesh(0.1, 0.07, 0.03, 4, 3, 1, 2);
const solid::Material kMaterial{4.98e10, 2.57e10, 2700, "", ""};

TEST(ModalModelRescaling, OtherDensityMatchesANewSolve) {
  solid::Material heavy = kMaterial;
  heavy.density_kg_m3 = 8500;
  expect_same(with_density(model_of(kBody, kMaterial), 8500), model_of(kBody, heavy));
}

TEST(ModalModelRescaling, CommonStiffnessFactorMatchesANewSolve) {
  solid::Material stiff = kMaterial;
  stiff.lame_lambda_pa *= 3.7;
  stiff.lame_mu_pa *= 3.7;
  expect_same(with_stiffness_factor(model_of(kBody, kMaterial), 3.7), model_of(kBody, stiff));
}

TEST(ModalModelRescaling, OtherSizeMatchesANewSolve) {
  auto large = kBody;
  large.nodes_m *= 2.5;
  const ModalModel scaled = with_size_factor(model_of(kBody, kMaterial), 2.5);
  EXPECT_EQ(scaled.mesh.nodes_m, large.nodes_m);
  expect_same(scaled, model_of(large, kMaterial));
}

TEST(ModalModelRescaling, RefusesFactorsThatAreNotPositive) {
  const ModalModel model = model_of(kBody, kMaterial);
  EXPECT_THROW(with_density(model, 0), InputError);
  EXPECT_THROW(with_stiffness_factor(model, -1), InputError);
  EXPECT_THROW(with_size_factor(model, std::nan("")), InputError);
}

}  // namespace
