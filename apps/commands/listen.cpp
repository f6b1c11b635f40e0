#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "apps/kit/capture.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/ringdown/takes.hpp"

namespace klang::apps {
namespace {

struct ListenOptions {
  std::string input, device, output;
  int n_takes = 0;
  double a4_hz = audio::kConcertPitchHz;
  double longest_s = 60.0;
};

void say_take(const fit::Take& take, std::size_t number, const CommonOptions& common) {
  say(common, "take %zu at %.3f s: %s %+.1f cents\n", number, take.strike_s, take.note.c_str(),
      take.cents.value_or(0.0));
  for (const fit::Partial& partial : take.partials) {
    say(common, "  %11.3f Hz  %-4s %+6.1f cents", partial.frequency_hz, partial.note.c_str(),
        partial.cents.value_or(0.0));
    if (partial.decay_per_s) say(common, "  60 dB in %.2f s", std::log(1000.0) / *partial.decay_per_s);
    say(common, "\n");
  }
}

int run_listen(const ListenOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  if (options.input.empty() == options.device.empty())
    throw InputError("listen", "needs one of --input and --device", "", "a sound file, or an input device");
  checked("command line", "--takes", options.n_takes, 0, 10000);
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  checked("command line", "--longest-s", options.longest_s, 0.5, 3600.0);
  const std::size_t most = options.n_takes > 0 ? static_cast<std::size_t>(options.n_takes) : 10000;
  audio::Signal recording;
  std::vector<std::filesystem::path> inputs;
  if (!options.input.empty()) {
    recording = audio::read_sound(options.input);
    inputs.emplace_back(options.input);
  }
  OutputDirectory out(options.output);
  if (!options.device.empty()) recording = captured_sound(options.device, options.longest_s, options.n_takes, monitor);
  fit::ListenDocument document;
  document.a4_hz = options.a4_hz;
  for (const fit::TakeSound& sound : fit::cut_takes(recording)) {
    if (document.takes.size() >= most) break;
    std::optional<fit::Take> take = fit::analysed_take(sound, options.a4_hz, monitor);
    if (!take) continue;
    const std::size_t number = document.takes.size() + 1;
    take->file = "take-" + std::to_string(number) + ".wav";
    audio::write_sound(out.staging() / *take->file, sound.sound);
    say_take(*take, number, common);
    document.takes.push_back(std::move(*take));
  }
  if (document.takes.empty())
    throw NumericalError((options.input.empty() ? options.device : options.input) + ": no tap was heard");
  document.header =
      make_header("listen", "done", common, {{"takes", options.n_takes}, {"a4_hz", options.a4_hz}}, inputs);
  if (options.n_takes > 0 && document.takes.size() < most)
    document.header.warnings.push_back("only " + std::to_string(document.takes.size()) + " of " +
                                       std::to_string(options.n_takes) + " takes were heard");
  const nlohmann::json json = json_of(document);
  write_file(out.staging() / "listen.json", json_text(json));
  out.commit();
  write_json(common, json);
  for (const std::string& warning : document.header.warnings) warn(warning);
  return kDone;
}

}  // namespace

Subcommand add_listen(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<ListenOptions>();
  CLI::App* app = program.add_subcommand("listen", "Taps as they come: each one's note and partials");
  app->add_option("--input", options->input, "Sound file instead of a device");
  app->add_option("--device", options->device, "Input device: a number, part of its name, or default");
  app->add_option("--takes", options->n_takes, "Stop after this many taps; 0: all that come")->capture_default_str();
  app->add_option("-o,--output", options->output, "Folder for listen.json and take-N.wav")->required();
  app->add_option("--a4-hz", options->a4_hz, "Frequency of A4, 300 to 600")->capture_default_str();
  app->add_option("--longest-s", options->longest_s, "A device is listened to for so long at most, 0.5 to 3600")
      ->capture_default_str();
  app->footer(
      "Examples:\n"
      "  klang listen --device default --takes 3 -o taps\n"
      "  klang listen --input session.wav -o taps");
  return {app,
          [options, &common] { return run_listen(*options, common); },
          {result_kind<fit::ListenDocument>("listen", "listen.json of `klang listen`")}};
}

}  // namespace klang::apps
