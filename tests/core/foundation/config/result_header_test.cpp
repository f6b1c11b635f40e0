#include "core/foundation/config/result_header.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"

namespace klang {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(ResultHeader, ReadsBackWithItsProvenance) {
  const fs::path input = fs::path(::testing::TempDir()) / "klang-header-input.txt";
  write_file(input, "abc");
  ResultHeader header;
  header.kind = "fit";
  header.status = "converged";
  header.provenance = make_provenance("klang fit x.toml", 7, {{"gate_cents", 60.0}}, {input});
  header.warnings = {"a warning"};
  const json file = json_of(header);
  EXPECT_EQ(file["provenance"]["version"], version());
  EXPECT_EQ(file["provenance"]["inputs"][0]["n_bytes"], 3);
  EXPECT_EQ(file["provenance"]["inputs"][0]["sha256"],
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(file["provenance"]["options"]["gate_cents"], 60.0);
  EXPECT_FALSE(file.contains("message"));
  EXPECT_FALSE(file.contains("wall_time_s"));
  EXPECT_EQ(json_of(read_fields<ResultHeader>(file, "fit.json")), file);
  EXPECT_THROW(make_provenance("", 1, {}, {"/nonexistent/file"}), InputError);
  fs::remove(input);
}

TEST(ResultFile, OtherFilesAreRefusedByName) {
  const fs::path file = fs::path(::testing::TempDir()) / "klang-result.json";
  const auto complaint = [&](const char* text) -> std::string {
    write_file(file, text);
    try {
      read_result_json(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(complaint("{").find("not JSON"), std::string::npos);
  EXPECT_NE(complaint("[1]").find("not a result file"), std::string::npos);
  EXPECT_NE(complaint("{}").find("schema_version"), std::string::npos);
  EXPECT_NE(complaint(R"({"schema_version": 2})").find("schema_version: cannot be read (2"), std::string::npos);
  EXPECT_EQ(complaint(R"({"schema_version": 1})"), "accepted");
  const std::string brackets =
      "{\"schema_version\": 1, \"a\": " + std::string(100000, '[') + std::string(100000, ']') + "}";
  EXPECT_NE(complaint(brackets.c_str()).find("nested too deep (100001 levels"), std::string::npos);
  const std::string text = "{\"schema_version\": 1, \"a\": \"\\\"" + std::string(1000, '[') + "\"}";
  EXPECT_EQ(complaint(text.c_str()), "accepted") << "brackets in a text are no depth";
  fs::remove(file);
}

}  // namespace
}  // namespace klang
