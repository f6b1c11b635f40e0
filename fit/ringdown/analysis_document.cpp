#include "fit/ringdown/analysis_document.hpp"

#include "fit/ringdown/partial_pairs.hpp"

namespace klang::fit {

AnalysisDocument analysis_document(ResultHeader header, const RingdownResult& result, double a4_hz) {
  AnalysisDocument document;
  document.header = std::move(header);
  document.header.warnings = result.warnings;
  document.header.wall_time_s = result.wall_time_s;
  document.sample_rate_hz = result.sample_rate_hz;
  document.strikes_s = result.strikes_s;
  document.amplitude_strike = result.amplitude_strike;
  document.strike_amplitudes = result.strike_amplitudes;
  document.explained_energy = result.explained_energy;
  document.noise_rms = result.noise_rms;
  document.n_coder_images = result.n_coder_images;
  document.steady_tones = result.steady_tones;
  document.a4_hz = a4_hz;
  std::vector<Partial> partials = result.partials.partials;
  name_notes(partials, a4_hz);
  name_pairs(partials);
  document.partials = with_shapes(partials);
  name_notes(document.steady_tones, a4_hz);
  return document;
}

}  // namespace klang::fit
