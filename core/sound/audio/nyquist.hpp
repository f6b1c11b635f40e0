#pragma once

namespace klang::audio {

/// What has a higher pitch than this part of the sample rate is not rendered: at a half it would fold back, and just
/// below a half it beats with its own mirror image. The one such limit of the house.
inline constexpr double kHighestRendered = 0.499;
constexpr double highest_rendered_hz(double sample_rate_hz) { return kHighestRendered * sample_rate_hz; }

/// Sounds are compared up to this part of the sample rate: above it converters and resamplers differ.
inline constexpr double kHighestCompared = 0.45;
constexpr double highest_compared_hz(double sample_rate_hz) { return kHighestCompared * sample_rate_hz; }

}  // namespace klang::audio
