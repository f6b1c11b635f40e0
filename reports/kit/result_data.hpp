#pragma once
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// A result JSON (docs/result-json.md) with types. Everything that a file may leave out is optional.
namespace klang::reports::detail {

using Number = std::optional<double>;

struct Estimate {
  std::string name;
  Number value, std;
  std::optional<std::array<double, 2>> ci95;
  bool identifiable = false;
  std::string why;
  Number start_value;
  bool derived = false;
};

struct DampingModel {
  std::string model;
  std::vector<Estimate> parameters;
  Number aicc, aicc_weight, rms_relative_residual;
  std::vector<double> curve_frequency_hz, curve_decay_per_s;  ///< same length
};

struct Match {
  std::string specimen;
  int mode_index = -1;
  double frequency_hz = 0, model_frequency_hz = 0, deviation_cents = 0;
  Number frequency_std_hz, decay_per_s, decay_std_per_s, model_decay_per_s, radiation_decay_per_s, mount_decay_per_kg,
      model_frequency_std_hz;
};

struct Predicted {
  std::string specimen;
  int mode_index = -1;
  double frequency_hz = 0;
  Number decay_per_s;
};

struct Partial {
  double frequency_hz = 0;
  Number frequency_std_hz, decay_per_s, decay_std_per_s, amplitude, amplitude_std, phase_rad, phase_std_rad;
  std::optional<int> matched_mode;
};

struct Mode {
  int index = 0;
  double frequency_hz = 0;
  Number relative_residual;
};

/// A specimen of a fit; the one recording of an analysis; the one body of a modes result.
struct Specimen {
  std::string name;
  std::string shape;  ///< in words: "tube, length 505 mm, outer radius 12.5 mm, wall 1 mm"
  std::string shape_kind;
  Number mass_kg, rms_deviation_cents, max_deviation_cents, explained_energy, noise_rms, sample_rate_hz, duration_s;
  std::optional<int> n_nodes, n_elements, n_channels;
  std::optional<bool> none_missing;
  bool predicted = false;  ///< no part of the fit: a test of it
  std::vector<Partial> partials;
  std::vector<double> strikes_s;
  std::vector<Mode> modes;  ///< modes result only
  std::string element;
  std::optional<int> n_rigid_modes;
  /// Names in the result's folder, empty where there is none.
  std::string recording, resynthesis, modes_file;
};

struct ProvenanceInput {
  std::string path, sha256;
  Number n_bytes;
};

struct StudyLevel {
  Number h_m, n, error, value, n_unknowns, pairwise_order;
  std::string excluded;  ///< why it is not in the fit, empty where it is
};

struct StudySeries {
  std::string id, title, reference, step, error, kind, floor, verdict;
  Number observed_order, expected_order, order_tolerance, error_tolerance, error_floor;
  std::optional<std::array<double, 2>> order_ci95;
  std::optional<bool> asymptotic;
  bool counts = true, passed = false, higher_is_fine = false;
  Number gci_order, gci_fine, gci_ratio, gci_extrapolated, gci_exact;
  std::vector<StudyLevel> levels;
};

struct StudyClaim {
  std::string name, words;
  Number measured, reference, tolerance;
  bool passed = false;
  std::string not_judged;  ///< why, empty where it was
};

enum class FieldKind { kSurface, kSlice, kBalloon };
struct StudyField {
  FieldKind kind = FieldKind::kSurface;
  std::string name, title, caption, file, quantity;
  bool decibels = false;
  double floor = 0;
};

struct StudyData {
  std::string name, title, question;
  bool passed = false;
  std::vector<StudySeries> series;
  std::vector<StudyClaim> claims;
  std::vector<StudyField> fields;
};

struct BubbleRow {
  double onset_s = 0, end_s = 0, frequency_start_hz = 0, frequency_end_hz = 0, decay_per_s = 0, radius_m = 0;
  Number frequency_std_hz, decay_std_per_s, theory_decay_per_s, radius_std_m, snr_db;
  std::string verdict;
  bool is_bubble = true;
  std::vector<double> track_time_s, track_frequency_hz;  ///< same length
};

struct BubbleData {
  std::vector<BubbleRow> rows;  ///< bubbles, then other rings
  std::vector<double> theory_frequency_hz, theory_decay_per_s;
  std::string pitch_status, pitch_message;
  std::vector<Estimate> pitch;  ///< constants, then combinations
};

struct RegressionPartial {
  std::optional<Partial> reference, sound;
  Number cents, cents_tolerance, decay_change, decay_tolerance;
  std::string note;
};

struct RegressionThird {
  double centre_hz = 0;
  Number reference_db, sound_db, difference_db, tolerance_db;
};

struct RegressionData {
  std::vector<StudyClaim> claims;
  std::vector<RegressionPartial> partials;
  std::vector<RegressionThird> thirds;
  std::string reference_origin;
  std::optional<int> reference_takes;
  Number gain_db, factor, log_spectral_distance_db, ring_10db_s, reference_ring_10db_s;
  std::vector<double> times_s, bands_hz;
  std::vector<std::vector<double>> reference_db, sound_db;  ///< [band][time]
};

struct PaperRow {
  std::string paper, place, quantity, reference_source, tolerance_source, note, verdict;
  Number printed, ours, reference, tolerance;
};

struct PaperGapRow {
  std::string paper, place, reason;
};

struct PapersData {
  std::vector<PaperRow> numbers;
  std::vector<PaperGapRow> gaps;
};

struct ProxyPieceRow {
  std::string name;
  double lowest_hz = 0;
  int n_modes = 0, n_proxy_modes = 0;
  bool bank_too_short = false, clamped = false;
  Number lowest_direct_hz, partial_rms_cents, log_spectral_distance_db, mel_distance_db, third_octave_db,
      loudness_difference_db, direct_s, proxy_s;
};

struct ProxyThresholdRow {
  double threshold_hz = 0, modes_replaced_percent = 0;
  int n_replaced = 0;
  Number log_spectral_distance_db, mel_distance_db, third_octave_db, loudness_difference_db, direct_s, with_proxies_s;
};

struct ProxyStudyData {
  std::vector<ProxyPieceRow> pieces;
  std::vector<ProxyThresholdRow> thresholds;
  std::vector<std::pair<std::string, double>> direct_stages, proxy_stages;  ///< processor time of all pieces [s]
  Number speedup, speedup_without_lowest;
  std::string direct_sound, proxy_sound;  ///< files beside the result
};

/// A fit of an ellipsoid to a body's sound.
struct ProxyFitData {
  struct Measure {
    std::string name;
    double before = 0, after = 0;
    std::optional<int> n_worse;  ///< proxies tried that were worse in it than the start
  };
  struct Ellipsoid {
    std::array<double, 3> axes_m{};
    double scale_m = 0, rayleigh_mass_per_s = 0, rayleigh_stiffness_s = 0, gain = 0;
  };
  struct Line {
    double frequency_hz = 0, decay_per_s = 0, amplitude = 0;
  };
  std::vector<Measure> measures;
  Ellipsoid start, fitted;
  std::vector<Line> target, before, after;  ///< by rank, same length
  int n_fitted = 0;                         ///< first partials that were compared in cents
  Number least_partial_rms_cents;
  std::optional<int> n_candidates, n_refused;
  bool improved = false;
  std::string sound, loudness, target_kind;
};

struct ResultData {
  std::string
      kind;  ///< "fit", "analysis", "modes", "study", "bubbles", "regression", "papers", "proxy_study", "proxy_fit"
  std::string name;
  std::string status, message;
  std::string material;  ///< a preset's name, where the file has one
  Number density_kg_m3;
  std::vector<Estimate> parameters;
  std::vector<std::string> correlation_names;
  std::vector<std::vector<Number>> correlation;
  std::string damping_model;
  std::vector<DampingModel> damping;
  std::vector<Match> matches;
  std::vector<Predicted> predicted;
  std::vector<Specimen> specimens;  ///< none in a study
  StudyData study;                  ///< of a study
  BubbleData bubbles;               ///< of bubbles, beside the one specimen
  RegressionData regression;        ///< of a regression
  PapersData papers;                ///< of the papers' numbers
  ProxyStudyData proxy_study;       ///< of a study of proxies
  ProxyFitData proxy;               ///< of a proxy fit
  Number cost_initial, cost_final, n_iterations, peak_memory_bytes;
  std::vector<std::string> warnings;
  std::string version, command, seed, options;
  std::vector<ProvenanceInput> inputs;
  std::vector<std::pair<std::string, double>> wall_time_s;
};

/// Reads a result file of schema 1.
/// @throws InputError naming the file and the key: not JSON, another schema or kind, a value of the wrong
/// type.
ResultData read_result(const std::filesystem::path& result_json);

/// How far matches are off, of the specimens that were fitted or of those that were predicted.
struct MatchSummary {
  std::size_t n_partials = 0, n_matched = 0;
  double rms_cents = 0.0;
  const Match* worst = nullptr;  ///< nullptr without a match
};
MatchSummary match_summary(const ResultData& data, bool predicted);

}  // namespace klang::reports::detail
