#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/sound/audio/signal.hpp"
#include "reports/kit/report_folder.hpp"
#include "reports/kit/svg_plot.hpp"
#include "reports/pages/spectrogram.hpp"

namespace klang::reports::detail {

/// A recording and what was computed for it.
struct SoundPair {
  std::string name;                  ///< of the specimen, for labels; may be empty
  audio::Signal recorded, computed;  ///< either may have no frames
  std::vector<double> strikes_s, breaks_s;
  double highest_hz = 0;            ///< of the partials
  std::optional<double> lowest_hz;  ///< then the frequency axis is logarithmic from a little below
  Ridges ridges;
  std::string recorded_words = "Recorded", computed_words;  ///< titles of panels and players
  std::string stem = "spectrogram";                         ///< of the figure's files
};

/// What a page shows of it.
struct SoundMedia {
  std::optional<Svg> spectrogram;
  std::string recorded_flac, computed_flac;  ///< clips for the players, empty without
  double spectrogram_s = 0;                  ///< how far the spectrogram reaches
  double clip_s = 0, gain = 1;
  bool cut = false;  ///< the clip is shorter than the recording
};

/// What keeps a page under about 10 MB whatever the number of specimens.
inline constexpr std::size_t kMaxMedia = 12;

/// Adds the spectrogram to the folder. @param n_in_page  how many pairs share the page's room for sounds; 0: this one is not in
/// the page
SoundMedia sound_media(const SoundPair& sounds, std::size_t n_in_page, ReportFolder& folder);

inline constexpr const char* kSpectrogramCaption =
    "Spectrograms on one scale of level. The difference is taken between magnitudes, so that phases do not enter: what "
    "is "
    "bright there is energy that one of the two has and the other has not. Triangles mark strikes.";

/// The spectrogram with its caption, which is another where there is no computed sound; empty without a spectrogram.
std::string spectrogram_html(const SoundMedia& media, const std::string& caption,
                             const std::string& alone = "Spectrogram of the recording; triangles mark strikes.");

/// Play, stop and loop of a box of players.
std::string listen_actions();

/// The players of a pair, with a button that switches between the two; empty without a clip.
std::string players(const SoundMedia& media, const SoundPair& sounds);

}  // namespace klang::reports::detail
