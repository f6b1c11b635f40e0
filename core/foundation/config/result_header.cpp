#include "core/foundation/config/result_header.hpp"

#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"

namespace klang {
namespace {

constexpr std::size_t kLargestResultBytes = std::size_t{1} << 30;

}  // namespace

InputFile input_file(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  return {path.string(), bytes.size(), sha256(bytes)};
}

Provenance make_provenance(std::string command, std::uint64_t seed, const nlohmann::json& options,
                           const std::vector<std::filesystem::path>& inputs) {
  Provenance provenance{version(), std::move(command), seed, {}, {}};
  provenance.options.text = options.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (const std::filesystem::path& input : inputs) provenance.inputs.push_back(input_file(input));
  return provenance;
}

nlohmann::json read_result_json(const std::filesystem::path& path) {
  const std::string place = path.string();
  nlohmann::json result = parse_json(read_file(path, kLargestResultBytes), place);
  if (!result.is_object()) throw InputError(place, "not a result file");
  const nlohmann::json schema = result.value("schema_version", nlohmann::json());
  if (schema != 1)
    throw InputError(place + ".schema_version", "cannot be read",
                     schema.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).substr(0, 60), "1");
  return result;
}

}  // namespace klang
