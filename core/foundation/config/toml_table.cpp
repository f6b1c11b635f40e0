#include "core/foundation/config/toml_table.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/config/toml_depth.hpp"

namespace klang {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{64} << 20, kMaxTextBytes = 4096;

const toml::table& table_of(const void* node) { return *static_cast<const toml::table*>(node); }

std::string range_text(const TomlField& field) {
  if (field.open) {
    std::string text;
    if (std::isfinite(field.low)) text = "above " + to_text(field.low);
    if (std::isfinite(field.high)) text += (text.empty() ? "below " : ", below ") + to_text(field.high);
    return text;
  }
  return std::isfinite(field.low) ? to_text(field.low) + " to " + to_text(field.high) : "";
}

/// Of a number. toml++ gives no double for an integer that is not one exactly.
double value_of(const toml::node& node) {
  const auto* integer = node.as_integer();
  return integer ? static_cast<double>(integer->get()) : node.as_floating_point()->get();
}

std::string shown_value(const toml::node& node) {
  if (const auto* text = node.as_string()) return "\"" + text->get().substr(0, 80) + "\"";
  if (node.is_number()) return to_text(value_of(node));
  if (node.is_table()) return "a table";
  if (node.is_array()) return "a list";
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  return "a date or time";
}

/// The value of { value = .., std = .. }, or the node itself.
const toml::node& value_node(const toml::node& node, const TomlField& field, const std::string& place) {
  const toml::table* table = field.with_std ? node.as_table() : nullptr;
  if (table == nullptr) return node;
  for (const auto& [key, inner] : *table) {
    if (key != "value" && key != "std")
      throw unknown_word(place, "unknown key", key.str(), key.str(), {"value", "std"});
  }
  if (!table->contains("value") || !table->contains("std"))
    throw InputError(place, "is a table without value or std", "", "{ value = .., std = .. }");
  return *table->get("value");
}

double number_of(const toml::node& given, const TomlField& field, const std::string& place) {
  const toml::node& node = value_node(given, field, place);
  if (!node.is_number()) throw InputError(place, "must be a number", shown_value(node), range_text(field));
  if (field.open) {
    const double value = value_of(node);
    if (!(value > field.low && value < field.high))
      throw InputError(place, "is out of range", to_text(value), range_text(field));
    return value;
  }
  return checked(place, "value", value_of(node), field.low, field.high);
}

std::string text_of(const toml::node& node, const std::string& place) {
  const auto* value = node.as_string();
  if (!value) throw InputError(place, "must be a text", shown_value(node));
  if (value->get().size() > kMaxTextBytes || value->get().find('\0') != std::string::npos)
    throw InputError(place, "is no usable text (a NUL byte, or over 4096 bytes)");
  return value->get();
}

}  // namespace

struct TomlTable::Document {
  std::string name;
  std::span<const TomlField> schema;
  toml::table root;
  const TomlField* find(std::string_view table, std::string_view key) const {
    for (const TomlField& field : schema) {
      if (field.table == table && field.key == key) return &field;
    }
    return nullptr;
  }
  std::vector<std::string> known_keys(std::string_view table) const {
    std::vector<std::string> keys;
    for (const TomlField& field : schema) {
      if (field.table == table) keys.emplace_back(field.key);
    }
    return keys;
  }
};

TomlTable TomlTable::parse(std::string_view text, std::string name, std::span<const TomlField> schema) {
  if (text.size() > kMaxBytes) throw InputError(name, "is too long", std::to_string(text.size()) + " bytes");
  if (toml_keys_too_deep(text))
    throw InputError(name, "a key has too many parts", "", "up to " + std::to_string(kDeepestTomlKey));
  auto document = std::make_shared<Document>();
  document->name = std::move(name);
  document->schema = schema;
  try {
    document->root = toml::parse(text, document->name);
  } catch (const toml::parse_error& error) {
    throw InputError(document->name + ":" + std::to_string(error.source().begin.line), error.description());
  }
  const void* root = &document->root;
  return {std::move(document), root, "", ""};
}

TomlTable::TomlTable(std::shared_ptr<const Document> document, const void* node, std::string schema_table,
                     std::string shown)
    : document_(std::move(document)), node_(node), schema_table_(std::move(schema_table)), shown_(std::move(shown)) {
  for (const auto& [key, value] : table_of(node_)) {
    if (!document_->find(schema_table_, key.str()))
      throw unknown_word(place(key.str()), "unknown key", "", key.str(), document_->known_keys(schema_table_));
  }
}

const TomlField& TomlTable::field(std::string_view key) const {
  const TomlField* found = document_->find(schema_table_, key);
  KLANG_CHECK(found != nullptr, "the reader asks for a key that the schema lacks");
  return *found;
}

bool TomlTable::has(std::string_view key) const { return table_of(node_).contains(key); }

std::string TomlTable::place(std::string_view key) const {
  const toml::table& table = table_of(node_);
  const toml::node* node = table.get(key);
  const auto line = (node ? *node : static_cast<const toml::node&>(table)).source().begin.line;
  std::string text = document_->name;
  if (line > 0) text += ":" + std::to_string(line);
  text += ": ";
  if (!shown_.empty()) text += shown_ + ".";
  return text.append(key);
}

std::string TomlTable::place() const {
  const auto line = table_of(node_).source().begin.line;
  return document_->name + (line > 0 ? ":" + std::to_string(line) : "") + (shown_.empty() ? "" : ": " + shown_);
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : table_of(node_)) keys.emplace_back(key.str());
  return keys;
}

bool TomlTable::is_text(std::string_view key) const {
  field(key);
  const toml::node* node = table_of(node_).get(key);
  return node && node->is_string();
}

std::optional<std::string> TomlTable::optional_text(std::string_view key) const {
  field(key);
  if (!has(key)) return std::nullopt;
  return text(key);
}

std::vector<double> TomlTable::numbers(std::string_view key) const {
  const toml::node* node = table_of(node_).get(key);
  if (!node) throw InputError(place(key), "is missing", "", field(key).meaning);
  const toml::array* array = node->as_array();
  if (!array) throw InputError(place(key), "must be a list", shown_value(*node));
  const auto n_wanted = static_cast<std::size_t>(field(key).length);
  if (n_wanted > 0 && array->size() != n_wanted)
    throw InputError(place(key), "has a wrong number of entries", std::to_string(array->size()),
                     std::to_string(n_wanted));
  std::vector<double> values;
  for (const toml::node& element : *array) values.push_back(number_of(element, field(key), place(key)));
  return values;
}

std::string TomlTable::text(std::string_view key) const {
  const toml::node* node = table_of(node_).get(key);
  if (!node) throw InputError(place(key), "is missing");
  return text_of(*node, place(key));
}

std::vector<std::string> TomlTable::texts(std::string_view key) const {
  field(key);
  std::vector<std::string> values;
  const toml::node* node = table_of(node_).get(key);
  if (!node) return values;
  const toml::array* array = node->as_array();
  if (!array) throw InputError(place(key), "must be a list of texts", shown_value(*node));
  for (const toml::node& element : *array) values.push_back(text_of(element, place(key)));
  return values;
}

void TomlTable::add_named(const void* node, const std::string& prefix, const std::string& schema_table,
                          std::vector<std::pair<std::string, TomlTable>>& found) const {
  for (const auto& [key, value] : table_of(node)) {
    const std::string name = prefix + std::string(key.str());
    const toml::table* table = value.as_table();
    const auto known = [&](const auto& entry) { return document_->find(schema_table, entry.first.str()) != nullptr; };
    if (table && prefix.empty() && std::none_of(table->begin(), table->end(), known)) {
      add_named(table, name + ".", schema_table, found);
      continue;
    }
    const std::string shown = shown_.empty() ? name : shown_ + "." + name;
    if (!table) {
      throw InputError(document_->name + ":" + std::to_string(value.source().begin.line) + ": " + shown,
                       "must be a table", shown_value(value),
                       "a table of " + word_list(document_->known_keys(schema_table)));
    }
    found.emplace_back(name, TomlTable(document_, table, schema_table, shown));
  }
}

std::vector<std::pair<std::string, TomlTable>> TomlTable::named_tables(std::string_view key) const {
  field(key);
  std::vector<std::pair<std::string, TomlTable>> found;
  const toml::node* node = table_of(node_).get(key);
  if (!node) return found;
  const toml::table* table = node->as_table();
  if (!table) throw InputError(place(key), "must be a table", shown_value(*node));
  const std::string inner = (schema_table_.empty() ? "" : schema_table_ + ".") + std::string(key);
  const TomlTable of_names(document_, node_, schema_table_, (shown_.empty() ? "" : shown_ + ".") + std::string(key));
  of_names.add_named(table, "", inner + ".*", found);
  return found;
}

std::string TomlTable::text(std::string_view key, std::string_view fallback) const {
  field(key);
  return has(key) ? text(key) : std::string(fallback);
}

std::string TomlTable::choice(std::string_view key, std::initializer_list<std::string_view> words) const {
  const std::string word = field(key).presence == "required" ? text(key) : text(key, *words.begin());
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  throw unknown_word(place(key), "unknown choice", word.substr(0, 80), word, {words.begin(), words.end()});
}

double TomlTable::number(std::string_view key) const {
  const toml::node* node = table_of(node_).get(key);
  if (!node) throw InputError(place(key), "is missing", "", range_text(field(key)));
  return number_of(*node, field(key), place(key));
}

double TomlTable::number(std::string_view key, double fallback) const {
  field(key);
  return has(key) ? number(key) : fallback;
}

std::optional<double> TomlTable::optional_number(std::string_view key) const {
  field(key);
  if (!has(key)) return std::nullopt;
  return number(key);
}

std::optional<double> TomlTable::standard_deviation(std::string_view key) const {
  const TomlField& known = field(key);
  const toml::node* node = table_of(node_).get(key);
  const toml::table* table = node && known.with_std ? node->as_table() : nullptr;
  if (table == nullptr) return std::nullopt;
  value_node(*node, known, place(key));  // complains
  const TomlField rule{known.table, key, TomlType::kNumber, "", 0.0, known.high, "", true};
  return number_of(*table->get("std"), rule, place(key) + ".std");
}

bool TomlTable::boolean(std::string_view key, bool fallback) const {
  field(key);
  const toml::node* node = table_of(node_).get(key);
  if (!node) return fallback;
  const auto* value = node->as_boolean();
  if (!value) throw InputError(place(key), "must be true or false", shown_value(*node));
  return value->get();
}

Eigen::Vector3d TomlTable::vector(std::string_view key) const {
  const toml::node* node = table_of(node_).get(key);
  if (!node) throw InputError(place(key), "is missing", "", "3 numbers");
  const toml::array* array = node->as_array();
  if (!array || array->size() != 3) throw InputError(place(key), "must be a list of 3 numbers", shown_value(*node));
  Eigen::Vector3d value;
  for (std::size_t i = 0; i < 3; ++i)
    value[static_cast<Eigen::Index>(i)] = number_of(*array->get(i), field(key), place(key));
  return value;
}

Eigen::Vector3d TomlTable::vector(std::string_view key, const Eigen::Vector3d& fallback) const {
  field(key);
  return has(key) ? vector(key) : fallback;
}

TomlTable TomlTable::table(std::string_view key) const {
  static const toml::table empty;
  field(key);
  const toml::node* node = table_of(node_).get(key);
  const toml::table* table = node ? node->as_table() : &empty;
  if (!table) throw InputError(place(key), "must be a table", shown_value(*node));
  const std::string dot = schema_table_.empty() ? "" : schema_table_ + ".", shown = shown_.empty() ? "" : shown_ + ".";
  return {document_, table, dot + std::string(key), shown + std::string(key)};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key, std::size_t most) const {
  field(key);
  std::vector<TomlTable> list;
  const toml::node* node = table_of(node_).get(key);
  if (!node) return list;
  const toml::array* array = node->as_array();
  if (!array || array->size() > most) {
    throw InputError(place(key), "must be a list of tables", array ? std::to_string(array->size()) : shown_value(*node),
                     "up to " + std::to_string(most) + " of them");
  }
  const std::string dot = schema_table_.empty() ? "" : schema_table_ + ".", shown = shown_.empty() ? "" : shown_ + ".";
  for (const toml::node& element : *array) {
    if (!element.is_table()) throw InputError(place(key), "must be a table", shown_value(element));
    list.push_back(TomlTable(document_, element.as_table(), dot + std::string(key),
                             shown + std::string(key) + "[" + std::to_string(list.size() + 1) + "]"));
  }
  return list;
}

std::vector<TomlTable> TomlTable::tables(std::string_view key, std::size_t fewest, std::size_t most) const {
  const toml::node* node = table_of(node_).get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (!array || array->size() < fewest || array->size() > most) {
    throw InputError(
        place(key),
        node ? "must be a list of " + std::to_string(fewest) + " to " + std::to_string(most) + " tables" : "is missing",
        node ? shown_value(*node) : "",
        node ? "" : std::to_string(fewest) + " to " + std::to_string(most) + " of them");
  }
  return tables(key, most);
}

std::filesystem::path existing_file(const std::string& text, const std::string& place,
                                    const std::filesystem::path& folder) {
  const std::filesystem::path path = (folder / text).lexically_normal();
  std::error_code error;
  if (text.empty() || !std::filesystem::is_regular_file(path, error))
    throw InputError(place, "no such file", path.string());
  return path;
}

std::string toml_schema_markdown(std::span<const TomlField> schema) {
  constexpr const char* kTypes[] = {"text",          "number", "true or false",  "3 numbers",
                                    "list of texts", "table",  "list of tables", "list of numbers"};
  std::string text;
  std::string_view table = "?";
  for (const TomlField& field : schema) {
    if (field.table != table) {
      table = field.table;
      text.append("\n## ").append(table.empty() ? "top level" : "`" + std::string(table) + "`");
      text += "\n| key | type | range | default | meaning |\n| --- | --- | --- | --- | --- |\n";
    }
    text.append("| `").append(field.key).append("` | ").append(kTypes[static_cast<int>(field.type)]);
    if (field.with_std) text += ", or { value, std }";
    if (field.length > 0) text += " (" + std::to_string(field.length) + ")";
    text.append(" | ");
    text.append(range_text(field)).append(" | ").append(field.presence).append(" | ").append(field.meaning) += " |\n";
  }
  return text;
}

}  // namespace klang
