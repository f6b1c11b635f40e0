#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/sound/audio/note.hpp"
#include "core/sound/audio/signal.hpp"
#include "fit/instrument/chime_document.hpp"
#include "fit/instrument/fitted_body.hpp"

namespace klang::fit {

struct ChimeOptions {
  std::vector<std::string> notes;  ///< "D5", "F#5"
  std::string specimen;  ///< whose section and material; empty: for each note the one that sounds nearest to it
  double a4_hz = audio::kConcertPitchHz;
  audio::Temperament temperament = audio::Temperament::equal();
  double sample_rate_hz = 48000.0;
};

struct ChimeSet {
  std::vector<ChimeNote> notes;
  bool damping_is_assumed = false;  ///< no decay was measured: assumed_decay_per_s
  audio::Signal sound;              ///< one strike each, one after the other
};

/// Lengths at which bodies of a fit sound notes by their first bending mode, with what the model says of each.
/// @throws InputError: no note, a note that is none or there twice, a specimen that has no length; NumericalError where a note cannot be
/// reached
ChimeSet chime_set(const FitDocument& fit, const std::filesystem::path& path, const ChimeOptions& options,
                   Monitor& monitor = silent_monitor());

}  // namespace klang::fit
