#include "core/sound/audio/note.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::audio {
namespace {

constexpr int kA4 = 69, kLowestKey = 0, kHighestKey = 155;
constexpr std::size_t kMaxScalaBytes = 1 << 16;

int floor_divided(int a, int b) { return a / b - (a % b < 0 ? 1 : 0); }

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

double number_of(std::string_view text, const std::string& place) {
  double value = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || !std::isfinite(value))
    throw InputError(place, "is no degree", text.substr(0, 40), "cents with a point, or a ratio such as 3/2");
  return value;
}

/// "701.955" (cents, for the point), "3/2" or "2"; what follows a blank is a comment.
double ratio_of(std::string_view line, const std::string& place) {
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  if (word.find('.') != std::string_view::npos) return std::exp2(number_of(word, place) / 1200.0);
  const auto slash = word.find('/');
  const double above = number_of(word.substr(0, slash), place);
  return slash == std::string_view::npos ? above : above / number_of(word.substr(slash + 1), place);
}

}  // namespace

std::string note_of_key(int key) {
  constexpr const char* kNames[] = {"C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"};
  const int octave = floor_divided(key, 12);
  return kNames[key - 12 * octave] + std::to_string(octave - 1);
}

NearestNote nearest_note(double frequency_hz, double a4_hz) {
  const double semitones = 12.0 * std::log2(frequency_hz / a4_hz);
  const double nearest = std::round(semitones);
  return {note_of_key(kA4 + static_cast<int>(nearest)), 100.0 * (semitones - nearest)};
}

int key_of_note(std::string_view name) {
  constexpr std::string_view kLetters = "CDEFGAB";
  constexpr int kSemitones[] = {0, 2, 4, 5, 7, 9, 11};
  const auto refuse = [&]() -> InputError {
    return {"note", "is none", name.substr(0, 40), "for example D5, F#4 or Bb3; C-1 to B11"};
  };
  const auto letter = name.empty()
                          ? std::string_view::npos
                          : kLetters.find(static_cast<char>(std::toupper(static_cast<unsigned char>(name[0]))));
  if (letter == std::string_view::npos) throw refuse();
  int key = kSemitones[letter];
  std::size_t at = 1;
  for (; at < name.size() && (name[at] == '#' || name[at] == 'b'); ++at) key += name[at] == '#' ? 1 : -1;
  int octave = 0;
  const auto parsed = std::from_chars(name.data() + at, name.data() + name.size(), octave);
  if (parsed.ec != std::errc() || parsed.ptr != name.data() + name.size() || octave < -1 || octave > 11) throw refuse();
  key += 12 * (octave + 1);
  if (at > 4 || key < kLowestKey || key > kHighestKey) throw refuse();
  return key;
}

Temperament Temperament::equal() {
  Temperament result;
  result.name_ = "equal";
  for (std::size_t i = 0; i < 12; ++i) result.ratio_[i] = std::exp2(static_cast<double>(i) / 12.0);
  return result;
}

Temperament Temperament::just() {
  Temperament result;
  result.name_ = "just";
  result.ratio_ = {1.0,       16.0 / 15.0, 9.0 / 8.0, 6.0 / 5.0, 5.0 / 4.0, 4.0 / 3.0,
                   45.0 / 32, 3.0 / 2.0,   8.0 / 5.0, 5.0 / 3.0, 9.0 / 5.0, 15.0 / 8.0};
  return result;
}

Temperament Temperament::read_scala(const std::filesystem::path& path) {
  const std::string text = read_file(path, kMaxScalaBytes), file = path.string();
  std::vector<double> degrees;
  int n_lines = 0, line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = trimmed(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    if (line.starts_with('!')) continue;
    ++n_lines;  // the first describes the scale and may be empty
    const std::string place = file + ", line " + std::to_string(line_number);
    if (n_lines == 2) {
      const std::string_view count = line.substr(0, line.find_first_of(" \t"));
      if (count != "12") throw InputError(place, "is no scale of twelve degrees", count.substr(0, 40), "12");
    }
    if (n_lines <= 2 || degrees.size() == 12) continue;
    if (line.empty()) throw InputError(place, "is empty", "", "a degree");
    degrees.push_back(ratio_of(line, place));
    const double before = degrees.size() > 1 ? degrees[degrees.size() - 2] : 1.0;
    if (!(degrees.back() > before && degrees.back() <= 16.0))
      throw InputError(place, "does not lie above the degree before", line.substr(0, 40));
  }
  if (degrees.size() != 12) throw InputError(file, "has too few degrees", std::to_string(degrees.size()), "12");
  Temperament result;
  result.name_ = path.filename().string();
  result.ratio_[0] = 1.0;
  std::copy(degrees.begin(), degrees.end() - 1, result.ratio_.begin() + 1);
  result.octave_ = degrees.back();
  return result;
}

Temperament Temperament::parse(const std::string& text) {
  if (text == "equal") return equal();
  if (text == "just") return just();
  if (text.ends_with(".scl")) return read_scala(text);
  throw option_error("temperament", "is unknown", text.substr(0, 80),
                     "equal, just or a .scl file" + did_you_mean(text, {"equal", "just"}));
}

double Temperament::frequency_hz(int key, double a4_hz) const {
  const auto relative = [this](int k) {
    const int octave = floor_divided(k, 12);
    return std::pow(octave_, octave) * ratio_[static_cast<std::size_t>(k - 12 * octave)];
  };
  return a4_hz * relative(key) / relative(kA4);
}

}  // namespace klang::audio
