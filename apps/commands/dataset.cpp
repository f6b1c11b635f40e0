#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/tool_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "datasets-synthetic/recipe.hpp"

namespace klang::apps {
namespace {

struct DatasetOptions {
  std::string recipe;
  std::string output;
};

int run_dataset(const DatasetOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  OutputDirectory out(options.output);
  const datasets::Dataset dataset = datasets::make_dataset(options.recipe, common.seed, monitor);
  DatasetDocument document;
  document.header = make_header("dataset", "done", common, nlohmann::json::object(), {options.recipe});
  document.truth = {dataset.truth_json};
  for (const auto& recording : dataset.recordings) {
    const std::string file = recording.name + ".wav";
    audio::write_sound(out.staging() / file, recording.signal);
    document.recordings.push_back(file);
    const bool drops = dataset.specimen_toml.empty();
    say(common, "%s: %.2f s at %g Hz, %zu true %s\n", file.c_str(), recording.signal.duration_s(),
        recording.signal.sample_rate_hz, drops ? recording.strikes_s.size() : recording.frequency_hz.size(),
        drops ? "bubbles" : "partials");
  }
  for (const auto& [name, text] : dataset.files) write_file(out.staging() / name, text);
  if (!dataset.specimen_toml.empty()) write_file(out.staging() / "specimen.toml", dataset.specimen_toml);
  write_file(out.staging() / "truth.json", json_text(json_of(document)));
  out.commit();
  write_json(common, json_of(document));
  if (!dataset.specimen_toml.empty())
    say(common, "fit it: klang fit %s -o DIR\n", (std::filesystem::path(options.output) / "specimen.toml").c_str());
  return kDone;
}

}  // namespace

Subcommand add_dataset(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<DatasetOptions>();
  CLI::App* app = program.add_subcommand("dataset", "Synthetic recordings with their truth, from a recipe");
  app->add_option("recipe", options->recipe, "Recipe (TOML, docs/recipes.md, docs/recipes-drops.md)")->required();
  app->add_option("-o,--output", options->output, "Folder for the recordings, truth.json and specimen.toml")
      ->required();
  app->footer(
      "Examples:\n  klang dataset datasets-synthetic/recipes/six_chimes.toml -o chimes --seed 7\n  klang dataset "
      "datasets-synthetic/recipes/drops.toml -o drops --seed 7");
  return {app,
          [options, &common] { return run_dataset(*options, common); },
          {result_kind<DatasetDocument>("dataset", "the result of `klang dataset`, truth.json beside its files")}};
}

}  // namespace klang::apps
