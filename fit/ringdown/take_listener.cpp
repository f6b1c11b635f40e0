#include "fit/ringdown/take_listener.hpp"

#include <algorithm>
#include <cmath>

namespace klang::fit {
namespace {

constexpr double kBeforeS = 0.5;     ///< kept in front of a tap: what the rise is told against
constexpr double kQuietS = 1.0;      ///< kept where nothing rings
constexpr double kEdgeS = 0.1;       ///< taps so near to the end, or to a cut, are not judged yet
constexpr double kLeastRingS = 0.4;  ///< before a tap can have died away
constexpr double kLevelS = 0.2;      ///< that a level is taken over
constexpr double kDiedAway = 0.003;  ///< of the level after the strike: -50 dB

double level(const Eigen::Ref<const Eigen::VectorXd>& x) {
  return x.size() > 0 ? std::sqrt(x.squaredNorm() / static_cast<double>(x.size())) : 0.0;
}

}  // namespace

TakeListener::TakeListener(double sample_rate_hz, double rings_s)
    : sample_rate_hz_(sample_rate_hz), rings_s_(rings_s) {}

std::vector<TakeSound> TakeListener::heard(std::span<const float> samples) {
  samples_.insert(samples_.end(), samples.begin(), samples.end());
  return complete(false);
}

std::vector<TakeSound> TakeListener::rest() { return complete(true); }

/// Its last level is gone against its first one, or is down at what was there before it.
bool TakeListener::has_died_away(double strike_s, const audio::Signal& sound) const {
  const auto frames = [this](double s) { return static_cast<Eigen::Index>(std::llround(s * sample_rate_hz_)); };
  const Eigen::VectorXd x = sound.samples.col(0);
  const Eigen::Index strike = frames(strike_s), span = frames(kLevelS);
  if (x.size() - strike < frames(kLeastRingS)) return false;
  const double now = level(x.tail(span)), first = level(x.segment(strike, frames(kEdgeS)));
  const Eigen::Index before = std::max<Eigen::Index>(0, strike - frames(0.01));
  const double noise = before >= frames(kEdgeS) ? level(x.head(before).tail(std::min(before, span))) : 0.0;
  return now <= kDiedAway * first || (now <= 1.5 * noise && now <= 0.1 * first);
}

void TakeListener::forget(std::int64_t before_frame) {
  const auto n = std::clamp<std::int64_t>(before_frame - begin_frame_, 0, static_cast<std::int64_t>(samples_.size()));
  samples_.erase(samples_.begin(), samples_.begin() + n);
  begin_frame_ += n;
}

std::vector<TakeSound> TakeListener::complete(bool is_end) {
  rings_now_ = false;
  if (samples_.empty()) return {};
  audio::Signal sound;
  sound.sample_rate_hz = sample_rate_hz_;
  sound.samples =
      Eigen::Map<const Eigen::VectorXf>(samples_.data(), static_cast<Eigen::Index>(samples_.size())).cast<double>();
  const double begin_s = static_cast<double>(begin_frame_) / sample_rate_hz_, end_s = begin_s + sound.duration_s();
  // What rings on from a tap that was handed out, or from a cut, looks like a strike at the first frame.
  const double from_s =
      std::max(static_cast<double>(handed_frame_) / sample_rate_hz_, begin_frame_ > 0 ? begin_s + kEdgeS : 0.0);
  std::vector<TakeSound> takes = cut_takes(sound), done;
  std::erase_if(takes, [&](const TakeSound& take) { return begin_s + take.strike_s < from_s; });
  if (!is_end && !takes.empty() && end_s - (begin_s + takes.back().strike_s) < kEdgeS) {
    takes.pop_back();
    rings_now_ = true;
  }
  for (std::size_t i = 0; i < takes.size(); ++i) {
    TakeSound& take = takes[i];
    const bool is_last = i + 1 == takes.size();
    if (is_last && !is_end && sound.duration_s() - take.strike_s < rings_s_ && !has_died_away(take.strike_s, sound)) {
      rings_now_ = true;
      break;
    }
    take.strike_s += begin_s;
    handed_frame_ = is_last ? begin_frame_ + static_cast<std::int64_t>(samples_.size())
                            : std::llround((begin_s + takes[i + 1].strike_s - 0.01) * sample_rate_hz_);
    done.push_back(std::move(take));
    if (is_last) break;
  }
  const std::size_t n_done = done.size();
  const double keep_s = n_done < takes.size() ? begin_s + takes[n_done].strike_s - kBeforeS : end_s - kQuietS;
  forget(std::llround(std::max(0.0, keep_s) * sample_rate_hz_));
  return done;
}

}  // namespace klang::fit
