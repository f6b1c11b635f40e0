// B99's separation tensor against tests/reference/separation.json, and step limits against tests/reference/stability.json.
#include "core/physics/fracture/dynamic/separation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/physics/fracture/dynamic/step_limit.hpp"
#include "tests/core/physics/fracture/dynamic/lattice.hpp"
#include "tests/places.hpp"

namespace klang::fracture {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

nlohmann::json reference(const std::string& name) {
  std::ifstream file(name == "separation" ? klang::test::source_dir() + "/tests/reference/separation.json"
                                          : klang::test::source_dir() + "/tests/reference/stability.json");
  return nlohmann::json::parse(file);
}

solid::Material material() {
  solid::Material m;
  m.lame_lambda_pa = 0.7;
  m.lame_mu_pa = 1.3;
  m.density_kg_m3 = 1.0;
  return m;
}

/// Every element under this stress without any strain: plastic strain is -C^-1 of it.
void set_stress(CrackMesh& mesh, const Matrix3d& stress) {
  const solid::Material m = material();
  const double k = 3.0 * m.lame_lambda_pa + 2.0 * m.lame_mu_pa;
  const Matrix3d strain =
      (stress - m.lame_lambda_pa / k * stress.trace() * Matrix3d::Identity()) / m.lame_mu_pa;  // doubled
  for (int e = 0; e < mesh.n_elements(); ++e)
    mesh.set_plastic(e, {-strain(0, 0), -strain(1, 1), -strain(2, 2), -strain(0, 1), -strain(1, 2), -strain(2, 0)});
}

Matrix3d stress_named(const std::string& name) {
  Matrix3d s = Matrix3d::Zero();
  if (name == "uniaxial_x") s(0, 0) = 1;
  if (name == "uniaxial_y") s(1, 1) = 1;
  if (name == "uniaxial_111") s.setConstant(1.0 / 3.0);
  if (name == "equibiaxial_yz") s(1, 1) = s(2, 2) = 1;
  if (name == "hydrostatic") s.setIdentity();
  if (name == "pure_shear_xy") s(0, 1) = s(1, 0) = 1;
  if (name == "uniaxial_compression_x") s(0, 0) = -1;
  return s;
}

int node_at(const CrackMesh& mesh, const Vector3d& place) {
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if ((mesh.rest_m[static_cast<std::size_t>(i)] - place).norm() < 1e-9) return i;
  return -1;
}

TEST(Separation, LatticeNodesHaveTheReferenceEigenvaluesAndStresses) {
  CrackMesh mesh(test::lattice({4, 4, 4}, {4, 4, 4}), 1.0);
  const std::map<std::string, Vector3d> places = {{"interior", {2, 2, 2}},
                                                  {"face_x_max", {4, 2, 2}},
                                                  {"face_z_max", {2, 2, 4}},
                                                  {"edge_xz", {4, 2, 4}},
                                                  {"corner", {4, 4, 4}}};
  for (const auto& row : reference("separation").at("rows")) {
    const std::string label = row.at("node").get<std::string>() + " " + row.at("stress").get<std::string>();
    set_stress(mesh, stress_named(row.at("stress")));
    const int node = node_at(mesh, places.at(row.at("node")));
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(separation_tensor(mesh, node, material()));
    for (int k = 0; k < 3; ++k)
      EXPECT_LE(std::abs(solver.eigenvalues()[k] - row.at("eigenvalues")[static_cast<std::size_t>(k)].get<double>()),
                1e-13)
          << label;
    if (row.at("plane_normal").is_null()) continue;
    const Separation found = separation_at(mesh, node, material(), CrackCriterion::kSeparation);
    if (solver.eigenvalues()[2] - solver.eigenvalues()[1] < 1e-9) continue;  // the plane is not determined
    EXPECT_LE(std::abs(found.stress_pa - row.at("normalised_to_stress").get<double>()), 1e-12) << label;
  }
}

TEST(Separation, NormalisedItIsThePrincipalStressAtEveryNodeOfAnyMesh) {
  CrackMesh mesh(test::lattice({3, 3, 3}, {3, 3, 3}, 0.25), 1.0);
  const Vector3d axis = Vector3d(0.3, -0.5, 0.8).normalized();
  set_stress(mesh, axis * axis.transpose());
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    // Where the star is closed, or cut along the load.
    const Vector3d& x = mesh.rest_m[static_cast<std::size_t>(i)];
    if ((x.array() < 1e-9 || x.array() > 3 - 1e-9).any()) continue;
    const Separation found = separation_at(mesh, i, material(), CrackCriterion::kSeparation);
    EXPECT_LE(std::abs(found.stress_pa - 1.0), 1e-12);
    EXPECT_LE(1.0 - std::abs(found.normal.dot(axis)), 1e-12);
  }
  set_stress(mesh, Vector3d::UnitX() * Vector3d::UnitX().transpose());
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const Vector3d& x = mesh.rest_m[static_cast<std::size_t>(i)];
    if (x.x() < 1e-9 || x.x() > 3 - 1e-9) continue;  // faces along the load, edges and inside
    EXPECT_LE(std::abs(separation_at(mesh, i, material(), CrackCriterion::kSeparation).stress_pa - 1.0), 1e-12);
    EXPECT_LE(std::abs(separation_at(mesh, i, material(), CrackCriterion::kRankine).stress_pa - 1.0), 1e-12);
  }
}

TEST(Separation, SplitStressesThatAreKeptGiveWhatEachNodeGivesAlone) {
  CrackMesh mesh(test::lattice({3, 3, 3}, {3, 3, 3}, 0.25), 1.0);
  for (std::size_t i = 0; i < mesh.place_m.size(); ++i) {
    const Vector3d x = mesh.rest_m[i];
    mesh.place_m[i] += 0.05 * Vector3d(std::sin(2.0 * x.y()), std::sin(3.0 * x.z() + x.x()), std::cos(2.5 * x.x()));
    mesh.velocity_m_s[i] = Vector3d(x.z(), std::sin(x.x()), x.y() * x.x());
  }
  const Viscosity viscosity{0.3, 0.2};
  for (const Viscosity* extra : {static_cast<const Viscosity*>(nullptr), &viscosity}) {
    SplitStresses split(mesh.n_elements());
    double largest = 0.0;
    for (int i = 0; i < mesh.n_nodes(); ++i) {
      const Separation alone = separation_at(mesh, i, material(), CrackCriterion::kSeparation, extra),
                       kept = separation_at(mesh, i, material(), CrackCriterion::kSeparation, extra, &split);
      EXPECT_LE(std::abs(kept.stress_pa - alone.stress_pa), 1e-12 * alone.stress_pa);
      largest = std::max(largest, alone.stress_pa);
    }
    EXPECT_GT(largest, 0.0);
  }
}

TEST(Separation, TurningTheBodyTurnsThePlanesAndNothingElse) {
  CrackMesh mesh(test::lattice({2, 2, 2}, {2, 2, 2}, 0.2), 1.0);
  set_stress(mesh, stress_named("pure_shear_xy") + 0.5 * stress_named("uniaxial_111"));
  const int node = node_at(mesh, mesh.rest_m[13]);
  const Separation before = separation_at(mesh, node, material(), CrackCriterion::kSeparation);
  const Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (Vector3d& place : mesh.place_m) place = turn * place;
  const Separation after = separation_at(mesh, node, material(), CrackCriterion::kSeparation);
  EXPECT_LE(std::abs(after.stress_pa - before.stress_pa), 1e-13);
  EXPECT_LE(1.0 - std::abs(after.normal.dot(turn * before.normal)), 1e-12);
}

TEST(Separation, ItIsNotRankine) {  // erratum 62
  const nlohmann::json star = reference("separation").at("isotropic_star_over_uniaxial");
  EXPECT_NEAR(star.at("equibiaxial").get<double>(), M_PI / 4, 1e-6);
  CrackMesh mesh(test::lattice({4, 4, 4}, {4, 4, 4}), 1.0);
  set_stress(mesh, stress_named("hydrostatic"));
  const int node = node_at(mesh, {2, 2, 2});
  EXPECT_LE(separation_at(mesh, node, material(), CrackCriterion::kSeparation).stress_pa, 0.8);
  EXPECT_NEAR(separation_at(mesh, node, material(), CrackCriterion::kRankine).stress_pa, 1.0, 1e-12);
}

TEST(StepLimit, IsThatOfTheReferenceForEverySchemeAndDamping) {  // errata 63
  for (const auto& row : reference("stability").at("largest_stable_omega_dt")) {
    const double z = row.at("damping_ratio");
    EXPECT_NEAR(largest_step_s(Integrator::kLeapfrog, 1.0, z), row.at("symplectic_formula").get<double>(), 1e-12);
    EXPECT_NEAR(largest_step_s(Integrator::kEuler, 1.0, z), row.at("forward_euler_formula").get<double>(), 1e-12);
    EXPECT_NEAR(largest_step_s(Integrator::kTaylor, 1.0, z), row.at("taylor_position_only").get<double>(), 1e-9);
  }
  EXPECT_EQ(largest_step_s(Integrator::kEuler, 1.0, 0.0), 0.0);
  EXPECT_EQ(largest_step_s(Integrator::kTaylor, 1.0, 0.0), 0.0);
}

TEST(StepLimit, ElementsOfTheTableHaveTheReferenceFrequencies) {
  const std::map<std::string, std::array<double, 5>> table = {// B99 Table 1: lambda, mu, phi, psi, rho
                                                              {"Glass", {1.04e8, 1.04e8, 0, 6760, 2588}},
                                                              {"TheEnd", {0, 9.21e6, 0, 9.2, 705}}};
  for (const auto& row : reference("stability").at("b99_table1").at("rows")) {
    const auto found = table.find(row.at("example"));
    if (found == table.end()) continue;
    const auto [lambda, mu, phi, psi, rho] = found->second;
    for (const double h : {0.005, 0.01, 0.02, 0.05}) {
      const auto& values = row.at("h=" + nlohmann::json(h).dump());
      const CrackMesh mesh(test::lattice({1, 1, 1}, {h, h, h}), rho);
      const double omega = std::sqrt(element_omega_sq(mesh.beta_of(0), lambda, mu, rho));
      EXPECT_NEAR(omega / values.at("omega_max").get<double>(), 1.0, 1e-9) << row.at("example") << h;
      const double ratio = 0.5 * psi / mu * omega;  // all stiffness damped as mu
      EXPECT_NEAR(ratio / values.at("damping_ratio_there").get<double>(), 1.0, 1e-9);
      EXPECT_NEAR(largest_step_s(Integrator::kLeapfrog, omega, ratio) / values.at("dt_symplectic").get<double>(), 1.0,
                  1e-9);
      EXPECT_NEAR(largest_step_s(Integrator::kEuler, omega, ratio) / values.at("dt_forward_euler").get<double>(), 1.0,
                  1e-9);
    }
  }
}

}  // namespace
}  // namespace klang::fracture
