#include "apps/commands/commands.hpp"

namespace klang::apps {

// Every subcommand, in the order of --help. Each stands in a file of its own, apps/commands/NAME.cpp (GROUP_NAME.cpp in a
// group), which defines add_NAME() (add_GROUP_NAME()): Subcommand in apps/kit/command.hpp. CMakeLists.txt reads the list.
// clang-format off
#define KLANG_COMMANDS(COMMAND, GROUP, MEMBER) \
  COMMAND(mesh) \
  COMMAND(modes) \
  COMMAND(stress) \
  COMMAND(analyze) \
  COMMAND(listen) \
  COMMAND(watch) \
  COMMAND(fit) \
  COMMAND(iet) \
  COMMAND(tune) \
  COMMAND(chime) \
  COMMAND(synth) \
  COMMAND(export) \
  COMMAND(transfer) \
  GROUP(bubble, "Gas bubbles: how they ring, their sound, recordings of drops") \
  MEMBER(bubble, info) \
  MEMBER(bubble, synth) \
  MEMBER(bubble, fit) \
  MEMBER(bubble, transfer) \
  GROUP(proxy, "Ellipsoids that stand for bodies: precomputed soundbanks, retrieval, errors") \
  MEMBER(proxy, build) \
  MEMBER(proxy, info) \
  MEMBER(proxy, fit) \
  MEMBER(proxy, lookup) \
  MEMBER(proxy, study) \
  GROUP(scene, "Solid bodies and liquids that move and sound: from sound to scene") \
  MEMBER(scene, check) \
  MEMBER(scene, run) \
  MEMBER(scene, sound) \
  MEMBER(scene, info) \
  MEMBER(scene, import) \
  MEMBER(scene, export) \
  MEMBER(scene, match) \
  COMMAND(converge) \
  GROUP(regress, "Recordings and models against a reference spectrum") \
  MEMBER(regress, make) \
  MEMBER(regress, check) \
  GROUP(validate, "Published numbers against this program") \
  MEMBER(validate, papers) \
  COMMAND(dataset) \
  COMMAND(report) \
  COMMAND(doctor)
// clang-format on

#define DECLARE_COMMAND(name) Subcommand add_##name(CLI::App& program, CommonOptions& common);
#define DECLARE_GROUP(name, description)
#define DECLARE_MEMBER(group, name) Subcommand add_##group##_##name(CLI::App& program, CommonOptions& common);
KLANG_COMMANDS(DECLARE_COMMAND, DECLARE_GROUP, DECLARE_MEMBER)

#define LIST_COMMAND(name) CommandEntry{"", add_##name},
#define LIST_GROUP(name, description) CommandEntry{#name, nullptr, description},
#define LIST_MEMBER(group, name) CommandEntry{#group, add_##group##_##name},

std::span<const CommandEntry> all_commands() {
  static constexpr CommandEntry kCommands[] = {KLANG_COMMANDS(LIST_COMMAND, LIST_GROUP, LIST_MEMBER)};
  return kCommands;
}

}  // namespace klang::apps
