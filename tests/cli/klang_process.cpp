#include "tests/cli/klang_process.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace klang::test {
namespace fs = std::filesystem;

int RunResult::err_lines() const { return static_cast<int>(std::count(err.begin(), err.end(), '\n')); }

namespace {

std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

fs::path unique_path() {
  static std::atomic<int> counter = 0;
  return fs::temp_directory_path() / ("klang-cli-" + std::to_string(::getpid()) + "-" + std::to_string(counter++));
}

}  // namespace

RunResult run_klang(const std::string& arguments, const fs::path& folder, const std::string& environment) {
  const fs::path out = unique_path(), err = unique_path();
  const std::string line = "cd '" + folder.string() + "' && " + environment + " '" KLANG_PROGRAM "' " + arguments +
                           " > '" + out.string() + "' 2> '" + err.string() + "' < /dev/null";
  const int status = std::system(line.c_str());
  RunResult result{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(out), slurp(err)};
  fs::remove(out);
  fs::remove(err);
  return result;
}

Scratch::Scratch() : path_(unique_path()) { fs::create_directories(path_); }

Scratch::~Scratch() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path Scratch::write(const std::string& name, std::string_view bytes) const {
  std::ofstream(path_ / name, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path_ / name;
}

std::vector<std::string> Scratch::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(path_)) {
    names.push_back(fs::relative(entry.path(), path_).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string wav_bytes(const std::vector<float>& interleaved, int n_channels, unsigned sample_rate_hz) {
  std::string bytes;
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const auto n_bytes = static_cast<std::uint32_t>(interleaved.size() * 4);
  bytes += "RIFF";
  put(std::uint32_t{36 + n_bytes});
  bytes += "WAVEfmt ";
  put(std::uint32_t{16});
  put(std::uint16_t{3});
  put(static_cast<std::uint16_t>(n_channels));
  put(std::uint32_t{sample_rate_hz});
  put(static_cast<std::uint32_t>(sample_rate_hz * 4U * static_cast<unsigned>(n_channels)));
  put(static_cast<std::uint16_t>(4 * n_channels));
  put(std::uint16_t{32});
  bytes += "data";
  put(n_bytes);
  for (const float sample : interleaved) put(sample);
  return bytes;
}

}  // namespace klang::test
