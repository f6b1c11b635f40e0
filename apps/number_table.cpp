#include "number_table.hpp"

#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/base/errors.hpp"
#include "core/base/output_file.hpp"

namespace klang::apps {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

bool parse(std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  return parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
}

}  // namespace

Eigen::MatrixXd read_number_table(const std::filesystem::path& path, int n_columns, const std::string& columns) {
  const std::string bytes = read_file(path);
  std::vector<double> values;
  bool first = true;
  int line_number = 0;
  for (std::size_t begin = 0; begin < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
    std::string_view line(bytes.data() + begin, end - begin);
    begin = end + 1;
    ++line_number;
    if (line_number == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const std::string place = path.string() + ", line " + std::to_string(line_number);
    std::vector<double> row;
    bool is_header = false;
    for (std::size_t at = 0; at <= line.size();) {
      const std::size_t comma = std::min(line.find(',', at), line.size());
      const std::string_view cell = trimmed(line.substr(at, comma - at));
      at = comma + 1;
      double value = 0.0;
      if (!parse(cell, value)) {
        if (first && row.empty()) {
          is_header = true;
          break;
        }
        throw InputError(place, "is not a number", cell.substr(0, 40), columns);
      }
      if (!std::isfinite(value)) throw InputError(place, "is not finite", cell.substr(0, 40), columns);
      row.push_back(value);
    }
    first = false;
    if (is_header) continue;
    if (static_cast<int>(row.size()) != n_columns)
      throw InputError(place, "has the wrong number of columns", std::to_string(row.size()), columns);
    values.insert(values.end(), row.begin(), row.end());
  }
  if (values.empty()) throw InputError(path.string(), "has no rows", "", columns);
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), static_cast<Eigen::Index>(values.size()) / n_columns, n_columns);
}

}  // namespace klang::apps
