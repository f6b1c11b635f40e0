// The page of klang regress check.
#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"
#include "reports/pages/regression_figures.hpp"
#include "reports/pages/sound_media.hpp"
#include "validate/regression/regression_document.hpp"

namespace klang::reports::detail {
namespace {

std::string with_std(double value, const Number& std) {
  if (!std || !(*std > 0)) return rounded(value, 6);
  const int decimals = decimals_for(*std);
  return fixed(value, decimals) + " ± " + fixed(*std, decimals);
}

std::string deviation(const Number& value, const Number& tolerance, double factor) {
  if (!value) return "—";
  const std::string text = (*value > 0 ? "+" : "") + fixed(factor * *value, 2) +
                           (tolerance ? " (± " + rounded(factor * *tolerance, 3) + ")" : "");
  return tolerance && !(std::abs(*value) <= *tolerance) ? "<b>" + text + "</b>" : text;
}

const validate::Claim* first_failed(const validate::RegressionDocument& data) {
  for (const validate::Claim& claim : data.claims) {
    if (!claim.passed && claim.not_judged.empty()) return &claim;
  }
  return nullptr;
}

std::size_t count_of(const validate::RegressionDocument& data, bool failed) {
  return static_cast<std::size_t>(std::count_if(data.claims.begin(), data.claims.end(), [&](const validate::Claim& c) {
    return failed ? !c.passed && c.not_judged.empty() : !c.not_judged.empty();
  }));
}

constexpr const char* kFailedPill = "<span class=\"tag bad\">failed</span>";
constexpr const char* kOpenPill = "<span class=\"tag fair\">not judged</span>";
constexpr const char* kPassedPill = "<span class=\"tag good\">passed</span>";

std::string verdict_of(const validate::PartialRecord& p) {
  if (!p.note.empty()) return kOpenPill;
  if (!p.sound) return "<span class=\"tag bad\">missing</span>";
  if (!p.reference) return "<span class=\"tag bad\">superfluous</span>";
  const bool kept = (!p.cents || std::abs(*p.cents) <= p.cents_tolerance.value_or(0)) &&
                    (!p.decay_change || std::abs(*p.decay_change) <= p.decay_tolerance.value_or(0));
  return kept ? "within" : kFailedPill;
}

std::string partials_table(const validate::RegressionDocument& data) {
  std::string body;
  for (const validate::PartialRecord& p : data.partials) {
    const auto frequency = [](const std::optional<validate::ComparedPartial>& side) {
      return side ? escaped(with_std(side->frequency_hz, side->frequency_std_hz)) : "—";
    };
    const auto decay = [](const std::optional<validate::ComparedPartial>& side) {
      return side && side->decay_per_s ? escaped(with_std(*side->decay_per_s, side->decay_std_per_s)) : "—";
    };
    body += "<tr" + std::string(p.note.empty() ? "" : " class=\"open\"") + ">" +
            tag("td", verdict_of(p), "class=\"nw\"") + number_cell(frequency(p.reference)) +
            number_cell(frequency(p.sound)) + number_cell(deviation(p.cents, p.cents_tolerance, 1)) +
            number_cell(decay(p.reference)) + number_cell(decay(p.sound)) +
            number_cell(deviation(p.decay_change, p.decay_tolerance, 100)) + "</tr>\n";
    if (!p.note.empty()) body += "<tr class=\"note\"><td colspan=\"7\">" + escaped(p.note) + "</td></tr>\n";
  }
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Verdict</th><th scope=\"col\" class=\"n\">Reference [Hz]</th><th "
      "scope=\"col\" class=\"n\">Sound "
      "[Hz]</th><th scope=\"col\" "
      "class=\"n\">Difference [cents]</th><th scope=\"col\" class=\"n\">Decay, reference [1/s]</th><th scope=\"col\" "
      "class=\"n\">sound [1/s]</th>"
      "<th scope=\"col\" class=\"n\">Change [%]</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Partials");
}

std::string claims_table(const validate::RegressionDocument& data) {
  std::string body;
  for (const int wanted : {0, 1, 2}) {  // failed, not judged, passed
    for (const validate::Claim& claim : data.claims) {
      const int kind = claim.passed ? 2 : claim.not_judged.empty() ? 0 : 1;
      if (kind != wanted) continue;
      const char* pills[] = {kFailedPill, kOpenPill, kPassedPill};
      body += "<tr" + std::string(kind == 1 ? " class=\"open\"" : "") + ">" + tag("td", pills[kind], "class=\"nw\"") +
              tag("th",
                  escaped(claim.words) +
                      (claim.not_judged.empty() ? "" : "<br><small>" + escaped(claim.not_judged) + "</small>"),
                  "scope=\"row\"") +
              number_cell(rounded(claim.measured, 3), claim.measured) +
              number_cell(rounded(claim.tolerance, 3), claim.tolerance) + "</tr>\n";
    }
  }
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Verdict</th><th scope=\"col\">Claim</th><th scope=\"col\" "
      "class=\"n\">Difference</th><th "
      "scope=\"col\" class=\"n\">Tolerance</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Claims");
}

std::string key_figures(const validate::RegressionDocument& data) {
  KeyFigures keys;
  const auto n_pairs = std::count_if(data.partials.begin(), data.partials.end(),
                                     [](const validate::PartialRecord& p) { return p.reference && p.sound; });
  const auto n_reference = std::count_if(data.partials.begin(), data.partials.end(),
                                         [](const validate::PartialRecord& p) { return p.reference.has_value(); });
  keys.add("Claims failed", std::to_string(count_of(data, true)), "of " + std::to_string(data.claims.size()));
  keys.add("Not judged", std::to_string(count_of(data, false)), "claims");
  keys.add("Partials found", std::to_string(n_pairs), "of " + std::to_string(n_reference));
  if (data.log_spectral_distance_db)
    keys.add("Log-spectral distance", fixed(*data.log_spectral_distance_db, 2) + "\u202fdB", "rms above the noise");
  if (data.gain_db)
    keys.add("Level", (*data.gain_db > 0 ? "+" : "") + fixed(*data.gain_db, 1) + "\u202fdB",
             "sound over reference, taken off");
  if (data.ring_10db_s && data.reference_ring_10db_s)
    keys.add("Energy falls by 10 dB in", rounded(*data.ring_10db_s, 3) + "\u202fs",
             "reference " + rounded(*data.reference_ring_10db_s, 3) + "\u202fs");
  if (data.factor)
    keys.add("Tolerance", rounded(*data.factor, 3) + " σ", "and scatter between takes; never under its floor");
  return keys.html();
}

std::vector<std::string> sentences_of(const validate::RegressionDocument& r) {
  const std::size_t failed = count_of(r, true), open = count_of(r, false);
  std::vector<std::string> sentences;
  if (r.header.status == "nothing_judged") {
    sentences.push_back("No partial could be judged, so nothing is passed.");
  } else if (failed == 0) {
    sentences.push_back("The sound keeps to its reference: <b>none of " +
                        counted(r.claims.size() - open, "judged claim", "judged claims") + " failed</b>.");
  } else if (r.header.message) {
    sentences.push_back("The sound differs from its reference for <b>one reason</b>: " + escaped(*r.header.message) +
                        ". " + capitalised(counted(failed, "claim", "claims")) + " of " +
                        std::to_string(r.claims.size() - open) + " that could be judged failed with it.");
  } else {
    sentences.push_back("The sound differs from its reference in <b>" + counted(failed, "claim", "claims") +
                        "</b> of " + std::to_string(r.claims.size() - open) +
                        " that could be judged. The first: " + escaped(first_failed(r)->words) + ": " +
                        rounded(measured(first_failed(r)->measured).value_or(0), 3) + ", tolerance " +
                        rounded(measured(first_failed(r)->tolerance).value_or(0), 3) + ".");
  }
  if (open > 0)
    sentences.push_back(capitalised(counted(open, "claim", "claims")) +
                        " could not be judged and count neither way; the table says why.");
  if (!r.reference_origin.empty())
    sentences.push_back("The reference was made from " + escaped(r.reference_origin) +
                        (r.reference_takes.value_or(1) > 1
                             ? " (" + std::to_string(*r.reference_takes) + " takes: tolerances hold their scatter)"
                             : "") +
                        ".");
  return sentences;
}

std::string overlay_html(const validate::RegressionDocument& data, ReportFolder& folder) {
  const validate::RegressionFiles files = data.files.value_or(validate::RegressionFiles{});
  SoundPair sounds;
  sounds.recorded = folder.sound_beside(files.sound.value_or(""));
  sounds.computed = folder.sound_beside(files.reference.value_or(""));
  sounds.recorded_words = "Sound";
  sounds.computed_words = "Reference, as its partials ring";
  for (const validate::PartialRecord& p : data.partials)
    if (p.reference) sounds.highest_hz = std::max(sounds.highest_hz, p.reference->frequency_hz);
  const SoundMedia media = sound_media(sounds, 1, folder);
  std::string html = players(media, sounds);
  const auto add = [&](const char* stem, const std::optional<Svg>& svg, const char* caption) {
    if (!svg) return;
    folder.add_figure(stem, *svg);
    html += figure(sheet(*svg), caption);
  };
  add("spectrum", regression_spectrum_figure(data),
      "Partials at the strike, side by side, and mean third-octave levels, the noise taken off.");
  add("levels", regression_spectrogram_figure(data),
      "Levels in bands of a twelfth octave from the onset on. What lies under the floor (12 dB over the louder "
      "noise, or 50 dB under the loudest cell) is set to it, "
      "so that noise shows no difference.");
  add("partials", regression_partials_figure(data),
      "How far the partials lie from the reference. A mark outside its bar is a failed claim; hollow marks were not "
      "judged.");
  html += spectrogram_html(media, "Spectrograms of the sound and of the reference’s partials on one scale of level.");
  return html;
}

Page make(const validate::RegressionDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · a sound against its reference";
  page.title = data.name.empty() ? "Result" : data.name;
  const bool passed = data.header.status == "passed";
  page.verdict = {passed                                   ? "Passed"
                  : data.header.status == "nothing_judged" ? "Nothing could be judged"
                                                           : "Not passed",
                  passed ? "good" : "bad", ""};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  page.sections = {
      {"overlay", "Overlay", overlay_html(data, folder)},
      {"partials", "Partials", partials_table(data)},
      {"claims", "Claims",
       data.header.message ? more("All claims, failed for one reason", claims_table(data)) : claims_table(data)}};
  if (data.files) {
    add_if_there(data.files->sound, "– the sound", folder, page.downloads);
    add_if_there(data.files->reference, "– the reference’s partials", folder, page.downloads);
  }
  add_if_there("junit.xml", "– the claims for a test report", folder, page.downloads);
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind regression_page() { return page_kind<validate::RegressionDocument>("regression", make); }

}  // namespace klang::reports::detail
