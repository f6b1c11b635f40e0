#include "core/foundation/config/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// A number with a decimal comma as one with a point; other texts as they are.
std::string with_point(std::string_view text) {
  std::string result(text);
  const std::size_t comma = result.find(',');
  if (comma != std::string::npos && result.find('.') == std::string::npos) result[comma] = '.';
  return result;
}

/// In the lines that count.
bool has_number_with_point(std::string_view bytes) {
  const auto is_digit = [&](std::size_t i) { return i < bytes.size() && bytes[i] >= '0' && bytes[i] <= '9'; };
  for (std::size_t at = bytes.find('.'); at != std::string_view::npos; at = bytes.find('.', at + 1)) {
    if (at == 0 || !is_digit(at - 1) || !is_digit(at + 1)) continue;
    const std::size_t line = bytes.rfind('\n', at) + 1;  // npos + 1 = 0
    if (!trimmed(bytes.substr(line, at - line)).starts_with('#')) return true;
  }
  return false;
}

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path, std::size_t max_bytes)
    : CsvFile(read_file(path, max_bytes), path.string()) {}

CsvFile::CsvFile(std::string bytes, std::string name) : name_(std::move(name)), bytes_(std::move(bytes)) {
  if (bytes_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  if (bytes_.starts_with("\xFF\xFE") || bytes_.starts_with("\xFE\xFF"))
    throw InputError(name_, "is text of 16-bit characters", {}, "UTF-8 (save it as CSV UTF-8)");
  if (bytes_.find('\0') != std::string::npos) throw InputError(name_, "holds a zero byte", {}, "a table as text");
  // Lines of old Macs, and of some spreadsheets, end with a carriage return alone.
  if (bytes_.find('\n') == std::string::npos) std::replace(bytes_.begin(), bytes_.end(), '\r', '\n');
}

bool CsvFile::next() {
  while (at_ < bytes_.size()) {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view raw = std::string_view(bytes_).substr(at_, end - at_);
    if (raw.ends_with('\r')) raw.remove_suffix(1);
    at_ = end + 1;
    ++line_number_;
    const std::string_view line = trimmed(raw);
    if (line.empty() || line.front() == '#') continue;
    if (separator_ == '\0') find_separator(line);
    split(separator_ == '\t' ? raw : line);  // a tab at the end leaves an empty cell
    return true;
  }
  return false;
}

void CsvFile::find_separator(std::string_view line) {
  bool quoted = false, has_semicolon = false, has_tab = false, has_comma = false;
  for (const char c : line) {
    quoted = quoted != (c == '"');
    has_semicolon = has_semicolon || (!quoted && c == ';');
    has_tab = has_tab || (!quoted && c == '\t');
    has_comma = has_comma || (!quoted && c == ',');
  }
  // Tabs beside commas are blanks, unless a comma stands in each cell as the mark of a number.
  if (has_tab && has_comma) {
    for (std::size_t at = 0; has_tab && at <= line.size();) {
      const std::size_t end = std::min(line.find('\t', at), line.size());
      has_tab = csv_number(with_point(trimmed(line.substr(at, end - at)))).has_value();
      at = end + 1;
    }
  }
  separator_ = has_semicolon ? ';' : has_tab ? '\t' : ',';
  decimal_comma_ = separator_ != ',' && !has_number_with_point(bytes_);
}

void CsvFile::split(std::string_view line) {
  cells_.clear();
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    const bool at_begin = trimmed(line.substr(begin, i - begin)).empty();  // a quote elsewhere is a character (5")
    if (i < line.size() && line[i] == '"' && (quoted || at_begin)) quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != separator_)) continue;
    cells_.push_back(cell_of(trimmed(line.substr(begin, i - begin))));
    begin = i + 1;
  }
}

std::string_view CsvFile::cell_of(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
    text = trimmed(text.substr(1, text.size() - 2));
    if (text.find("\"\"") != std::string_view::npos) {
      std::string& made = made_cells_.emplace_back();
      for (std::size_t i = 0; i < text.size(); ++i) {
        made += text[i];
        if (text.substr(i, 2) == "\"\"") ++i;
      }
      text = made;
    }
  }
  if (!decimal_comma_ || text.find(',') == std::string_view::npos) return text;
  std::string number = with_point(text);
  return csv_number(number) ? made_cells_.emplace_back(std::move(number)) : text;
}

std::optional<double> csv_number(std::string_view cell) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  double value = 0.0;
  const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != cell.data() + cell.size()) return std::nullopt;
  return value;
}

double csv_number(std::string_view cell, std::string_view place, std::string_view allowed) {
  const auto value = csv_number(cell);
  if (!value) throw InputError(place, "is not a number", cell.substr(0, 40), allowed);
  if (!std::isfinite(*value)) throw InputError(place, "is not finite", cell.substr(0, 40), allowed);
  return *value;
}

}  // namespace klang
