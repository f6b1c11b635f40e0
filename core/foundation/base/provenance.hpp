#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace klang {

struct InputFile {
  std::string path;
  std::uintmax_t n_bytes = 0;
  std::string sha256;
};

/// What every output records about how it was made.
struct Provenance {
  std::string command;  ///< the command line, or the call
  std::uint64_t seed = 0;
  std::string options_json = "{}";  ///< the options that were used, after defaults
  std::vector<InputFile> inputs;
};

/// "0.1.0" or "0.1.0+g1234abc" (the commit it was configured from).
std::string version();

/// Lower-case hexadecimal SHA-256 of the bytes.
std::string sha256(std::string_view bytes);

/// Path, size and SHA-256 of a file; InputError when it cannot be read.
InputFile input_file(const std::filesystem::path& path);

/// {"version", "command", "seed", "options", "inputs": [{"path", "n_bytes", "sha256"}]}; no dates and no host names,
/// so that the same run gives the same bytes.
nlohmann::json to_json(const Provenance& provenance);

}  // namespace klang
