// The command line as the registry builds it, without running the program.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>

#include "apps/commands/commands.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/option_tables.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/dual_domain/transfer_series.hpp"
#include "core/sound/soundbank/soundbank_build.hpp"
#include "core/sound/transfer/radiate.hpp"
#include "fit/bubble/bubble_search.hpp"
#include "fit/proxy/proxy_fit.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "tests/places.hpp"
#include "validate/debris/debris_study.hpp"
#include "validate/regression/regression.hpp"
#include "validate/studies/study.hpp"

namespace klang::apps {
namespace {

enum class Colour { kRed, kBlue };
constexpr auto words_of(Colour) { return std::array{Word{Colour::kRed, "red"}, Word{Colour::kBlue, "blue"}}; }

struct Inner {
  double density_kg_m3 = 1.5;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"density_kg_m3", "Density", between(0.0, 10.0)}, self.density_kg_m3);
  }
};

struct Thing {
  double length_m = 0.25;
  int n_rounds = 7;
  bool images = true;
  std::optional<double> wall_m;
  Colour colour = Colour::kBlue;
  Inner medium;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"length_m", "Length of the thing", above(0.0)}, self.length_m);
    visit({"n_rounds", "Rounds", between(1.0, 9.0)}, self.n_rounds);
    visit({"images", "With images"}, self.images);
    visit({"wall_m", "Wall; default: none"}, self.wall_m);
    visit({"colour", "Its colour"}, self.colour);
    visit({"medium", "Around it"}, self.medium);
  }
};

struct ThingCommand {
  CLI::App app{"thing"};
  CommonOptions common;
  Thing thing;
  ThingCommand() {
    add_fields(app, common, thing,
               {{"length_m"},
                {"n_rounds", "--rounds"},
                {"images", "!--no-images", "Without images"},
                {"wall_m"},
                {"colour"},
                {"medium.density_kg_m3", "--air-density-kg-m3"}});
  }
};

TEST(FieldOptions, HelpShowsMeaningRangeTypeAndDefaultOfTheField) {
  ThingCommand command;
  const std::string help = command.app.help();
  for (const char* text : {"--length-m FLOAT=0.25", "Length of the thing, above 0", "--rounds INT=7", "Rounds, 1 to 9",
                           "--no-images", "Without images", "--wall-m FLOAT", "Wall; default: none",
                           "--colour TEXT:{red,blue}=blue", "--air-density-kg-m3 FLOAT=1.5", "Density, 0 to 10"})
    EXPECT_NE(help.find(text), std::string::npos) << text << "\n" << help;
}

TEST(FieldOptions, ParsingFillsTheStruct) {
  ThingCommand command;
  command.app.parse("--no-images=false");
  EXPECT_TRUE(command.thing.images);
  command.app.parse("--length-m 3 --rounds 2 --no-images --wall-m 0.5 --colour red --air-density-kg-m3 4");
  EXPECT_EQ(command.thing.length_m, 3.0);
  EXPECT_EQ(command.thing.n_rounds, 2);
  EXPECT_FALSE(command.thing.images);
  EXPECT_EQ(command.thing.wall_m, 0.5);
  EXPECT_EQ(command.thing.colour, Colour::kRed);
  EXPECT_EQ(command.thing.medium.density_kg_m3, 4.0);
  EXPECT_THROW(command.app.parse("--colour green"), CLI::ParseError);
}

TEST(FieldOptions, MessageListsEveryViolationUnderTheNameOfItsOption) {
  ThingCommand command;
  command.thing.length_m = -1.0;
  command.thing.n_rounds = 10;
  command.thing.medium.density_kg_m3 = 11.0;
  try {
    validate_fields("thing", command.thing);
    FAIL() << "accepted";
  } catch (const OptionsError& error) {
    const auto& flags = command.common.flags.at(&command.app);
    EXPECT_EQ(
        error.text([&](const std::string& field) { return flags.at(field); }),
        "thing: --length-m is out of range (-1; allowed: above 0); --rounds is out of range (10; allowed: 1 to 9); "
        "--air-density-kg-m3 is out of range (11; allowed: 0 to 10)");
  }
}

/// Every option that comes from a field of T and shows a default shows that of T. Flags show none, nor do options that
/// must be given, nor those whose default the command finds from others. @return how many options were compared
template <class T>
int expect_defaults(const Program& program, const std::string& path) {
  int n = 0;
  for (const CLI::App* app : program.commands()) {
    if (program.path_of(*app) != path) continue;
    for (const FieldRow& row : field_rows<T>()) {
      if (row.type == "table" || row.type == "boolean" || row.name.starts_with("band.")) continue;
      const std::string flag = program.flag_of_field(*app, row.name);
      const CLI::Option* option = flag.empty() ? nullptr : app->get_option_no_throw(flag);
      if (option == nullptr || option->get_required()) continue;
      const std::string shown = option->get_default_str();
      if (shown.empty() && !row.default_text.empty()) continue;
      ++n;
      if (row.type == "number" || row.type == "integer") {
        const double value = std::stod(row.default_text);
        EXPECT_NEAR(std::stod(shown), value, 1e-5 * std::abs(value)) << path << " " << flag;
      } else {
        EXPECT_EQ(shown, row.default_text) << path << " " << flag;
      }
    }
  }
  return n;
}

TEST(Commands, DefaultsShownAreThoseOfTheStructs) {
  const Program program(all_commands());
  EXPECT_EQ(expect_defaults<fit::RingdownOptions>(program, "klang analyze"), 2);
  EXPECT_EQ(expect_defaults<fit::bubble::BubbleSearchOptions>(program, "klang bubble fit"), 4);
  EXPECT_EQ(expect_defaults<fit::ProxyFitOptions>(program, "klang proxy fit"), 4);
  EXPECT_EQ(expect_defaults<acoustics::RadiateOptions>(program, "klang transfer"), 5);
  EXPECT_EQ(expect_defaults<soundbank::BuildOptions>(program, "klang proxy build"), 9);
  EXPECT_EQ(expect_defaults<validate::DebrisStudyOptions>(program, "klang proxy study"), 16);
  EXPECT_EQ(expect_defaults<validate::RegressionOptions>(program, "klang regress check"), 10);
  EXPECT_EQ(expect_defaults<validate::DescriptionOptions>(program, "klang regress make"), 2);
  EXPECT_EQ(expect_defaults<validate::StudyOptions>(program, "klang converge"), 2);
  EXPECT_EQ(expect_defaults<bubble::TransferSeriesOptions>(program, "klang bubble transfer"), 15);
  EXPECT_EQ(expect_defaults<bubble::BubbleMedium>(program, "klang bubble info"), 7);
}

TEST(Commands, EachShowsAnExampleAndTakesTheCommonOptions) {
  const Program program(all_commands());
  EXPECT_EQ(program.commands().size(), 36U);
  for (const CLI::App* app : program.commands()) {
    const std::string path = program.path_of(*app), footer = app->get_footer();
    EXPECT_NE(footer.find("Example"), std::string::npos) << path;
    EXPECT_NE(footer.find("  " + path), std::string::npos) << path;
    EXPECT_FALSE(app->get_description().empty()) << path;
    for (const char* common : {"--json", "--quiet", "--threads", "--seed"})
      EXPECT_NE(app->get_option_no_throw(common), nullptr) << path << " " << common;
  }
}

TEST(Commands, OptionsPageIsWhatTheProgramTakes) {
  const Program program(all_commands());
  const std::string now = option_tables_markdown(program);
  const auto file = std::filesystem::temp_directory_path() / "klang-options.md";
  if (now != read_file(klang::test::source_dir() + "/docs/options.md")) write_file(file, now);
  EXPECT_EQ(now, read_file(klang::test::source_dir() + "/docs/options.md")) << "copy " << file << " to docs/options.md";
}

}  // namespace
}  // namespace klang::apps
