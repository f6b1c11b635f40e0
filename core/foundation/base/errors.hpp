#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

namespace klang {

/// Bad input of any kind (file, option, mesh): one line that says where, what, the value and what is allowed.
/// The command line turns it into exit code 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
  /// "place: problem (value; allowed: ...)". Empty parts are left out. Line breaks become spaces.
  InputError(std::string_view place, std::string_view problem, std::string_view value = {},
             std::string_view allowed = {});
};

/// The method ran and cannot give an answer (nothing above the noise, no convergence): exit code 3.
/// Used only at the border to the command line; algorithms return a status.
class NumericalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Ctrl-C: exit code 130.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Shortest decimal text that reads back to the same double.
std::string to_text(double value);

/// Throws InputError unless value is finite and low <= value <= high. The name carries the unit ("length_m").
double checked(std::string_view place, std::string_view name, double value, double low, double high);

/// As checked, for low < value < high.
double checked_open(std::string_view place, std::string_view name, double value, double low, double high);

}  // namespace klang
