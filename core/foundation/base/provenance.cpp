#include "core/foundation/base/provenance.hpp"

#include <openssl/evp.h>

#include <array>
#include <nlohmann/json.hpp>

#include "core/foundation/base/output_file.hpp"

namespace klang {

std::string version() { return KLANG_VERSION_TEXT; }

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

InputFile input_file(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  return {path.string(), bytes.size(), sha256(bytes)};
}

nlohmann::json to_json(const Provenance& provenance) {
  nlohmann::json inputs = nlohmann::json::array();
  for (const InputFile& file : provenance.inputs) {
    inputs.push_back({{"path", file.path}, {"n_bytes", file.n_bytes}, {"sha256", file.sha256}});
  }
  return {{"version", version()},
          {"command", provenance.command},
          {"seed", provenance.seed},
          {"options", nlohmann::json::parse(provenance.options_json)},
          {"inputs", inputs}};
}

}  // namespace klang
