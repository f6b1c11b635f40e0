#include "core/sound/stage/oscillator_bank.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/stage/detail/contact_pulse.hpp"
#include "core/sound/stage/detail/mix_kernel.hpp"
#include "core/sound/stage/detail/oscillator_response.hpp"

// How it works. The exact one-step matrix A(dt) of an oscillator is used at two levels: A^256 carries the
// state from block to block and A^j (j < 256) yields the samples inside a block, both in extended precision.
// The samples of all blocks and modes are then one matrix product, (256 x 2 modes) times (2 modes x blocks),
// in double. Nothing drifts: no error survives a block boundary but that of the extended-precision powers
// (1e-19 each).
namespace klang::stage {
namespace {

using detail::Column;
using detail::kBlockFrames;
using detail::kColumnGroup;
using detail::kLane;
using detail::OscillatorResponse;

constexpr std::size_t kChunkModes = 64;  // table of 256 kB: stays in the second-level cache
constexpr std::size_t kWaveChunks = 16;  // chunks summed at a time; bounds the memory, not the result
constexpr double kLongestContact_s = 0.1;

struct State {
  long double z = 0, zd = 0;
};

// A modal impulse as the bank needs it: from which sample on the motion is free.
struct Event {
  const ModalImpulse* impulse;
  std::size_t sample;  // first sample of free motion, >= 0
  std::shared_ptr<const detail::ContactPulse> pulse;
};

void check_inputs(const std::vector<Oscillator>& oscillators, const std::vector<ModalImpulse>& impulses,
                  double sample_rate_hz, Eigen::Index n_frames) {
  checked("oscillator bank", "sample_rate_hz", sample_rate_hz, 1.0, 1e6);
  if (n_frames < 0) throw InputError("oscillator bank", "n_frames is negative", std::to_string(n_frames));
  for (std::size_t i = 0; i < oscillators.size(); ++i) {
    const std::string place = "oscillator " + std::to_string(i);
    checked(place, "angular_frequency_rad_s", oscillators[i].angular_frequency_rad_s, 0.0, 1e9);
    checked(place, "decay_per_s", oscillators[i].decay_per_s, 0.0, 1e9);
    checked(place, "output_gain", oscillators[i].output_gain, -1e100, 1e100);
  }
  for (std::size_t i = 0; i < impulses.size(); ++i) {
    const std::string place = "impulse " + std::to_string(i);
    checked(place, "time_s", impulses[i].time_s, -1e6, 1e6);
    checked(place, "contact_duration_s", impulses[i].contact_duration_s, 0.0, kLongestContact_s);
    if (static_cast<std::size_t>(impulses[i].impulse.size()) != oscillators.size()) {
      throw InputError(place, "needs one value an oscillator", std::to_string(impulses[i].impulse.size()),
                       std::to_string(oscillators.size()));
    }
    if (!impulses[i].impulse.allFinite()) throw InputError(place, "impulse is not finite");
  }
}

std::vector<Event> events_of(const std::vector<ModalImpulse>& impulses, double sample_rate_hz, std::size_t n_frames) {
  std::vector<Event> events;
  for (const ModalImpulse& impulse : impulses) {
    Event event{&impulse, 0, impulse.pulse};
    if (event.pulse || impulse.contact_duration_s > 0) {
      if (!event.pulse)
        event.pulse =
            std::make_shared<const detail::ContactPulse>(impulse.time_s, impulse.contact_duration_s, sample_rate_hz);
      if (event.pulse->first_sample() >= static_cast<long>(n_frames)) continue;
      event.sample = static_cast<std::size_t>(std::max(0L, event.pulse->last_sample()));
    } else {
      const long double position = static_cast<long double>(impulse.time_s) * sample_rate_hz;
      if (position > static_cast<long double>(n_frames)) continue;
      event.sample = static_cast<std::size_t>(std::max(0.0L, std::ceil(position)));
    }
    events.push_back(std::move(event));
  }
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.sample < b.sample; });
  return events;
}

/// How the motion of all is written.
struct Rendering {
  double sample_rate_hz = 0.0;
  Heard heard = Heard::kMotion;
};

/// A mode's share of an impulse, and what it adds to the mix.
struct Drive {
  double impulse = 0.0, gain = 0.0;
  Heard heard = Heard::kMotion;
};

/// Takes the bending under a slow force off the output.
void take_bending(const detail::ContactPulse& pulse, const OscillatorResponse& response,
                  const detail::ContactPulse::State& state, const Drive& drive, Eigen::Ref<Eigen::VectorXd> output) {
  constexpr double kLeastShare = 0.01;
  const double share = pulse.slow_share(response, state, drive.impulse);
  if (share < kLeastShare) return;
  std::vector<double> bending;
  const long first = pulse.first_sample() - pulse.add_bending(response, drive.impulse, bending);
  for (std::size_t i = 0; i < bending.size(); ++i) {
    const long n = first + static_cast<long>(i);
    if (n >= 0 && n < output.size()) output[n] -= share * drive.gain * bending[i];
  }
}

State start_state(const Event& event, const OscillatorResponse& response, const Drive& drive, double sample_rate_hz,
                  std::vector<double>& during, Eigen::Ref<Eigen::VectorXd> output) {
  if (!event.pulse) {
    const long double since = event.sample / static_cast<long double>(sample_rate_hz) - event.impulse->time_s;
    const auto r = response.impulse(std::max(0.0L, since));
    return {drive.impulse * r.z, drive.impulse * r.zd};
  }
  const auto state = event.pulse->drive(response, drive.impulse, &during);
  const long first = event.pulse->first_sample();
  for (std::size_t i = 0; i < during.size(); ++i) {
    const long n = first + static_cast<long>(i);
    if (n >= 0 && n < output.size()) output[n] += drive.gain * during[i];
  }
  if (drive.heard == Heard::kRinging) take_bending(*event.pulse, response, state, drive, output);
  if (event.pulse->last_sample() >= 0) return {state.z, state.zd};
  // The whole pulse lies before the first sample: free motion up to it.
  const auto r = response.impulse(static_cast<long double>(-event.pulse->last_sample()) / sample_rate_hz);
  return {state.z * (r.zd + response.damping() * r.z) + state.zd * r.z,
          state.zd * r.zd - response.omega_sq() * r.z * state.z};
}

// Subnormal numbers cost a hundred times the time of others and cannot be heard.
double flushed(long double value) { return std::abs(value) < 1e-140L ? 0.0 : static_cast<double>(value); }

// All modes of a chunk: output += their mix.
void render_chunk(const Oscillator* oscillators, std::size_t first_mode, std::size_t n_modes,
                  const std::vector<Event>& events, const Rendering& rendering, Eigen::VectorXd& output) {
  const double sample_rate_hz = rendering.sample_rate_hz;
  const auto n_frames = static_cast<std::size_t>(output.size());
  const std::size_t n_blocks = (n_frames + kBlockFrames - 1) / kBlockFrames;
  const std::size_t first_block = events.front().sample / kBlockFrames + 1;  // states before it are zero
  const std::size_t n_block_columns = first_block < n_blocks ? n_blocks - first_block : 0;

  std::vector<Column> columns(n_block_columns);
  for (std::size_t k = 0; k < n_block_columns; ++k) {
    columns[k].offset = (first_block + k) * kBlockFrames;
    columns[k].length = std::min(kBlockFrames, n_frames - columns[k].offset);
  }
  for (const Event& event : events) {
    if (event.sample >= n_frames) continue;  // only what happens during its pulse is heard
    const std::size_t block_end = std::min(n_frames, (event.sample / kBlockFrames + 1) * kBlockFrames);
    columns.push_back({event.sample, block_end - event.sample});
  }
  const std::size_t n_used = columns.size();
  const std::size_t n_groups = (n_used + kColumnGroup - 1) / kColumnGroup;
  columns.resize(n_groups * kColumnGroup, Column{0, 0});

  const std::size_t n_rows = 2 * n_modes;
  std::vector<double> table(kBlockFrames * n_rows), states(n_groups * n_rows * kColumnGroup, 0.0);
  std::vector<OscillatorResponse::Impulse> powers(kBlockFrames + 1);
  std::vector<double> during;

  for (std::size_t m = 0; m < n_modes; ++m) {
    const Oscillator& oscillator = oscillators[m];
    const OscillatorResponse response(oscillator.angular_frequency_rad_s, oscillator.decay_per_s);
    const long double c = response.damping(), omega_sq = response.omega_sq();
    const auto moved = [&](const State& s, const OscillatorResponse::Impulse& r) {
      return State{s.z * (r.zd + c * r.z) + s.zd * r.z, s.zd * r.zd - omega_sq * r.z * s.z};
    };
    const auto one = response.impulse(1.0L / sample_rate_hz);
    powers[0] = {0.0L, 1.0L};
    for (std::size_t j = 0; j < kBlockFrames; ++j) {
      const auto& r = powers[j];
      powers[j + 1] = {r.z * (one.zd + c * one.z) + r.zd * one.z, r.zd * one.zd - omega_sq * one.z * r.z};
      double* const row = table.data() + (j / kLane * n_rows + 2 * m) * kLane + j % kLane;
      row[0] = flushed(r.zd + c * r.z);
      row[kLane] = flushed(r.z);
    }
    const auto block = response.impulse(kBlockFrames / static_cast<long double>(sample_rate_hz));
    powers[kBlockFrames] = block;

    const double gain = oscillator.output_gain;
    const auto put = [&](std::size_t column, const State& s) {
      double* const to =
          states.data() + (column / kColumnGroup * n_rows + 2 * m) * kColumnGroup + column % kColumnGroup;
      to[0] = flushed(gain * s.z);
      to[kColumnGroup] = flushed(gain * s.zd);
    };
    State state;  // at the start of block next_block
    std::size_t next_block = first_block, event_column = n_block_columns;
    const auto advance_to = [&](std::size_t last_block) {  // writes the states of blocks before last_block
      for (; next_block < std::min(last_block, n_blocks); ++next_block) {
        put(next_block - first_block, state);
        state = moved(state, block);
        if (std::abs(state.z) + std::abs(state.zd) < 1e-200L) state = {};
      }
    };
    for (const Event& event : events) {
      const double impulse = event.impulse->impulse[static_cast<Eigen::Index>(first_mode + m)];
      const State s = start_state(event, response, {impulse, gain, rendering.heard}, sample_rate_hz, during, output);
      if (event.sample >= n_frames) continue;
      const std::size_t event_block = event.sample / kBlockFrames;
      advance_to(event_block + 1);
      put(event_column++, s);
      const State at_next = moved(s, powers[(event_block + 1) * kBlockFrames - event.sample]);
      state.z += at_next.z;
      state.zd += at_next.zd;
    }
    advance_to(n_blocks);
  }
  detail::mix_columns(table.data(), states.data(), n_rows, columns.data(), n_groups, output.data());
}

}  // namespace

Eigen::VectorXd oscillation(const std::vector<Oscillator>& oscillators, const std::vector<ModalImpulse>& impulses,
                            double sample_rate_hz, Eigen::Index n_frames, Heard heard) {
  check_inputs(oscillators, impulses, sample_rate_hz, n_frames);
  Eigen::VectorXd output = Eigen::VectorXd::Zero(n_frames);
  const std::vector<Event> events = events_of(impulses, sample_rate_hz, static_cast<std::size_t>(n_frames));
  if (events.empty() || n_frames == 0) return output;

  const std::size_t n_chunks = (oscillators.size() + kChunkModes - 1) / kChunkModes;
  std::vector<Eigen::VectorXd> parts(std::min(kWaveChunks, n_chunks));
  for (std::size_t wave = 0; wave < n_chunks; wave += kWaveChunks) {
    const std::size_t n_parts = std::min(kWaveChunks, n_chunks - wave);
    parallel_for(n_parts, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t part = begin; part < end; ++part) {
        const std::size_t first = (wave + part) * kChunkModes;
        parts[part].setZero(n_frames);
        render_chunk(oscillators.data() + first, first, std::min(kChunkModes, oscillators.size() - first), events,
                     {sample_rate_hz, heard}, parts[part]);
      }
    });
    for (std::size_t part = 0; part < n_parts; ++part) output += parts[part];
  }
  return output;
}

}  // namespace klang::stage
