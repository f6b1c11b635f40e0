// What the judge says of fits whose error is known.
#include "fit/judge/judge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/physics/solid/material.hpp"
#include "fit/ringdown/merge_partials.hpp"

namespace klang::fit {
namespace {

constexpr double kCent = 5.7779e-4;

/// A free bar of given mass: ln f by ln E is a half for all; by dimensions as a beam's bending (three), in-plane bending and
/// torsion go.
JudgedResiduals bar_residuals() {
  JudgedResiduals r;
  r.coordinates = {"youngs_modulus_pa", "poissons_ratio"};
  r.guess_std = Eigen::Vector2d(0.35, 0.12);
  r.residual = Eigen::VectorXd::Zero(6);
  r.sigma = Eigen::VectorXd::Constant(6, 0.05 * kCent);
  r.derivative.resize(6, 2);
  r.derivative.col(0).setConstant(0.5);
  r.derivative.col(1) << 0.01, 0.01, 0.02, 0.0, -0.38, -0.38;
  const auto given = [&](const char* name, double value_m, std::initializer_list<double> slope) {
    Eigen::VectorXd by(6);
    std::copy(slope.begin(), slope.end(), by.begin());
    r.given.push_back({"bar", name, value_m, by, GivenKind::kDimension});
  };
  given("length_m", 0.12, {-1.5, -1.5, -1.45, -1.4, -0.5, -0.5});
  given("width_m", 0.025, {0.5, 0.5, 0.5, 1.4, -0.5, -0.5});
  given("height_m", 0.006, {1.5, 1.5, 1.45, 0.5, 1.4, 1.4});
  for (int k = 0; k < 6; ++k) r.rings.push_back("mode " + std::to_string(k));
  return r;
}

/// Its flat bending alone.
JudgedResiduals flat_bending() {
  JudgedResiduals r = bar_residuals();
  r.residual.conservativeResize(3);
  r.sigma.conservativeResize(3);
  r.derivative.conservativeResize(3, Eigen::NoChange);
  for (GivenValue& given : r.given) given.slope.conservativeResize(3);
  r.rings.resize(3);
  return r;
}

JudgeInput steel_bar(double young_pa) {
  JudgeInput input;
  input.start = solid::material_preset("steel");
  input.found = solid::from_youngs_modulus(young_pa, 0.287, 7850.0);
  FitParameter young;
  young.name = "youngs_modulus_pa";
  young.value = young_pa;
  young.std = 0.002 * young_pa;
  young.identifiable = true;
  input.parameters = {young};
  JudgedSpecimen bar;
  bar.name = "bar";
  bar.n_takes = 3;
  bar.density_kg_m3 = 7850.0;
  bar.frequency_hz = Eigen::VectorXd::LinSpaced(8, 1000.0, 8000.0);
  bar.visibility = Eigen::VectorXd::Ones(8);
  for (int k = 0; k < 6; ++k) {
    bar.partials.partials.push_back({});
    bar.partials.partials.back().frequency_hz = bar.frequency_hz[k];
    bar.mode_of_partial.push_back(k);
  }
  input.specimens = {bar};
  input.residuals = bar_residuals();
  input.n_data = 6;
  input.n_free = 2;
  return input;
}

const Reason* reason_of(const Judgement& judgement, ReasonKind kind) {
  for (const Reason& reason : judgement.reasons) {
    if (reason.kind == kind) return &reason;
  }
  return nullptr;
}

TEST(Judge, FitThatAgreesWithAllIsTrusted) {
  const Judgement judgement = judge_fit(steel_bar(208e9));
  EXPECT_EQ(judgement.verdict, Verdict::kTrusted) << (judgement.reasons.empty() ? "" : judgement.reasons[0].text);
}

/// The bar with amplitudes and decays, and lines beside its partials: of one decay, or each of its own.
JudgeInput bar_with_lines(double first_decay, double decay_ratio) {
  JudgeInput input = steel_bar(208e9);
  JudgedSpecimen& bar = input.specimens[0];
  for (Partial& partial : bar.partials.partials) {
    partial.amplitude = 0.1;
    partial.decay_per_s = 5.0 + 1e-3 * partial.frequency_hz;
  }
  for (int k = 0; k < 8; ++k) {
    Partial line;
    line.frequency_hz = bar.frequency_hz[k / 2] + (k % 2 == 0 ? -3.0 : 4.5);
    line.amplitude = 0.05;
    line.decay_per_s = first_decay * std::pow(decay_ratio, k);
    bar.partials.partials.push_back(line);
    bar.mode_of_partial.push_back(-1);
  }
  return input;
}

TEST(Judge, LinesOfOneDecayBesidePartialsAreTheRoomAndContradictNothing) {
  const Judgement judgement = judge_fit(bar_with_lines(8.0, 1.1));
  EXPECT_EQ(judgement.verdict, Verdict::kDoubtful);
  const Reason* room = reason_of(judgement, ReasonKind::kRoom);
  ASSERT_NE(room, nullptr);
  EXPECT_NE(room->text.find("8 lines"), std::string::npos) << room->text;
  EXPECT_NE(room->text.find("reverberation"), std::string::npos) << room->text;
  EXPECT_EQ(reason_of(judgement, ReasonKind::kUnmatched), nullptr);
}

TEST(Judge, LinesOfTheirOwnDecaysOrFarFromPartialsAreNoRoom) {
  const Judgement own = judge_fit(bar_with_lines(3.0, 2.3));
  EXPECT_EQ(reason_of(own, ReasonKind::kRoom), nullptr);
  EXPECT_NE(reason_of(own, ReasonKind::kUnmatched), nullptr);
  JudgeInput far = bar_with_lines(8.0, 1.1);
  for (std::size_t i = 6; i < 14; ++i) far.specimens[0].partials.partials[i].frequency_hz += 150.0;
  EXPECT_EQ(reason_of(judge_fit(far), ReasonKind::kRoom), nullptr);
}

TEST(Judge, SixMillimetresTypedForEightIsNoSteelAndTheHeightIsNamed) {
  JudgeInput input = steel_bar(474.7e9);
  input.residuals = flat_bending();
  const Judgement judgement = judge_fit(input);
  EXPECT_EQ(judgement.verdict, Verdict::kContradicted);
  const Reason* reason = reason_of(judgement, ReasonKind::kMaterialRange);
  ASSERT_NE(reason, nullptr);
  EXPECT_NE(reason->text.find("height_m 7."), std::string::npos) << reason->text;
  EXPECT_NE(reason->text.find("is no steel"), std::string::npos) << reason->text;
}

TEST(Judge, AGuessOfSteelAndItsDensityWithAllDimensionsFivePerCentOffIsDoubtful) {
  JudgeInput own = steel_bar(1.05 * 1.05 * 208e9);  // E goes with length squared where all dimensions scale
  own.start = solid::from_youngs_modulus(205e9, 0.29, 7850.0);
  const Judgement judgement = judge_fit(own);
  EXPECT_EQ(judgement.verdict, Verdict::kDoubtful);
  const Reason* reason = reason_of(judgement, ReasonKind::kMaterialRange);
  ASSERT_NE(reason, nullptr);
  EXPECT_NE(reason->text.find("no known material"), std::string::npos) << reason->text;
  EXPECT_NE(reason->text.find("dimensions"), std::string::npos) << reason->text;

  JudgeInput right = steel_bar(208e9);
  right.start = own.start;
  EXPECT_EQ(judge_fit(right).verdict, Verdict::kTrusted);
}

TEST(Judge, StiffnessOfABarOfGivenMassGoesWithItsThicknessToMinusThree) {
  const std::vector<double> powers = stiffness_powers(flat_bending());
  ASSERT_EQ(powers.size(), 3u);
  EXPECT_NEAR(powers[2], -3.0, 0.25);
  EXPECT_NEAR(powers[0], 3.0, 0.25);
}

TEST(Judge, WidthTwoPerCentOffIsNamedByItsInPlaneBending) {
  JudgeInput input = steel_bar(208e9);
  input.residuals.residual = -0.019 * input.residuals.given[1].slope;
  const auto hints = given_hints(input.residuals, 2.0);
  ASSERT_EQ(hints.size(), 3u);
  EXPECT_EQ(hints[0].given, 1u);
  EXPECT_NEAR(hints[0].error, -0.019, 0.002);
  EXPECT_EQ(hints[0].ring, "mode 3");
  const Judgement judgement = judge_fit(input);
  EXPECT_GE(judgement.verdict, Verdict::kDoubtful);
  const Reason* reason = reason_of(judgement, ReasonKind::kDimension);
  ASSERT_NE(reason, nullptr);
  EXPECT_NE(reason->text.find("width_m: 24.5"), std::string::npos) << reason->text;
}

TEST(Judge, AWidthWithinItsStatedToleranceIsNotDoubted) {
  JudgeInput input = steel_bar(208e9);
  input.residuals.residual = -0.019 * input.residuals.given[1].slope;
  input.residuals.given[1].relative_tolerance = 0.012;
  EXPECT_EQ(reason_of(judge_fit(input), ReasonKind::kDimension), nullptr);
  input.residuals.given[1].relative_tolerance = 0.002;  // nine of its deviations off
  EXPECT_NE(reason_of(judge_fit(input), ReasonKind::kDimension), nullptr);
}

TEST(Judge, APoissonsRatioGivenThreeHundredthsTooHighIsNamed) {
  JudgeInput input = steel_bar(208e9);
  JudgedResiduals& r = input.residuals;
  r.given.push_back({"", "poissons_ratio", 0.30, r.derivative.col(1), GivenKind::kPoissonsRatio});
  r.coordinates = {"youngs_modulus_pa"};  // it alone is asked for
  r.guess_std.conservativeResize(1);
  r.derivative.conservativeResize(Eigen::NoChange, 1);
  input.n_free = 1;
  r.residual << 0.5, -0.4, 0.3, 0.4, -0.5, 0.2;
  r.residual = (kCent * r.residual - 0.03 * r.given.back().slope).eval();
  EXPECT_GE(judge_fit(input).verdict, Verdict::kDoubtful);
  const Reason* reason = reason_of(judge_fit(input), ReasonKind::kGuess);
  ASSERT_NE(reason, nullptr);
  EXPECT_EQ(reason->subject, "poissons_ratio");
  EXPECT_NE(reason->text.find("poissons_ratio: 0.2"), std::string::npos) << reason->text;
  EXPECT_LE(reason->expected_low.value(), 0.27);
  EXPECT_GE(reason->expected_high.value(), 0.27);
}

TEST(Judge, ResidualsOfHalfACentNameNoDimension) {
  JudgeInput input = steel_bar(208e9);
  input.residuals.residual << 0.5, -0.4, 0.3, 0.6, -0.5, 0.2;
  input.residuals.residual *= kCent;
  EXPECT_EQ(reason_of(judge_fit(input), ReasonKind::kDimension), nullptr);
}

TEST(Judge, ClearRingNearAModeThatWasLeftOutIsSaid) {
  JudgeInput input = steel_bar(208e9);
  JudgedSpecimen& bar = input.specimens[0];
  bar.mode_of_partial[5] = -1;
  bar.partials.partials[5].frequency_hz *= std::exp2(31.0 / 1200.0);
  const Judgement judgement = judge_fit(input);
  EXPECT_EQ(judgement.verdict, Verdict::kDoubtful);
  const Reason* reason = reason_of(judgement, ReasonKind::kLeftOut);
  ASSERT_NE(reason, nullptr);
  EXPECT_NEAR(reason->value.value(), 31.0, 0.01);
}

TEST(Judge, OneOfThreePartialsMatchedIsDoubtful) {
  JudgeInput input = steel_bar(208e9);
  JudgedSpecimen& bar = input.specimens[0];
  bar.partials.partials.resize(3);
  bar.mode_of_partial = {0, -1, -1};
  EXPECT_GE(judge_fit(input).verdict, Verdict::kDoubtful);
  EXPECT_NE(reason_of(judge_fit(input), ReasonKind::kUnmatched), nullptr);
}

TEST(Judge, AsManyFreeNumbersAsFrequenciesLeaveNothingToTestTheModel) {
  JudgeInput input = steel_bar(208e9);
  input.n_data = 2;
  EXPECT_EQ(judge_fit(input).verdict, Verdict::kDoubtful);
  EXPECT_NE(reason_of(judge_fit(input), ReasonKind::kUntested), nullptr);
}

TEST(MergePartials, ScatterFromTakeToTakeEntersTheDeviation) {
  std::vector<PartialTable> takes(4);
  const double offset_cents[] = {1.0, -1.0, 0.5, -0.5};
  for (int t = 0; t < 4; ++t) {
    for (const double frequency_hz : {500.0, 1300.0, 2700.0}) {
      Partial partial;
      partial.frequency_hz = frequency_hz * std::exp2(offset_cents[t] / 1200.0);
      partial.frequency_std_hz = 0.05 * kCent * frequency_hz;
      partial.amplitude = 1.0;
      takes[static_cast<std::size_t>(t)].partials.push_back(partial);
    }
  }
  // Variance of the offsets 2.5 / 3, less what the partials' own deviations hold.
  EXPECT_NEAR(take_agreement(takes).scatter / kCent, std::sqrt(2.5 / 3.0 - 0.0025), 1e-3);
  EXPECT_NEAR(take_agreement(takes).least_share, 1.0, 1e-12);
  const PartialTable merged = merge_partials(takes);
  ASSERT_EQ(merged.partials.size(), 3u);
  EXPECT_GE(*merged.partials[0].frequency_std_hz / (500.0 * kCent), 0.4);
  EXPECT_LE(*merged.partials[0].frequency_std_hz / (500.0 * kCent), 0.6);
  takes[1].partials.resize(1);
  takes[1].partials[0].frequency_hz = 900.0;
  EXPECT_NEAR(take_agreement(takes).least_share, 0.0, 1e-12) << "another body";
}

}  // namespace
}  // namespace klang::fit
