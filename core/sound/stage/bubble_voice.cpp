#include "core/sound/stage/bubble_voice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/stage/ring_sound.hpp"

namespace klang::stage {
namespace {

using bubble::RingBlock;
using events::BubbleBirth;
using Complex = std::complex<double>;

constexpr std::size_t kBubblesAJob = 32, kJobsABatch = 64;  // fixed: the order of summation does not know the threads
constexpr double kSeriesBlockS = 5e-4;                      // where the transfer comes from a file

// Gains of a bubble in each channel at both ends of each block, and its arrival.
struct SoundingBubble {
  bubble::RingTrack track;
  std::array<std::vector<Complex>, 2> gain_start, gain_end;
  std::array<double, 2> onset_s{};
  SoundedBubble summary;
  bool too_high = false;
};

// How one listener hears bubbles.
class Hearing {
 public:
  Hearing(const BubbleSettings& settings, const Listener& listener, double sample_rate_hz)
      : settings_(settings), listener_(listener), sample_rate_hz_(sample_rate_hz) {}

  SoundingBubble hear(const BubbleBirth& birth, const BubbleSource& source) const {
    SoundingBubble sounding;
    sounding.track = track_of(birth, source);
    const auto& blocks = sounding.track.blocks;
    double highest = 0.0;
    for (const RingBlock& block : blocks) highest = std::max({highest, block.rate_start.imag(), block.rate_end.imag()});
    const double faded_s = sounding.track.faded_from_s;
    sounding.summary = {blocks.front().rate_start.imag() / (2 * kPi),
                        sounding.track.block_at(faded_s).rate_at(faded_s).imag() / (2 * kPi),
                        sounding.track.decay_start_per_s, sounding.track.amplitude_m, 0.0};
    sounding.too_high = !(highest / (2 * kPi) < audio::highest_rendered_hz(sample_rate_hz_));
    if (sounding.too_high) return sounding;

    const double air_m_s = settings_.air_sound_speed_m_s;
    const Eigen::Vector3d birth_place = source.motion->position_m(0.0);
    for (int c = 0; c < listener_.n_channels(); ++c) {
      // Against the earliest sound that the ears could hear, so that nothing comes before its birth.
      const double delay = listener_.way_s(c, birth.time_s, birth_place, air_m_s) + listener_.lead_s(air_m_s);
      const auto channel = static_cast<std::size_t>(c);
      sounding.onset_s[channel] = birth.time_s + delay;
      for (const RingBlock& block : blocks) {
        const double end_s = block.start_s + block.length_s;
        sounding.gain_start[channel].push_back(gain(birth, source, c, delay, block.start_s, block.rate_start));
        sounding.gain_end[channel].push_back(gain(birth, source, c, delay, end_s, block.rate_end));
        const double level = std::exp(block.log_start.real()) * std::abs(sounding.gain_start[channel].back());
        sounding.summary.peak = std::max(sounding.summary.peak, level);
      }
    }
    return sounding;
  }

 private:
  bubble::RingTrack track_of(const BubbleBirth& birth, const BubbleSource& source) const {
    bubble::RingingBubble ringing{birth.radius_m,  0.0,          settings_.medium, settings_.theory,
                                  settings_.pitch, source.motion};
    const double unit = settings_.printed_excitation
                            ? bubble::printed_entrainment(birth.radius_m, settings_.medium)
                            : bubble::entrainment_velocity_m_s(birth.radius_m, settings_.medium, settings_.theory);
    ringing.onset_velocity_m_s = birth.strength * unit;
    bubble::RingOptions options;
    if (source.transfer && settings_.transfer != SceneTransfer::kUnit) options.longest_block_s = kSeriesBlockS;
    return ring_track(ringing, options);
  }
  Complex gain(const BubbleBirth& birth, const BubbleSource& source, int channel, double delay_s, double age_s,
               Complex rate) const {
    const double t = birth.time_s + age_s, air_m_s = settings_.air_sound_speed_m_s;
    const Eigen::Vector3d place = source.motion->position_m(age_s);
    Complex transfer = 1.0;
    if (settings_.transfer != SceneTransfer::kUnit) {
      transfer = source.transfer
                     ? source.transfer->at(t, rate.imag() / (2 * kPi))
                     : half_space_transfer(settings_, birth.radius_m, place, listener_.ear_m(channel, t), rate);
    }
    if (!listener_.stereo()) return std::abs(transfer);
    const double omega = rate.imag();
    const double later_s = listener_.way_s(channel, t, place, air_m_s) + listener_.lead_s(air_m_s) - delay_s;
    return transfer * listener_.shadow(channel, t, place, omega) * std::polar(1.0, -omega * later_s);
  }
  const BubbleSettings& settings_;
  const Listener& listener_;
  double sample_rate_hz_;
};

struct JobSound {
  std::int64_t first = 0;
  std::array<std::vector<double>, 2> samples;
};

// What the jobs of one voice share.
struct Jobs {
  const std::string& name;
  const Hearing& hearing;
  const Mix& mix;
  const std::vector<BubbleBirth>& births;
  const std::vector<BubbleSource>& sources;
  std::vector<SoundedBubble>& summaries;
  std::vector<char>& too_high;
  bool soft_attack;
};

JobSound render_job(const Jobs& jobs, std::span<const std::size_t> members) {
  std::vector<SoundingBubble> sounding;
  sounding.reserve(members.size());
  std::vector<std::array<RingSound, 2>> rings;
  FrameRange all{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
  for (const std::size_t i : members) {
    try {
      sounding.push_back(jobs.hearing.hear(jobs.births[i], jobs.sources[i]));
    } catch (const InputError& error) {
      throw InputError(jobs.name + ", number " + std::to_string(i + 1), error.what());
    }
    const SoundingBubble& one = sounding.back();
    jobs.summaries[i] = one.summary;
    jobs.too_high[i] = one.too_high ? 1 : 0;
    if (one.too_high) continue;
    rings.emplace_back();
    for (int c = 0; c < jobs.mix.n_channels(); ++c) {
      const auto channel = static_cast<std::size_t>(c);
      RingSound& ring = rings.back()[channel];
      ring = {&one.track, one.onset_s[channel], one.gain_start[channel], one.gain_end[channel], jobs.soft_attack};
      const FrameRange range = frames_of(ring, jobs.mix.sample_rate_hz());
      all = {std::min(all.first, range.first), std::max(all.end, range.end)};
    }
  }
  JobSound job;
  if (rings.empty()) return job;
  // Nothing before time 0 or after the given end is kept, so nothing is made.
  all.first = std::max<std::int64_t>(all.first, 0);
  if (jobs.mix.n_frames()) all.end = std::min<std::int64_t>(all.end, *jobs.mix.n_frames());
  if (all.first >= all.end) return job;
  job.first = all.first;
  for (int c = 0; c < jobs.mix.n_channels(); ++c) {
    const auto channel = static_cast<std::size_t>(c);
    job.samples[channel].assign(static_cast<std::size_t>(all.end - all.first), 0.0);
    for (const auto& ring : rings) add_ring(ring[channel], jobs.mix.sample_rate_hz(), all.first, job.samples[channel]);
  }
  return job;
}

// Where the log's bubbles move, by the samples of their paths.
std::vector<BubbleSource> sources_of(const events::EventLog& log) {
  std::vector<BubbleSource> sources;
  const std::vector<std::vector<events::BubblePoint>> paths = log.bubble_paths();
  for (std::size_t i = 0; i < log.bubbles.size(); ++i) {
    const BubbleBirth& birth = log.bubbles[i];
    bubble::SampledMotion samples;
    for (const events::BubblePoint& point : paths[i]) {
      samples.times_s.push_back(point.time_s - birth.time_s);
      samples.positions_m.push_back(point.position_m);
      samples.phi_m.push_back(point.phi_m);
    }
    const bool born_late = !paths[i].empty() && samples.times_s.front() > 0.0;
    if (born_late) throw InputError("bubbles[" + std::to_string(i) + "]", "its path starts after its birth");
    sources.push_back({paths[i].empty() ? bubble::analytic_rise(birth.position_m, birth.radius_m)
                                        : bubble::sampled_motion(std::move(samples)),
                       nullptr});
  }
  return sources;
}

}  // namespace

Complex half_space_transfer(const BubbleSettings& settings, double radius_m, const Eigen::Vector3d& bubble_m,
                            const Eigen::Vector3d& listener_m, Complex rate) {
  const Eigen::Vector3d way(listener_m.x() - bubble_m.x(), listener_m.y() - bubble_m.y(), listener_m.z());
  const double distance = way.norm(), sine_sq = 1.0 - std::pow(way.z() / distance, 2), omega = rate.imag();
  const double in_air = omega / settings.air_sound_speed_m_s,
               in_liquid = omega / settings.medium.liquid_sound_speed_m_s;
  const double vertical_sq = in_air * in_air * sine_sq - in_liquid * in_liquid;
  const double reach = std::max(0.0, -bubble_m.z()) * std::sqrt(std::abs(vertical_sq));
  const Complex surface = vertical_sq > 0.0 ? Complex(std::exp(-reach), 0.0) : std::polar(1.0, -reach);
  return 2.0 * settings.air_density_kg_m3 * radius_m * radius_m / distance * rate * rate * surface;
}

BubbleVoice::BubbleVoice(BubbleSettings settings, std::vector<BubbleSource> sources)
    : settings_(std::move(settings)), sources_(std::move(sources)) {}

void BubbleVoice::add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) {
  const std::size_t n = log.bubbles.size();
  if (n == 0) return;
  if (!listener.has_place()) throw InputError("listener", "has no place, which bubbles need");
  const std::vector<BubbleSource> sampled = sources_.empty() ? sources_of(log) : std::vector<BubbleSource>{};
  const std::vector<BubbleSource>& sources = sources_.empty() ? sampled : sources_;
  KLANG_CHECK(sources.size() == n, "one source for each bubble of the log");
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return log.bubbles[a].time_s < log.bubbles[b].time_s; });

  const Hearing hearing(settings_, listener, mix.sample_rate_hz());
  bubbles_.assign(n, {});
  std::vector<char> too_high(n, 0);
  const Jobs all{settings_.name, hearing, mix, log.bubbles, sources, bubbles_, too_high, settings_.soft_attack};
  const std::size_t n_jobs = (n + kBubblesAJob - 1) / kBubblesAJob;
  for (std::size_t batch = 0; batch < n_jobs; batch += kJobsABatch) {
    const std::size_t in_batch = std::min(kJobsABatch, n_jobs - batch);
    std::vector<JobSound> jobs(in_batch);
    for_each_job(
        in_batch,
        [&](std::size_t j) {
          const std::size_t from = (batch + j) * kBubblesAJob, until = std::min(n, from + kBubblesAJob);
          jobs[j] = render_job(all, std::span(order).subspan(from, until - from));
        },
        "bubbles", monitor);
    for (const JobSound& job : jobs) {
      for (int c = 0; c < mix.n_channels(); ++c) mix.add(c, job.first, job.samples[static_cast<std::size_t>(c)]);
    }
  }
  n_too_high_ = static_cast<std::size_t>(std::count(too_high.begin(), too_high.end(), 1));
}

}  // namespace klang::stage
