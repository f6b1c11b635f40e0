// The page of klang analyze.
#include <algorithm>
#include <cmath>

#include "core/foundation/config/fields_csv.hpp"
#include "fit/ringdown/analysis_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/body_facts.hpp"
#include "reports/pages/decay_figure.hpp"
#include "reports/pages/fit_tables.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/response_figures.hpp"
#include "reports/pages/sound_media.hpp"
#include "reports/pages/spectrum_view.hpp"

namespace klang::reports::detail {
namespace {

std::string bold(const std::string& text) { return "<b>" + escaped(text) + "</b>"; }

/// How many fall in two stages or beat.
void add_pairs(const fit::AnalysisDocument& data, std::vector<std::string>& sentences) {
  const auto count = [&](auto&& holds) {
    return static_cast<std::size_t>(std::count_if(data.partials.begin(), data.partials.end(), holds));
  };
  const std::size_t n_stages = count([](const fit::Partial& p) { return p.stage == "late"; });
  const std::size_t n_beating = count([](const fit::Partial& p) { return p.beat_hz.has_value(); });
  if (n_stages > 0)
    sentences.push_back(counted(n_stages, "line falls", "lines fall") +
                        " in two stages, a fast and a slow one: one decay does not say how long it rings.");
  if (n_beating > 0)
    sentences.push_back(counted(n_beating, "partial beats", "partials beat") +
                        " with a neighbour of nearly its frequency.");
}

std::vector<std::string> sentences_of(const fit::AnalysisDocument& data) {
  std::vector<std::string> sentences;
  const std::string message = data.header.message.value_or("");
  if (data.partials.empty()) {
    sentences.push_back("No partial stands out of the noise." + (message.empty() ? "" : " " + escaped(message)));
    return sentences;
  }
  const auto loudest = std::max_element(
      data.partials.begin(), data.partials.end(),
      [](const fit::Partial& a, const fit::Partial& b) { return a.amplitude.value_or(0) < b.amplitude.value_or(0); });
  const auto [lowest, highest] =
      std::minmax_element(data.partials.begin(), data.partials.end(),
                          [](const fit::Partial& a, const fit::Partial& b) { return a.frequency_hz < b.frequency_hz; });
  std::string sentence = std::string(data.responses ? "The responses hold " : "The recording holds ") +
                         bold(counted(data.partials.size(), "partial", "partials"));
  if (data.partials.size() > 1)
    sentence += " from " + escaped(hertz(lowest->frequency_hz, lowest->frequency_std_hz)) + " to " +
                escaped(hertz(highest->frequency_hz, highest->frequency_std_hz));
  if (data.strikes_s.size() > 1) sentence += " and " + std::to_string(data.strikes_s.size()) + " strikes";
  sentences.push_back(sentence + ".");
  const auto n_undecided = static_cast<std::size_t>(
      std::count_if(data.partials.begin(), data.partials.end(), [](const fit::Partial& p) { return !p.decay_per_s; }));
  if (n_undecided > 0) {
    sentences.push_back(counted(n_undecided, "partial has", "partials have") +
                        " no decay: the recording is too short to tell whether they fall.");
  }
  if (!data.steady_tones.empty()) {
    sentences.push_back(counted(data.steady_tones.size(), "steady tone", "steady tones") +
                        " in band do not decay and are left out.");
  }
  add_pairs(data, sentences);
  sentence = std::string(data.responses ? "The strongest (in its largest response) lies at "
                                        : "The strongest (by amplitude at the strike) lies at ") +
             bold(hertz(loudest->frequency_hz, loudest->frequency_std_hz));
  if (loudest->decay_per_s && *loudest->decay_per_s > 0) {
    sentence += " and falls by 60 dB in " + rounded(std::log(1000.0) / *loudest->decay_per_s, 3) + " s";
  }
  sentences.push_back(sentence + ".");
  if (data.explained_energy) {
    sentences.push_back(
        "Together they explain " + bold(rounded(100 * *data.explained_energy, 4) + " %") +
        (data.responses ? " of the responses in band." : " of the recording’s energy in band after the first strike.") +
        (*data.explained_energy < fit::kMostlyExplained ? " <b>The rest is not explained.</b>" : ""));
  }
  return sentences;
}

/// Hum, prime, tierce, quint, nominal and strike note of a bell.
std::string bell_table(const fit::Bell& bell, double a4_hz) {
  std::string body;
  const auto add = [&](const char* name, const std::optional<double>& frequency_hz) {
    std::string cells = number_cell("not found") + tag("td", "—") + number_cell("—") + number_cell("—");
    if (frequency_hz) {
      const audio::NearestNote note = audio::nearest_note(*frequency_hz, a4_hz);
      cells = number_cell(fixed(*frequency_hz, 2), *frequency_hz) + tag("td", escaped(note.name)) +
              number_cell(signed_cents(note.cents), note.cents) +
              number_cell(bell.nominal_hz ? fixed(*frequency_hz / *bell.nominal_hz, 4) : "—",
                          bell.nominal_hz ? Number(*frequency_hz / *bell.nominal_hz) : Number());
    }
    body += "<tr>" + tag("th", name, "scope=\"row\"") + cells + "</tr>\n";
  };
  add("Hum", bell.hum_hz);
  add("Prime", bell.prime_hz);
  add("Tierce", bell.tierce_hz);
  add("Quint", bell.quint_hz);
  add("Nominal", bell.nominal_hz);
  add("Strike note", bell.strike_note_hz);
  return scrolled(
      "<table><caption>The bell’s partials by their names. The strike note is half the nominal: it is heard, and "
      "need not be there.</caption><thead><tr><th scope=\"col\">Partial</th><th class=\"n\" scope=\"col\">Frequency "
      "[Hz]</th><th scope=\"col\">Note</th><th class=\"n\" scope=\"col\">Cents</th><th class=\"n\" scope=\"col\">to "
      "the nominal</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Partials of the bell");
}

std::string key_figures(const fit::AnalysisDocument& data) {
  KeyFigures keys;
  keys.add("Partials", std::to_string(data.partials.size()));
  if (data.explained_energy) keys.add("Energy explained", rounded(100 * *data.explained_energy, 4) + " %");
  if (!data.strikes_s.empty())
    keys.add(data.strikes_s.size() == 1 ? "Strike" : "Strikes", std::to_string(data.strikes_s.size()),
             "first at " + rounded(data.strikes_s[0], 4) + " s");
  if (data.duration_s)
    keys.add(
        "Duration", rounded(*data.duration_s, 4) + "\u202fs",
        data.n_channels ? counted(static_cast<std::size_t>(std::max(0, *data.n_channels)), "channel", "channels") : "");
  if (data.sample_rate_hz) keys.add("Sample rate", rounded(*data.sample_rate_hz / 1000, 5) + "\u202fkHz");
  if (data.noise_rms && *data.noise_rms > 0)
    keys.add("Noise", fixed(20 * std::log10(*data.noise_rms), 1) + "\u202fdB", "re full scale, rms in band");
  return keys.html();
}

std::string title_of(const fit::AnalysisDocument& data) {
  if (!data.name.empty()) return data.name;
  for (const InputFile& input : data.header.provenance.inputs) {
    const std::size_t slash = input.path.rfind('/');
    return slash == std::string::npos ? input.path : input.path.substr(slash + 1);
  }
  return "Recording";
}

SoundPair sounds_of(const fit::AnalysisDocument& data, ReportFolder& folder) {
  const fit::SoundFiles files = data.files.value_or(fit::SoundFiles{});
  SoundPair sounds;
  sounds.name = data.name;
  sounds.recorded = folder.sound_beside(files.recording.value_or(""));
  sounds.computed = folder.sound_beside(files.resynthesis.value_or(""));
  sounds.strikes_s = data.strikes_s;
  for (const fit::Partial& partial : data.partials)
    sounds.highest_hz = std::max(sounds.highest_hz, partial.frequency_hz);
  sounds.computed_words = "Resynthesis";
  return sounds;
}

Page make(const fit::AnalysisDocument& data, ReportFolder& folder) {
  Page page;
  page.over = data.responses ? "Klangprobe · poles of measured responses" : "Klangprobe · partials of a recording";
  page.title = title_of(data);
  page.verdict = status_verdict(data.header);
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  DecayPlot plot;
  std::vector<PartialRow> rows;
  for (const fit::Partial& partial : data.partials) {
    plot.marks.push_back({0, data.name, partial, false});
    rows.push_back({data.name, {partial, {}}});
  }
  std::string damping, partials;
  if (const std::optional<Svg> decays = decay_figure(plot)) {
    folder.add_figure("decays", *decays);
    damping = figure(sheet(*decays),
                     "Decay rate of the amplitude; a partial falls by 60 dB in 6.91 divided by "
                     "it. Bars are one standard deviation.");
  }
  const SoundPair sounds = sounds_of(data, folder);
  const std::vector<fit::Partial> rings = fit::without_shapes(data.partials);
  SpectrumView spectrum{data.name, sounds.recorded, sounds.computed, 0, rings};
  spectrum.strike_s = told_strike_s(data.strikes_s, data.amplitude_strike);
  if (data.responses) {
    spectrum.given = level_spectrum(data.responses->curve_hz, data.responses->curve_db);
    spectrum.axis = "Level [dB re 1 " + data.responses->unit + "]";
  }
  if (!data.responses || !spectrum.given.level_db.empty()) partials = spectrum_html(spectrum, folder);
  if (!data.partials.empty())
    partials += scrolled(partial_table(rings, data.responses ? std::vector<fit::Partial>() : rings), "Partials");
  if (data.a4_hz) partials += "<p class=\"caption\">Notes by A4 = " + rounded(*data.a4_hz, 5) + " Hz.</p>";
  if (data.bell && data.bell->found()) partials += bell_table(*data.bell, data.a4_hz.value_or(audio::kConcertPitchHz));
  const SoundMedia media = sound_media(sounds, 1, folder);
  BodyFacts facts;
  facts.explained_energy = data.explained_energy;
  facts.n_strikes = data.strikes_s.size();
  page.sections = {
      {"sound", "Sound",
       data.responses ? std::string()
                      : players(media, sounds) + spectrogram_html(media, kSpectrogramCaption) + facts_html(facts)},
      {"partials", "Partials", partials},
      {"stability", "Stability", stability_html(data, folder)},
      {"assurance", "Modal assurance", assurance_html(data)},
      {"damping", "Damping", damping}};
  add_table("partials.csv", csv_table(rows), data.header.provenance.inputs, folder, page.downloads);
  if (data.files) {
    add_if_there(data.files->recording, "– recording", folder, page.downloads);
    add_if_there(data.files->resynthesis, "– fitted model’s sound", folder, page.downloads);
  }
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind analysis_page() { return page_kind<fit::AnalysisDocument>("analysis", make); }

}  // namespace klang::reports::detail
