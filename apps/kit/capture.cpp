#include "apps/kit/capture.hpp"

#include "core/foundation/base/errors.hpp"

#ifdef KLANG_HAS_PORTAUDIO
#include <fcntl.h>
#include <portaudio.h>
#include <unistd.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace klang::apps {
namespace portaudio {

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

constexpr double kBlockS = 0.05, kEnoughS = 0.25;

}  // namespace portaudio

struct Microphone::Parts {
  portaudio::Sound sound;
  double rate_hz;
  portaudio::Input input;
  std::mutex mutex;
  std::condition_variable enough_has_come;
  std::vector<float> come;
  std::exception_ptr failure;
  std::jthread taker;

  explicit Parts(PaDeviceIndex index) : rate_hz(Pa_GetDeviceInfo(index)->defaultSampleRate), input(index, rate_hz) {
    taker = std::jthread([this](const std::stop_token& stop) { take(stop); });
  }

  std::size_t enough() const { return static_cast<std::size_t>(portaudio::kEnoughS * rate_hz); }

  void take(const std::stop_token& stop) {
    std::vector<float> block(static_cast<std::size_t>(portaudio::kBlockS * rate_hz));
    while (!stop.stop_requested()) {
      std::exception_ptr problem;
      try {
        input.read(block.data(), block.size());
      } catch (...) {
        problem = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      if (problem) {
        failure = problem;
      } else {
        come.insert(come.end(), block.begin(), block.end());
      }
      if (failure || come.size() >= enough()) enough_has_come.notify_one();
      if (failure) return;
    }
  }
};

Microphone::Microphone(const std::string& device) {
  const portaudio::Sound sound;  // PortAudio counts who has opened it
  parts_ = std::make_unique<Parts>(portaudio::device_of(device));
}

Microphone::~Microphone() = default;

double Microphone::sample_rate_hz() const { return parts_->rate_hz; }

std::vector<float> Microphone::next() {
  std::unique_lock lock(parts_->mutex);
  parts_->enough_has_come.wait(lock, [this] { return parts_->failure || parts_->come.size() >= parts_->enough(); });
  if (parts_->failure) std::rethrow_exception(parts_->failure);
  return std::exchange(parts_->come, {});
}

}  // namespace klang::apps
#else

namespace klang::apps {

struct Microphone::Parts {};

Microphone::Microphone(const std::string& device) {
  throw InputError("--device", "this build has no PortAudio", device, "--input FILE");
}

Microphone::~Microphone() = default;

double Microphone::sample_rate_hz() const { return 0.0; }

std::vector<float> Microphone::next() { return {}; }

}  // namespace klang::apps
#endif
