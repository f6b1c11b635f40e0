// docs/result-json.md as the program describes it: `result_docs FILE` says whether FILE is that, `result_docs FILE --write`
// writes it.
#include <cstdio>
#include <exception>
#include <string>

#include "apps/commands/commands.hpp"
#include "core/foundation/base/output_file.hpp"

namespace {

constexpr const char* kMark = "<!-- Made by tests/docs/result_docs.cpp from here to the end; a test compares it. -->\n";

std::string described() {
  std::vector<klang::ResultKind> kinds;
  for (const klang::apps::CommandEntry& entry : klang::apps::all_commands()) {
    if (entry.add == nullptr) continue;
    CLI::App parent;
    klang::apps::CommonOptions common;
    for (const klang::ResultKind& kind : entry.add(parent, common).results) kinds.push_back(kind);
  }
  return klang::result_kinds_markdown(kinds);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 2) return 2;
    const std::string text = klang::read_file(argv[1]);
    const std::size_t mark = text.find(kMark);
    if (mark == std::string::npos) {
      std::fprintf(stderr, "%s: no line %s", argv[1], kMark);
      return 2;
    }
    const std::string wanted = text.substr(0, mark) + kMark + described();
    if (argc > 2 && std::string(argv[2]) == "--write") {
      klang::write_file(argv[1], wanted);
      return 0;
    }
    if (text == wanted) return 0;
    std::fprintf(stderr, "%s is not what the program describes; result_docs %s --write makes it so\n", argv[1],
                 argv[1]);
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
