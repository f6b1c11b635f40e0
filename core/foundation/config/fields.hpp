#pragma once
#include <array>
#include <concepts>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/foundation/base/errors.hpp"

/// A struct of options or results names its fields once:
///
///   struct RingOptions {
///     double window_s = 0.1;
///     template <class Self, class Visitor>
///     static void describe(Self& self, Visitor&& visit) {
///       visit({"window_s", "length of the window", above(0.0)}, self.window_s);
///     }
///   };
///
/// JSON writing and reading (fields_json.hpp), checking (validate_fields), TOML keys, command-line options and the tables in
/// docs/ come from that. A struct may hold other described structs, lists of them and optional ones.
namespace klang {

/// The values that a number may have. NaN is never among them.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;  ///< the end itself is left out
  bool holds(double value) const;
  std::string text() const;  ///< "above 0", "0 to 1", "at least 1"; "" without limits
};
constexpr Range between(double low, double high) { return {low, high, false, false}; }
constexpr Range inside(double low, double high) { return {low, high, true, true}; }
constexpr Range above(double low) { return {low, std::numeric_limits<double>::infinity(), true, false}; }
constexpr Range at_least(double low) { return {low, std::numeric_limits<double>::infinity(), false, false}; }

/// What a writer makes of an optional without a value, an empty text or an empty list.
enum class WhenEmpty {
  kKept,    ///< null, "", []
  kNull,    ///< null
  kLeftOut  ///< the key is not there
};

/// What a struct says of one of its members.
struct Field {
  std::string_view name;     ///< with its unit, "frequency_hz": the key in JSON and TOML, the column of a CSV file
  std::string_view meaning;  ///< one line for docs and --help
  Range range = {};          ///< of a number, or of each number of a list
  bool required = false;     ///< a reader complains where it is missing; otherwise the member keeps its default
  WhenEmpty when_empty = WhenEmpty::kKept;
};
constexpr Field needed(Field field) {
  field.required = true;
  return field;
}
constexpr Field null_if_empty(Field field) {
  field.when_empty = WhenEmpty::kNull;
  return field;
}
constexpr Field absent_if_empty(Field field) {
  field.when_empty = WhenEmpty::kLeftOut;
  return field;
}

/// JSON of any shape inside a described struct, as its text: the options that a program used.
struct JsonText {
  std::string text;  ///< "": null
};

namespace detail {
struct AnyVisitor {
  template <class T>
  void operator()(const Field&, T&) const {}
};
}  // namespace detail

/// A struct with a describe() as above.
template <class T>
concept Described = requires(T& value) {
  T::describe(value, detail::AnyVisitor{});
};

/// A value of an enum and its word in files. An enum gets its words from a function beside it, found by its argument:
///   constexpr auto words_of(FitStatus) { return std::array{Word{FitStatus::kConverged, "converged"}, ...}; }
template <class Enum>
struct Word {
  Enum value;
  std::string_view text;
};
template <class Enum>
Word(Enum, const char*) -> Word<Enum>;

template <class T>
concept Worded = std::is_enum_v<T> && requires(T value) {
  words_of(value);
};

/// The word of an enum's value.
template <Worded Enum>
std::string to_text(Enum value) {
  for (const auto& word : words_of(value)) {
    if (word.value == value) return std::string(word.text);
  }
  return {};
}

/// The value of a word, if it is one.
template <Worded Enum>
std::optional<Enum> enum_from_text(std::string_view text) {
  for (const auto& word : words_of(Enum{})) {
    if (word.text == text) return word.value;
  }
  return std::nullopt;
}

/// "one of a, b, c", for messages and docs.
template <Worded Enum>
std::string allowed_words() {
  std::string text;
  for (const auto& word : words_of(Enum{})) text += (text.empty() ? "one of " : ", ") + std::string(word.text);
  return text;
}

/// One line of a table of fields.
struct FieldRow {
  std::string name, type, default_text, range, meaning;  ///< name of an inner field: "partials[].frequency_hz"
  bool required = false;
};

/// Collects the rows of a struct and of those inside it.
class FieldRows {
 public:
  explicit FieldRows(std::vector<FieldRow>& rows, std::string prefix = {}) : rows_(rows), prefix_(std::move(prefix)) {}

  template <class T>
  void operator()(const Field& field, const T& value) {
    if constexpr (Described<T>) {
      add(field, "table", {});
      T::describe(value, FieldRows(rows_, prefix_ + std::string(field.name) + "."));
    } else {
      add(field, type_of(value), text_of(value));
      if constexpr (requires { typename T::value_type; }) describe_inner<typename T::value_type>(field, value);
    }
  }

 private:
  template <class Inner, class T>
  void describe_inner(const Field& field, const T&) {
    if constexpr (Described<Inner>) {
      constexpr bool is_optional = std::same_as<T, std::optional<Inner>>;
      const Inner inner{};
      Inner::describe(inner, FieldRows(rows_, prefix_ + std::string(field.name) + (is_optional ? "." : "[].")));
    }
  }
  template <class T>
  static std::string type_of(const T&) {
    if constexpr (std::same_as<T, bool>)
      return "boolean";
    else if constexpr (std::integral<T>)
      return "integer";
    else if constexpr (std::floating_point<T>)
      return "number";
    else if constexpr (Worded<T>)
      return allowed_words<T>();
    else if constexpr (std::convertible_to<T, std::string>)
      return "text";
    else if constexpr (Described<T>)
      return "table";
    else if constexpr (requires { typename T::mapped_type; })
      return "table";
    else if constexpr (requires(const T& t) { t.has_value(); })
      return type_of(typename T::value_type{}) + " or null";
    else if constexpr (requires { typename T::value_type; })
      return "list of " + type_of(typename T::value_type{});
    else if constexpr (std::same_as<T, JsonText>)
      return "any";
    else
      return "value";
  }
  template <class T>
  static std::string text_of(const T& value) {
    if constexpr (std::same_as<T, bool>)
      return value ? "true" : "false";
    else if constexpr (std::integral<T>)
      return std::to_string(value);
    else if constexpr (std::floating_point<T>)
      return number_text(value);
    else if constexpr (Worded<T>)
      return to_text(value);
    else if constexpr (std::convertible_to<T, std::string>)
      return std::string(value);
    else
      return {};
  }
  static std::string number_text(double value);
  void add(const Field& field, std::string type, std::string default_text);

  std::vector<FieldRow>& rows_;
  std::string prefix_;
};

template <Described T>
std::vector<FieldRow> field_rows() {
  std::vector<FieldRow> rows;
  const T value{};
  T::describe(value, FieldRows(rows));
  return rows;
}

/// A Markdown table of key, type, default, range, meaning; with_defaults for options, without for results.
std::string field_rows_markdown(const std::vector<FieldRow>& rows, bool with_defaults);

/// A member whose value breaks its rule.
struct Violation {
  std::string field;    ///< "band.low_hz"
  std::string problem;  ///< "is out of range"
  std::string value, allowed = {};
};

/// Options that break rules, all of them at once: "place: field problem (value; allowed: ...); field ...".
class OptionsError : public InputError {
 public:
  OptionsError(std::string place, std::vector<Violation> violations);
  const std::vector<Violation>& violations() const { return violations_; }
  /// The message with what others call the fields, say the flags of a command line.
  std::string text(const std::function<std::string(const std::string& field)>& name_of) const;

 private:
  std::string place_;
  std::vector<Violation> violations_;
};

/// Checks the numbers of a struct against the ranges of its fields.
class FieldCheck {
 public:
  explicit FieldCheck(std::vector<Violation>& violations, std::string prefix = {})
      : violations_(violations), prefix_(std::move(prefix)) {}

  template <class T>
  void operator()(const Field& field, const T& value) {
    if constexpr (Described<T>) {
      T::describe(value, FieldCheck(violations_, prefix_ + std::string(field.name) + "."));
    } else if constexpr (std::same_as<T, bool> || Worded<T> || std::convertible_to<T, std::string> ||
                         std::same_as<T, JsonText>) {
    } else if constexpr (std::integral<T> || std::floating_point<T>) {
      number(field, static_cast<double>(value));
    } else if constexpr (requires { value.has_value(); }) {
      if (value) (*this)(field, *value);
    } else if constexpr (requires { typename T::mapped_type; }) {
    } else if constexpr (requires { value.begin(); }) {
      for (const auto& entry : value) (*this)(field, entry);
    }
  }

 private:
  void number(const Field& field, double value);
  std::vector<Violation>& violations_;
  std::string prefix_;
};

/// Every number of a struct that is not finite or not within the range that its field names.
template <Described T>
std::vector<Violation> violations_of(const T& value) {
  std::vector<Violation> violations;
  T::describe(value, FieldCheck(violations));
  return violations;
}

/// For rules that a range cannot tell, as "high_hz above low_hz".
Violation out_of_range(std::string field, double value, const Range& range);

/// One option that breaks a rule. A command line calls the field by its flag.
OptionsError option_error(std::string field, std::string problem, std::string value = {}, std::string allowed = {});

/// Throws one OptionsError that lists every violation, if there is one.
void throw_violations(std::string_view place, std::vector<Violation> violations);

/// All numbers of a struct within the ranges that it names. @throws OptionsError listing every violation
template <Described T>
void validate_fields(std::string_view place, const T& value) {
  throw_violations(place, violations_of(value));
}

}  // namespace klang
