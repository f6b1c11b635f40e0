#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace klang::test {

struct RunResult {
  int exit_code = -1;
  std::string out, err;
  int err_lines() const;
};

/// Runs the klang of this build with a shell-quoted argument text, in folder; environment: extra assignments in front.
RunResult run_klang(const std::string& arguments, const std::filesystem::path& folder,
                    const std::string& environment = {});

/// An empty folder of its own, removed at the end.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::string_view bytes) const;
  /// Names of all files below, sorted: to show that nothing was left behind.
  std::vector<std::string> files() const;

 private:
  std::filesystem::path path_;
};

/// Bytes of a WAV of 32-bit floats; the header can lie about the rate, channels and length.
std::string wav_bytes(const std::vector<float>& interleaved, int n_channels, unsigned sample_rate_hz);

}  // namespace klang::test
