#pragma once
#include <Eigen/Core>
#include <optional>

namespace klang::audio {

/// Frame of a stretch of ringing (frames x channels) at which it is cut off (a hand on the body, a noise gate, an editor's fade):
/// from there on its level falls at least 15 dB within a span of 10 to 350 ms before which it fell by less than a fifth of that
/// over the same span, it does not come back, and what is left does not fall on (noise, silence, or nothing). A sum of decaying
/// exponentials cannot do so: its level is convex but for beats, which come back. No value where the ring dies by itself, or
/// where less than 0.1 s stands before the drop (that may be the blow). A drop longer than 50 ms must be followed by 0.1 s of rest: a slow beat falls into its null, too.
std::optional<Eigen::Index> sudden_end(const Eigen::Ref<const Eigen::MatrixXd>& stretch, double sample_rate_hz);

}  // namespace klang::audio
