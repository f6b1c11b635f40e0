#include "core/geometry/files/byte_cursor.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::mesh {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }

std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text.substr(0, 32)) result += c >= ' ' && c <= '~' ? c : '?';
  return result;
}

}  // namespace

bool parse_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range && end == word.data() + word.size()) {
    value = 0.0;  // too small or too large for a double: only the first is usual ("1e-320")
    return word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos;
  }
  return error == std::errc() && end == word.data() + word.size();
}

bool parse_integer(std::string_view word, long long& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while (at < line.size()) {
    while (at < line.size() && is_blank(line[at])) ++at;
    const std::size_t begin = at;
    while (at < line.size() && !is_blank(line[at])) ++at;
    if (at > begin) words.push_back(line.substr(begin, at - begin));
  }
  return words;
}

bool ByteCursor::skip_blanks() {
  while (at_ < bytes_.size()) {
    if (is_blank(bytes_[at_])) {
      ++at_;
    } else if (comment_ != '\0' && bytes_[at_] == comment_) {
      while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
    } else {
      return true;
    }
  }
  return false;
}

std::string_view ByteCursor::line() {
  const std::size_t begin = at_;
  while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
  std::string_view result = bytes_.substr(begin, at_ - begin);
  if (at_ < bytes_.size()) ++at_;
  if (!result.empty() && result.back() == '\r') result.remove_suffix(1);
  return result;
}

std::string_view ByteCursor::peek_word() {
  if (!skip_blanks()) return {};
  std::size_t end = at_;
  while (end < bytes_.size() && !is_blank(bytes_[end])) ++end;
  return bytes_.substr(at_, end - at_);
}

std::string_view ByteCursor::word(std::string_view what) {
  const std::string_view result = peek_word();
  if (result.empty()) fail("the file ends before " + std::string(what));
  at_ += result.size();
  return result;
}

double ByteCursor::number(std::string_view what) {
  const std::string_view text = word(what);
  double value = 0.0;
  if (!parse_number(text, value)) fail(std::string(what) + " is not a number", printable(text));
  return value;
}

long long ByteCursor::integer(std::string_view what) {
  const std::string_view text = word(what);
  long long value = 0;
  if (!parse_integer(text, value)) fail(std::string(what) + " is not an integer", printable(text));
  return value;
}

std::size_t ByteCursor::count(std::string_view what, std::size_t bytes_each) {
  return checked_count(static_cast<double>(integer(what)), what, bytes_each);
}

std::size_t ByteCursor::checked_count(double n, std::string_view what, std::size_t bytes_each) {
  const double most = static_cast<double>(remaining()) / static_cast<double>(bytes_each) + 1.0;
  if (!(n >= 0.0 && n <= most && n <= 2147483647.0 && n == std::floor(n)))
    fail(std::string(what) + " does not fit the length of the file", to_text(n),
         "0 to " + to_text(std::min(most, 2147483647.0)));
  return static_cast<std::size_t>(n);
}

void ByteCursor::need(std::size_t n_bytes, std::string_view what) {
  if (remaining() < n_bytes) fail("the file ends inside " + std::string(what));
}

void ByteCursor::skip(std::size_t n_bytes, std::string_view what) {
  need(n_bytes, what);
  at_ += n_bytes;
}

void ByteCursor::fail(std::string_view problem, std::string_view value, std::string_view allowed) const {
  std::string place = name_;
  if (binary_)
    place += ": byte " + std::to_string(at_);
  else
    place += ": line " +
             std::to_string(1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
  throw InputError(place, problem, value, allowed);
}

}  // namespace klang::mesh
