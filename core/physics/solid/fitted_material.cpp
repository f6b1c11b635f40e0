#include "core/physics/solid/fitted_material.hpp"

#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"

namespace klang::solid {
namespace {

constexpr std::size_t kLargestFitBytes = std::size_t{256} << 20;

}  // namespace

nlohmann::json read_fit_json(const std::filesystem::path& path) {
  nlohmann::json fit = parse_json(read_file(path, kLargestFitBytes), path.string());
  if (!fit.is_object() || !fit.contains("material"))
    throw InputError(path.string(), "has no material", "", "a fit.json");
  if (const std::string kind = text_under(fit, "kind"); fit.contains("kind") && kind != "fit")
    throw InputError(path.string(), "is no result of klang fit", kind, "fit");
  if (const std::string status = text_under(fit, "status"); fit.contains("status") && status != "converged")
    throw InputError(path.string(), "is a fit that did not converge", status, "converged");
  return fit;
}

std::optional<std::string> contradiction_of(const nlohmann::json& fit, const std::filesystem::path& path) {
  const auto judgement = fit.find("judgement");
  if (judgement == fit.end() || !judgement->is_object() || text_under(*judgement, "verdict") != "contradicted")
    return {};
  std::string why;
  if (const auto reasons = judgement->find("reasons"); reasons != judgement->end() && reasons->is_array())
    for (const nlohmann::json& reason : *reasons)
      if (why.empty() && reason.is_object() && text_under(reason, "weight") == "contradicted")
        why = ": " + text_under(reason, "text");
  return path.string() + ": the fit's verdict is contradicted, its material is not to be believed" + why;
}

Material fitted_material(const nlohmann::json& fit, const std::filesystem::path& path, double density_kg_m3) {
  const nlohmann::json& found = fit.at("material");
  const auto number = [&](const std::string& key) {
    if (!found.is_object() || !found.contains(key) || !found[key].is_number())
      throw InputError(path.string() + ": material." + key, "is no number");
    return found[key].get<double>();
  };
  Material material;
  material.lame_lambda_pa = number("lame_lambda_pa");
  material.lame_mu_pa = number("lame_mu_pa");
  material.density_kg_m3 = density_kg_m3 > 0.0 ? density_kg_m3 : number("density_kg_m3");
  material.source = "fitted: " + path.filename().string();
  try {
    validate(material);
  } catch (const InputError& error) {
    throw InputError(path.string(), error.what());
  }
  return material;
}

}  // namespace klang::solid
