#include "apps/kit/number_options.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::apps {
namespace {

double parse_number(const std::string& option, std::string_view text) {
  double value = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || !std::isfinite(value)) {
    throw InputError(option, "is not a number", text);
  }
  return value;
}

}  // namespace

void add_band_option(CLI::App& app, CommonOptions& common, std::string& band, const std::string& help) {
  app.add_option("--band-hz", band, help)->capture_default_str();
  for (const char* field : {"band.low_hz", "band.high_hz"}) name_field(app, common, field, "--band-hz");
}

Band parse_band(const std::string& option, const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) throw InputError(option, "is not LOW:HIGH", text, "for example 20:20000");
  const Band band{parse_number(option, std::string_view(text).substr(0, colon)),
                  parse_number(option, std::string_view(text).substr(colon + 1))};
  if (!(band.low_hz >= 0.0 && band.low_hz < band.high_hz)) {
    throw InputError(option, "is not a band", text, "0 <= LOW < HIGH");
  }
  return band;
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text, int n) {
  std::vector<double> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    numbers.push_back(parse_number(option, std::string_view(text).substr(begin, end - begin)));
    begin = end + 1;
  }
  if (n >= 0 && static_cast<int>(numbers.size()) != n) {
    throw InputError(option, "has the wrong number of values", text, std::to_string(n) + " separated by commas");
  }
  return numbers;
}

Eigen::Vector3d parse_vector(const std::string& option, const std::string& text) {
  const std::vector<double> numbers = parse_numbers(option, text, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace klang::apps
