#pragma once
#include <concepts>
#include <map>
#include <string>

#include "core/foundation/config/fields.hpp"

namespace klang {

/// The numbers of a described struct by their names, without those of inner structs.
class NamedNumbers {
 public:
  explicit NamedNumbers(std::map<std::string, double>& numbers) : numbers_(numbers) {}
  template <class T>
  void operator()(const Field& field, const T& value) {
    if constexpr (std::floating_point<T>) numbers_[std::string(field.name)] = value;
  }

 private:
  std::map<std::string, double>& numbers_;
};
template <Described T>
std::map<std::string, double> numbers_of(const T& value) {
  std::map<std::string, double> numbers;
  T::describe(value, NamedNumbers(numbers));
  return numbers;
}

}  // namespace klang
