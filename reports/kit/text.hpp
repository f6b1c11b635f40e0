#pragma once
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

/// Numbers and names as a reader sees them. The only place of the project where SI units are scaled.
namespace klang::reports::detail {

/// A number, where it was measured.
using Number = std::optional<double>;
inline Number measured(double value) { return std::isfinite(value) ? Number(value) : Number(); }

/// Text made safe inside HTML and SVG, in element content and in quoted attributes. Control characters are
/// dropped, bytes that are not UTF-8 become U+FFFD.
std::string escaped(std::string_view text);

/// Fixed notation with that many decimals (0 to 12) and a true minus sign; an em dash for what is not finite.
std::string fixed(double value, int decimals);

/// About that many significant digits, without an exponent between 1e-4 and 1e7 and as "1.2 × 10^5"
/// (superscript characters) elsewhere.
std::string rounded(double value, int digits = 4);

/// For SVG coordinates: at most two decimals, '.' whatever the locale, "-0" never.
std::string coordinate(double value);

/// Decimals that show a standard deviation with two significant digits.
int decimals_for(double standard_deviation, int at_most = 9);

/// What a parameter is called and shown in.
struct Quantity {
  std::string words;   ///< "Young's modulus", "length of D3"
  std::string symbol;  ///< "E", "" where there is none
  std::string unit;    ///< after scaling: "GPa", "µs", "mm", "" for a pure number
  double factor = 1;   ///< shown = SI value times factor
};

/// By name and unit suffix ("lame_lambda_pa", "rayleigh_stiffness_s", "D3.length_m"); the prefix suits the
/// magnitude.
Quantity quantity(std::string_view name, double magnitude);

/// An estimate in readable units; parts that were not measured are empty.
struct ShownEstimate {
  Quantity quantity;
  std::string value, std, low, high;
  std::string value_with_std() const;  ///< "68.40 ± 0.12 GPa"
  std::string interval() const;        ///< "68.16 to 68.63 GPa", or empty
};
ShownEstimate shown(std::string_view name, const Number& value, const Number& std,
                    const std::optional<std::array<double, 2>>& ci95);

/// "587.883 Hz": decimals from the standard deviation where there is one, else seven significant digits at
/// most.
std::string hertz(double frequency_hz, const std::optional<double>& std_hz = {});
std::string signed_cents(double value);

/// Model names of a damping candidate in words: "rayleigh" -> "Rayleigh".
std::string damping_words(std::string_view model);

/// With a capital first letter, where it is a plain small one.
std::string capitalised(std::string text);

/// A share as a person says it: "0.37", "> 0.999" instead of 1, "< 0.001" instead of 0.
std::string share(double value);

/// "3 partials", "1 partial", "no partials".
std::string counted(std::size_t n, std::string_view singular, std::string_view plural);

/// A file name's worth of a specimen's name: letters, digits, '-', '_', '.'; never empty, never a leading
/// dot.
std::string file_stem(std::string_view name);

}  // namespace klang::reports::detail
