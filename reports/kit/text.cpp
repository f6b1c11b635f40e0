#include "reports/kit/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/physics/modal/damping/damping_laws.hpp"

namespace klang::reports::detail {
namespace {

constexpr std::string_view kMinus = "\u2212";
constexpr std::string_view kThinSpace = "\u202f";

std::string plain_fixed(double value, int decimals) {
  std::array<char, 400> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed,
                                 std::clamp(decimals, 0, 12));
  return {buffer.data(), end.ptr};
}

std::string with_true_minus(std::string text) {
  if (text.empty() || text.front() != '-') return text;
  const bool zero = text.find_first_of("123456789") == std::string::npos;
  return (zero ? std::string() : std::string(kMinus)) + text.substr(1);
}

int exponent_of(double value) { return static_cast<int>(std::floor(std::log10(std::abs(value)))); }

/// Length of the UTF-8 sequence that starts at i, 0 when it is not one.
std::size_t sequence_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(i);
  const std::size_t n = first < 0x80                    ? 1
                        : first >= 0xc2 && first < 0xe0 ? 2
                        : first >= 0xe0 && first < 0xf0 ? 3
                        : first >= 0xf0 && first < 0xf5 ? 4
                                                        : 0;
  if (n == 0 || i + n > text.size()) return 0;
  for (std::size_t k = 1; k < n; ++k) {
    if ((byte(i + k) & 0xc0) != 0x80) return 0;
  }
  if (n == 3 && ((first == 0xe0 && byte(i + 1) < 0xa0) || (first == 0xed && byte(i + 1) >= 0xa0))) return 0;
  if (n == 4 && ((first == 0xf0 && byte(i + 1) < 0x90) || (first == 0xf4 && byte(i + 1) >= 0x90))) return 0;
  return n;
}

struct Known {
  std::string_view name, words, symbol;
};
constexpr Known kKnown[] = {
    {"lame_lambda_pa", "first Lamé parameter", "λ"},
    {"lame_mu_pa", "shear modulus", "μ"},
    {"shear_modulus_pa", "shear modulus", "G"},
    {"bulk_modulus_pa", "bulk modulus", "K"},
    {"youngs_modulus_pa", "Young’s modulus", "E"},
    {"poissons_ratio", "Poisson’s ratio", "ν"},
    {"density_kg_m3", "density", "ρ"},
    {"mass_kg", "mass", "m"},
    {"mount_damping_n_s_per_m", "damping of each mount", "c"},
    {"relaxation_strength", "relaxation strength", "Δ"},
    {"zener_time_s", "relaxation time", "τ"},
    {"relaxation_time_s", "relaxation time", "τ"},
    {"zener_relaxation_strength", "relaxation strength", "Δ"},
};

struct Suffix {
  std::string_view suffix, unit;
  bool prefixed;
};
// Longest first: "_per_s" before "_s".
constexpr Suffix kSuffixes[] = {{"_n_s_per_m", "N s/m", false},
                                {"_kg_m3", "kg/m³", false},
                                {"_per_s", "1/s", false},
                                {"_cents", "cents", false},
                                {"_rad", "rad", false},
                                {"_hz", "Hz", true},
                                {"_kg", "g", true},
                                {"_pa", "Pa", true},
                                {"_m", "m", true},
                                {"_s", "s", true}};

/// Engineering prefix that leaves 1 to 1000 before the point.
void add_prefix(double magnitude, Quantity& quantity) {
  static constexpr std::array<std::string_view, 9> kPrefixes = {"p", "n", "µ", "m", "", "k", "M", "G", "T"};
  if (!(std::isfinite(magnitude) && magnitude != 0)) return;
  int third = static_cast<int>(std::floor(std::log10(std::abs(magnitude)) / 3 + 1e-12));
  // Lengths and seconds above one are not said in kilo.
  const int highest = quantity.unit == "m" || quantity.unit == "s" ? 0 : 4;
  third = std::clamp(third, -4, highest);
  quantity.factor *= std::pow(10.0, -3 * third);
  quantity.unit = std::string(kPrefixes[static_cast<std::size_t>(third + 4)]) + quantity.unit;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t n = sequence_length(text, i);
    if (n == 0) {
      result += "\ufffd";
      ++i;
      continue;
    }
    const char c = text[i];
    if (n > 1) {
      result.append(text.substr(i, n));
    } else if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '"') {
      result += "&quot;";
    } else if (c == '\'') {
      result += "&#39;";
    } else if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) {
      result += c;
    } else if (c == '\n' || c == '\t') {
      result += c;
    }
    i += n;
  }
  return result;
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "—";
  return with_true_minus(plain_fixed(value, decimals));
}

std::string rounded(double value, int digits) {
  if (!std::isfinite(value)) return "—";
  if (value == 0) return "0";
  int exponent = exponent_of(value);
  if (exponent >= -4 && exponent < 7) {
    std::string text = plain_fixed(value, std::max(0, digits - 1 - exponent));
    if (text.find('.') != std::string::npos) {
      while (text.back() == '0') text.pop_back();
      if (text.back() == '.') text.pop_back();
    }
    return with_true_minus(text);
  }
  const double mantissa = value / std::pow(10.0, exponent);
  static constexpr std::array<std::string_view, 10> kSuper = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string power = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) power += kSuper[static_cast<std::size_t>(c - '0')];
  return rounded(mantissa, digits) + std::string(kThinSpace) + "×" + std::string(kThinSpace) + "10" + power;
}

std::string coordinate(double value) {
  std::string text = plain_fixed(std::isfinite(value) ? value : 0.0, 2);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

int decimals_for(double standard_deviation, int at_most) {
  if (!(standard_deviation > 0) || !std::isfinite(standard_deviation)) return std::min(at_most, 3);
  int decimals = 1 - exponent_of(standard_deviation);
  // 0.0996 shown with two digits is 0.100: one digit fewer is enough.
  if (std::round(standard_deviation * std::pow(10.0, decimals)) >= 100) --decimals;
  return std::clamp(decimals, 0, at_most);
}

Quantity quantity(std::string_view name, double magnitude) {
  Quantity result;
  std::string_view bare = name;
  std::string owner;
  const std::size_t dot = name.rfind('.');
  if (dot != std::string_view::npos && dot + 1 < name.size()) {
    owner = std::string(name.substr(0, dot));
    bare = name.substr(dot + 1);
  }
  for (const Known& known : kKnown) {
    if (known.name == bare) {
      result.words = known.words;
      result.symbol = known.symbol;
    }
  }
  for (const damping::DampingLaw* law : damping::damping_laws()) {
    for (const damping::LawParameter& parameter : law->parameters()) {
      if (parameter.name != bare) continue;
      result.words = parameter.words;
      result.symbol = parameter.symbol;
    }
  }
  std::string_view stem = bare;
  for (const Suffix& suffix : kSuffixes) {
    if (bare.size() > suffix.suffix.size() && bare.ends_with(suffix.suffix)) {
      result.unit = suffix.unit;
      if (suffix.suffix == "_kg") {
        result.factor = 1000;
        magnitude *= 1000;
      }
      if (suffix.prefixed) add_prefix(magnitude, result);
      stem = bare.substr(0, bare.size() - suffix.suffix.size());
      break;
    }
  }
  if (result.words.empty()) {
    result.words = std::string(stem);
    std::replace(result.words.begin(), result.words.end(), '_', ' ');
  }
  if (!owner.empty()) result.words += " of " + owner;
  return result;
}

std::string ShownEstimate::value_with_std() const {
  std::string text = value;
  if (!std.empty()) text += " ± " + std;
  if (!quantity.unit.empty()) text += std::string(kThinSpace) + quantity.unit;
  return text;
}

std::string ShownEstimate::interval() const {
  if (low.empty()) return {};
  return low + " to " + high + (quantity.unit.empty() ? "" : std::string(kThinSpace) + quantity.unit);
}

ShownEstimate shown(std::string_view name, const Number& value, const Number& std,
                    const std::optional<std::array<double, 2>>& ci95) {
  ShownEstimate result;
  result.quantity = quantity(name, value.value_or(0));
  const double factor = result.quantity.factor;
  const bool has_std = std && *std > 0;
  const int decimals = has_std ? decimals_for(*std * factor) : -1;
  const auto text = [&](double si) { return has_std ? fixed(si * factor, decimals) : rounded(si * factor, 5); };
  result.value = value ? text(*value) : "—";
  if (has_std) result.std = text(*std);
  if (ci95) {
    result.low = text((*ci95)[0]);
    result.high = text((*ci95)[1]);
  }
  return result;
}

std::string hertz(double frequency_hz, const std::optional<double>& std_hz) {
  const int decimals = std_hz && *std_hz > 0
                           ? std::min(decimals_for(*std_hz), 4)
                           : std::clamp(5 - exponent_of(std::max(std::abs(frequency_hz), 1e-3)), 0, 4);
  return fixed(frequency_hz, decimals) + std::string(kThinSpace) + "Hz";
}

std::string signed_cents(double value) {
  const int decimals = std::abs(value) < 0.095 ? 2 : std::abs(value) < 99.5 ? 1 : 0;
  const std::string text = fixed(value, decimals);
  return value > 0 && text.find_first_of("123456789") != std::string::npos ? "+" + text : text;
}

std::string damping_words(std::string_view model) {
  if (const damping::DampingLaw* law = damping::find_law(model)) return std::string(law->words());
  for (const auto& [suffix, words] :
       {std::pair<std::string_view, const char*>{"_and_mount", " and mounts"},
        std::pair<std::string_view, const char*>{"_and_radiation", " beside radiation"}}) {
    if (model.size() > suffix.size() && model.ends_with(suffix))
      return damping_words(model.substr(0, model.size() - suffix.size())) + words;
  }
  std::string words(model);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string share(double value) {
  if (value > 0.9995) return "> 0.999";
  if (value < 0.0005) return "< 0.001";
  return fixed(value, 3);
}

std::string counted(std::size_t n, std::string_view singular, std::string_view plural) {
  return (n == 0 ? "no" : std::to_string(n)) + " " + std::string(n == 1 ? singular : plural);
}

std::string file_stem(std::string_view name) {
  std::string stem;
  for (const char c : name.substr(0, 60)) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
    stem += plain ? c : '_';
  }
  while (!stem.empty() && stem.front() == '.') stem.erase(stem.begin());
  return stem.empty() ? "specimen" : stem;
}

}  // namespace klang::reports::detail
