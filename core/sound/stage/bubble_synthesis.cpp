#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/stage/bubble_scene.hpp"
#include "core/sound/stage/bubble_voice.hpp"

namespace klang::bubble {
namespace {

using Complex = std::complex<double>;

constexpr double kHighestOfSampleRate = 0.499;
constexpr std::size_t kBubblesAJob = 32, kJobsABatch = 64;  // fixed: the order of summation does not know the threads
constexpr double kSeriesBlockS = 5e-4;                      // where the transfer comes from a file

// Gains of a bubble in each channel at both ends of each block, and its arrival.
struct Heard {
  RingTrack track;
  std::array<std::vector<Complex>, 2> gain_start, gain_end;
  std::array<double, 2> onset_s{};
  SoundedBubble summary;
  bool too_high = false;
};

class Listener {
 public:
  explicit Listener(const BubbleScene& scene) : scene_(scene) {}
  int n_channels() const { return scene_.stereo ? 2 : 1; }

  Heard hear(const SceneBubble& bubble) const {
    RingingBubble ringing{bubble.radius_m, 0.0, scene_.medium, scene_.theory, scene_.pitch, bubble.motion};
    const double unit = scene_.printed_excitation
                            ? printed_entrainment(bubble.radius_m, scene_.medium)
                            : entrainment_velocity_m_s(bubble.radius_m, scene_.medium, scene_.theory);
    ringing.onset_velocity_m_s = bubble.strength * unit;
    RingOptions options;
    if (bubble.transfer && scene_.transfer != SceneTransfer::kUnit) options.longest_block_s = kSeriesBlockS;
    Heard heard;
    heard.track = ring_track(ringing, options);
    const auto& blocks = heard.track.blocks;
    double highest = 0.0;
    for (const RingBlock& block : blocks) highest = std::max({highest, block.rate_start.imag(), block.rate_end.imag()});
    const double faded_s = heard.track.faded_from_s;
    heard.summary = {blocks.front().rate_start.imag() / (2 * kPi),
                     heard.track.block_at(faded_s).rate_at(faded_s).imag() / (2 * kPi), heard.track.decay_start_per_s,
                     heard.track.amplitude_m, 0.0};
    heard.too_high = !(highest < 2 * kPi * kHighestOfSampleRate * scene_.sample_rate_hz);
    if (heard.too_high) return heard;

    const Eigen::Vector3d birth_place = bubble.motion->position_m(0.0);
    const HeadModel birth_head = scene_.head_path.at(scene_.head, bubble.birth_s);
    for (int c = 0; c < n_channels(); ++c) {
      // Against the earliest sound that a head could hear, so that nothing comes before its birth.
      const double delay = way_s(birth_head, c, birth_place) +
                           (scene_.stereo ? scene_.head.radius_m / scene_.head.sound_speed_m_s : 0.0);
      const auto channel = static_cast<std::size_t>(c);
      heard.onset_s[channel] = bubble.birth_s + delay;
      for (const RingBlock& block : blocks) {
        const double end_s = block.start_s + block.length_s;
        heard.gain_start[channel].push_back(gain(bubble, c, delay, block.start_s, block.rate_start));
        heard.gain_end[channel].push_back(gain(bubble, c, delay, end_s, block.rate_end));
        const double level = std::exp(block.log_start.real()) * std::abs(heard.gain_start[channel].back());
        heard.summary.peak = std::max(heard.summary.peak, level);
      }
    }
    return heard;
  }

 private:
  // Time on the way to an ear; without propagation delay against the centre of the head.
  double way_s(const HeadModel& head, int channel, const Eigen::Vector3d& place) const {
    const double ear_s = scene_.stereo ? head.delay_s(head.angle_rad(channel, place)) : 0.0;
    return ear_s + (scene_.propagation_delay ? (place - head.centre_m).norm() / scene_.air_sound_speed_m_s : 0.0);
  }
  Complex gain(const SceneBubble& bubble, int channel, double delay_s, double age_s, Complex rate) const {
    const Eigen::Vector3d place = bubble.motion->position_m(age_s);
    const HeadModel head = scene_.head_path.at(scene_.head, bubble.birth_s + age_s);
    Complex transfer = 1.0;
    if (scene_.transfer != SceneTransfer::kUnit) {
      transfer = bubble.transfer ? bubble.transfer->at(bubble.birth_s + age_s)
                                 : half_space_transfer(scene_, bubble.radius_m, place, head.centre_m, rate);
    }
    if (!scene_.stereo) return std::abs(transfer);
    const double omega = rate.imag();
    const double later_s = way_s(head, channel, place) + scene_.head.radius_m / scene_.head.sound_speed_m_s - delay_s;
    return transfer * head.shadow(head.angle_rad(channel, place), omega) * std::polar(1.0, -omega * later_s);
  }
  const BubbleScene& scene_;
};

struct JobSound {
  std::int64_t first = 0;
  std::array<std::vector<double>, 2> samples;
};

JobSound render_job(const Listener& listener, const BubbleScene& scene, std::span<const std::size_t> members,
                    std::vector<SoundedBubble>& summaries, std::vector<char>& too_high) {
  std::vector<Heard> heard;
  heard.reserve(members.size());
  std::vector<std::array<BubbleVoice, 2>> voices;
  FrameRange all{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
  for (const std::size_t i : members) {
    try {
      heard.push_back(listener.hear(scene.bubbles[i]));
    } catch (const InputError& error) {
      throw InputError(scene.name + ", number " + std::to_string(i + 1), error.what());
    }
    const Heard& one = heard.back();
    summaries[i] = one.summary;
    too_high[i] = one.too_high ? 1 : 0;
    if (one.too_high) continue;
    voices.emplace_back();
    for (int c = 0; c < listener.n_channels(); ++c) {
      const auto channel = static_cast<std::size_t>(c);
      BubbleVoice& voice = voices.back()[channel];
      voice = {&one.track, one.onset_s[channel], one.gain_start[channel], one.gain_end[channel], scene.soft_attack};
      const FrameRange range = frames_of(voice, scene.sample_rate_hz);
      all = {std::min(all.first, range.first), std::max(all.end, range.end)};
    }
  }
  JobSound job;
  if (voices.empty()) return job;
  // Nothing before time 0 or after the scene's end is kept, so nothing is made.
  all.first = std::max<std::int64_t>(all.first, 0);
  if (scene.duration_s)
    all.end = std::min(all.end, static_cast<std::int64_t>(std::llround(*scene.duration_s * scene.sample_rate_hz)));
  if (all.first >= all.end) return job;
  job.first = all.first;
  for (int c = 0; c < listener.n_channels(); ++c) {
    const auto channel = static_cast<std::size_t>(c);
    job.samples[channel].assign(static_cast<std::size_t>(all.end - all.first), 0.0);
    for (const auto& voice : voices) add_voice(voice[channel], scene.sample_rate_hz, all.first, job.samples[channel]);
  }
  return job;
}

}  // namespace

Complex half_space_transfer(const BubbleScene& scene, double radius_m, const Eigen::Vector3d& bubble_m,
                            const Eigen::Vector3d& listener_m, Complex rate) {
  const Eigen::Vector3d way(listener_m.x() - bubble_m.x(), listener_m.y() - bubble_m.y(), listener_m.z());
  const double distance = way.norm(), sine_sq = 1.0 - std::pow(way.z() / distance, 2), omega = rate.imag();
  const double in_air = omega / scene.air_sound_speed_m_s, in_liquid = omega / scene.medium.liquid_sound_speed_m_s;
  const double vertical_sq = in_air * in_air * sine_sq - in_liquid * in_liquid;
  const double reach = std::max(0.0, -bubble_m.z()) * std::sqrt(std::abs(vertical_sq));
  const Complex surface = vertical_sq > 0.0 ? Complex(std::exp(-reach), 0.0) : std::polar(1.0, -reach);
  return 2.0 * scene.air_density_kg_m3 * radius_m * radius_m / distance * rate * rate * surface;
}

BubbleSound synthesise_bubbles(const BubbleScene& scene, Monitor& monitor) {
  const auto start = std::chrono::steady_clock::now();
  const Listener listener(scene);
  const std::size_t n = scene.bubbles.size();
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scene.bubbles[a].birth_s < scene.bubbles[b].birth_s; });

  BubbleSound result;
  result.bubbles.resize(n);
  std::vector<char> too_high(n, 0);
  std::array<std::vector<double>, 2> sound;
  if (scene.duration_s) {
    for (auto& channel : sound)
      channel.assign(static_cast<std::size_t>(std::llround(*scene.duration_s * scene.sample_rate_hz)), 0.0);
  }
  const std::size_t n_jobs = (n + kBubblesAJob - 1) / kBubblesAJob;
  for (std::size_t batch = 0; batch < n_jobs; batch += kJobsABatch) {
    const std::size_t in_batch = std::min(kJobsABatch, n_jobs - batch);
    std::vector<JobSound> jobs(in_batch);
    for_each_job(
        in_batch,
        [&](std::size_t j) {
          const std::size_t from = (batch + j) * kBubblesAJob, until = std::min(n, from + kBubblesAJob);
          jobs[j] = render_job(listener, scene, std::span(order).subspan(from, until - from), result.bubbles, too_high);
        },
        "bubbles", monitor);
    for (const JobSound& job : jobs) {
      for (std::size_t c = 0; c < static_cast<std::size_t>(listener.n_channels()); ++c) {
        const auto first = static_cast<std::size_t>(job.first);
        if (sound[c].size() < first + job.samples[c].size()) sound[c].resize(first + job.samples[c].size(), 0.0);
        for (std::size_t i = 0; i < job.samples[c].size(); ++i) sound[c][first + i] += job.samples[c][i];
      }
    }
  }
  result.n_too_high = static_cast<std::size_t>(std::count(too_high.begin(), too_high.end(), 1));
  const auto n_frames = static_cast<Eigen::Index>(std::max(sound[0].size(), sound[1].size()));
  result.sound.sample_rate_hz = scene.sample_rate_hz;
  result.sound.origin = scene.name;
  result.sound.samples = Eigen::MatrixXd::Zero(n_frames, listener.n_channels());
  for (int c = 0; c < listener.n_channels(); ++c) {
    const auto& channel = sound[static_cast<std::size_t>(c)];
    std::copy(channel.begin(), channel.end(), result.sound.samples.col(c).data());
  }
  const bool silent = n_frames == 0 || !(result.sound.samples.cwiseAbs().maxCoeff() > 0.0);
  result.status = silent ? BubbleSoundStatus::kSilent : BubbleSoundStatus::kDone;
  result.wall_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace klang::bubble
