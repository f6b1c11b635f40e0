#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/tool_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/note.hpp"
#include "core/sound/instrument/instrument_files.hpp"
#include "fit/instrument/banks.hpp"

namespace klang::apps {
namespace {

struct ExportOptions {
  std::string result, specimen, output, sfz;
  bool faust = false, scala = false, pure_data = false, csv = false;
  double a4_hz = audio::kConcertPitchHz;
  double rate_hz = 48000.0;
};

const instrument::ModalBank& only_bank(const std::vector<instrument::ModalBank>& banks, const std::string& format) {
  if (banks.size() == 1) return banks.front();
  std::string names;
  for (const instrument::ModalBank& bank : banks) names += (names.empty() ? "" : ", ") + bank.name;
  throw InputError(format, "holds one thing: which? --specimen says it", "", names);
}

int run_export(const ExportOptions& options, const CommonOptions& given) {
  CommonOptions common = given;
  TerminalMonitor monitor(common.quiet);
  const int n_formats =
      int(options.faust) + int(options.scala) + int(options.pure_data) + int(options.csv) + int(!options.sfz.empty());
  if (n_formats != 1)
    throw InputError("export", "needs one format", std::to_string(n_formats),
                     "--faust, --sfz DIR, --scl, --pd or --csv");
  if (options.sfz.empty() == options.output.empty())
    throw InputError("-o", options.sfz.empty() ? "is missing" : "has no meaning beside --sfz DIR", options.output);
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  checked("command line", "--rate-hz", options.rate_hz, 8000.0, 192000.0);
  const fit::ReadBanks read = fit::read_banks(options.result, options.specimen, options.rate_hz, monitor);
  const std::vector<instrument::ModalBank>& banks = read.banks;
  std::vector<std::string> warnings;
  if (!options.scala) warnings = read.warnings;  // a scale has no damping
  std::size_t n_partials = 0;
  for (const instrument::ModalBank& bank : banks) n_partials += bank.partials.size();
  const std::string name = std::filesystem::path(options.sfz.empty() ? options.output : options.sfz).stem().string();
  if (!options.sfz.empty()) {
    OutputDirectory folder(options.sfz);
    for (const std::string& warning : instrument::write_sfz(
             folder, banks, banks.size() == 1 ? banks.front().name : name, options.a4_hz, options.rate_hz))
      warnings.push_back(warning);
    folder.commit();
  } else {
    const std::string text = options.faust       ? instrument::faust_text(only_bank(banks, "--faust"))
                             : options.pure_data ? instrument::pure_data_text(only_bank(banks, "--pd"))
                             : options.scala     ? instrument::scala_text(banks, name)
                                                 : instrument::bank_csv(banks);
    common.table_on_stdout = options.output == "-";
    write_table(options.output, text);
  }
  const nlohmann::json used = {{"specimen", options.specimen}, {"a4_hz", options.a4_hz}, {"rate_hz", options.rate_hz}};
  ExportDocument document;
  document.header = make_header("export", "done", common, used, {options.result});
  for (const instrument::ModalBank& bank : banks)
    document.banks.push_back({bank.name, static_cast<std::int64_t>(bank.partials.size()), instrument::pitch_hz(bank)});
  document.header.warnings = warnings;
  for (const std::string& warning : warnings) warn(warning);
  write_json(common, json_of(document));
  say(common, "%s: %zu thing(s), %zu partials\n", options.sfz.empty() ? options.output.c_str() : options.sfz.c_str(),
      banks.size(), n_partials);
  return kDone;
}

}  // namespace

Subcommand add_export(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* app =
      program.add_subcommand("export", "What was analysed or fitted, for other programs: Faust, SFZ, Scala, Pd");
  app->add_option("result", options->result, "analysis.json or fit.json in its folder")->required();
  app->add_option("--specimen", options->specimen, "fit.json: this specimen only");
  app->add_flag("--faust", options->faust, "Faust program (.dsp): modal bank with one input and one output");
  app->add_option("--sfz", options->sfz, "Folder for an SFZ instrument with its samples, a region for each specimen");
  app->add_flag("--scl", options->scala, "Scala scale (.scl): the partials, or the lowest ones of several specimens");
  app->add_flag("--pd", options->pure_data, "Pure Data patch (.pd): modal bank");
  app->add_flag("--csv", options->csv, "Table of frequency, decay, amplitude and phase");
  app->add_option("-o,--output", options->output, "File to write (but for --sfz); - for standard output");
  app->add_option("--a4-hz", options->a4_hz, "SFZ: frequency of A4, 300 to 600")->capture_default_str();
  app->add_option("--rate-hz", options->rate_hz, "SFZ: sample rate, 8000 to 192000")->capture_default_str();
  app->footer(
      "Examples:\n"
      "  klang export tap.json --faust -o tap.dsp\n"
      "  klang export chimes/fit.json --sfz chimes-sfz\n"
      "  klang export chimes/fit.json --specimen D5 --pd -o d5.pd");
  return {app,
          [options, &common] { return run_export(*options, common); },
          {result_kind<ExportDocument>("export", "the result of `klang export`")}};
}

}  // namespace klang::apps
