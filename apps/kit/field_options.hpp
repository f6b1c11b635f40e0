#pragma once
#include <CLI/App.hpp>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "apps/kit/command.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::apps {

/// A field of a described struct that a command takes as an option.
struct OptionOfField {
  std::string_view field;  ///< "min_snr_db"; "medium.density_kg_m3" of an inner struct
  std::string_view flag =
      {};  ///< where it is not the field's name: "--thresholds"; of a boolean "!--no-images" clears it
  std::string_view help = {};  ///< where the field's meaning does not say it
  Range range = {};            ///< where the command allows less than the field
};

namespace detail {

/// Adds one option; the overloads are the types of members that an option can have.
class OptionAdder {
 public:
  OptionAdder(CLI::App& app, CommonOptions& common, const OptionOfField& wanted, std::string prefix, bool& found)
      : app_(app), common_(common), wanted_(wanted), prefix_(std::move(prefix)), found_(found) {}

  template <class T>
  void operator()(const Field& field, T& value) {
    const std::string path = prefix_ + std::string(field.name);
    if constexpr (Described<T>) {
      T::describe(value, OptionAdder(app_, common_, wanted_, path + ".", found_));
    } else if (path == wanted_.field) {
      found_ = true;
      if constexpr (Worded<T>) {
        std::vector<std::string> words;
        for (const auto& word : words_of(T{})) words.emplace_back(word.text);
        add_word(field, to_text(value), words,
                 [&value](const std::string& text) { value = enum_from_text<T>(text).value_or(value); });
      } else if constexpr (requires { this->add(field, value); }) {
        add(field, value);
      } else {
        cannot_be_an_option(field);
      }
    }
  }

 private:
  void add(const Field& field, double& value);
  void add(const Field& field, int& value);
  void add(const Field& field, bool& value);
  void add(const Field& field, std::string& value);
  void add(const Field& field, std::optional<double>& value);
  void add_word(const Field& field, const std::string& now, const std::vector<std::string>& words,
                std::function<void(const std::string&)> set);
  static void cannot_be_an_option(const Field& field);
  std::string flag(const Field& field) const;
  std::string help(const Field& field) const;

  CLI::App& app_;
  CommonOptions& common_;
  const OptionOfField& wanted_;
  std::string prefix_;
  bool& found_;
};

void check_found(const OptionOfField& wanted, bool found);

}  // namespace detail

/// One option for each of these fields, in this order: --field-name with the field's meaning and range in --help, its type,
/// and as default what the struct has now. What breaks a rule is said by the struct's validate(), under the option's name.
/// options must live as long as the program.
template <Described T>
void add_fields(CLI::App& app, CommonOptions& common, T& options, std::initializer_list<OptionOfField> fields) {
  for (const OptionOfField& wanted : fields) {
    bool found = false;
    T::describe(options, detail::OptionAdder(app, common, wanted, {}, found));
    detail::check_found(wanted, found);
  }
}

}  // namespace klang::apps
