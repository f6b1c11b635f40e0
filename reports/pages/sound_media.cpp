#include "reports/pages/sound_media.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/audio_clip.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

/// Of 16-bit samples in a page; FLAC makes about half of them.
constexpr double kAudioBytes = 3.5e6, kLongestClipS = 10.0, kHighestClipRateHz = 48000.0;
constexpr Eigen::Index kLeastFrames = 16;

std::string player(const std::string& flac, const std::string& what, const std::string& name) {
  if (flac.empty()) return {};
  return "<label>" + what + "<audio controls preload=\"auto\" aria-label=\"" +
         escaped(name.empty() ? what : what + ", " + name) + "\" src=\"" + data_uri("audio/flac", flac) +
         "\"></audio></label>";
}

}  // namespace

SoundMedia sound_media(const SoundPair& sounds, std::size_t n_in_page, ReportFolder& folder) {
  SoundMedia media;
  const audio::Signal& first = sounds.recorded.n_frames() > 0 ? sounds.recorded : sounds.computed;
  if (first.n_frames() < kLeastFrames) return media;
  const bool both = sounds.recorded.n_frames() > 0 && sounds.computed.n_frames() >= kLeastFrames;
  SpectrogramRange range = spectrogram_range(first, sounds.highest_hz);
  if (sounds.lowest_hz) range.low_hz = std::clamp(0.6 * *sounds.lowest_hz, 100.0, 0.5 * range.high_hz);
  SpectrogramSpec spec;
  spec.name = sounds.name.empty() ? "the recording" : sounds.name;
  spec.recorded_words = sounds.recorded_words;
  spec.computed_words = sounds.computed_words;
  spec.strikes_s = sounds.strikes_s;
  spec.breaks_s = sounds.breaks_s;
  spec.range = range;
  spec.ridges = sounds.ridges;
  spec.small = n_in_page > 3;
  Svg svg = spectrogram_figure(first, both ? sounds.computed : audio::Signal{}, spec);
  folder.add_figure(sounds.stem, svg);
  if (n_in_page == 0) return media;
  media.spectrogram = std::move(svg);
  media.spectrogram_s = range.duration_s;
  const double n_clips = 2.0 * static_cast<double>(std::min(kMaxMedia, n_in_page));
  const double rate = std::min(kHighestClipRateHz, first.sample_rate_hz);
  media.clip_s = std::min(kLongestClipS, kAudioBytes / n_clips / (2 * rate));
  media.cut = media.clip_s < first.duration_s();
  media.gain = clip_gain(first, media.clip_s);
  if (both) media.gain = std::min(media.gain, clip_gain(sounds.computed, media.clip_s));
  if (sounds.recorded.n_frames() > 0) media.recorded_flac = flac_clip(sounds.recorded, media.clip_s, media.gain);
  if (sounds.computed.n_frames() > 0) media.computed_flac = flac_clip(sounds.computed, media.clip_s, media.gain);
  return media;
}

std::string spectrogram_html(const SoundMedia& media, const std::string& caption, const std::string& alone) {
  if (!media.spectrogram) return {};
  const bool compared = !media.computed_flac.empty() && !media.recorded_flac.empty();
  std::string lines;
  for (const auto& [left, width] : spectrogram_panels(compared)) {
    const std::string at = coordinate(left);
    lines += "<i data-left=\"" + at + "\" data-width=\"" + coordinate(width) + "\" style=\"left:" + at + "%\"></i>";
  }
  return "<figure data-figure=\"spectrogram\" data-duration-s=\"" + rounded(media.spectrogram_s, 6) +
         "\"><div class=\"sheet scroll\" tabindex=\"0\" role=\"group\" aria-label=\"Spectrogram, scrolls sideways on a "
         "small screen\"><div class=\"plot\">" +
         media.spectrogram->inline_markup() + "<div data-playhead data-time-s=\"0\" aria-hidden=\"true\">" + lines +
         "</div></div></div>" + tag("figcaption", media.computed_flac.empty() ? alone : caption) + "</figure>\n";
}

std::string listen_actions() {
  return "<div class=\"actions\"><button type=\"button\" data-action=\"play\">Play</button><button type=\"button\" "
         "data-action=\"stop\">Stop</button><button type=\"button\" data-action=\"loop\" "
         "aria-pressed=\"false\">Loop</button></div>";
}

std::string players(const SoundMedia& media, const SoundPair& sounds) {
  if (media.recorded_flac.empty() && media.computed_flac.empty()) return {};
  const bool both = !media.recorded_flac.empty() && !media.computed_flac.empty();
  std::string html = "<div class=\"listen\"" + std::string(both ? " data-switch" : "") + ">" +
                     player(media.recorded_flac, sounds.recorded_words, sounds.name) +
                     player(media.computed_flac, sounds.computed_words, sounds.name);
  if (both) html += "<button type=\"button\" class=\"compare\" hidden>Compare</button>";
  html += listen_actions() + "</div>\n";
  std::string note;
  if (media.cut) note = "The first " + rounded(media.clip_s, 2) + " s; the whole sound lies beside this page.";
  const double gain_db = 20 * std::log10(media.gain);
  if (std::abs(gain_db) > 0.5) {
    note += std::string(note.empty() ? "" : " ") + (both ? "Both are" : "It is") + " played " +
            fixed(std::abs(gain_db), 1) + " dB " + (media.gain > 1 ? "louder" : "softer") +
            (both || sounds.recorded_words == SoundPair().recorded_words ? " than recorded." : " than in its file.");
  }
  return html + (note.empty() ? "" : "<p class=\"how\"><small>" + note + "</small></p>\n");
}

}  // namespace klang::reports::detail
