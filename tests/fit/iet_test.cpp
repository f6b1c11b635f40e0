#include "fit/iet/iet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/box_modes.hpp"
#include "core/physics/solid/material.hpp"
#include "fit/iet/iet_meter.hpp"

using namespace klang;
using namespace klang::fit;

namespace {

struct Bar {
  Eigen::Vector3d size_m;  // length, width, thickness
  double young_pa, nu, density_kg_m3;
};

IetSpecimen specimen_of(const Bar& bar) {
  IetSpecimen specimen;
  specimen.specimen = "bar";
  specimen.length_m = bar.size_m.x();
  specimen.width_m = bar.size_m.y();
  specimen.thickness_m = bar.size_m.z();
  specimen.mass_kg = bar.density_kg_m3 * bar.size_m.prod();
  return specimen;
}

/// The lowest modes of the bar, by Legendre products.
std::vector<double> modes_hz(const Bar& bar) {
  const mesh::ShapeSpec shape{
      "box", {{"length_m", bar.size_m.x()}, {"width_m", bar.size_m.y()}, {"height_m", bar.size_m.z()}}, {}};
  mesh::ShapeMeshOptions coarse;
  coarse.max_edge_m = 0.3 * bar.size_m.x();
  modal::EigenOptions options;
  options.count = 12;
  const solid::Material material = solid::from_youngs_modulus(bar.young_pa, bar.nu, bar.density_kg_m3);
  const Eigen::VectorXd f =
      modal::solve_box_modes(shape, mesh::mesh_shape(shape, coarse), material, {}, options).model.frequency_hz();
  return {f.begin(), f.end()};
}

/// The n-th free bending of a Timoshenko beam in the direction of the blow names which mode that is (n = 0, 1, 2).
double bending_hz(const Bar& bar, const std::vector<double>& modes, int n) {
  const double l = bar.size_m.x(), t = bar.size_m.z(), g = bar.young_pa / (2.0 * (1.0 + bar.nu));
  const double beta = (n == 0 ? 4.7300 : n == 1 ? 7.8532 : 10.9956) / l;
  const double slender = beta * beta * t * std::sqrt(bar.young_pa / (12.0 * bar.density_kg_m3)) / (2.0 * M_PI);
  const double guess = slender / std::sqrt(1.0 + beta * beta * t * t / 12.0 * (1.0 + 1.2 * bar.young_pa / g));
  return *std::min_element(modes.begin(), modes.end(), [&](double a, double b) {
    return std::abs(std::log(a / guess)) < std::abs(std::log(b / guess));
  });
}

std::vector<Partial> partials_of(const std::vector<double>& frequencies_hz) {
  std::vector<Partial> partials;
  for (const double f : frequencies_hz) {
    Partial& partial = partials.emplace_back();
    partial.frequency_hz = f;
    partial.decay_per_s = 2e-3 * f;
    partial.amplitude = 0.1;
  }
  std::sort(partials.begin(), partials.end(),
            [](const Partial& a, const Partial& b) { return a.frequency_hz < b.frequency_hz; });
  return partials;
}

const std::vector<Bar> kBars = {{{0.15, 0.03, 0.01}, 70e9, 0.33, 2700.0},
                                {{0.12, 0.01, 0.005}, 200e9, 0.29, 7850.0},
                                {{0.1, 0.02, 0.005}, 200e9, 0.29, 7850.0}};

TEST(Iet, FlexuralOvertonesAreNoTorsionalFrequency) {
  for (const Bar& bar : kBars) {
    const std::vector<double> modes = modes_hz(bar);
    const IetMeter meter(specimen_of(bar));
    for (const int n : {2, 3}) {
      std::vector<double> struck;
      for (int k = 0; k < n; ++k) struck.push_back(bending_hz(bar, modes, k));
      const IetRow row = meter.row(partials_of(struck));
      EXPECT_FALSE(row.g_e1876_pa) << bar.size_m.transpose() << ", " << n << ": " << *row.g_e1876_pa;
      EXPECT_FALSE(row.nu_e1876);
      EXPECT_TRUE(row.nu_assumed);
      EXPECT_NEAR(*row.e_model_pa / bar.young_pa, 1.0, 5e-3) << row.remark;
      EXPECT_NE(row.remark.find("no torsional frequency"), std::string::npos) << row.remark;
      EXPECT_TRUE(row.counts());
    }
  }
}

TEST(Iet, TorsionThatIsThereIsTakenBesideFlexuralOnes) {
  for (const Bar& bar : kBars) {
    const std::vector<double> modes = modes_hz(bar);
    std::vector<double> lowest(modes.begin(), modes.begin() + 6);
    const IetRow row = IetMeter(specimen_of(bar)).row(partials_of(lowest));
    ASSERT_TRUE(row.g_model_pa) << bar.size_m.transpose() << ": " << row.remark;
    EXPECT_NEAR(*row.g_model_pa / (bar.young_pa / (2.0 * (1.0 + bar.nu))), 1.0, 1e-3);
    EXPECT_NEAR(*row.nu_model, bar.nu, 3e-3);
    EXPECT_FALSE(row.implausible) << row.remark;
  }
}

TEST(Iet, WidthAndThicknessChangedOverAreNoticedAndLeftOutOfTheMean) {
  const Bar bar = kBars[2];
  const std::vector<double> modes = modes_hz(bar);
  const std::vector<Partial> heard = partials_of({modes.begin(), modes.begin() + 5});
  IetSpecimen swapped = specimen_of(bar);
  std::swap(swapped.width_m, swapped.thickness_m);
  std::vector<IetRow> rows = {IetMeter(specimen_of(bar)).row(heard), IetMeter(swapped).row(heard)};
  EXPECT_TRUE(rows[1].implausible);
  EXPECT_NE(rows[1].remark.find("width and thickness changed over"), std::string::npos) << rows[1].remark;
  mark_outliers(rows);
  for (const IetSummary& line : summary_of(rows)) {
    EXPECT_EQ(line.n, 1) << line.quantity;
    if (line.quantity == "e_e1876_pa") EXPECT_NEAR(line.mean, bar.young_pa, 0.01 * bar.young_pa);
  }
}

TEST(Iet, NothingIsStifferThanDiamond) {
  const Bar bar = kBars[2];
  const IetRow row = IetMeter(specimen_of(bar)).row(partials_of({7034.0}));  // its torsional frequency alone
  EXPECT_GT(*row.e_model_pa, 1.2e12);
  EXPECT_TRUE(row.implausible);
  EXPECT_NE(row.remark.find("stiffer than any solid"), std::string::npos) << row.remark;
}

}  // namespace
