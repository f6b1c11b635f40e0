// A PortAudio of one input, "Fake microphone", that plays the sound file KLANG_FAKE_INPUT (mono floats at 16000 Hz without a head) eight times
// as fast as it would come, and then silence. Loaded before the real one by the tests of klang listen.
#include <portaudio.h>

#include <cstdio>
#include <cstdlib>
#include <thread>

namespace {

constexpr double kRateHz = 16000.0, kFaster = 8.0;
std::FILE* playing = nullptr;

}  // namespace

extern "C" {

PaError Pa_Initialize() { return paNoError; }
PaError Pa_Terminate() { return paNoError; }
const char* Pa_GetErrorText(PaError) { return "failed"; }
PaDeviceIndex Pa_GetDeviceCount() { return 1; }
PaDeviceIndex Pa_GetDefaultInputDevice() { return 0; }

const PaDeviceInfo* Pa_GetDeviceInfo(PaDeviceIndex) {
  static PaDeviceInfo info{};
  info.name = "Fake microphone";
  info.maxInputChannels = 1;
  info.defaultSampleRate = kRateHz;
  return &info;
}

PaError Pa_OpenStream(PaStream** stream, const PaStreamParameters*, const PaStreamParameters*, double, unsigned long,
                      PaStreamFlags, PaStreamCallback*, void*) {
  playing = std::fopen(std::getenv("KLANG_FAKE_INPUT"), "rb");
  *stream = playing;
  return playing != nullptr ? paNoError : paDeviceUnavailable;
}

PaError Pa_StartStream(PaStream*) { return paNoError; }

PaError Pa_ReadStream(PaStream*, void* samples, unsigned long n) {
  auto* out = static_cast<float*>(samples);
  for (std::size_t i = std::fread(out, sizeof(float), n, playing); i < n; ++i) out[i] = 0.0f;
  std::this_thread::sleep_for(std::chrono::duration<double>(static_cast<double>(n) / kRateHz / kFaster));
  return paNoError;
}

PaError Pa_CloseStream(PaStream*) {
  std::fclose(playing);
  return paNoError;
}
}
