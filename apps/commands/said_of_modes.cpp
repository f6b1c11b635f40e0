#include "apps/commands/said_of_modes.hpp"

#include <nlohmann/json.hpp>

#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"

namespace klang::apps {

SaidOfModes::SaidOfModes(const SceneFolder* folder, const std::string& stem, const scene::SceneNotes& notes)
    : folder_(folder), file_("modes/" + stem + ".json"), notes_(notes), listening_(notes) {
  listening_.warning = [this](const std::string& text) {
    warnings_.push_back(text);
    if (notes_.warning) notes_.warning(text);
  };
}

void SaidOfModes::keep(std::optional<double> mesh_error) const {
  if (folder_ == nullptr || (warnings_.empty() && !mesh_error)) return;
  write_file(folder_->file(file_),
             json_text({{"warnings", warnings_}, {"mesh_error", mesh_error ? nlohmann::json(*mesh_error) : nullptr}}));
}

std::optional<double> SaidOfModes::say_again() const {
  if (folder_ == nullptr || !folder_->has(file_)) return {};
  const nlohmann::json kept = parse_json(read_file(folder_->file(file_)), folder_->file(file_).string());
  if (!kept.is_object()) return {};
  const nlohmann::json warnings = kept.value("warnings", nlohmann::json::array());
  for (const nlohmann::json& text : warnings)
    if (text.is_string() && notes_.warning) notes_.warning(text.get<std::string>());
  const nlohmann::json error = kept.value("mesh_error", nlohmann::json());
  return error.is_number() ? std::optional<double>(error.get<double>()) : std::nullopt;
}

}  // namespace klang::apps
