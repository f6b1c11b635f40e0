// The floor as a slab, and ellipsoids in place of bodies.
#include "core/sound/scene/scene_floor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/sound/scene/scene_proxies.hpp"
#include "core/sound/soundbank/soundbank_build.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "tests/process_file.hpp"

namespace klang::scene {
namespace {

solid::Material concrete() { return solid::from_youngs_modulus(30e9, 0.2, 2400); }

TEST(FloorSlab, AThinPlateHasKirchhoffsFrequencies) {
  FloorSound floor;
  floor.slab_m = {2.0, 1.0, 0.001};
  floor.low_hz = 1.0;
  floor.high_hz = 60.0;
  const std::vector<SlabMode> modes = slab_modes(floor, concrete());
  ASSERT_GT(modes.size(), 5u);
  const double d = 30e9 * 1e-9 / (12.0 * (1.0 - 0.04));
  for (const SlabMode& mode : modes) {
    const double s = std::pow(mode.m * kPi / 2.0, 2) + std::pow(mode.n * kPi, 2);
    EXPECT_NEAR(mode.angular_frequency_rad_s / (s * std::sqrt(d / (2400 * 0.001))), 1.0, 1e-4);
    EXPECT_NEAR(mode.amplitude, std::sqrt(4.0 / (2400 * 0.001 * 2.0)), 1e-3 * mode.amplitude);
  }
}

TEST(FloorSlab, AThickPlateIsSlowerThanShearWavesAllow) {
  FloorSound floor;
  floor.high_hz = 4000.0;
  floor.n_modes = 20000;
  const solid::Material material = concrete();
  const std::vector<SlabMode> modes = slab_modes(floor, material);
  for (const SlabMode& mode : modes) {
    const double k = kPi * std::hypot(mode.m / 9.0, mode.n / 9.0);
    EXPECT_LT(mode.angular_frequency_rad_s / k, std::sqrt(5.0 / 6.0) * material.shear_speed_m_s());
  }
  EXPECT_GT(modes.size(), 900u);
  floor.n_modes = 500;
  EXPECT_EQ(slab_modes(floor, material).size(), 500u) << "band and count are apart (erratum 54)";
}

TEST(FloorSlab, FarOffRayleighsIntegralIsThatOfThePlatesVolumeVelocity) {
  FloorSound floor;
  floor.slab_m = {0.2, 0.2, 0.02};
  const SlabMode mode{1, 1, 2.0 * kPi * 50.0, 1.0};
  const double r = 40.0, volume = 0.04 * std::pow(2.0 / kPi, 2);  // of the displacement
  const double expected = 2.0 * kPi * 50.0 * 1.2041 / (2.0 * kPi * r) * volume;
  EXPECT_NEAR(std::abs(slab_pressure_pa(mode, floor, {0.1, 0.1, r})) / expected, 1.0, 2e-3);
}

class Proxies : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    soundbank::BuildOptions options;
    options.material = solid::from_youngs_modulus(6.2e10, 0.2, 2600);
    options.thinnest = 0.2;
    options.tolerance = 0.1;
    options.n_checked_modes = 3;
    options.modes_per_cell = 8;
    options.degree = 8;
    options.check_shapes = 3;
    options.boundary_tolerance = 0.05;
    bank_ = klang::test::process_file("proxies.bank");
    soundbank::write_soundbank(bank_, soundbank::build_soundbank(options).bank);
  }
  static void TearDownTestSuite() { std::filesystem::remove(bank_); }
  static Scene scene(const std::string& sound, double poissons_ratio, const std::string& body_sound = "auto") {
    return parse_scene(
        "[[material]]\nname = \"g\"\nyoungs_modulus_pa = 6.2e10\npoissons_ratio = " + to_text(poissons_ratio) +
            "\ndensity_kg_m3 = 2600\ndamping = { model = \"loss_factor\", loss_factor = 1e-3 }\n"
            "[[body]]\nname = \"b\"\nshape = { kind = \"ellipsoid\", a_m = 0.08, b_m = 0.12, c_m = 0.2 }\n"
            "material = \"g\"\nmax_edge_m = 0.06\nsound = \"" +
            body_sound + "\"\n[sound]\nband_hz = [20, 9500]\nbank = \"" + bank_.string() + "\"\n" + sound,
        "s.toml");
  }
  static std::optional<SoundModel> stand_in(const Scene& scene) {
    const SceneBody& body = scene.bodies[0];
    return SceneProxies(scene).stand_in({&body, body.name, nullptr, mesh_of(body)});
  }
  static inline std::filesystem::path bank_;
};

TEST_F(Proxies, AnEllipsoidsProxyIsItself) {
  const Scene own = scene("proxy_above_hz = 0\n", 0.2);
  const auto proxy = stand_in(own);
  ASSERT_TRUE(proxy.has_value());
  EXPECT_TRUE(proxy->proxy);
  const mesh::TetMesh mesh = mesh_of(own.bodies[0]);
  modal::ModesOptions options;
  options.eigen.count = 5;
  const modal::EigenResult modes =
      modal::modes_of({own.bodies[0].shape, {}, 2}, mesh, own.materials[0].elastic, options);
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
  const auto on_surface = [&](const modal::ModalModel& model, int mode) {
    double sum = 0.0;
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k) sum += model.shapes.block<3, 1>(3 * surface.triangles(t, k), mode).squaredNorm();
    return std::sqrt(sum);
  };
  EXPECT_NEAR(proxy->modes.frequency_hz()[0] / modes.model.frequency_hz()[0], 1.0, 2e-3);
  for (int k = 0; k < std::min<int>(5, static_cast<int>(proxy->modes.n_modes())); ++k) {
    EXPECT_NEAR(proxy->modes.frequency_hz()[k] / modes.model.frequency_hz()[k], 1.0, 0.1)
        << k << ": the bank's tolerance";
    EXPECT_NEAR(on_surface(proxy->modes, k) / on_surface(modes.model, k), 1.0, 0.15) << k;
  }
}

TEST_F(Proxies, TheThresholdIsTheLowestFrequency) {
  const double lowest = stand_in(scene("proxy_above_hz = 0\n", 0.2))->modes.frequency_hz()[0];
  EXPECT_TRUE(stand_in(scene("proxy_above_hz = " + to_text(0.98 * lowest) + "\n", 0.2)).has_value());
  EXPECT_FALSE(stand_in(scene("proxy_above_hz = " + to_text(1.02 * lowest) + "\n", 0.2)).has_value());
  EXPECT_FALSE(stand_in(scene("", 0.2)).has_value());
  EXPECT_TRUE(stand_in(scene("", 0.2, "proxy")).has_value());
  EXPECT_FALSE(stand_in(scene("proxy_above_hz = 0\n", 0.2, "modes")).has_value());
}

TEST_F(Proxies, ABankOfAnotherPoissonsRatioIsRefused) {
  EXPECT_THROW(SceneProxies(scene("proxy_above_hz = 0\n", 0.3)), InputError);
  EXPECT_NO_THROW(SceneProxies(scene("", 0.3)));
  EXPECT_THROW(parse_scene("[[material]]\nname=\"m\"\npreset=\"steel\"\n[[body]]\nname=\"b\"\nmaterial=\"m\"\n"
                           "shape={kind=\"sphere\",radius_m=0.1}\nsound=\"none\"\n[sound]\nproxy_above_hz = 100\n",
                           "s.toml"),
               InputError);
}

}  // namespace
}  // namespace klang::scene
