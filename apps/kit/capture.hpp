#pragma once
#include <memory>
#include <string>
#include <vector>

namespace klang::apps {

/// An input device (PortAudio, one channel at its own rate), which is listened to as long as this lives; a thread of its own takes
/// what comes, so that nothing is lost while a tap is analysed.
class Microphone {
 public:
  /// @param device  its number, part of its name, or "default"
  /// @throws InputError: no such device (lists them), a build without PortAudio
  explicit Microphone(const std::string& device);
  ~Microphone();
  Microphone(const Microphone&) = delete;
  Microphone& operator=(const Microphone&) = delete;

  double sample_rate_hz() const;
  /// What has come since the last call, a quarter of a second at least. @throws InputError where the device fails
  std::vector<float> next();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace klang::apps
