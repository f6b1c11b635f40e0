#pragma once
#include <vector>

#include "core/sound/stage/rendering.hpp"

namespace klang::stage {

/// A decaying partial: amplitude exp(-decay t) sin(2 pi frequency t).
struct Partial {
  double frequency_hz = 0.0, decay_per_s = 0.0, amplitude = 0.0;
};

/// Partials that ring from time 0 on, whatever happens: a body, or its proxy, after one strike. Made fast (three
/// products for a sample) for searches that compare sounds: partials at or above audio::highest_compared_hz are left
/// out, and a partial ends where it has fallen by 60 neper (521 dB).
class PartialsVoice : public Voice {
 public:
  explicit PartialsVoice(std::vector<Partial> partials) : partials_(std::move(partials)) {}
  void add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) override;

 private:
  std::vector<Partial> partials_;
};

}  // namespace klang::stage
