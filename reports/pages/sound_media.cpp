#include "reports/pages/sound_media.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/audio_clip.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kAudioBytes = 6e6, kLongestClipS = 10.0, kHighestClipRateHz = 48000.0;
constexpr Eigen::Index kLeastFrames = 16;

std::string player(const std::string& wav, const std::string& what, const std::string& name) {
  if (wav.empty()) return {};
  return "<label>" + what + "<audio controls preload=\"auto\" aria-label=\"" +
         escaped(name.empty() ? what : what + ", " + name) + "\" src=\"" + data_uri("audio/wav", wav) +
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
  spec.range = range;
  spec.ridges = sounds.ridges;
  Svg svg = spectrogram_figure(first, both ? sounds.computed : audio::Signal{}, spec);
  folder.add_figure(sounds.stem, svg);
  if (n_in_page == 0) return media;
  media.spectrogram = std::move(svg);
  const double n_clips = 2.0 * static_cast<double>(std::min(kMaxMedia, n_in_page));
  const double rate = std::min(kHighestClipRateHz, first.sample_rate_hz);
  media.clip_s = std::min(kLongestClipS, kAudioBytes / n_clips / (2 * rate));
  media.cut = media.clip_s < first.duration_s();
  media.gain = clip_gain(first, media.clip_s);
  if (both) media.gain = std::min(media.gain, clip_gain(sounds.computed, media.clip_s));
  if (sounds.recorded.n_frames() > 0) media.recorded_wav = wav_clip(sounds.recorded, media.clip_s, media.gain);
  if (sounds.computed.n_frames() > 0) media.computed_wav = wav_clip(sounds.computed, media.clip_s, media.gain);
  return media;
}

std::string spectrogram_html(const SoundMedia& media, const std::string& caption) {
  if (!media.spectrogram) return {};
  return figure(sheet(*media.spectrogram),
                media.computed_wav.empty() ? "Spectrogram of the recording; triangles mark strikes." : caption);
}

std::string players(const SoundMedia& media, const SoundPair& sounds) {
  if (media.recorded_wav.empty() && media.computed_wav.empty()) return {};
  const bool both = !media.recorded_wav.empty() && !media.computed_wav.empty();
  std::string html = "<div class=\"listen\"" + std::string(both ? " data-switch" : "") + ">" +
                     player(media.recorded_wav, sounds.recorded_words, sounds.name) +
                     player(media.computed_wav, sounds.computed_words, sounds.name);
  if (both) html += "<button type=\"button\" hidden>Compare</button>";
  html += "</div>\n";
  std::string note;
  if (media.cut) note = "The first " + rounded(media.clip_s, 2) + " s; the whole sound lies beside this page.";
  const double gain_db = 20 * std::log10(media.gain);
  if (std::abs(gain_db) > 0.5) {
    note += std::string(note.empty() ? "" : " ") + (both ? "Both are" : "It is") + " played " +
            fixed(std::abs(gain_db), 1) + " dB " + (media.gain > 1 ? "louder" : "softer") + " than recorded.";
  }
  return html + (note.empty() ? "" : "<p class=\"how\"><small>" + note + "</small></p>\n");
}

}  // namespace klang::reports::detail
