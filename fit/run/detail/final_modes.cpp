#include "fit/run/detail/final_modes.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "fit/elastic/elastic_blocks.hpp"

namespace klang::fit::detail {
namespace {

/// Modes whose shapes are kept: up to here above the highest partial. The list of frequencies goes on to the band's end.
constexpr double kShapeMargin = 1.25;
constexpr int kMostPredicted = 150;  // of tetrahedra

/// @param n_matched  modes, from the lowest above the band's beginning on, that are needed whatever the band's end
FinalModes final_modes(const FitProblem& fitted, std::size_t index, const SpecimenModel& reduced, int n_matched,
                       double highest_partial_hz) {
  const Specimen& specimen = fitted.specimens[index];
  SpecimenBody body = specimen.shape && specimen.shape->dims != reduced.body.shape_dims
                          ? make_body_like(specimen, fitted.material, reduced.body)
                          : reduced.body;
  solid::Material material = fitted.material;
  if (specimen.mass_kg) material.density_kg_m3 = *specimen.mass_kg / body.volume_m3;
  body.material = material;
  body.mass_kg = material.density_kg_m3 * body.volume_m3;
  const int n_skipped = reduced.spectrum->n_skipped();
  ReducedSpectrumOptions options;
  options.band = fitted.band;
  options.min_count = n_matched + n_skipped;
  options.max_count = std::max(kMostPredicted, static_cast<int>(reduced.spectrum->n_modes()) + n_skipped);
  auto modes = elastic_blocks(specimen, body, 0, silent_monitor())->lowest(material, options, true);

  FinalModes result;
  result.model = std::move(modes.result.model);
  const Eigen::Index n_kept = result.model.n_modes() - n_skipped;
  result.model.angular_frequency_rad_s = result.model.angular_frequency_rad_s.tail(n_kept).eval();
  result.model.shapes = result.model.shapes.rightCols(n_kept).eval();
  result.none_missing = modes.result.none_missing.value_or(false);
  result.mesh_relative_error = modes.relative_error.tail(n_kept);
  const Eigen::VectorXd frequency_hz = result.model.frequency_hz();
  const double highest = std::max(fitted.band.high_hz, 1.05 * highest_partial_hz);
  if (n_kept < n_matched) {
    throw NumericalError("specimen " + specimen.name + ": only " + std::to_string(n_kept) +
                         " modes were found, and a " + "partial is matched to mode " + std::to_string(n_matched - 1));
  }
  for (Eigen::Index k = 0; k < n_kept && (k < n_matched || frequency_hz[k] <= highest); ++k)
    result.frequency_hz.push_back(frequency_hz[k]);
  const auto n_shown =
      std::max<Eigen::Index>({1, n_matched, (frequency_hz.array() <= kShapeMargin * highest_partial_hz).count()});
  result.model.angular_frequency_rad_s.conservativeResize(n_shown);
  result.model.shapes.conservativeResize(Eigen::NoChange, n_shown);
  return result;
}

}  // namespace

std::vector<std::optional<FinalModes>> solve_final_modes(const MaterialFit& fit, const MeasuredData& data,
                                                         Monitor& monitor) {
  const FitProblem fitted = fit.fitted();
  std::vector<std::optional<FinalModes>> modes(fit.specimens.size());
  for_each_job(
      modes.size(),
      [&](std::size_t s) {
        if (fit.specimens[s].spectrum)
          modes[s] =
              final_modes(fitted, s, fit.specimens[s], fit.n_modes_matched(s), data.specimens[s].highest_partial_hz());
      },
      "final modes", monitor);
  return modes;
}

}  // namespace klang::fit::detail
