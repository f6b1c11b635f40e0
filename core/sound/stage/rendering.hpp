#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/events/event_log.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/stage/listener.hpp"

namespace klang::stage {

struct RenderOptions {
  double sample_rate_hz = 48000.0;
  std::optional<double> duration_s;  ///< none: until the last voice has ended, for voices that know their end

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"sample_rate_hz", "of the sound", between(1000.0, 768000.0)}, self.sample_rate_hz);
    visit({"duration_s", "from time 0 of the events; null: until the last voice has ended", between(0.0, 3600.0)},
          self.duration_s);
  }
};

/// The channels of a sound while voices add to them. Frame 0 is time 0 of the events.
class Mix {
 public:
  Mix(int n_channels, const RenderOptions& options);
  int n_channels() const { return static_cast<int>(channels_.size()); }
  double sample_rate_hz() const { return options_.sample_rate_hz; }
  std::optional<double> duration_s() const { return options_.duration_s; }
  /// Of the whole sound, where its length is given.
  std::optional<Eigen::Index> n_frames() const { return n_frames_; }
  /// The same, for voices that do not know their end. @throws InputError where the length is not given
  Eigen::Index known_frames() const;
  /// Adds samples to a channel from first_frame on. What lies before frame 0 or after a given end is left out; without
  /// a given end the sound grows.
  void add(int channel, std::int64_t first_frame, std::span<const double> samples);
  Eigen::MatrixXd samples() const;

 private:
  RenderOptions options_;
  std::optional<Eigen::Index> n_frames_;
  std::vector<std::vector<double>> channels_;
};

/// Something that sounds because of what happened: a body that rings when it is pushed, bubbles that are born. A voice
/// of a new kind is a class beside these; nothing else knows of it.
class Voice {
 public:
  virtual ~Voice() = default;
  /// Adds what the listener hears of the events to the mix: the same bits on any number of threads.
  /// @throws InputError where the events, the listener or the length of the mix do not suit the voice
  virtual void add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) = 0;
};

/// The sound of the events: the sum of the voices in their order, one after another, each with all threads. Bits do not
/// depend on the number of threads.
/// @throws InputError for a log, a listener or options that are not valid
audio::Signal render(const events::EventLog& log, std::span<Voice* const> voices, const Listener& listener,
                     const RenderOptions& options, Monitor& monitor = silent_monitor());

}  // namespace klang::stage
