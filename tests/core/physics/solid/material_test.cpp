#include "core/physics/solid/material.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace {

using klang::InputError;
using namespace klang::solid;

TEST(Material, LameAndEngineeringConstantsAgree) {
  // tests/reference/chimes.json: material.
  const Material chime = material_preset("s02_chime");
  EXPECT_NEAR(chime.youngs_modulus_pa(), 68351788079.4702, 1e-4);
  EXPECT_NEAR(chime.poissons_ratio(), 0.32980132450331123, 1e-15);
  const Material again = from_youngs_modulus(chime.youngs_modulus_pa(), chime.poissons_ratio(), 2700);
  EXPECT_NEAR(again.lame_lambda_pa / 4.98e10, 1, 1e-14);
  EXPECT_NEAR(again.lame_mu_pa / 2.57e10, 1, 1e-14);
}

TEST(Material, RefusesWhatHasNoPositiveEnergy) {
  EXPECT_THROW(from_youngs_modulus(7e10, 0.5, 2700), InputError);
  EXPECT_THROW(from_youngs_modulus(7e10, -1.0, 2700), InputError);
  EXPECT_THROW(from_youngs_modulus(0, 0.3, 2700), InputError);
  EXPECT_THROW(from_youngs_modulus(7e10, 0.3, 0), InputError);
  EXPECT_THROW(from_youngs_modulus(std::nan(""), 0.3, 2700), InputError);
  EXPECT_THROW(validate({-0.7e10, 1e10, 2700, "", ""}), InputError);
  EXPECT_NO_THROW(validate({-0.6e10, 1e10, 2700, "", ""}));
  EXPECT_THROW(validate({HUGE_VAL, 1e10, 2700, "", ""}), InputError);
}

TEST(Material, EveryPresetIsValidAndNamesItsSource) {
  for (const auto& name : material_preset_names()) {
    const Material material = material_preset(name);
    EXPECT_NO_THROW(validate(material)) << name;
    EXPECT_EQ(material.name, name);
    EXPECT_FALSE(material.source.empty()) << name;
  }
  EXPECT_THROW(material_preset("unobtainium"), InputError);
}

}  // namespace
