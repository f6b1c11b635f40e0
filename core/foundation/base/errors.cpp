#include "core/foundation/base/errors.hpp"

#include <charconv>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang {
namespace {

/// A value as it was given, of which a file may have megabytes: its beginning, cut between characters.
std::string shortened(std::string_view value) {
  constexpr std::size_t kShown = 200;
  if (value.size() <= kShown) return std::string(value);
  std::size_t end = kShown;
  while (end > 0 && (static_cast<unsigned char>(value[end]) & 0xC0U) == 0x80U) --end;
  return std::string(value.substr(0, end)) + "... (" + std::to_string(value.size()) + " bytes)";
}

std::string one_line(std::string_view place, std::string_view problem, std::string_view value,
                     std::string_view allowed) {
  // A word that may have been meant ends the line, wherever the values that are allowed name it (nearest_word.hpp).
  const std::size_t meant = allowed.find("; did you mean ");
  const std::string_view hint = meant == std::string_view::npos ? std::string_view() : allowed.substr(meant);
  allowed = allowed.substr(0, meant);
  std::string text(place);
  if (!text.empty()) text += ": ";
  text += problem;
  if (!value.empty() || !allowed.empty()) {
    text += " (";
    text += shortened(value);
    if (!value.empty() && !allowed.empty()) text += "; ";
    if (!allowed.empty()) text.append("allowed: ").append(allowed);
    text += ")";
  }
  text += hint;
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  }
  return text;
}

}  // namespace

InputError::InputError(std::string_view place, std::string_view problem, std::string_view value,
                       std::string_view allowed)
    : std::runtime_error(one_line(place, problem, value, allowed)) {}

std::string to_text(double value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value);
  return {buffer, end.ptr};
}

double checked(std::string_view place, std::string_view name, double value, double low, double high) {
  if (value >= low && value <= high && std::isfinite(value)) return value;
  throw InputError(place, std::string(name) + " is out of range", to_text(value),
                   to_text(low) + " to " + to_text(high));
}

double checked_open(std::string_view place, std::string_view name, double value, double low, double high) {
  if (value > low && value < high && std::isfinite(value)) return value;
  throw InputError(place, std::string(name) + " is out of range", to_text(value),
                   "above " + to_text(low) + ", below " + to_text(high));
}

double cents(double frequency_hz, double reference_hz) { return 1200.0 * std::log2(frequency_hz / reference_hz); }

}  // namespace klang
