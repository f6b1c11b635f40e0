#include "core/foundation/base/errors.hpp"

#include <charconv>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/nearest_word.hpp"

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

/// The words of "one of a, b or c".
std::vector<std::string> words_of_list(std::string_view list) {
  constexpr std::string_view kOneOf = "one of ";
  if (list.starts_with(kOneOf)) list.remove_prefix(kOneOf.size());
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= list.size();) {
    std::size_t end = list.size(), next = list.size() + 1;
    for (const std::string_view between : {std::string_view(", "), std::string_view(" or ")}) {
      const std::size_t found = list.find(between, at);
      if (found >= end) continue;
      end = found;
      next = found + between.size();
    }
    words.emplace_back(list.substr(at, end - at));
    at = next;
  }
  return words;
}

std::string_view without_quotes(std::string_view text) {
  const bool quoted = text.size() > 1 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front();
  return quoted ? text.substr(1, text.size() - 2) : text;
}

std::string one_line(std::string_view place, std::string_view problem, std::string_view value,
                     std::string_view allowed) {
  // A word that may have been meant ends the line (nearest_word.hpp): what the caller found or, where a word is unknown, one of those allowed.
  const std::size_t meant = allowed.find("; did you mean ");
  std::string hint(meant == std::string_view::npos ? std::string_view() : allowed.substr(meant));
  allowed = allowed.substr(0, meant);
  if (hint.empty() && problem.find("unknown") != std::string_view::npos)
    hint = did_you_mean(without_quotes(value), words_of_list(allowed));
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
