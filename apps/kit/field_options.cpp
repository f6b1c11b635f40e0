#include "apps/kit/field_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "core/foundation/base/check.hpp"

namespace klang::apps::detail {

std::string OptionAdder::flag(const Field& field) const {
  std::string flag(wanted_.flag);
  if (flag.empty()) {
    flag = "--" + std::string(field.name);
    std::replace(flag.begin(), flag.end(), '_', '-');
  }
  name_field(app_, common_, std::string(wanted_.field), flag.substr(flag.front() == '!' ? 1 : 0));
  return flag;
}

std::string OptionAdder::help(const Field& field) const {
  const std::string own = wanted_.range.text(), range = own.empty() ? field.range.text() : own;
  return std::string(wanted_.help.empty() ? field.meaning : wanted_.help) + (range.empty() ? "" : ", " + range);
}

void OptionAdder::add(const Field& field, double& value) {
  app_.add_option(flag(field), value, help(field))->capture_default_str();
}

void OptionAdder::add(const Field& field, int& value) {
  app_.add_option(flag(field), value, help(field))->capture_default_str();
}

void OptionAdder::add(const Field& field, std::string& value) {
  app_.add_option(flag(field), value, help(field))->capture_default_str();
}

void OptionAdder::add(const Field& field, std::optional<double>& value) {
  app_.add_option(flag(field), value, help(field));
}

void OptionAdder::add(const Field& field, bool& value) {
  const std::string name = flag(field);
  const bool clears = name.front() == '!';
  app_.add_flag_function(
      clears ? name.substr(1) : name, [&value, clears](std::int64_t count) { value = (count > 0) != clears; },
      help(field));
}

void OptionAdder::add_word(const Field& field, const std::string& now, const std::vector<std::string>& words,
                           std::function<void(const std::string&)> set) {
  app_.add_option_function(flag(field), std::move(set), help(field))->check(CLI::IsMember(words))->default_str(now);
}

void OptionAdder::cannot_be_an_option(const Field& field) {
  KLANG_CHECK(false, "no option has the type of " + std::string(field.name));
}

void check_found(const OptionOfField& wanted, bool found) {
  KLANG_CHECK(found, "the struct has a field " + std::string(wanted.field));
}

}  // namespace klang::apps::detail
