#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "fit/bubble/bubble_search.hpp"

namespace klang::fit::bubble {

/// How one bubble rose, known from elsewhere (a film of the drop, a liquid solver).
struct BubbleRise {
  double onset_s = 0.0;         ///< belongs to the bubble found within kRiseMatchS of it
  std::vector<double> times_s;  ///< since the onset, ascending; one entry: an even rise at speed_m_s from there
  std::vector<double> phi_m;    ///< signed distance to the surface, negative in the liquid
  double speed_m_s = 0.0;
};
inline constexpr double kRiseMatchS = 0.02;

/// CSV with columns onset_s,phi_m,speed_m_s (an even rise, one line per bubble) or onset_s,time_s,phi_m (one line per moment,
/// time_s since the onset, lines of a bubble together). @throws InputError with file and line
std::vector<BubbleRise> read_rises(const std::filesystem::path& path);

enum class PitchStatus {
  kNotRun,
  kSoundOnly,  ///< no rise was given: each bubble's own pitch rate and growth, no constants
  kFitted,
  kFailed
};
constexpr auto words_of(PitchStatus) {
  return std::array{Word{PitchStatus::kFitted, "fitted"}, Word{PitchStatus::kSoundOnly, "sound_only"},
                    Word{PitchStatus::kFailed, "failed"}};
}

/// A number, with its standard deviation and 95 % interval where the sound determines it.
struct PitchNumber {
  std::string name;  ///< with its unit, or a formula
  std::optional<double> value, standard_deviation, low95, high95;
  bool determined = false;  ///< relative standard deviation up to 20 %
};

struct PitchFitOptions {
  std::optional<double> phi0_m;  ///< known: K and eta follow each by itself
  double max_factor = 3.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"phi0_m", "phi0 of the pitch model, where it is known: separates K_delta and eta", between(-1.0, -1e-5)},
          self.phi0_m);
    visit({"max_factor", "No bubble's pitch rises above this times that at its onset", between(1.0, 1000.0)},
          self.max_factor);
  }
};

struct PitchFitResult {
  PitchStatus status = PitchStatus::kNotRun;
  std::string message;
  std::vector<PitchNumber> parameters;       ///< k_delta_per_m, eta, phi0_m
  std::vector<PitchNumber> identifiable;     ///< combinations that the data determine, whatever the rest
  std::size_t n_bubbles = 0;                 ///< that carry the joint fit
  std::vector<double> chi_square_per_datum;  ///< of the joint fit, by group of bubbles that overlap
};

/// Constants of HF eq. (6) shared by all bubbles with a known rise. Pitch depends on P = K e^eta |phi0| / eta and
/// q = eta / |phi0| only (pitch_formulas.hpp): with a rise both follow, with phi0 too K and eta do; with neither, only each
/// bubble's rate K v e^(eta (1 - d/|phi0|)) and growth eta v / |phi0|.
PitchFitResult fit_pitch(const BubbleSearchResult& found, const std::vector<BubbleRise>& rises,
                         const BubbleSearchOptions& search, const PitchFitOptions& options = {},
                         Monitor& monitor = silent_monitor());

}  // namespace klang::fit::bubble
