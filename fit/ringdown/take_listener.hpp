#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "fit/ringdown/takes.hpp"

namespace klang::fit {

/// Taps of a sound that is still coming in, each handed out as soon as it is complete: the next one has come, it has died away, or it
/// has rung for long enough. Keeps no more of the sound than the tap that rings and a second of what was before.
class TakeListener {
 public:
  /// @param rings_s  a tap that has rung so long is complete
  TakeListener(double sample_rate_hz, double rings_s);

  /// The taps that are complete with these samples (one channel); their times count from the first sample of all.
  std::vector<TakeSound> heard(std::span<const float> samples);
  /// What still rings when the sound has ended.
  std::vector<TakeSound> rest();
  /// A tap has come that is not complete.
  bool rings() const { return rings_now_; }

 private:
  std::vector<TakeSound> complete(bool is_end);
  bool has_died_away(double strike_s, const audio::Signal& sound) const;
  void forget(std::int64_t before_frame);

  double sample_rate_hz_, rings_s_;
  std::vector<float> samples_;
  std::int64_t begin_frame_ = 0;   ///< of samples_, from the first sample of all
  std::int64_t handed_frame_ = 0;  ///< what lies before belongs to taps that were handed out
  bool rings_now_ = false;
};

}  // namespace klang::fit
