#include "core/physics/entrainment/tracked_bubbles.hpp"

#include <lzma.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::entrainment {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostBytes = std::size_t{2} << 30;

std::string unpacked(const std::string& bytes, const std::string& name) {
  lzma_stream stream = LZMA_STREAM_INIT;
  if (lzma_stream_decoder(&stream, std::uint64_t{1} << 30, LZMA_CONCATENATED) != LZMA_OK)
    throw InputError(name, "cannot be unpacked");
  std::string text, part(std::size_t{1} << 20, '\0');
  stream.next_in = reinterpret_cast<const std::uint8_t*>(bytes.data());
  stream.avail_in = bytes.size();
  lzma_ret status = LZMA_OK;
  while (status == LZMA_OK && text.size() <= kMostBytes) {
    stream.next_out = reinterpret_cast<std::uint8_t*>(part.data());
    stream.avail_out = part.size();
    status = lzma_code(&stream, LZMA_FINISH);
    text.append(part.data(), part.size() - stream.avail_out);
  }
  lzma_end(&stream);
  if (status != LZMA_STREAM_END) throw InputError(name, "is no whole .xz file, or holds more than 2 GB");
  return text;
}

std::string packed(const std::string& text) {
  std::string bytes(lzma_stream_buffer_bound(text.size()), '\0');
  std::size_t size = 0;
  const lzma_ret status =
      lzma_easy_buffer_encode(6, LZMA_CHECK_CRC64, nullptr, reinterpret_cast<const std::uint8_t*>(text.data()),
                              text.size(), reinterpret_cast<std::uint8_t*>(bytes.data()), &size, bytes.size());
  if (status != LZMA_OK) throw NumericalError("tracked bubbles: .xz could not be made");
  bytes.resize(size);
  return bytes;
}

std::vector<std::string_view> words_in(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t from = line.find_first_not_of(" \t\r", i);
    if (from == std::string_view::npos) break;
    i = std::min(line.find_first_of(" \t\r", from), line.size());
    words.push_back(line.substr(from, i - from));
  }
  return words;
}

std::optional<double> number(std::string_view word) {
  double value = 0.0;
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

class Reader {
 public:
  explicit Reader(std::string name) : name_(std::move(name)) {}
  void line(std::string_view text);
  TrackedBubbles finish();

 private:
  [[noreturn]] void fail(const std::string& what, std::string_view got = {}) const {
    throw InputError(name_ + ", line " + std::to_string(n_), what, std::string(got.substr(0, 40)));
  }
  double needed(std::string_view word, const char* what) const {
    const std::optional<double> value = number(word);
    if (!value || !std::isfinite(*value)) fail(std::string(what) + " is no number", word);
    return *value;
  }
  std::int64_t id(std::string_view word) const {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) fail("is no number of a bubble", word);
    return value;
  }
  void start(const std::vector<std::string_view>& words);
  void end(const std::vector<std::string_view>& words);
  void sample(const std::vector<std::string_view>& words);
  void close();

  std::string name_;
  std::size_t n_ = 0;
  bool open_ = false, started_ = false, ended_ = false;
  BubblePath path_;
  TrackedBubbles result_;
};

void Reader::line(std::string_view text) {
  ++n_;
  const std::vector<std::string_view> words = words_in(text);
  if (words.empty() || words[0].front() == '#') return;
  if (words[0] == "Bub") {
    close();
    if (words.size() != 3) fail("a bubble has a number and a radius", text);
    path_.id = id(words[1]);
    path_.radius_m = needed(words[2], "the radius");
    if (!(path_.radius_m > 0.0 && path_.radius_m <= 1.0)) fail("the radius is not between 0 and 1 m", words[2]);
    open_ = true;
    return;
  }
  if (!open_) fail("stands before the first Bub", text);
  if (words[0] == "Start:") return start(words);
  if (words[0] == "End:") return end(words);
  sample(words);
}

void Reader::start(const std::vector<std::string_view>& words) {
  if (started_ || words.size() < 3) fail("one Start: with a letter and a time is expected");
  if (words[1] != "N" && words[1] != "M" && words[1] != "S") fail("a bubble starts by N, M or S", words[1]);
  path_.start = words[1] == "N" ? StartKind::kEntrained : words[1] == "M" ? StartKind::kMerged : StartKind::kSplit;
  path_.told_birth_s = needed(words[2], "the time");
  for (std::size_t i = 3; i < words.size(); ++i) path_.parents.push_back(id(words[i]));
  started_ = true;
}

void Reader::end(const std::vector<std::string_view>& words) {
  if (!started_ || ended_ || words.size() < 3) fail("one End: with a letter and a time is expected after Start:");
  if (words[1] != "C" && words[1] != "M" && words[1] != "S") fail("a bubble ends by M, S or C", words[1]);
  path_.end = words[1] == "C" ? EndKind::kSurface : words[1] == "M" ? EndKind::kMerge : EndKind::kSplit;
  path_.told_end_s = needed(words[2], "the time");
  for (std::size_t i = 3; i < words.size(); ++i) path_.children.push_back(id(words[i]));
  ended_ = true;
}

void Reader::sample(const std::vector<std::string_view>& words) {
  if (!started_ || ended_) fail("a sample stands outside of Start: and End:");
  if (words.size() < 5 || words.size() > 7)
    fail("a sample has time, frequency, x, y, z and perhaps pressure and depth");
  const double time = needed(words[0], "the time");
  if (!path_.time_s.empty() && !(time > path_.time_s.back())) fail("the time does not rise", words[0]);
  const std::optional<double> frequency = number(words[1]);
  Vector3d place;
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[static_cast<Eigen::Index>(axis)] = needed(words[axis + 2], "a place");
  if (!frequency || !std::isfinite(*frequency) || *frequency <= 0.0) {
    ++result_.n_without_frequency;
    return;
  }
  path_.time_s.push_back(time);
  path_.frequency_hz.push_back(*frequency);
  path_.position_m.emplace_back(place.x(), -place.z(), place.y());
  path_.phi_m.push_back(words.size() == 7 ? -needed(words[6], "the depth") : std::numeric_limits<double>::quiet_NaN());
}

void Reader::close() {
  if (!open_) return;
  if (!ended_) fail("bubble " + std::to_string(path_.id) + " has no End:");
  if (path_.time_s.empty()) {
    ++result_.n_left_out;
  } else {
    const double first_s = path_.time_s.front(), last_s = path_.time_s.back();
    result_.n_outside += *path_.told_birth_s > first_s || *path_.told_end_s < last_s ? 1U : 0U;
    if (!(*path_.told_birth_s < first_s)) path_.told_birth_s.reset();
    if (!(*path_.told_end_s > last_s)) path_.told_end_s.reset();
    path_.time_s.shrink_to_fit();
    path_.frequency_hz.shrink_to_fit();
    path_.position_m.shrink_to_fit();
    path_.phi_m.shrink_to_fit();
    result_.paths.push_back(std::move(path_));
  }
  path_ = {};
  open_ = started_ = ended_ = false;
}

TrackedBubbles Reader::finish() {
  close();
  if (result_.paths.empty() && result_.n_left_out == 0)
    throw InputError(name_, "holds no bubble", "", "lines \"Bub ID RADIUS\"");
  return std::move(result_);
}

bool is_packed(const std::filesystem::path& path) { return path.extension() == ".xz"; }

}  // namespace

TrackedBubbles parse_tracked_bubbles(const std::string& text, const std::string& name) {
  Reader reader(name);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find('\n', i), text.size());
    reader.line(std::string_view(text).substr(i, end - i));
    i = end + 1;
  }
  return reader.finish();
}

TrackedBubbles read_tracked_bubbles(const std::filesystem::path& path) {
  std::error_code error;
  if (!is_packed(path) && std::filesystem::is_regular_file(path, error)) {  // gigabytes, which need not be held as text
    std::ifstream in(path);
    if (in && std::filesystem::file_size(path, error) <= kMostBytes) {
      Reader reader(path.string());
      for (std::string line; std::getline(in, line);) reader.line(line);
      return reader.finish();
    }
  }
  const std::string bytes = read_file(path, kMostBytes);
  return parse_tracked_bubbles(is_packed(path) ? unpacked(bytes, path.string()) : bytes, path.string());
}

std::string tracked_bubbles_text(const std::vector<BubblePath>& paths) {
  std::string text;
  const auto add = [&](const char* lead, const std::string& kind, double time,
                       const std::vector<std::int64_t>& others) {
    text += std::string("  ") + lead + " " + kind + " " + to_text(time);
    for (const std::int64_t other : others) text += " " + std::to_string(other);
    text += "\n";
  };
  for (const BubblePath& path : paths) {
    text += "Bub " + std::to_string(path.id) + " " + to_text(path.radius_m) + "\n";
    add("Start:",
        path.start == StartKind::kEntrained ? "N"
        : path.start == StartKind::kMerged  ? "M"
                                            : "S",
        path.birth_s(), path.parents);
    for (std::size_t i = 0; i < path.time_s.size(); ++i) {
      const Vector3d& x = path.position_m[i];
      text += "  " + to_text(path.time_s[i]) + " " + to_text(path.frequency_hz[i]) + " " + to_text(x.x()) + " " +
              to_text(x.z()) + " " + to_text(x.y() == 0.0 ? 0.0 : -x.y());
      if (std::isfinite(path.phi_m[i])) text += " 0 " + to_text(path.phi_m[i] == 0.0 ? 0.0 : -path.phi_m[i]);
      text += "\n";
    }
    add("End:",
        path.end == EndKind::kMerge   ? "M"
        : path.end == EndKind::kSplit ? "S"
                                      : "C",
        path.end_s(), path.children);
  }
  return text;
}

void write_tracked_bubbles(const std::filesystem::path& path, const std::vector<BubblePath>& paths) {
  const std::string text = tracked_bubbles_text(paths);
  write_file(path, is_packed(path) ? packed(text) : text);
}

}  // namespace klang::entrainment
