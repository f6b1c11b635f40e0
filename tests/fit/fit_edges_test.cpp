// What lies at the edges of the lists that a fit makes: the band's end, the material that comes out.
#include <gtest/gtest.h>

#include <fstream>

#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/run/fit.hpp"
#include "fit/run/fit_document.hpp"

namespace klang::fit {
namespace {

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("klang-" + std::to_string(::getpid()) + "-" + name);
}

/// A block of coarse tetrahedra, whose own frequencies lie per cents above the corrected ones.
Specimen coarse_block() {
  const mesh::ShapeSpec shape{"box", {{"length_m", 0.1}, {"width_m", 0.07}, {"height_m", 0.04}}, {}};
  Specimen specimen;
  specimen.name = "block";
  specimen.mesh_file = scratch("block.vtu");
  mesh::write_tet_mesh(*specimen.mesh_file, mesh::mesh_shape(shape, mesh::ShapeDivisions{{5, 4, 2}}, 2));
  return specimen;
}

TEST(RunFit, ModeWhoseCorrectedFrequencyAloneLiesInTheBandIsMatchedAndListed) {
  const solid::Material truth = solid::from_youngs_modulus(70e9, 0.22, 2500.0);
  FitProblem problem;
  problem.material = truth;
  problem.parameters = {"youngs_modulus_pa"};
  problem.specimens = {coarse_block()};
  ReducedSpectrumOptions options;
  options.band = {20.0, 1e5};
  options.count = 30;
  const SpecimenBody body = make_body(problem.specimens[0], truth, 1e5);
  const ReducedSpectrum spectrum(problem.specimens[0], body, {}, options);
  const Eigen::VectorXd frequency_hz = spectrum.nominal().model.frequency_hz();
  problem.specimens[0].partials = scratch("edge.csv");
  std::ofstream file(*problem.specimens[0].partials);
  file.precision(12);
  file << "frequency_hz\n";
  for (int k = 0; k < 25; ++k) file << frequency_hz[k] << '\n';
  file.close();
  problem.band = {20.0, 1.0005 * frequency_hz[24]};
  const FitResult result = run_fit(problem, {});
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_EQ(result.matches.size(), 25u);
  for (const PartialMatch& match : result.matches)
    EXPECT_LT(match.mode, static_cast<int>(result.specimens[0].predicted_frequency_hz.size()));
  ASSERT_EQ(result.parameters[0].name, "youngs_modulus_pa");
  EXPECT_LE(std::abs(result.parameters[0].value / 70e9 - 1.0), 0.001);
}

TEST(RunFit, DocumentHoldsTheMaterialThatWasFoundAndTheOneItBeganWith) {
  FitProblem problem;
  problem.material = solid::material_preset("soda_lime_glass");
  FitResult result;
  result.material = solid::from_youngs_modulus(66e9, 0.24, 2480.0);
  const FitDocument document = fit_document(problem, result, {});
  EXPECT_NEAR(document.material.youngs_modulus_pa.value(), 66e9, 1.0);
  EXPECT_NEAR(document.material.density_kg_m3.value(), 2480.0, 1e-9);
  EXPECT_NEAR(document.material_start.youngs_modulus_pa.value(), 72e9, 1.0);
  EXPECT_EQ(document.material_start.preset, "soda_lime_glass");
  EXPECT_EQ(document.material.preset, "");
}

}  // namespace
}  // namespace klang::fit
