#include "apps/commands/commands.hpp"

int main(int argc, char** argv) {
  klang::apps::Program program(klang::apps::all_commands());
  return program.run(argc, argv);
}
