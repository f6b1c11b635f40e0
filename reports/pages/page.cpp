#include "reports/pages/page.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/bubble_page.hpp"
#include "reports/pages/fit_tables.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/papers_page.hpp"
#include "reports/pages/proxy_page.hpp"
#include "reports/pages/proxy_study_page.hpp"
#include "reports/pages/regression_page.hpp"
#include "reports/pages/study_page.hpp"

namespace klang::reports::detail {
namespace {

std::string players(const SpecimenMedia& media, const std::string& name, const std::string& fitted,
                    const std::string& recorded = "Recorded") {
  if (media.recorded_wav.empty() && media.fitted_wav.empty()) return {};
  const auto player = [&](const std::string& wav, const std::string& what) {
    if (wav.empty()) return std::string();
    return "<label>" + what + "<audio controls preload=\"auto\" aria-label=\"" +
           escaped(name.empty() ? what : what + ", " + name) + "\" src=\"" + data_uri("audio/wav", wav) +
           "\"></audio></label>";
  };
  const bool both = !media.recorded_wav.empty() && !media.fitted_wav.empty();
  std::string html = "<div class=\"listen\"" + std::string(both ? " data-switch" : "") + ">" +
                     player(media.recorded_wav, recorded) + player(media.fitted_wav, fitted);
  if (both) html += "<button type=\"button\" hidden>Compare</button>";
  html += "</div>\n";
  std::string note;
  if (media.cut) note = "The first " + rounded(media.clip_s, 2) + " s; the whole sound lies beside this page.";
  if (std::abs(20 * std::log10(media.gain)) > 0.5) {
    note += std::string(note.empty() ? "" : " ") + (both ? "Both are" : "It is") + " played " +
            fixed(std::abs(20 * std::log10(media.gain)), 1) + " dB " + (media.gain > 1 ? "louder" : "softer") +
            " than recorded.";
  }
  return html + (note.empty() ? "" : "<p class=\"how\"><small>" + note + "</small></p>\n");
}

std::string shapes(const SpecimenMedia& media, const SpecimenRows& rows) {
  if (media.pictures.empty()) return {};
  int wide = 0;
  std::string body;
  for (const ModePicture& picture : media.pictures) {
    if (picture.width > 2 * picture.height) ++wide;
    std::string caption = "<b>" + escaped(hertz(picture.frequency_hz)) + "</b> mode " +
                          std::to_string(picture.mode_index) + escaped(picture.twins);
    for (const Match& match : rows.matches) {
      if (match.mode_index == picture.mode_index)
        caption += "; measured " + escaped(hertz(match.frequency_hz, match.frequency_std_hz));
    }
    if (picture.tangential) {
      caption += "; moves within its surface only, colour is the size of the motion";
    }
    body += "<figure><img alt=\"Shape of mode " + std::to_string(picture.mode_index) + " at " +
            escaped(hertz(picture.frequency_hz)) + "\" width=\"" + std::to_string(picture.width) + "\" height=\"" +
            std::to_string(picture.height) + "\" src=\"" + data_uri("image/png", picture.png) + "\">" +
            tag("figcaption", caption) + "</figure>\n";
  }
  return "<h3>Mode shapes</h3>\n<div class=\"shapes" +
         std::string(2 * wide > static_cast<int>(media.pictures.size()) ? " long" : "") + "\">" + body +
         "</div>\n<p class=\"how\"><small>The body at one extreme of its motion, greatly enlarged. Colour is "
         "the displacement normal "
         "to the surface, which is what sounds: red outwards, blue inwards; dark lines are the "
         "nodes.</small></p>\n";
}

std::string specimen_facts(const ResultData& data, const Specimen& specimen, const SpecimenRows& rows) {
  std::vector<std::string> facts;
  if (data.kind == "fit") {
    if (specimen.predicted) facts.push_back("predicted: no part of the fit");
    facts.push_back(std::to_string(rows.matches.size()) + " of " +
                    std::to_string(std::max(rows.matches.size(), specimen.partials.size())) + " partials matched");
    if (specimen.rms_deviation_cents) facts.push_back("rms " + rounded(*specimen.rms_deviation_cents, 2) + " cents");
    if (specimen.max_deviation_cents) facts.push_back("largest " + rounded(*specimen.max_deviation_cents, 2));
  }
  std::string text;
  for (const std::string& fact : facts) text += (text.empty() ? "" : " · ") + fact;
  return text;
}

std::string specimen_details(const ResultData& data, const Specimen& specimen, const SpecimenRows& rows) {
  std::string facts;
  const auto fact = [&](const std::string& text) { facts += (facts.empty() ? "" : " · ") + text; };
  if (specimen.mass_kg) fact("mass " + rounded(1000 * *specimen.mass_kg, 5) + " g");
  if (specimen.explained_energy) fact(rounded(100 * *specimen.explained_energy, 4) + " % of the energy explained");
  if (specimen.strikes_s.size() > 1) fact(std::to_string(specimen.strikes_s.size()) + " strikes");
  if (specimen.n_nodes)
    fact(std::to_string(*specimen.n_nodes) + " nodes" +
         (specimen.n_elements ? ", " + std::to_string(*specimen.n_elements) + " elements" : ""));
  if (specimen.none_missing)
    fact(*specimen.none_missing ? "no mode missing in the band (proven by a Sturm count)"
                                : "not proven that no mode is missing in the band");
  std::string html = facts.empty() ? "" : "<p class=\"how\"><small>" + facts + "</small></p>\n";
  if (data.kind != "fit") return html;
  std::string tables;
  if (!rows.matches.empty())
    tables += more(counted(rows.matches.size(), "matched partial", "matched partials"),
                   scrolled(match_table(rows.matches), "Matched partials"));
  if (!rows.unmatched.empty()) {
    tables += more(counted(rows.unmatched.size(), "partial", "partials") + " without a mode",
                   scrolled(partial_table(rows.unmatched), "Partials without a mode"));
  }
  if (!rows.unheard.empty()) {
    tables += more(counted(rows.unheard.size(), "mode", "modes") + " of the model that no partial matches",
                   "<p>" + mode_list(rows.unheard) + "</p>");
  }
  return html + tables;
}

std::string specimen_section(const ResultData& data, const PageParts& parts, std::size_t index) {
  const Specimen& specimen = data.specimens[index];
  const SpecimenMedia& media = parts.media[index];
  const SpecimenRows rows = rows_of(data, specimen);
  std::string body = players(media, specimen.name, fitted_words(data));
  if (media.spectrogram) {
    body += figure(sheet(*media.spectrogram),
                   media.fitted_wav.empty() ? "Spectrogram of the recording; triangles mark strikes."
                   : data.kind == "bubbles"
                       ? "Spectrograms on one scale of level; bright lines over the recording are the "
                         "fitted chirps while they are heard. The difference is taken between "
                         "magnitudes: what is bright there is energy that one has and the other has not."
                       : "Spectrograms on one scale of level. The difference is "
                         "taken between magnitudes, so that phases do not enter: "
                         "what is bright there is energy that one of the two has "
                         "and the other has not. Triangles mark strikes.");
  }
  body += shapes(media, rows) + specimen_details(data, specimen, rows);
  if (data.kind != "fit") return body;
  const bool open = index == 0 || data.specimens.size() <= 3;
  return "<details class=\"body\" id=\"specimen-" + std::to_string(index) + "\"" + (open ? " open" : "") +
         "><summary><h3>" + escaped(specimen.name.empty() ? "specimen " + std::to_string(index + 1) : specimen.name) +
         "</h3><span class=\"shape\">" + escaped(specimen.shape) + "</span><span class=\"how\">" +
         specimen_facts(data, specimen, rows) + "</span></summary>\n" + body + "</details>\n";
}

std::string key_figures(const ResultData& data) {
  if (data.kind == "study") return study_key_figures(data.study);
  if (data.kind == "bubbles") return bubble_key_figures(data);
  if (data.kind == "regression") return regression_key_figures(data.regression);
  if (data.kind == "papers") return papers_key_figures(data.papers);
  if (data.kind == "proxy_study") return proxy_study_key_figures(data.proxy_study);
  if (data.kind == "proxy_fit") return proxy_key_figures(data.proxy);
  std::string html;
  const auto key = [&](const std::string& name, const std::string& value, const std::string& note) {
    html += "<div><dt>" + capitalised(name) + "</dt><dd>" + value + (note.empty() ? "" : tag("small", note)) +
            "</dd></div>";
  };
  int n = 0;
  for (const char* name : {"youngs_modulus_pa", "poissons_ratio", "shear_modulus_pa", "lame_mu_pa",
                           "rayleigh_stiffness_s", "rayleigh_mass_per_s"}) {
    for (const Estimate& e : data.parameters) {
      if (e.name != name || !e.identifiable || n >= 4) continue;
      const ShownEstimate text = shown(e);
      key(name_html(text.quantity), with_unit(text.value, text.quantity),
          text.std.empty() ? "" : "± " + with_unit(text.std, text.quantity));
      ++n;
    }
  }
  if (data.kind == "fit" && !data.matches.empty()) {
    const MatchSummary fitted = match_summary(data, false), predicted = match_summary(data, true);
    if (fitted.worst) {
      key("partials matched", std::to_string(fitted.n_matched), "of " + std::to_string(fitted.n_partials));
      key("deviation", rounded(fitted.rms_cents, 2) + " cents",
          "rms; largest " + rounded(std::abs(fitted.worst->deviation_cents), 2));
    }
    if (predicted.n_partials > 0)
      key("partials predicted", std::to_string(predicted.n_matched) + " of " + std::to_string(predicted.n_partials),
          predicted.worst ? "largest error " + rounded(std::abs(predicted.worst->deviation_cents), 2) + " cents" : "");
    if (!data.damping_model.empty()) {
      std::string note;
      for (const DampingModel& model : data.damping) {
        if (model.model == data.damping_model && model.aicc_weight)
          note = "AICc weight " + escaped(share(*model.aicc_weight));
      }
      key("damping", escaped(capitalised(damping_words(data.damping_model))), note);
    }
  }
  if (data.kind == "analysis") {
    const Specimen& body = data.specimens.front();
    key("partials", std::to_string(body.partials.size()), "");
    if (body.explained_energy) key("energy explained", rounded(100 * *body.explained_energy, 4) + " %", "");
    if (!body.strikes_s.empty())
      key(body.strikes_s.size() == 1 ? "strike" : "strikes", std::to_string(body.strikes_s.size()),
          "first at " + rounded(body.strikes_s[0], 4) + " s");
    if (body.duration_s)
      key("duration", rounded(*body.duration_s, 4) + "\u202fs",
          body.n_channels ? counted(static_cast<std::size_t>(std::max(0, *body.n_channels)), "channel", "channels")
                          : "");
    if (body.sample_rate_hz) key("sample rate", rounded(*body.sample_rate_hz / 1000, 5) + "\u202fkHz", "");
    if (body.noise_rms && *body.noise_rms > 0)
      key("noise", fixed(20 * std::log10(*body.noise_rms), 1) + "\u202fdB", "re full scale, rms in band");
  }
  if (data.kind == "modes") {
    const Specimen& body = data.specimens.front();
    key("modes", std::to_string(body.modes.size()), body.none_missing.value_or(false) ? "none missing (proven)" : "");
    if (body.n_nodes)
      key("nodes", std::to_string(*body.n_nodes),
          body.n_elements ? std::to_string(*body.n_elements) + " elements" : "");
    if (body.n_rigid_modes) key("rigid modes", std::to_string(*body.n_rigid_modes), "");
    if (data.peak_memory_bytes) key("memory", rounded(*data.peak_memory_bytes / 1e6, 4) + "\u202fMB", "at the peak");
  }
  return html.empty() ? "" : "<dl class=\"keys\">" + html + "</dl>\n";
}

std::string warning_box(const ResultData& data, const PageParts& parts) {
  std::string items;
  for (const std::string& warning : data.warnings) items += tag("li", escaped(warning)) + "\n";
  for (const std::string& warning : parts.warnings) items += tag("li", escaped(warning)) + "\n";
  return items.empty() ? ""
                       : "<aside class=\"warn\" aria-label=\"Warnings\"><h2>To know when reading this page</h2><ul>" +
                             items + "</ul></aside>\n";
}

std::string title_of(const ResultData& data) {
  if (!data.name.empty()) return data.name;
  if (data.kind == "papers") return "The papers’ numbers";
  if (data.kind == "proxy_study") return "Debris by ellipsoids";
  if (data.kind == "proxy_fit") return "Ellipsoid for a body";
  if (data.kind == "study") return data.study.title.empty() ? "Convergence study" : data.study.title;
  if (data.kind == "analysis") {
    for (const ProvenanceInput& input : data.inputs) {
      const std::size_t slash = input.path.rfind('/');
      return slash == std::string::npos ? input.path : input.path.substr(slash + 1);
    }
    return "Recording";
  }
  const Specimen* body = data.specimens.empty() ? nullptr : &data.specimens.front();
  return body && !body->shape.empty() ? capitalised(body->shape) : "Result";
}

}  // namespace

std::string page_html(const ResultData& data, const PageParts& parts) {
  const std::string title = title_of(data);
  const std::string over = data.kind == "fit"           ? "Klangprobe · material from sound"
                           : data.kind == "analysis"    ? "Klangprobe · partials of a recording"
                           : data.kind == "study"       ? "Klangprobe · convergence study"
                           : data.kind == "bubbles"     ? "Klangprobe · bubbles in a recording"
                           : data.kind == "regression"  ? "Klangprobe · a sound against its reference"
                           : data.kind == "papers"      ? "Klangprobe · published numbers"
                           : data.kind == "proxy_study" ? "Klangprobe · sound proxies"
                           : data.kind == "proxy_fit"   ? "Klangprobe · a body replaced by an ellipsoid"
                                                        : "Klangprobe · modes of a body";
  std::vector<std::pair<std::string, std::string>> contents;
  std::string sections;
  const auto section = [&](const std::string& id, const std::string& name, const std::string& body) {
    if (body.empty()) return;
    contents.emplace_back(id, name);
    sections += "<section id=\"" + id + "\"><h2>" + name + "</h2>\n" + body + "</section>\n";
  };

  if (data.kind == "fit") {
    if (!data.parameters.empty()) {
      section("parameters", "Parameters",
              scrolled(parameter_table(data.parameters), "Parameters") + correlation_table(data));
    }
    std::string partials;
    for (const Svg& ladder : parts.ladders)
      partials +=
          figure(sheet(ladder), &ladder == &parts.ladders.back()
                                    ? "Each column is a specimen: measured partials left, modes of the fitted model "
                                      "right, and how many cents the measured one lies above the model."
                                    : "");
    if (parts.residuals)
      partials += figure(sheet(*parts.residuals),
                         "What is left between measurement and model. Error bars are one standard deviation "
                         "of the measured frequency alone.");
    section("partials", "Partials", partials);
    std::string damping = parts.decays
                              ? figure(sheet(*parts.decays),
                                       "Decay rate of the amplitude; a partial falls by 60 dB in 6.91 divided by it. "
                                       "Bars are one standard deviation; hollow marks are partials without a mode.")
                              : "";
    if (!data.damping.empty()) damping += damping_table(data);
    section("damping", "Damping", damping);
    std::string bodies;
    for (std::size_t i = 0; i < data.specimens.size(); ++i) bodies += specimen_section(data, parts, i);
    section("specimens", data.specimens.size() == 1 ? "Specimen" : "Specimens", bodies);
  } else if (data.kind == "study") {
    for (const StudySection& part : study_sections(data.study, parts.study)) section(part.id, part.name, part.html);
  } else if (data.kind == "regression") {
    std::string figures;
    for (const CaptionedFigure& plot : parts.regression) figures += figure(sheet(plot.svg), plot.caption);
    section("overlay", "Overlay", figures);
    section("partials", "Partials", regression_partial_table(data.regression));
    section("claims", "Claims", regression_claim_table(data.regression));
  } else if (data.kind == "proxy_study") {
    const ProxyStudyData& study = data.proxy_study;
    section("curve", "Error and time",
            figure(sheet(proxy_error_figure(study)),
                   "The mix of all pieces with proxies above the threshold against the mix of direct sounds; at the "
                   "left all pieces sound by proxies.") +
                figure(sheet(proxy_time_figure(study)), "Processor time of all threads: modes, radiation and audio.") +
                proxy_threshold_table(study));
    std::string sound = parts.media.empty() ? "" : players(parts.media.front(), "", "All by proxies", "All directly");
    if (!sound.empty() && parts.media.front().spectrogram)
      sound += figure(sheet(*parts.media.front().spectrogram), "Spectrograms of both mixes on one scale of level.");
    section("sound", "Sound", sound);
    section("pieces", "Pieces", proxy_piece_table(study));
    section("stages", "Stages", proxy_stage_table(study));
  } else if (data.kind == "papers") {
    const auto tables = papers_sections(data.papers);
    for (std::size_t i = 0; i < tables.size(); ++i)
      section("table-" + std::to_string(i), tables[i].first, tables[i].second);
  } else if (data.kind == "proxy_fit") {
    std::string clips;
    for (const auto& [what, wav] : parts.proxy_clips)
      clips += "<label>" + what + "<audio controls preload=\"auto\" aria-label=\"" + what + "\" src=\"" +
               data_uri("audio/wav", wav) + "\"></audio></label>";
    section("measures", "Measures", proxy_measure_table(data.proxy));
    if (!clips.empty())
      section(
          "sounds", "Sounds",
          "<div class=\"listen\">" + clips + "</div>\n<p class=\"how\"><small>Each at its own level.</small></p>\n");
    std::string figures;
    for (const CaptionedFigure& plot : parts.proxy) figures += figure(sheet(plot.svg), plot.caption);
    section("partials", "Partials and shape", figures);
    section("parameters", "Parameters", proxy_parameter_table(data.proxy));
    section("table", "Partial by partial", proxy_partial_table(data.proxy));
  } else if (data.kind == "bubbles") {
    section("sound", "Sound", specimen_section(data, parts, 0));
    section("bubbles", "Bubbles", bubble_table(data.bubbles));
    section("damping", "Damping",
            parts.decays
                ? figure(sheet(*parts.decays),
                         "Decay of the amplitude over the pitch at the onset; the line is a free bubble's damping by "
                         "radiation, viscosity and heat, the least that a bubble of this pitch can have. Bars are one "
                         "standard deviation; hollow marks are rings that are no bubbles.")
                : "");
    section("pitch", "Pitch constants", pitch_table(data.bubbles));
  } else if (data.kind == "analysis") {
    const Specimen& body = data.specimens.front();
    section("sound", "Sound", specimen_section(data, parts, 0));
    std::string partials =
        parts.spectrum ? figure(sheet(*parts.spectrum), "Each partial at the moment of the first strike.") : "";
    if (!body.partials.empty()) partials += scrolled(partial_table(body.partials), "Partials");
    section("partials", "Partials", partials);
    section("damping", "Damping",
            parts.decays ? figure(sheet(*parts.decays),
                                  "Decay rate of the amplitude; a partial falls by 60 dB in 6.91 divided by "
                                  "it. Bars are one standard deviation.")
                         : "");
  } else {
    const Specimen& body = data.specimens.front();
    std::string modes = parts.modes ? figure(sheet(*parts.modes), "") : "";
    std::string rows;
    for (const Mode& mode : body.modes) {
      rows += "<tr>" + number_cell(std::to_string(mode.index)) + number_cell(fixed(mode.frequency_hz, 3)) +
              number_cell(mode.relative_residual ? rounded(*mode.relative_residual, 2) : "—") + "</tr>\n";
    }
    if (!rows.empty())
      modes += scrolled(
          "<table><thead><tr><th class=\"n\" scope=\"col\">Mode</th><th class=\"n\" scope=\"col\">Frequency "
          "[Hz]</th><th class=\"n\" scope=\"col\">Relative residual</th></tr></thead><tbody>" +
              rows + "</tbody></table>",
          "Modes");
    section("modes", "Modes", modes);
    section("shapes", "Shapes", specimen_section(data, parts, 0));
  }
  section("provenance", "How it was made", provenance(data));
  std::string files;
  for (const auto& [file, what] : parts.downloads)
    files += "<li><a href=\"" + encoded_path(file) + "\">" + escaped(file) + "</a> " + escaped(what) + "</li>\n";
  if (!files.empty()) section("files", "Files beside this page", "<ul class=\"files\">" + files + "</ul>");

  std::string toc;
  for (const auto& [id, name] : contents) toc += "<li><a href=\"#" + id + "\">" + name + "</a></li>";
  const Verdict result = verdict(data);
  std::string lead;
  for (const std::string& sentence : summary_sentences(data)) lead += tag("p", sentence, "class=\"lead\"") + "\n";

  // The policy makes sure that nothing is ever fetched: all a browser may load is in this file.
  return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
         "media-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
         escaped(title) + "</title>\n<style>" + page_css() +
         "</style>\n</head>\n<body>\n<header class=\"top\"><p class=\"over\">" + over + "</p>\n<h1>" + escaped(title) +
         "</h1>\n<p class=\"verdict\"><span class=\"pill " + result.kind + "\">" + escaped(result.words) +
         "</span><span class=\"how\">" + escaped(result.details) + "</span></p>\n" + lead + key_figures(data) +
         warning_box(data, parts) + "<nav class=\"toc\" aria-label=\"Contents\"><ol>" + toc +
         "</ol></nav></header>\n<main>\n" + sections + "</main>\n<footer>This page is one file and needs no network. " +
         std::string(
             data.kind == "study"
                 ? "Orders are slopes of least-squares lines through the logarithms; intervals hold with 95 % by "
                   "Student’s t."
                 : "Numbers: standard deviations are one sigma; frequencies in hertz, decays of the amplitude in "
                   "1/s, 100 cents = one semitone.") +
         "</footer>\n<script>" + page_script() + "</script>\n</body>\n</html>\n";
}

}  // namespace klang::reports::detail
