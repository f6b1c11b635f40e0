// The page of klang modes.
#include <algorithm>
#include <cmath>

#include "core/foundation/config/fields_csv.hpp"
#include "core/physics/modal/modes_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/body_facts.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/mode_shapes.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"
#include "reports/pages/shape_view.hpp"

namespace klang::reports::detail {
namespace {

/// Frequencies as one ladder; empty without a mode.
std::optional<Svg> modes_figure(const modal::ModesDocument& data) {
  if (data.modes.empty()) return {};
  constexpr double kHeight = 150, kLeft = 20, kTop = 20;
  std::vector<double> frequencies;
  for (const modal::ModeRecord& mode : data.modes) frequencies.push_back(mode.frequency_hz);
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.05);
  Svg svg(kPageWidth, kHeight, "Frequencies of the modes on a logarithmic axis.");
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48}, x, {"", Scale::kLinear, 0, 1, false});
  for (const Tick& tick : axis_ticks(x, 9)) {
    const double at = frame.x(tick.value);
    svg.line(at, frame.bottom(), at, frame.bottom() + (tick.label.empty() ? 3 : 5), "axis");
    svg.text(at, frame.bottom() + 18, tick.label, "muted small", Anchor::kMiddle);
  }
  svg.line(frame.left(), frame.bottom(), frame.right(), frame.bottom(), "axis");
  svg.text((frame.left() + frame.right()) / 2, frame.bottom() + 36, x.label, "muted", Anchor::kMiddle);
  for (const modal::ModeRecord& mode : data.modes) {
    if (!(mode.frequency_hz > 0)) continue;
    svg.begin_group("mode " + std::to_string(mode.index) + ", " + hertz(mode.frequency_hz));
    svg.line(frame.x(mode.frequency_hz), frame.top(), frame.x(mode.frequency_hz), frame.bottom(), "accent");
    svg.end_group();
  }
  return svg;
}

std::vector<std::string> sentences_of(const modal::ModesDocument& data) {
  if (data.modes.empty()) return {};
  return {"The body has <b>" + escaped(counted(data.modes.size(), "elastic mode", "elastic modes")) + "</b> from " +
          escaped(hertz(data.modes.front().frequency_hz)) + " to " + escaped(hertz(data.modes.back().frequency_hz)) +
          (data.none_missing.value_or(false) ? "; a Sturm count proves that none between them is missing." : ".")};
}

std::string key_figures(const modal::ModesDocument& data) {
  KeyFigures keys;
  keys.add("Modes", std::to_string(data.modes.size()),
           data.none_missing.value_or(false) ? "none missing (proven)" : "");
  if (data.n_nodes)
    keys.add("Nodes", std::to_string(*data.n_nodes),
             data.n_elements ? std::to_string(*data.n_elements) + " elements" : "");
  if (data.n_rigid_modes) keys.add("Rigid modes", std::to_string(*data.n_rigid_modes));
  if (data.peak_memory_bytes)
    keys.add("Memory", rounded(static_cast<double>(*data.peak_memory_bytes) / 1e6, 4) + "\u202fMB", "at the peak");
  return keys.html();
}

std::string mode_table(const modal::ModesDocument& data) {
  std::string rows;
  for (const modal::ModeRecord& mode : data.modes) {
    rows += "<tr>" + number_cell(std::to_string(mode.index)) +
            number_cell(fixed(mode.frequency_hz, 3), mode.frequency_hz) +
            number_cell(mode.relative_residual ? rounded(*mode.relative_residual, 2) : "—", mode.relative_residual) +
            "</tr>\n";
  }
  if (rows.empty()) return {};
  return scrolled(
      "<table><thead><tr><th class=\"n\" scope=\"col\">Mode</th><th class=\"n\" scope=\"col\">Frequency "
      "[Hz]</th><th class=\"n\" scope=\"col\">Relative residual</th></tr></thead><tbody>" +
          rows + "</tbody></table>",
      "Modes");
}

std::string shapes_of(const modal::ModesDocument& data, const ShapeWords& shape, ReportFolder& folder) {
  std::vector<ModePicture> modes;
  for (const modal::ModeRecord& mode : data.modes) {
    modes.emplace_back();
    modes.back().mode_index = mode.index;
    modes.back().frequency_hz = mode.frequency_hz;
  }
  const std::string file = data.files && data.files->modes ? *data.files->modes : "";
  const BodyModes body{file, "mode", shape.kind, without_twins(modes)};
  const auto pictures = mode_pictures({body}, folder);
  BodyFacts facts;
  facts.mass_kg = data.mass_kg;
  facts.n_nodes = data.n_nodes;
  facts.n_elements = data.n_elements;
  facts.none_missing = data.none_missing;
  return shape_view_html(body, 1, folder) + shapes_html(pictures.front()) + facts_html(facts);
}

Page make(const modal::ModesDocument& data, ReportFolder& folder) {
  Page page;
  const ShapeWords shape = shape_words(data.shape);
  page.over = "Klangprobe · modes of a body";
  page.title = shape.words.empty() ? "Result" : capitalised(shape.words);
  page.verdict = status_verdict(data.header);
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  std::string modes;
  if (const std::optional<Svg> ladder = modes_figure(data)) {
    folder.add_figure("modes", *ladder);
    modes = figure(sheet(*ladder), "");
  }
  page.sections = {{"modes", "Modes", modes + mode_table(data)}, {"shapes", "Shapes", shapes_of(data, shape, folder)}};
  add_table("modes.csv", csv_table(data.modes, {"mesh_relative_error"}), data.header.provenance.inputs, folder,
            page.downloads);
  if (data.files) add_if_there(data.files->modes, "– mode shapes for ParaView", folder, page.downloads);
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind modes_page() { return page_kind<modal::ModesDocument>("modes", make); }

}  // namespace klang::reports::detail
