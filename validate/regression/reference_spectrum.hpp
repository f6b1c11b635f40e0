#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "validate/regression/sound_description.hpp"

namespace klang::validate {

/// Newest schema of a reference file that this program reads.
inline constexpr int kReferenceSchema = 1;

/// A partial of the reference; scatters are standard deviations between takes beyond those of the analyses.
struct ReferencePartial {
  fit::Partial partial;  ///< mean over the takes with its standard deviation; amplitude at the first take's level
  double frequency_scatter_cents = 0.0;
  double decay_scatter = 0.0;  ///< relative
  int n_takes = 1;             ///< in which it was found
};

/// What a sound is held against: one take, or several of the same object.
struct ReferenceSpectrum {
  std::string origin;  ///< of the takes, comma separated
  int n_takes = 0;
  /// Degrees of freedom behind the scatters of frequency, decay and levels; 0 with one take.
  double scatter_dof = 0.0, decay_scatter_dof = 0.0, level_scatter_dof = 0.0;
  double common_scatter_cents =
      0.0;  ///< of the takes' common shift where it is more than the partials' scatter explains
  double sample_rate_hz = 0.0, duration_s = 0.0;  ///< lowest, shortest
  double contact_s = 0.0;                         ///< longest of the takes
  Band band;
  std::vector<ReferencePartial> partials;  ///< ascending; found in more than half of the takes
  std::vector<double> occasional_hz;       ///< found in some takes only: neither missed nor superfluous
  Fingerprint fingerprint;                 ///< mean power at the first take's level
  std::vector<double> third_scatter_db;    ///< n_thirds: between takes, after alignment of the level
  double spectrum_scatter_db = 0.0;        ///< rms difference of a take's cells from the mean
  double ring_10db_s = 0.0;

  std::vector<fit::Partial> table() const;
};

/// Several takes of one object become one reference: takes are aligned by onset and level, partials are paired, means are
/// weighted by the inverse variances, and the scatter between takes is what exceeds the analyses' own deviations, of each partial
/// but with the strength of all (detail::moderated_scatter).
/// @throws InputError without a take
ReferenceSpectrum make_reference(const std::vector<SoundDescription>& takes);

/// Every key carries its unit; powers are levels in dB to 0.1 dB. docs/regression.md lists the keys.
nlohmann::json to_json(const ReferenceSpectrum& reference);

/// @param text  of a file that `klang regress make` wrote
/// @param name  for messages
/// @throws InputError: not JSON (or cut short), no reference, a newer schema, no partials, numbers out of range
ReferenceSpectrum parse_reference(std::string_view text, const std::string& name);

}  // namespace klang::validate
