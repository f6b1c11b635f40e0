#include "core/foundation/base/references.hpp"
#include "tests/places.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(klang::test::source_dir() + "/" + path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

TEST(References, EveryCodeHasItsEntryWithTitleAndCodeInTheBibliography) {
  const std::string bib = text_of("docs/references.bib");
  for (const klang::Reference& reference : klang::kReferences) {
    const auto from = bib.find("{" + std::string(reference.key) + ",");
    ASSERT_NE(from, std::string::npos) << reference.key;
    const std::string entry = bib.substr(from, bib.find("\n}", from) - from);
    EXPECT_NE(entry.find("title = {" + std::string(reference.title) + "}"), std::string::npos) << entry;
    EXPECT_NE(entry.find("note = {" + std::string(reference.code) + "}"), std::string::npos) << entry;
  }
}

TEST(References, EveryCodeThatTheErrataUseIsDefined) {
  std::set<std::string> known;
  for (const klang::Reference& reference : klang::kReferences) known.emplace(reference.code);
  const std::string errata = text_of("docs/errata.md");
  const std::regex row("\\n\\| [0-9-]+ \\| ([A-Z0-9]+) \\|");
  int n_rows = 0;
  for (std::sregex_iterator at(errata.begin(), errata.end(), row), end; at != end; ++at, ++n_rows)
    EXPECT_EQ(known.count((*at)[1]), 1u) << (*at)[1];
  EXPECT_GE(n_rows, 20);
}

TEST(References, EveryTestThatTheErrataNameIsThere) {
  namespace fs = std::filesystem;
  std::set<std::string> tests;
  const auto word = [](const std::string& text, std::size_t& at) {
    const auto from = text.find_first_not_of(", \n", at);
    at = text.find_first_of(",) \n", from);
    return text.substr(from, at - from);
  };
  for (const auto& file : fs::recursive_directory_iterator(fs::path(klang::test::source_dir()) / "tests")) {
    if (file.path().extension() != ".cpp") continue;
    const std::string text = text_of(fs::relative(file.path(), klang::test::source_dir()));
    for (const char* head : {"\nTEST(", "\nTEST_F(", "\nTEST_P("})
      for (auto at = text.find(head); at != std::string::npos; at = text.find(head, at)) {
        at += std::strlen(head);
        const std::string suite = word(text, at), name = word(text, at);
        tests.insert(suite + "." + name);
      }
  }
  const std::string errata = text_of("docs/errata.md");
  const std::regex named("`(?:\\w+/)?([A-Z]\\w+\\.[A-Z]\\w+)`");
  int n_named = 0;
  for (std::sregex_iterator at(errata.begin(), errata.end(), named), end; at != end; ++at, ++n_named)
    EXPECT_EQ(tests.count((*at)[1]), 1u) << (*at)[1];
  EXPECT_GE(n_named, 90);
}

TEST(References, BibliographysKeysAreUnique) {
  const std::string bib = text_of("docs/references.bib");
  const std::regex head("\\n@[a-z]+\\{([a-z0-9]+),");
  std::set<std::string> keys;
  for (std::sregex_iterator at(bib.begin(), bib.end(), head), end; at != end; ++at)
    EXPECT_TRUE(keys.insert((*at)[1]).second) << (*at)[1];
  EXPECT_GE(keys.size(), klang::kReferences.size());
}
