#include "apps/kit/capture.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/strikes.hpp"

#ifdef KLANG_HAS_PORTAUDIO
#include <fcntl.h>
#include <portaudio.h>
#include <unistd.h>

namespace klang::apps {
namespace {

/// Standard error goes nowhere as long as this lives: ALSA and JACK say there what they miss, on tens of lines.
class Silence {
 public:
  Silence() : kept_(::dup(STDERR_FILENO)) {
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (kept_ >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) ::close(nowhere);
  }
  ~Silence() {
    if (kept_ < 0) return;
    ::dup2(kept_, STDERR_FILENO);
    ::close(kept_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int kept_;
};

/// PortAudio, open as long as this lives.
class Sound {
 public:
  Sound() {
    const Silence silence;
    if (const PaError error = Pa_Initialize(); error != paNoError) throw InputError("--device", Pa_GetErrorText(error));
  }
  ~Sound() {
    const Silence silence;
    Pa_Terminate();
  }
  Sound(const Sound&) = delete;
  Sound& operator=(const Sound&) = delete;
};

PaDeviceIndex device_of(const std::string& wanted) {
  std::string names;
  for (PaDeviceIndex i = 0; i < Pa_GetDeviceCount(); ++i) {
    const PaDeviceInfo* info = Pa_GetDeviceInfo(i);
    if (info->maxInputChannels < 1) continue;
    const std::string name = info->name;
    if (wanted == std::to_string(i) || name.find(wanted) != std::string::npos) return i;
    names += (names.empty() ? "" : ", ") + std::to_string(i) + " " + name;
  }
  if (wanted == "default" && Pa_GetDefaultInputDevice() != paNoDevice) return Pa_GetDefaultInputDevice();
  throw InputError("--device", "no such input", wanted, names.empty() ? "there is none" : names);
}

/// An open input stream of one channel.
class Input {
 public:
  Input(PaDeviceIndex device, double rate_hz) {
    const PaStreamParameters parameters{device, 1, paFloat32, Pa_GetDeviceInfo(device)->defaultLowInputLatency,
                                        nullptr};
    const Silence silence;
    PaError error = Pa_OpenStream(&stream_, &parameters, nullptr, rate_hz, paFramesPerBufferUnspecified, paNoFlag,
                                  nullptr, nullptr);
    if (error == paNoError) error = Pa_StartStream(stream_);
    if (error != paNoError) throw InputError("--device", Pa_GetErrorText(error));
  }
  ~Input() { Pa_CloseStream(stream_); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  void read(float* samples, unsigned long n) {
    const PaError error = Pa_ReadStream(stream_, samples, n);
    if (error != paNoError && error != paInputOverflowed) throw InputError("--device", Pa_GetErrorText(error));
  }

 private:
  PaStream* stream_ = nullptr;
};

}  // namespace

audio::Signal captured_sound(const std::string& device, double longest_s, int n_takes, Monitor& monitor) {
  constexpr double kRingsS = 1.0, kBlockS = 0.25, kGapS = 0.3;
  const Sound sound;
  const PaDeviceIndex index = device_of(device);
  const double rate_hz = Pa_GetDeviceInfo(index)->defaultSampleRate;
  Input input(index, rate_hz);
  const auto block = static_cast<unsigned long>(kBlockS * rate_hz);
  std::vector<float> samples;
  audio::Signal heard;
  heard.sample_rate_hz = rate_hz;
  while (static_cast<double>(samples.size()) < longest_s * rate_hz && !monitor.stop_requested()) {
    samples.resize(samples.size() + block);
    input.read(samples.data() + samples.size() - block, block);
    const double now_s = static_cast<double>(samples.size()) / rate_hz;
    monitor.progress("listening", now_s / longest_s);
    heard.samples =
        Eigen::Map<const Eigen::VectorXf>(samples.data(), static_cast<Eigen::Index>(samples.size())).cast<double>();
    if (n_takes == 0 || !(heard.samples.cwiseAbs().maxCoeff() > 1e-3)) continue;
    int n_taps = 0;
    double last_s = -1.0;
    for (const audio::Strike& strike : audio::detect_strikes(heard)) {
      if (last_s >= 0.0 && strike.time_s - last_s < kGapS) continue;
      ++n_taps;
      last_s = strike.time_s;
    }
    if (n_taps >= n_takes && now_s - last_s >= kRingsS) break;
  }
  return heard;
}

}  // namespace klang::apps
#else

namespace klang::apps {

audio::Signal captured_sound(const std::string& device, double, int, Monitor&) {
  throw InputError("--device", "this build has no PortAudio", device, "--input FILE");
}

}  // namespace klang::apps
#endif
