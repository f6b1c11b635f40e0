// The page of klang fit.
#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/config/fields_csv.hpp"
#include "fit/run/fit_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/body_facts.hpp"
#include "reports/pages/decay_figure.hpp"
#include "reports/pages/fit_figures.hpp"
#include "reports/pages/fit_sentences.hpp"
#include "reports/pages/fit_tables.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/mode_shapes.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/shape_view.hpp"
#include "reports/pages/sound_media.hpp"
#include "reports/pages/spectrum_view.hpp"

namespace klang::reports::detail {
namespace {

constexpr std::size_t kMostLadders = 8, kSpecimensPerLadder = 8, kMostKeyParameters = 4, kMostOpenSpecimens = 3;

/// A specimen with what its section shows.
struct SpecimenView {
  SpecimenRows rows;
  ShapeWords shape;
  SoundPair sounds;
  SoundMedia media;
  std::string spectrum, turning;  ///< its figures
  std::vector<ModePicture> pictures;
};

/// A row of damping.csv.
struct DampingRow {
  fit::DampingRecord model;
  fit::FitParameter parameter;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"model", "its name"}, self.model.model);
    fit::FitParameter::describe(self.parameter, visit);
    visit({"aicc", "of the model"}, self.model.aicc);
    visit({"aicc_weight", "of the model"}, self.model.aicc_weight);
    visit({"rms_relative_residual", "of the model"}, self.model.rms_relative_residual);
  }
};

Verdict verdict_of(const fit::FitDocument& data) {
  const std::string& status = data.header.status;
  Verdict result{status.empty() ? "No status" : status, "bad", {}};
  if (status == "converged") result = {"Converged", "good", {}};
  if (status == "not_converged") result = {"Not converged", "fair", {}};
  if (status == "no_partials") result = {"No partials found", "bad", {}};
  if (status == "no_match") result = {"No partial matches", "bad", {}};
  if (status != "converged" && data.matches.empty()) {
    result.details = data.header.message.value_or("");
    return result;
  }
  const MatchSummary summary = match_summary(data, false);
  result.details =
      std::to_string(summary.n_matched) + " of " + std::to_string(summary.n_partials) + " partials matched";
  if (summary.worst)
    result.details += ", none further than " + rounded(std::abs(summary.worst->deviation_cents), 2) + " cents";
  if (data.n_iterations)
    result.details +=
        "; " + counted(static_cast<std::size_t>(std::max(0, *data.n_iterations)), "solver step", "solver steps");
  using fit::Verdict;
  const Verdict judged = data.judgement.verdict;
  if (status == "converged" && judged != Verdict::kNotJudged) {
    result.words = judged == Verdict::kTrusted ? "Trusted" : judged == Verdict::kDoubtful ? "Doubtful" : "Contradicted";
    result.kind = judged == Verdict::kTrusted ? "good" : judged == Verdict::kDoubtful ? "fair" : "bad";
  }
  return result;
}

/// What speaks for and against, gravest first.
std::string judgement_html(const fit::Judgement& judgement) {
  std::string items;
  for (const fit::Reason& reason : judgement.reasons) {
    const bool note = reason.weight == fit::Verdict::kTrusted;
    const char* kind = note ? "good" : reason.weight == fit::Verdict::kDoubtful ? "fair" : "bad";
    items += "<li><span class=\"tag " + std::string(kind) + "\">" +
             (note ? "note" : std::string(to_text(reason.weight))) + "</span> " +
             escaped(reason.specimen.empty() ? capitalised(reason.text) : reason.specimen + ": " + reason.text) +
             ".</li>\n";
  }
  return items.empty() ? "" : "<ul class=\"reasons\">" + items + "</ul>";
}

std::string key_figures(const fit::FitDocument& data) {
  KeyFigures keys;
  std::size_t n = 0;
  for (const char* name : {"youngs_modulus_pa", "poissons_ratio", "shear_modulus_pa", "lame_mu_pa",
                           "rayleigh_stiffness_s", "rayleigh_mass_per_s"}) {
    for (const fit::FitParameter& e : data.parameters) {
      if (e.name != name || !e.identifiable || n >= kMostKeyParameters) continue;
      const ShownEstimate text = shown(e);
      keys.add(name_html(text.quantity), with_unit(text.value, text.quantity),
               text.std.empty()
                   ? ""
                   : "± " + with_unit(text.std, text.quantity) + (e.caveat.empty() ? "" : ", " + escaped(e.caveat)));
      ++n;
    }
  }
  if (data.matches.empty()) return keys.html();
  const MatchSummary fitted = match_summary(data, false), predicted = match_summary(data, true);
  if (fitted.worst) {
    keys.add("Partials matched", std::to_string(fitted.n_matched), "of " + std::to_string(fitted.n_partials));
    keys.add("Deviation", rounded(fitted.rms_cents, 2) + " cents",
             "rms; largest " + rounded(std::abs(fitted.worst->deviation_cents), 2));
  }
  if (predicted.n_partials > 0)
    keys.add(
        "Partials predicted", std::to_string(predicted.n_matched) + " of " + std::to_string(predicted.n_partials),
        predicted.worst ? "largest error " + rounded(std::abs(predicted.worst->deviation_cents), 2) + " cents" : "");
  if (!data.damping.model.empty()) {
    std::string note;
    for (const fit::DampingRecord& model : data.damping.candidates) {
      if (model.model == data.damping.model && model.aicc_weight)
        note = "AICc weight " + escaped(share(*model.aicc_weight));
    }
    keys.add("Damping", escaped(capitalised(damping_words(data.damping.model))), note);
  }
  return keys.html();
}

DecayPlot decay_plot(const fit::FitDocument& data) {
  DecayPlot plot{{}, names_of(data), data.damping.candidates, data.damping.model};
  for (std::size_t s = 0; s < data.specimens.size(); ++s) {
    for (const fit::PartialRecord& p : data.specimens[s].partials)
      plot.marks.push_back({s, data.specimens[s].name, p, !p.matched_mode});
  }
  return plot;
}

std::string partials_html(const fit::FitDocument& data, ReportFolder& folder) {
  std::string html;
  const std::size_t n = data.specimens.size();
  for (std::size_t first = 0; first < n && first < kMostLadders * kSpecimensPerLadder; first += kSpecimensPerLadder) {
    const Svg ladder = ladder_figure(data, first, kSpecimensPerLadder);
    folder.add_figure(first == 0 ? "ladder" : "ladder-" + std::to_string(first / kSpecimensPerLadder + 1), ladder);
    const bool last = first + kSpecimensPerLadder >= std::min(n, kMostLadders * kSpecimensPerLadder);
    html += figure(sheet(ladder), last ? "Each column is a specimen: measured partials left, modes of the fitted model "
                                         "right, and how many cents the measured one lies above the model."
                                       : "");
  }
  if (const std::optional<Svg> residuals = residual_figure(data)) {
    folder.add_figure("residuals", *residuals);
    html += figure(sheet(*residuals),
                   "What is left between measurement and model. Error bars are one standard deviation "
                   "of the measured frequency alone.");
  }
  return html;
}

std::string damping_html(const fit::FitDocument& data, ReportFolder& folder) {
  std::string html;
  if (const std::optional<Svg> decays = decay_figure(decay_plot(data))) {
    folder.add_figure("decays", *decays);
    html = figure(sheet(*decays),
                  "Decay rate of the amplitude; a partial falls by 60 dB in 6.91 divided by it. "
                  "Bars are one standard deviation; hollow marks are partials without a mode.");
  }
  return html + (data.damping.candidates.empty() ? "" : damping_table(data));
}

/// Names of files made from the names of specimens, told apart.
std::string stem_of(const fit::FitDocument& data, std::size_t index) {
  const std::string stem = file_stem(data.specimens[index].name);
  for (std::size_t i = 0; i < data.specimens.size(); ++i) {
    if (i != index && file_stem(data.specimens[i].name) == stem) return stem + "-" + std::to_string(index + 1);
  }
  return stem;
}

SoundPair sounds_of(const fit::FitDocument& data, std::size_t index, ReportFolder& folder) {
  const fit::SpecimenRecord& specimen = data.specimens[index];
  SoundPair sounds;
  sounds.name = specimen.name;
  sounds.recorded = folder.sound_beside(specimen.files.recording.value_or(""));
  sounds.computed = folder.sound_beside(specimen.files.resynthesis.value_or(""));
  sounds.strikes_s = specimen.strikes_s;
  for (const fit::PartialRecord& partial : specimen.partials)
    sounds.highest_hz = std::max(sounds.highest_hz, partial.frequency_hz);
  sounds.computed_words = "Fitted model";
  sounds.stem = "spectrogram-" + stem_of(data, index);
  return sounds;
}

std::vector<fit::Partial> partials_of(const fit::SpecimenRecord& specimen) {
  return {specimen.partials.begin(), specimen.partials.end()};
}

std::string spectrum_of(const fit::FitDocument& data, std::size_t index, const SoundPair& sounds,
                        ReportFolder& folder) {
  const fit::SpecimenRecord& specimen = data.specimens[index];
  SpectrumView view{specimen.name, sounds.recorded, sounds.computed, 0, partials_of(specimen)};
  view.strike_s = told_strike_s(specimen.strikes_s, specimen.amplitude_strike);
  view.stem.clear();
  return spectrum_html(view, folder);
}

/// Modes that were heard, else all.
BodyModes modes_of(const fit::FitDocument& data, std::size_t index, const SpecimenView& view) {
  std::set<int> heard;
  for (const fit::MatchRecord& match : view.rows.matches) heard.insert(match.mode_index);
  std::vector<ModePicture> modes;
  for (const fit::PredictedRecord& mode : view.rows.predicted) {
    if (!heard.empty() && !heard.count(mode.mode_index)) continue;
    ModePicture picture;
    picture.mode_index = mode.mode_index;
    picture.frequency_hz = mode.frequency_hz;
    for (const fit::MatchRecord& match : view.rows.matches) {
      if (match.mode_index == mode.mode_index)
        picture.measured += "; measured " + escaped(hertz(match.frequency_hz, match.frequency_std_hz));
    }
    modes.push_back(std::move(picture));
  }
  return {data.specimens[index].files.modes.value_or(""), "mode-" + stem_of(data, index), view.shape.kind,
          without_twins(modes)};
}

std::vector<SpecimenView> specimen_views(const fit::FitDocument& data, ReportFolder& folder) {
  const std::size_t n = data.specimens.size();
  std::vector<SpecimenView> views(n);
  for (std::size_t i = 0; i < n; ++i) {
    folder.monitor().throw_if_stopped();
    SpecimenView& view = views[i];
    view.rows = rows_of(data, data.specimens[i]);
    view.shape = shape_words(data.specimens[i].shape);
    view.sounds = sounds_of(data, i, folder);
    const bool sounds = std::max(view.sounds.recorded.n_frames(), view.sounds.computed.n_frames()) >= 16;
    if (i == kMaxMedia && sounds)
      folder.warn("sounds and spectrograms of " + counted(n - kMaxMedia, "specimen", "specimens") +
                  " are left out of the page to keep it small; they lie beside it");
    view.media = sound_media(view.sounds, i < kMaxMedia ? n : 0, folder);
    if (i < kMaxMedia) view.spectrum = spectrum_of(data, i, view.sounds, folder);
    view.sounds.recorded = view.sounds.computed = {};  // minutes of sound are not kept
    folder.monitor().progress("report", 0.1 + 0.5 * static_cast<double>(i + 1) / static_cast<double>(n));
  }
  std::vector<BodyModes> bodies;
  for (std::size_t i = 0; i < n; ++i) bodies.push_back(modes_of(data, i, views[i]));
  std::vector<std::vector<ModePicture>> pictures = mode_pictures(bodies, folder);
  for (std::size_t i = 0; i < n; ++i) {
    views[i].pictures = std::move(pictures[i]);
    if (i < kMaxMedia) views[i].turning = shape_view_html(bodies[i], std::min(n, kMaxMedia), folder);
  }
  return views;
}

std::string summary_line(const fit::SpecimenRecord& specimen, const SpecimenRows& rows) {
  std::string text = specimen.predicted ? "predicted: no part of the fit · " : "";
  text += std::to_string(rows.matches.size()) + " of " +
          std::to_string(std::max(rows.matches.size(), specimen.partials.size())) + " partials matched";
  if (specimen.rms_deviation_cents) text += " · rms " + rounded(*specimen.rms_deviation_cents, 2) + " cents";
  if (specimen.max_deviation_cents) text += " · largest " + rounded(*specimen.max_deviation_cents, 2);
  return text;
}

std::string tables_html(const SpecimenRows& rows, const std::vector<fit::Partial>& heard) {
  std::string tables;
  if (!rows.matches.empty())
    tables += more(counted(rows.matches.size(), "matched partial", "matched partials"),
                   scrolled(match_table(rows.matches, heard), "Matched partials"));
  if (!rows.unmatched.empty())
    tables +=
        more(counted(rows.unmatched.size(), "partial", "partials") + " without a mode",
             scrolled(partial_table({rows.unmatched.begin(), rows.unmatched.end()}, heard), "Partials without a mode"));
  if (!rows.unheard.empty())
    tables += more(counted(rows.unheard.size(), "mode", "modes") + " of the model that no partial matches",
                   "<p>" + mode_list(rows.unheard) + "</p>");
  return tables;
}

std::string specimen_html(const fit::FitDocument& data, std::size_t index, const SpecimenView& view) {
  const fit::SpecimenRecord& specimen = data.specimens[index];
  std::string body =
      players(view.media, view.sounds) + spectrogram_html(view.media, kSpectrogramCaption) + view.spectrum;
  body += view.turning + shapes_html(view.pictures) +
          facts_html({specimen.mass_kg, specimen.explained_energy, specimen.strikes_s.size(), specimen.n_nodes,
                      specimen.n_elements, specimen.none_missing}) +
          tables_html(view.rows, view.spectrum.empty() ? std::vector<fit::Partial>() : partials_of(specimen));
  const bool open = index == 0 || data.specimens.size() <= kMostOpenSpecimens;
  return "<details class=\"body\" id=\"specimen-" + std::to_string(index) + "\"" + (open ? " open" : "") +
         "><summary><h3>" + escaped(specimen.name.empty() ? "specimen " + std::to_string(index + 1) : specimen.name) +
         "</h3><span class=\"shape\">" + escaped(view.shape.words) + "</span><span class=\"how\">" +
         summary_line(specimen, view.rows) + "</span></summary>\n" + body + "</details>\n";
}

void add_tables(const fit::FitDocument& data, ReportFolder& folder, std::vector<Download>& downloads) {
  std::vector<PartialRow> partials;
  for (const fit::SpecimenRecord& specimen : data.specimens) {
    for (const fit::PartialRecord& partial : specimen.partials) partials.push_back({specimen.name, partial});
  }
  std::vector<DampingRow> damping;
  for (const fit::DampingRecord& model : data.damping.candidates) {
    for (const fit::FitParameter& parameter : model.parameters) damping.push_back({model, parameter});
  }
  const auto& inputs = data.header.provenance.inputs;
  add_table("partials.csv", csv_table(partials), inputs, folder, downloads);
  add_table("parameters.csv", csv_table(data.parameters), inputs, folder, downloads);
  add_table("matches.csv", csv_table(data.matches), inputs, folder, downloads);
  add_table("predicted.csv", csv_table(data.predicted, {"mesh_relative_error"}), inputs, folder, downloads);
  add_table("damping.csv", csv_table(damping), inputs, folder, downloads);
}

void add_specimen_files(const fit::FitDocument& data, const ReportFolder& folder, std::vector<Download>& downloads) {
  for (const fit::SpecimenRecord& specimen : data.specimens) {
    add_if_there(specimen.files.recording, "– recording", folder, downloads);
    add_if_there(specimen.files.resynthesis, "– fitted model’s sound", folder, downloads);
    add_if_there(specimen.files.modes, "– mode shapes for ParaView", folder, downloads);
  }
}

std::string title_of(const fit::FitDocument& data) {
  if (!data.name.empty()) return data.name;
  const std::string shape = data.specimens.empty() ? "" : shape_words(data.specimens.front().shape).words;
  return shape.empty() ? "Result" : capitalised(shape);
}

Page make(const fit::FitDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · material from sound";
  page.title = title_of(data);
  page.verdict = verdict_of(data);
  page.sentences = fit_sentences(data);
  page.key_figures = key_figures(data);
  page.sections.push_back({"verdict", "Verdict", judgement_html(data.judgement)});
  if (!data.parameters.empty())
    page.sections.push_back(
        {"parameters", "Parameters",
         scrolled(parameter_table(data.parameters), "Parameters") + budget_table(data) + correlation_table(data)});
  page.sections.push_back({"partials", "Partials", partials_html(data, folder)});
  page.sections.push_back({"damping", "Damping", damping_html(data, folder)});
  const std::vector<SpecimenView> views = specimen_views(data, folder);
  std::string bodies;
  for (std::size_t i = 0; i < views.size(); ++i) bodies += specimen_html(data, i, views[i]);
  page.sections.push_back({"specimens", views.size() == 1 ? "Specimen" : "Specimens", bodies});
  if (data.cost_initial && data.cost_final)
    page.cost = rounded(*data.cost_initial, 4) + " → " + rounded(*data.cost_final, 4);
  add_tables(data, folder, page.downloads);
  add_specimen_files(data, folder, page.downloads);
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind fit_page() { return page_kind<fit::FitDocument>("fit", make); }

}  // namespace klang::reports::detail
