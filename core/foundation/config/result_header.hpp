#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"

/// What every result file begins with. A kind of result is a described struct beside what computes it, a "document": its header
/// and its own fields. The program writes it, reports read it back into the same struct, docs/result-json.md is made from it.
namespace klang {

struct InputFile {
  std::string path;
  std::uint64_t n_bytes = 0;
  std::string sha256;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"path", "as it was given"}, self.path);
    visit({"n_bytes", "its size"}, self.n_bytes);
    visit({"sha256", "SHA-256 of its bytes, hexadecimal"}, self.sha256);
  }
};

/// Path, size and SHA-256 of a file. @throws InputError when it cannot be read
InputFile input_file(const std::filesystem::path& path);

/// What every output records about how it was made; no dates and no host names, so that the same run gives the same bytes.
struct Provenance {
  std::string version;  ///< klang::version()
  std::string command;  ///< the command line, or the call
  std::uint64_t seed = 0;
  JsonText options{"{}"};  ///< that were used, after defaults
  std::vector<InputFile> inputs;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"version", "of the program"}, self.version);
    visit({"command", "the command line"}, self.command);
    visit({"seed", "of everything that is random"}, self.seed);
    visit({"options", "that were used, after defaults"}, self.options);
    visit({"inputs", "files that were read"}, self.inputs);
  }
};

/// Of this program. @throws InputError for an input that cannot be read
Provenance make_provenance(std::string command, std::uint64_t seed, const nlohmann::json& options,
                           const std::vector<std::filesystem::path>& inputs);

struct ResultHeader {
  int schema_version = 1;
  std::string kind, status;
  std::optional<std::string> message;
  Provenance provenance;
  std::vector<std::string> warnings;
  std::map<std::string, double> wall_time_s;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"schema_version", "of these files", between(1, 1)}, self.schema_version);
    visit({"kind", "of result"}, self.kind);
    visit({"status", "what came out, one word"}, self.status);
    visit(absent_if_empty({"message", "the same as a sentence, where the kind has one"}), self.message);
    visit({"provenance", "how it was made"}, self.provenance);
    visit({"warnings", "sentences"}, self.warnings);
    visit(absent_if_empty({"wall_time_s", "by stage, where the kind has it"}), self.wall_time_s);
  }
};

/// The object of a result file. @throws InputError naming the file: no JSON, no object, another schema than 1
nlohmann::json read_result_json(const std::filesystem::path& path);

}  // namespace klang
