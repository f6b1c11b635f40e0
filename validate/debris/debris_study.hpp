#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/modal/damping/rayleigh.hpp"
#include "core/physics/solid/material.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/soundbank/soundbank.hpp"
#include "datasets-synthetic/debris.hpp"
#include "fit/proxy/proxy_sound.hpp"

namespace klang::validate {

/// Where a blow meets the proxy.
enum class ProxyContact {
  kNormal,  ///< where the ellipsoid's normal opposes the force, SB eqs. 23, 24
  kPlace    ///< where the body is hit, soundbank::point_of_place
};
constexpr auto words_of(ProxyContact) {
  return std::array{Word{ProxyContact::kNormal, "normal"}, Word{ProxyContact::kPlace, "place"}};
}

struct DebrisStudyOptions {
  datasets::DebrisOptions debris;  ///< its seed also draws strikes, listeners and onsets
  solid::Material material =
      solid::from_youngs_modulus(6.2e10, 0.2, 2600.0);  ///< glass of SB Table 1; must be the bank's
  double highest_hz = 20000.0;                          ///< at most 0.45 sample_rate_hz
  /// Quadratic elements to the shortest shear wave or thin plate's bending wave (in thick pieces real ones are up to a quarter
  /// shorter).
  double elements_per_wavelength = 6.0;
  int polynomial_degree = 6;                                                  ///< of the single-frequency calculation
  damping::RayleighDamping damping{.stiffness_s = 1e-7, .mass_per_s = 10.0};  ///< not both 0
  double impulse_n_s = 0.01;
  double contact_duration_s = 1e-5;              ///< standard deviation of the Gaussian pulse
  double friction_deg = 20.0;                    ///< to the inward normal
  ProxyContact contact = ProxyContact::kNormal;  ///< of the proxy
  double listener_m = 1.0;                       ///< from each piece's centre of mass, beyond the body
  double duration_s = 1.0;
  double mix_s = 1.0;
  double sample_rate_hz = 48000.0;
  int n_partials = 10;
  int n_thresholds = 8;
  int proxy_repeats = 1;  ///< more are steadier, with warm caches
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"debris", "The pieces"}, self.debris);
    visit({"highest_hz", "Modes up to here are heard", between(1000.0, 0.45 * 192000.0)}, self.highest_hz);
    visit({"elements_per_wavelength", "Finite elements to the shortest wave, direct way", between(2.0, 20.0)},
          self.elements_per_wavelength);
    visit({"polynomial_degree", "Of the polynomials that give the lowest frequency", between(2.0, 10.0)},
          self.polynomial_degree);
    visit({"rayleigh_mass_per_s", "Damping: mass coefficient", between(0.0, 1e4)}, self.damping.mass_per_s);
    visit({"rayleigh_stiffness_s", "Damping: stiffness coefficient", between(0.0, 1e-4)}, self.damping.stiffness_s);
    visit({"impulse_n_s", "Impulse of each strike", between(1e-6, 100.0)}, self.impulse_n_s);
    visit({"contact_duration_s", "Duration of each strike", between(0.0, 0.01)}, self.contact_duration_s);
    visit({"friction_deg", "Largest angle of a strike's force to the normal", between(0.0, 80.0)}, self.friction_deg);
    visit({"contact",
           "Where a blow meets the proxy: normal (where its normal opposes the force) or place (where the body is "
           "hit)"},
          self.contact);
    visit({"listener_m", "Distance of the listener from each piece", between(1e-3, 1000.0)}, self.listener_m);
    visit({"duration_s", "Length of each piece's sound", between(0.05, 10.0)}, self.duration_s);
    visit({"mix_s", "The strikes of the mix fall within this time", between(0.0, 60.0)}, self.mix_s);
    visit({"sample_rate_hz", "Sample rate", between(8000.0, 192000.0)}, self.sample_rate_hz);
    visit({"n_partials", "First partials that are compared", between(1.0, 40.0)}, self.n_partials);
    visit({"n_thresholds", "Points of the curve", between(2.0, 100.0)}, self.n_thresholds);
    visit({"proxy_repeats", "The proxy's way is timed as the mean of so many", between(1.0, 1000.0)},
          self.proxy_repeats);
  }
};

/// Processor time of all threads [s], stage by stage.
struct DirectTimes {
  double mesh_s = 0.0, modes_s = 0.0, transfer_s = 0.0, audio_s = 0.0;
  double total_s() const { return mesh_s + modes_s + transfer_s + audio_s; }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"mesh_s", "TetGen"}, self.mesh_s);
    visit({"modes_s", "finite elements"}, self.modes_s);
    visit({"transfer_s", "boundary elements and multipoles"}, self.transfer_s);
    visit({"audio_s", "the sound"}, self.audio_s);
  }
};
struct ProxyTimes {
  double lowest_s = 0.0;     ///< the single-frequency calculation
  double retrieval_s = 0.0;  ///< moments, rotation, lookup
  double transfer_s = 0.0;   ///< scaled modes and multipoles, pressure at the listener
  double audio_s = 0.0;
  double total_s() const { return lowest_s + retrieval_s + transfer_s + audio_s; }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"lowest_s", "the single-frequency calculation"}, self.lowest_s);
    visit({"retrieval_s", "moments, rotation, lookup"}, self.retrieval_s);
    visit({"transfer_s", "scaled modes and multipoles"}, self.transfer_s);
    visit({"audio_s", "the sound"}, self.audio_s);
  }
};

struct DebrisPieceResult {
  std::string name;
  double volume_m3 = 0.0;
  int n_elements = 0;
  double lowest_direct_hz = 0.0;  ///< of the mesh
  double lowest_hz = 0.0;  ///< by modal::lowest_frequency_hz: what fixes the proxy's scale and decides about its use
  int n_modes = 0;         ///< up to highest_hz, of the mesh
  int n_proxy_modes = 0;   ///< the same of the proxy
  bool bank_too_short = false;                     ///< the bank's cell ends below highest_hz
  bool clamped = false;                            ///< thinner than the bank
  Eigen::Vector3d axes = Eigen::Vector3d::Zero();  ///< of the proxy, length 1
  double scale_m = 0.0, cell_distance = 0.0;
  double onset_s = 0.0;  ///< in the mix
  DirectTimes direct;
  ProxyTimes proxy;
  std::optional<fit::ProxyErrors> errors;  ///< empty where one of the two is silent
};

/// Pieces whose lowest frequency lies above the threshold sound by their proxies (SB section 5.4).
struct DebrisThreshold {
  double threshold_hz = 0.0;
  int n_replaced = 0;
  double modes_replaced_percent = 0.0;
  double direct_s = 0.0,
         with_proxies_s = 0.0;  ///< processor time; with proxies the single-frequency calculation of every piece counts
  double log_spectral_distance_db = 0.0, mel_distance_db = 0.0, third_octave_db = 0.0,
         loudness_difference_db = 0.0;  ///< mix against the all-direct mix
};

enum class DebrisStudyStatus { kNotRun, kDone };
struct DebrisStudyResult {
  DebrisStudyStatus status = DebrisStudyStatus::kNotRun;
  std::vector<DebrisPieceResult> pieces;
  std::vector<DebrisThreshold> thresholds;  ///< ascending: from all replaced to none
  audio::Signal direct_mix, proxy_mix;      ///< Pa
  double preparation_s =
      0.0;  ///< of the bank, once; in both sums of the proxies. Reading and building the bank is in none
  double direct_s = 0.0, proxy_s = 0.0, proxy_without_lowest_s = 0.0;
};

/// Debris the direct way and by proxies, in one run. Direct: TetGen, finite elements, boundary elements with the options of `klang transfer`,
/// multipoles at the listener. Proxy: lowest frequency from the surface, moments, nearest cell, its scaled multipoles at the listener.
/// Both: sum_i |p_i(x)| omega_i q_i(t) (SB eq. 8) of a strike at a random place of the surface, its force within friction_deg of the inward
/// normal; the proxy's contact by `contact`, force and listener turned by R. Pieces one after the other; all but the
/// times are the same bits for the same options.
/// @throws InputError for options, a bank without sound or of another material; NumericalError where a direct solution fails; Interrupted
DebrisStudyResult debris_study(const soundbank::Soundbank& bank, const DebrisStudyOptions& options = {},
                               Monitor& monitor = silent_monitor());
/// The same of given pieces: closed surfaces, normals outward. @throws InputError for no pieces
DebrisStudyResult debris_study(const soundbank::Soundbank& bank, const std::vector<datasets::DebrisPiece>& pieces,
                               const DebrisStudyOptions& options, Monitor& monitor = silent_monitor());

}  // namespace klang::validate
