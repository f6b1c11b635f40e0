// The page of klang chime: a cut list that prints, and the set's sound.
#include "core/foundation/config/fields_csv.hpp"
#include "fit/instrument/chime_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/sound_media.hpp"

namespace klang::reports::detail {
namespace {

std::string millimetres(const std::optional<double>& length_m, int decimals) {
  return length_m ? fixed(1e3 * *length_m, decimals) : "—";
}

std::string cut_list(const fit::ChimeDocument& data) {
  std::string body;
  for (const fit::ChimeNote& note : data.notes) {
    const int decimals = note.length_std_m ? decimals_for(1e3 * *note.length_std_m, 2) : 2;
    body +=
        "<tr>" + tag("th", escaped(note.note), "scope=\"row\"") +
        number_cell(fixed(note.frequency_hz, 2), note.frequency_hz) +
        number_cell("<b>" + millimetres(note.length_m, decimals) + "</b>" +
                        (note.length_std_m ? " ± " + millimetres(note.length_std_m, decimals) : "") +
                        (note.length_caveat.empty() ? "" : "<br><small>" + escaped(note.length_caveat) + "</small>"),
                    note.length_m) +
        number_cell(fixed(note.cents_per_tenth_mm, 2), note.cents_per_tenth_mm) +
        number_cell(millimetres(note.node_m, 1), note.node_m) +
        number_cell(millimetres(note.node_rule_m, 1), note.node_rule_m) + tag("td", escaped(note.specimen)) + "</tr>\n";
  }
  return scrolled(
      "<table><caption>Cut a little long and file: each 0.1 mm less raises the note by the cents given. Hang each "
      "chime at "
      "its nodes, that far from both ends.</caption><thead><tr><th scope=\"col\">Note</th><th class=\"n\" "
      "scope=\"col\">Frequency [Hz]</th><th class=\"n\" scope=\"col\">Length [mm]</th><th class=\"n\" "
      "scope=\"col\">Cents per "
      "0.1 mm longer</th><th class=\"n\" scope=\"col\">Node from an end, by the model [mm]</th><th class=\"n\" "
      "scope=\"col\">by "
      "the 22.4 % rule [mm]</th><th scope=\"col\">Cut from the stock of</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Cut list");
}

Page make(const fit::ChimeDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · a set of chimes";
  page.title = data.name.empty() ? "Chimes" : data.name;
  page.verdict = status_verdict(data.header);
  page.sentences = {"Lengths for <b>" + counted(data.notes.size(), "note", "notes") +
                        "</b>, A4 = " + rounded(data.a4_hz, 5) + " Hz, " + escaped(data.temperament) + " temperament.",
                    data.damping == "fitted"
                        ? "The set sounds with the fitted damping."
                        : "<b>The damping of the sound is assumed</b>: the fit measured no decay."};
  KeyFigures keys;
  keys.add("Notes", std::to_string(data.notes.size()));
  keys.add("A4", rounded(data.a4_hz, 5) + "\u202fHz", escaped(data.temperament));
  page.key_figures = keys.html();
  SoundPair sounds;
  sounds.name = data.name;
  sounds.recorded = folder.sound_beside(data.sound.value_or(""));
  sounds.recorded_words = "The set";
  for (const fit::ChimeNote& note : data.notes)
    sounds.highest_hz = std::max(sounds.highest_hz, 6.0 * note.frequency_hz);
  const SoundMedia media = sound_media(sounds, 1, folder);
  page.sections = {
      {"cut-list", "Cut list", cut_list(data)},
      {"sound", "Sound", players(media, sounds) + spectrogram_html(media, "", "The set, one strike each.")}};
  add_table("cut-list.csv", csv_table(data.notes), data.header.provenance.inputs, folder, page.downloads);
  add_if_there(data.sound, "– the set, one strike each", folder, page.downloads);
  return page;
}

}  // namespace

PageKind chime_page() { return page_kind<fit::ChimeDocument>("chime", make); }

}  // namespace klang::reports::detail
