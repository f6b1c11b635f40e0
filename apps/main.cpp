#include <malloc.h>

#include "apps/commands/commands.hpp"

namespace {

/// Memory that was freed is kept for what comes next: a solver that gives back and fetches its matrices in every step would pay for each page
/// again. 256 MB at most lie idle.
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_TOP_PAD, 8 << 20);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  klang::apps::Program program(klang::apps::all_commands());
  return program.run(argc, argv);
}
