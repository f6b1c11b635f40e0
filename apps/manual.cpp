// Writes what a package holds beside the program, from the program's own descriptions: klang_manual FOLDER makes man1/*.1,
// klang.bash, _klang, klang.fish.
#include <cstdio>
#include <filesystem>

#include "apps/commands/commands.hpp"
#include "apps/kit/manual.hpp"
#include "core/foundation/base/output_file.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const std::filesystem::path folder = argv[1];
    const klang::apps::Program program(klang::apps::all_commands());
    std::filesystem::create_directories(folder / "man1");
    for (const auto& [name, text] : klang::apps::manual_pages(program)) klang::write_file(folder / "man1" / name, text);
    klang::write_file(folder / "klang.bash", klang::apps::bash_completion(program));
    klang::write_file(folder / "_klang", klang::apps::zsh_completion(program));
    klang::write_file(folder / "klang.fish", klang::apps::fish_completion(program));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
