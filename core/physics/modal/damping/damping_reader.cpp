#include "core/physics/modal/damping/damping_reader.hpp"

#include <limits>
#include <set>
#include <string>

#include "core/foundation/base/errors.hpp"

namespace klang::damping {
namespace {

/// "`rayleigh`, `loss_factor` or `zener`".
std::string law_choice() {
  const auto& laws = damping_laws(LawUse::kRecipes);
  std::string text;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    text += i == 0 ? "" : i + 1 < laws.size() ? ", " : " or ";
    text.append("`").append(laws[i]->name()).append("`");
  }
  return text;
}

}  // namespace

std::vector<TomlField> damping_fields(std::string_view table) {
  static const std::string choice = law_choice();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  std::vector<TomlField> fields = {{table, "model", TomlType::kText, "required", -kInf, kInf, choice}};
  for (const DampingLaw* law : damping_laws(LawUse::kRecipes)) {
    for (const LawParameter& p : law->parameters())
      fields.push_back({table, p.name, TomlType::kNumber, "0", p.low, p.high, p.meaning});
  }
  return fields;
}

LawValue read_damping(const TomlTable& table) {
  const std::string model = table.text("model");
  LawValue value;
  value.law = find_law(model, LawUse::kRecipes);
  if (!value.law) throw InputError(table.place("model"), "unknown damping model", model, law_names(LawUse::kRecipes));
  std::set<std::string> meant = {"model"};
  for (const LawParameter& parameter : value.law->parameters()) {
    value.parameters.push_back(parameter.required ? table.number(parameter.name) : table.number(parameter.name, 0.0));
    meant.emplace(parameter.name);
  }
  for (const std::string& key : table.keys())
    if (!meant.count(key)) throw InputError(table.place(key), "has no meaning in the model", model);
  return value;
}

}  // namespace klang::damping
