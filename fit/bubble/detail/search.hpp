#pragma once
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "fit/bubble/bubble_search.hpp"
#include "fit/bubble/damped_filter.hpp"

namespace klang::fit::bubble::detail {

inline constexpr double kChi2OfScore = 2.0;      // a ring's chi square is twice its best matched-filter score
inline constexpr std::size_t kMostTogether = 6;  // rings fitted in one least-squares problem
inline constexpr double kHeardSpan = 7.0;        // decay times until a ring is over (-61 dB)
// And so is what it leaves at any pitch while it begins.
inline constexpr double kOnsetFragmentEnergy = 0.003, kOnsetS = 0.003, kFarFragmentEnergy = 3e-4;
inline constexpr double kQuickAttack = 2.0;  // rate of the quick attack over the frequency: a twelfth of a cycle

/// Samples of a ring: from its onset until it is over.
struct Span {
  Eigen::Index first = 0, last = 0;
};

/// The search behind find_bubbles: what is left of the recording, what has been found, and the filters that look for more.
class Search {
 public:
  Search(const audio::Signal& recording, const BubbleSearchOptions& options, Monitor& monitor)
      : options_(options),
        monitor_(monitor),
        work_(std::make_shared<SearchWork>(monitor,
                                           options.max_work * (kWorkAtOnce + kWorkPerSecond * recording.duration_s()))),
        rate_(recording.sample_rate_hz) {
    result_.mono.sample_rate_hz = rate_;
    result_.mono.origin = recording.origin;
    result_.mono.samples = recording.samples.rowwise().mean();
    high_hz_ = std::min(options.band.high_hz, 0.45 * rate_);
    if (!(high_hz_ > options.band.low_hz))
      throw InputError(recording.origin, "band lies above 0.45 of the sample rate");
  }

  BubbleSearchResult run();
  std::vector<RingGroup> windows(const BubbleSearchResult& result);

 private:
  ChirpLaw law_at(double frequency_hz, const ChirpLaw& like) const;
  Span span_of(const Chirp& chirp) const;
  std::pair<double, double> band_of(const FoundBubble& bubble) const;
  ChirpWindow window_of(const std::vector<const FoundBubble*>& group) const;
  void add(const FoundBubble& bubble, double sign);
  std::optional<FoundBubble> fitted_near(const DampedFilterBank::Peak& peak, const DampedFilterBank::Atom& atom) const;
  double choose_attack(const ChirpWindow& own, FoundBubble& bubble, double chi_square, double share) const;
  double choose_rest(const ChirpWindow& own, FoundBubble& bubble, double chi_square) const;
  void choose_attacks();
  void choose_rests();
  bool overlap(const FoundBubble& a, const FoundBubble& b) const;
  bool plausible(const Chirp& chirp) const;
  void refit(const std::vector<std::size_t>& group, bool last);
  std::vector<std::vector<std::size_t>> groups() const;
  void make_filters();
  double band_edge(double frequency_hz) const;
  double noise_energy() const;
  void look_everywhere();
  void whiten(const Eigen::VectorXd& change, Eigen::Index first, Eigen::Index n);
  double energy_of(const FoundBubble& bubble) const;
  void mask(const FoundBubble& bubble);
  void prune();
  void judge(FoundBubble& bubble) const;

  BubbleSearchOptions options_;
  Monitor& monitor_;
  std::shared_ptr<SearchWork> work_;
  double rate_, high_hz_ = 0.0;
  BubbleSearchResult result_;
  Eigen::VectorXd residual_;
  Eigen::VectorXf whitened_;
  std::unique_ptr<DampedFilterBank> filters_;
};

/// Decay of the amplitude of a bubble of this radius that rings at omega [1/s].
double decay_of(const klang::bubble::BubbleMedium& medium, klang::bubble::BubbleTheory theory, double radius_m,
                double omega);

}  // namespace klang::fit::bubble::detail
