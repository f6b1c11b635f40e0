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

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path, std::size_t max_bytes)
    : name_(path.string()), bytes_(read_file(path, max_bytes)) {
  if (bytes_.starts_with("\xEF\xBB\xBF")) at_ = 3;
}

bool CsvFile::next() {
  while (at_ < bytes_.size()) {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view line = trimmed(std::string_view(bytes_).substr(at_, end - at_));
    at_ = end + 1;
    ++line_number_;
    if (line.empty() || line.front() == '#') continue;
    cells_.clear();
    for (;;) {
      const std::size_t comma = line.find(',');
      cells_.push_back(trimmed(line.substr(0, comma)));
      if (comma == std::string_view::npos) return true;
      line.remove_prefix(comma + 1);
    }
  }
  return false;
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
