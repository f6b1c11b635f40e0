#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"
#include "validate/papers/papers.hpp"

namespace klang::apps {
namespace {

struct PapersCommand {
  std::string output;
  std::string markdown;
  std::string scenes;
};

int run_papers(const PapersCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  std::unique_ptr<OutputDirectory> out;
  if (!command.output.empty()) out = std::make_unique<OutputDirectory>(command.output);
  const validate::PaperTables tables = validate::run_papers(monitor, command.scenes);

  const nlohmann::json json = json_of(validate::papers_document(
      make_header("papers", tables.passed() ? "passed" : "not_passed", common, {{"scenes", command.scenes}}, {}),
      tables));
  if (out) {
    write_file(out->staging() / "papers.json", json_text(json));
    write_file(out->staging() / "junit.xml", validate::junit_xml("klang validate papers", validate::claims_of(tables)));
    const auto report = reports::write_report(out->staging() / "papers.json", {}, monitor);
    for (const std::string& warning : report.warnings) warn(warning);
    monitor.throw_if_stopped();
    out->commit();
  }
  if (!command.markdown.empty()) write_file(command.markdown, validate::markdown(tables));
  write_json(common, json);

  for (const validate::PaperNumber& n : tables.numbers) {
    say(common, "%-12s  %-34s printed %-11.6g ours %-11.6g", to_text(n.verdict).c_str(), n.id.c_str(), n.printed,
        n.ours);
    if (n.reference) say(common, " reference %.6g", *n.reference);
    say(common, "\n");
  }
  for (const validate::PaperScene& scene : tables.scenes) {
    if (!scene.ours && (command.scenes.empty() || scene.version.empty())) continue;
    say(common, "%-12s  %-34s printed %-11s ours %-11s %s\n", validate::verdict_words(scene).c_str(),
        scene.scene.c_str(), scene.printed ? to_text(*scene.printed).c_str() : "-",
        scene.ours ? to_text(*scene.ours).c_str() : "-", scene.quantity.c_str());
  }
  const auto program = std::count_if(tables.numbers.begin(), tables.numbers.end(), [](const validate::PaperNumber& n) {
    return n.source == validate::NumberSource::kProgram;
  });
  say(common, "%s: %zu numbers, %zu computed by the program\n", tables.passed() ? "passed" : "NOT PASSED",
      tables.numbers.size(), static_cast<std::size_t>(program));
  if (out) say(common, "report: %s\n", (std::filesystem::path(command.output) / "report.html").c_str());
  return tables.passed() ? kDone : kCheckNotPassed;
}

}  // namespace

Subcommand add_validate_papers(CLI::App& group, CommonOptions& common) {
  auto command = std::make_shared<PapersCommand>();
  CLI::App* papers = group.add_subcommand(
      "papers", "The numbers of the papers' tables beside what should stand there: printed, ours, reference, verdict");
  papers->add_option("-o,--output", command->output, "Folder for papers.json, junit.xml and report.html");
  papers->add_option("--markdown", command->markdown, "Write the tables as Markdown (docs/papers.md)")
      ->type_name("FILE");
  papers
      ->add_option("--scenes", command->scenes,
                   "Folder with folders of klang scene run, PAPER_NAME each (sb_tile for scenes/sb/tile.toml)")
      ->type_name("RUNS");
  papers->footer(
      "Examples:\n"
      "  klang validate papers -o papers\n"
      "  klang validate papers --markdown docs/papers.md\n"
      "  klang scene run datasets-synthetic/scenes/sb/tile.toml -o RUNS/sb_tile && klang validate papers --scenes "
      "RUNS\n"
      "Exit code 1: a number differs from the paper and it is not known why.");
  return {papers,
          [command, papers, &common] {
            if (papers->count("--scenes") > 0 && command->scenes.empty())
              throw InputError("--scenes", "is empty", "", "a folder with runs of scenes");
            return run_papers(*command, common);
          },
          {result_kind<validate::PapersDocument>("papers", "papers.json of `klang validate papers`")}};
}

}  // namespace klang::apps
