#include "core/sound/stage/ring_sound.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/check.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"
#include "core/sound/stage/detail/ring_kernel.hpp"

namespace klang::stage {
namespace {

using Complex = std::complex<double>;
using bubble::RingBlock;
using bubble::RingTrack;
using detail::kRingLanes;

constexpr std::size_t kMostFrames = 256;  // of a lane: the ratios' round-off grows with the fourth power

Complex product(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// e^x, for the small exponents of the higher ratios by its series.
Complex exponential(Complex x) {
  if (std::abs(x.real()) + std::abs(x.imag()) > 0.01) return std::exp(x);
  Complex sum = 1.0 + x / 7.0;
  for (int k = 6; k >= 1; --k) sum = 1.0 + product(x, sum) / static_cast<double>(k);
  return sum;
}

struct Piece {
  std::int64_t first = 0;
  std::size_t n_frames = 0;
};

/// Over a block.
struct GainRamp {
  Complex start, end;
};

// One lane from a block: the sample at age a, then steps of h.
void fill_lane(const RingBlock& block, const GainRamp& gain_of, double age_s, double h, std::size_t lane,
               detail::RingLanes& lanes) {
  const double s = age_s - block.start_s;
  const Complex log_z = block.log_start + s * (block.c1 + s * (block.c2 + s * (block.c3 + s * block.c4)));
  const Complex a4 = block.c4 * (h * h * h * h);
  const Complex a3 = (block.c3 + 4.0 * s * block.c4) * (h * h * h);
  const Complex a2 = (block.c2 + s * (3.0 * block.c3 + 6.0 * s * block.c4)) * (h * h);
  const Complex a1 = (block.c1 + s * (2.0 * block.c2 + s * (3.0 * block.c3 + 4.0 * s * block.c4))) * h;
  const Complex z = std::exp(log_z);
  const Complex ratio[4] = {std::exp(a1 + a2 + a3 + a4), exponential(2.0 * a2 + 6.0 * a3 + 14.0 * a4),
                            exponential(6.0 * a3 + 36.0 * a4), exponential(24.0 * a4)};
  lanes.z_re[lane] = z.real();
  lanes.z_im[lane] = z.imag();
  for (std::size_t k = 0; k < 4; ++k) {
    lanes.ratio_re[k][lane] = ratio[k].real();
    lanes.ratio_im[k][lane] = ratio[k].imag();
  }
  const Complex slope = (gain_of.end - gain_of.start) / block.length_s;
  const Complex gain = gain_of.start + s * slope;
  lanes.gain_re[lane] = gain.real();
  lanes.gain_im[lane] = gain.imag();
  lanes.gain_step_re[lane] = h * slope.real();
  lanes.gain_step_im[lane] = h * slope.imag();
}

}  // namespace

FrameRange frames_of(const RingSound& ring, double sample_rate_hz) {
  return {static_cast<std::int64_t>(std::ceil(ring.onset_s * sample_rate_hz)),
          static_cast<std::int64_t>(std::ceil((ring.onset_s + ring.track->end_s) * sample_rate_hz))};
}

void add_ring(const RingSound& ring, double sample_rate_hz, std::int64_t first_frame, std::span<double> output) {
  const RingTrack& track = *ring.track;
  KLANG_CHECK(ring.gain_start.size() == track.blocks.size() && ring.gain_end.size() == track.blocks.size(),
              "one gain for each block");
  const FrameRange range = frames_of(ring, sample_rate_hz);
  const std::int64_t last_frame = first_frame + static_cast<std::int64_t>(output.size());
  const std::int64_t from = std::max(range.first, first_frame), until = std::min(range.end, last_frame);
  if (from >= until) return;
  const double h = 1.0 / sample_rate_hz;
  const auto age_of = [&](std::int64_t frame) { return static_cast<double>(frame) * h - ring.onset_s; };

  static thread_local std::vector<double> sound, panel;
  sound.assign(static_cast<std::size_t>(until - from), 0.0);
  panel.resize(kMostFrames * kRingLanes);
  detail::RingLanes lanes = {};
  Piece pieces[kRingLanes];
  std::size_t n_lanes = 0;
  const auto flush = [&] {
    std::size_t longest = 0;
    for (std::size_t k = 0; k < n_lanes; ++k) longest = std::max(longest, pieces[k].n_frames);
    detail::ring_samples(lanes, longest, panel.data());
    for (std::size_t k = 0; k < n_lanes; ++k) {
      double* const to = sound.data() + (pieces[k].first - from);
      for (std::size_t i = 0; i < pieces[k].n_frames; ++i) to[i] = panel[i * kRingLanes + k];
    }
    n_lanes = 0;
    lanes = {};
  };
  for (std::size_t b = 0; b < track.blocks.size(); ++b) {
    const RingBlock& block = track.blocks[b];
    const auto frame_at = [&](double age) {
      return static_cast<std::int64_t>(std::ceil((ring.onset_s + age) * sample_rate_hz));
    };
    std::int64_t frame = std::max(from, frame_at(block.start_s));
    const bool is_last = b + 1 == track.blocks.size();
    const std::int64_t end = std::min(until, is_last ? range.end : frame_at(track.blocks[b + 1].start_s));
    for (; frame < end; frame += static_cast<std::int64_t>(kMostFrames)) {
      const auto n = static_cast<std::size_t>(std::min<std::int64_t>(end - frame, kMostFrames));
      fill_lane(block, {ring.gain_start[b], ring.gain_end[b]}, age_of(frame), h, n_lanes, lanes);
      pieces[n_lanes++] = {frame, n};
      if (n_lanes == kRingLanes) flush();
    }
  }
  if (n_lanes > 0) flush();

  if (ring.soft_attack) {
    const double attack_s = -std::log(0.85) / track.decay_start_per_s;
    for (std::int64_t frame = from; frame < until && age_of(frame) < attack_s; ++frame)
      sound[static_cast<std::size_t>(frame - from)] *= bubble::attack_window(track.decay_start_per_s, age_of(frame));
  }
  const auto fade = static_cast<std::int64_t>(std::ceil((ring.onset_s + track.faded_from_s) * sample_rate_hz));
  for (std::int64_t frame = std::max(from, fade); frame < until; ++frame) {
    const double part = (age_of(frame) - track.faded_from_s) / (track.end_s - track.faded_from_s);
    sound[static_cast<std::size_t>(frame - from)] *= 0.5 * (1.0 + std::cos(kPi * std::min(1.0, part)));
  }
  double* const to = output.data() + (from - first_frame);
  for (std::size_t i = 0; i < sound.size(); ++i) to[i] += sound[i];
}

}  // namespace klang::stage
