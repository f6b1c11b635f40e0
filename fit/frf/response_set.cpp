#include "fit/frf/response_set.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "fit/frf/detail/mat_file.hpp"

namespace klang::fit {
namespace {

constexpr Eigen::Index kFewestLines = 16, kMostLines = 4'000'000, kMostResponses = 4096;

std::string lower_extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return text;
}

}  // namespace

bool is_response_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".uff" || extension == ".unv" || extension == ".uf58" || extension == ".mat";
}

ResponseSet read_responses(const std::filesystem::path& path) {
  if (lower_extension(path) == ".mat") return detail::read_mat_responses(path);
  return read_universal_bytes(read_file(path), path.string());
}

int derivative_of_unit(const std::string& unit, const std::string& place) {
  std::string plain;
  for (const char c : unit)
    if (c != ' ' && c != '(' && c != ')' && c != '*' && c != '^') plain += c;
  if (const std::size_t at = plain.find("²"); at != std::string::npos) plain.replace(at, std::string("²").size(), "2");
  const auto has = [&](const char* text) { return plain.find(text) != std::string::npos; };
  const auto begins = [&](const char* text) { return plain.rfind(text, 0) == 0; };
  if (plain == "g" || begins("g/") || plain == "1/kg") return 2;
  if (begins("m/") || begins("mm/") || begins("um/") || plain == "m" || plain == "mm" || begins("ms-") || begins("mN-"))
    return has("s2") || has("s-2") ? 2 : has("s") ? 1 : 0;
  throw InputError(place, "unknown unit", unit,
                   "m/s^2/N, m/s/N or m/N, also of mm or g (the scale is not used); of decays m/s^2, m/s or m");
}

void validate(const ResponseSet& set) {
  const std::string& place = set.origin;
  checked(place, "responses", static_cast<double>(set.n_responses()), 1, static_cast<double>(kMostResponses));
  checked(place, "lines", static_cast<double>(set.n_lines()), static_cast<double>(kFewestLines),
          static_cast<double>(kMostLines));
  const char* name = set.in_time ? "time_s" : "frequency_hz";
  if (set.abscissa.size() != set.n_lines())
    throw InputError(place, std::string(name) + " and the responses differ in length",
                     std::to_string(set.abscissa.size()), std::to_string(set.n_lines()));
  for (Eigen::Index i = 0; i < set.abscissa.size(); ++i) {
    if (!std::isfinite(set.abscissa[i]) || (i > 0 && !(set.abscissa[i] > set.abscissa[i - 1])))
      throw InputError(place, std::string(name) + " does not rise", to_text(set.abscissa[i]));
  }
  if (!set.in_time && set.abscissa[0] < 0) throw InputError(place, "a frequency below 0", to_text(set.abscissa[0]));
  for (Eigen::Index r = 0; r < set.n_responses(); ++r) {
    if (!set.values.row(r).allFinite())
      throw InputError(place, "response " + std::to_string(r + 1) + " has a value that is no finite number");
  }
  if (set.in_time && !set.values.imag().isZero(0.0)) throw InputError(place, "free decays are complex");
  for (const ResponsePoint& point : set.points)
    if (std::abs(point.direction) > 3)
      throw InputError(place, "a response's direction is no axis (rotations are not read)",
                       std::to_string(point.direction), "1, 2, 3 with sign, or 0");
  for (const auto& [node, at_m] : set.nodes_m)
    if (!at_m.allFinite())
      throw InputError(place, "node " + std::to_string(node) + " has a coordinate that is no finite number");
  if (set.values.cwiseAbs().maxCoeff() == 0.0) throw InputError(place, "all responses are 0");
  if (set.values.cwiseAbs().maxCoeff() > 1e15) throw InputError(place, "a response above 1e15");
}

Band whole_band(const ResponseSet& set) {
  const Eigen::Index n = set.n_lines();
  if (!set.in_time) return {set.abscissa[0], set.abscissa[n - 1]};
  const double step_s = (set.abscissa[n - 1] - set.abscissa[0]) / static_cast<double>(n - 1);
  return {2.0 / (step_s * static_cast<double>(n)), 0.5 / step_s};
}

}  // namespace klang::fit
