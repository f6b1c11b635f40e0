// What the program describes of its results, in docs: `result_docs FILE` says whether FILE is docs/result-json.md as it should
// be, `result_docs FILE --write` writes it; `result_docs --schemas FOLDER [--write]` does so with a JSON Schema for each kind.
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>

#include "apps/commands/commands.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/result_schema.hpp"

namespace {

constexpr const char* kMark = "<!-- Made by tests/docs/result_docs.cpp from here to the end; a test compares it. -->\n";

std::vector<klang::ResultKind> all_kinds() {
  std::vector<klang::ResultKind> kinds;
  for (const klang::apps::CommandEntry& entry : klang::apps::all_commands()) {
    if (entry.add == nullptr) continue;
    CLI::App parent;
    klang::apps::CommonOptions common;
    for (const klang::ResultKind& kind : entry.add(parent, common).results) kinds.push_back(kind);
  }
  return kinds;
}

/// Whether a file holds the text; with write it does afterwards.
bool is_or_becomes(const std::filesystem::path& file, const std::string& wanted, bool write) {
  if (std::filesystem::exists(file) && klang::read_file(file) == wanted) return true;
  if (write) {
    klang::write_file(file, wanted);
    return true;
  }
  std::fprintf(stderr, "%s is not what the program describes; --write makes it so\n", file.c_str());
  return false;
}

int check_schemas(const std::filesystem::path& folder, bool write) {
  bool same = true;
  std::size_t n_files = 0;
  const std::vector<klang::ResultKind> kinds = all_kinds();
  for (const klang::ResultKind& kind : kinds)
    same = is_or_becomes(folder / (kind.kind + ".schema.json"), klang::result_schema(kind), write) && same;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) n_files += entry.is_regular_file() ? 1 : 0;
  if (n_files == kinds.size()) return same ? 0 : 1;
  std::fprintf(stderr, "%s has %zu files for %zu kinds\n", folder.c_str(), n_files, kinds.size());
  return 1;
}

int check_page(const std::filesystem::path& page, bool write) {
  const std::string text = klang::read_file(page);
  const std::size_t mark = text.find(kMark);
  if (mark == std::string::npos) {
    std::fprintf(stderr, "%s: no line %s", page.c_str(), kMark);
    return 2;
  }
  return is_or_becomes(page, text.substr(0, mark) + kMark + klang::result_kinds_markdown(all_kinds()), write) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool write = argc > 2 && std::strcmp(argv[argc - 1], "--write") == 0;
    if (argc > 2 && std::strcmp(argv[1], "--schemas") == 0) return check_schemas(argv[2], write);
    return argc < 2 ? 2 : check_page(argv[1], write);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
