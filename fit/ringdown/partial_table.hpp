#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/fields.hpp"

namespace klang::fit {

/// What a recording says about a line of its spectrum.
enum class PartialKind {
  kDecaying,  ///< rings and decays
  kWeak,      ///< decays, but lies 60 dB or more below the loudest: room, noise or misfit may have made it
  kTooShort,  ///< the recording is too short to tell whether it decays: no decay, and no evidence of a mode
  kSteady,    ///< does not decay: hum, a tone of the room
};
constexpr auto words_of(PartialKind) {
  return std::array{Word{PartialKind::kDecaying, "decaying"}, Word{PartialKind::kWeak, "weak"},
                    Word{PartialKind::kTooShort, "too_short"}, Word{PartialKind::kSteady, "steady"}};
}

/// One measured partial: amplitude exp(-decay_per_s t) cos(2 pi frequency_hz t + phase_rad), t from the
/// strike.
struct Partial {
  double frequency_hz = 0.0;
  std::optional<double> frequency_std_hz;
  std::optional<double> decay_per_s;
  std::optional<double> decay_std_per_s;
  std::optional<double> amplitude;  ///< full scale = 1
  std::optional<double> amplitude_std;
  std::optional<double> phase_rad;
  std::optional<double> phase_std_rad;
  PartialKind kind = PartialKind::kDecaying;
  std::string note;               ///< the nearest of equal temperament (name_notes); empty: not named
  std::optional<double> cents;    ///< above it
  std::optional<double> beat_hz;  ///< with the loudest ring next to it (name_pairs)
  std::string stage;              ///< of two decays at one frequency "early" or "late" (name_pairs); else empty

  /// Whether it may be held against a mode of a body: what is not known to decay is not.
  bool is_ring() const { return kind == PartialKind::kDecaying || kind == PartialKind::kWeak; }

  /// Without the phases, which only its own recording has.
  template <class Self, class Visitor>
  static void describe_ring(Self& self, Visitor&& visit) {
    visit(needed({"frequency_hz", "of the partial"}), self.frequency_hz);
    visit({"frequency_std_hz", "its standard deviation"}, self.frequency_std_hz);
    visit({"decay_per_s", "of the amplitude: exp(-decay t)"}, self.decay_per_s);
    visit({"decay_std_per_s", "its standard deviation"}, self.decay_std_per_s);
    visit({"amplitude",
           "when it is struck, full scale = 1; of several strikes at the one that amplitude_strike names, or that "
           "excites it most"},
          self.amplitude);
    visit({"amplitude_std", "its standard deviation"}, self.amplitude_std);
  }
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    describe_ring(self, visit);
    visit({"phase_rad", "at the same strike: cos(2 pi f t + phase)"}, self.phase_rad);
    visit({"phase_std_rad", "its standard deviation"}, self.phase_std_rad);
    visit({"kind",
           "decaying; weak: 60 dB or more below the loudest, each at the strike that excites it most; too_short: the "
           "recording does not tell "
           "whether it decays; steady: it does not"},
          self.kind);
    visit(absent_if_empty({"note", "the nearest of equal temperament, by A4"}), self.note);
    visit(absent_if_empty({"cents", "above that note"}), self.cents);
    visit(
        absent_if_empty({"beat_hz", "beats with the loudest ring beside it (within 20 Hz and 20 dB): their distance"}),
        self.beat_hz);
    visit(absent_if_empty({"stage", "of two decays at one frequency: early (the faster) or late"}), self.stage);
  }
};

struct PartialTable {
  std::vector<Partial> partials;                   ///< ascending in frequency
  std::string origin;                              ///< the recording or file
  std::vector<std::string> left_out_columns = {};  ///< of a CSV: those of names that mean nothing here
};

/// CSV with a header line (frequency_hz required; the other names of Partial optional, an empty cell is "not
/// measured") or JSON as klang analyze writes it (by extension). Frequencies and standard deviations are
/// above 0, decays and amplitudes at least 0; kind is a word, "decaying" where it is missing. Lines that are empty or start with # are skipped; rows come
/// back ascending in frequency. In JSON null or a missing key is "not measured" and keys of other names are
/// left alone; in CSV so are columns, which left_out_columns names. Separators, quotes and decimal commas: CsvFile. InputError names file, line (or partials[index]),
/// column, value.
/// What follows from the others (note, cents, beat_hz, stage, matched_mode) is not read. Where a column `specimen` (in JSON: the specimens of a
/// fit.json) names several specimens, the rows of this one are taken.
/// @param specimen  its name; empty: the file holds one specimen
PartialTable read_partial_table(const std::filesystem::path& path, std::string_view specimen = {});
PartialTable parse_partial_csv(std::string_view text, const std::string& name, std::string_view specimen = {});
PartialTable parse_partial_json(std::string_view text, const std::string& name, std::string_view specimen = {});

/// Names the nearest note of each.
void name_notes(std::vector<Partial>& partials, double a4_hz);

/// CSV with all thirteen columns; a number reads back to the same bits.
std::string partial_csv(const PartialTable& table);
void write_partial_table(const std::filesystem::path& path, const PartialTable& table);

}  // namespace klang::fit
