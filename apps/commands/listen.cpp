#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "apps/kit/capture.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/iet/iet.hpp"
#include "fit/iet/iet_meter.hpp"
#include "fit/iet/listen_document.hpp"
#include "fit/ringdown/take_listener.hpp"

namespace klang::apps {
namespace {

struct ListenOptions {
  std::string input, device, output, specimens, specimen_name;
  int n_takes = 0;
  double a4_hz = audio::kConcertPitchHz;
  double longest_s = 60.0, rings_s = 3.0;
  bool has_shape = false;
  fit::IetSpecimen body;  ///< by options

  bool has_dimensions() const {
    return has_shape || body.length_m || body.width_m || body.thickness_m || body.diameter_m || body.mass_kg != 0.0;
  }
};

/// The specimen whose moduli are wanted; none where only notes are.
std::optional<fit::IetSpecimen> specimen_of(const ListenOptions& options) {
  if (options.specimens.empty()) {
    if (!options.specimen_name.empty()) throw InputError("--name", "belongs to --specimen", options.specimen_name);
    if (!options.has_dimensions()) return std::nullopt;
    fit::IetSpecimen body = options.body;
    body.specimen = "specimen";
    if (!options.has_shape) throw InputError("--shape", "is missing", "", "bar, rod or disc");
    validate_fields("command line", body);
    fit::check_dimensions(body, "command line");
    return body;
  }
  if (options.has_dimensions()) throw InputError("--specimen", "excludes --shape and dimensions", options.specimens);
  const auto all = fit::read_iet_specimens(options.specimens, fit::IetRecordings::kNotYet);
  std::vector<std::string> names;
  for (const fit::IetSpecimen& one : all) {
    if (one.specimen == options.specimen_name || (all.size() == 1 && options.specimen_name.empty())) return one;
    names.push_back(one.specimen);
  }
  if (options.specimen_name.empty())
    throw InputError("--name", "is needed: the file has several specimens", options.specimens, word_list(names));
  throw unknown_word("--name", "no such specimen", options.specimen_name, options.specimen_name, names);
}

void say_moduli(const fit::IetRow& row, const CommonOptions& common) {
  if (row.e_e1876_pa) {
    say(common, "  E %.5g Pa (full model %.5g)", *row.e_e1876_pa, row.e_model_pa.value_or(0.0));
    if (row.g_e1876_pa) say(common, "  G %.5g Pa", *row.g_e1876_pa);
    if (row.nu_e1876) say(common, "  nu %.3f", *row.nu_e1876);
    if (row.q_inverse_flexural) say(common, "  1/Q %.2g", *row.q_inverse_flexural);
    say(common, "\n");
  }
  if (!row.remark.empty()) say(common, "  %s\n", row.remark.c_str());
}

/// Takes as they are heard: analysed, said, and kept.
class Session {
 public:
  Session(const ListenOptions& options, const CommonOptions& common, OutputDirectory& out)
      : options_(options), common_(common), out_(out), specimen_(specimen_of(options)) {
    if (specimen_) meter_ = std::make_unique<fit::IetMeter>(*specimen_);
    document.a4_hz = options.a4_hz;
  }

  bool is_full() const {
    return document.takes.size() >= (options_.n_takes > 0 ? static_cast<std::size_t>(options_.n_takes) : 10000);
  }

  void hear(const fit::TakeSound& sound, Monitor& monitor) {
    std::optional<fit::Take> take = fit::analysed_take(sound, options_.a4_hz, monitor);
    if (!take) return;
    const std::size_t number = document.takes.size() + 1;
    take->file = "take-" + std::to_string(number) + ".wav";
    audio::write_sound(out_.staging() / *take->file, sound.sound);
    say_take(*take, number);
    if (meter_) {
      fit::IetRow row = meter_->row(take->partials);
      row.given.recording = *take->file;
      say_moduli(row, common_);
      document.moduli.push_back(std::move(row));
    }
    document.takes.push_back(std::move(*take));
    std::fflush(stdout);
  }

  void finish() {
    fit::mark_outliers(document.moduli);
    document.summary = fit::summary_of(document.moduli);
    for (const fit::IetSummary& line : document.summary) {
      if (line.n < 2) continue;
      say(common_, "%-20s %.5g", line.quantity.c_str(), line.mean);
      if (line.std) say(common_, " ± %.2g over %d taps", *line.std, line.n);
      say(common_, ", without the tolerances of dimensions and mass\n");
    }
  }

  fit::ListenDocument document;

 private:
  void say_take(const fit::Take& take, std::size_t number) const {
    say(common_, "take %zu at %.3f s: %s %+.1f cents\n", number, take.strike_s, take.note.c_str(),
        take.cents.value_or(0.0));
    for (const fit::Partial& partial : take.partials) {
      say(common_, "  %11.3f Hz  %-4s %+6.1f cents", partial.frequency_hz, partial.note.c_str(),
          partial.cents.value_or(0.0));
      if (partial.decay_per_s) say(common_, "  60 dB in %.2f s", std::log(1000.0) / *partial.decay_per_s);
      say(common_, "\n");
    }
  }

  const ListenOptions& options_;
  const CommonOptions& common_;
  OutputDirectory& out_;
  std::optional<fit::IetSpecimen> specimen_;
  std::unique_ptr<fit::IetMeter> meter_;
};

/// Until enough taps have come, the time is over, or Ctrl-C: what was heard until then is kept.
void hear_device(Session& session, const ListenOptions& options, Monitor& monitor) {
  Microphone microphone(options.device);
  fit::TakeListener listener(microphone.sample_rate_hz(), options.rings_s);
  double heard_s = 0.0;
  const auto hear = [&](const std::vector<fit::TakeSound>& takes) {
    for (const fit::TakeSound& take : takes)
      if (!session.is_full()) session.hear(take, silent_monitor());
  };
  while (!session.is_full() && heard_s < options.longest_s && !monitor.stop_requested()) {
    monitor.progress(listener.rings() ? "a tap rings" : "waiting for a tap", heard_s / options.longest_s);
    const std::vector<float> samples = microphone.next();
    heard_s += static_cast<double>(samples.size()) / microphone.sample_rate_hz();
    hear(listener.heard(samples));
  }
  hear(listener.rest());
}

int run_listen(const ListenOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  if (options.input.empty() == options.device.empty())
    throw InputError("listen", "needs one of --input and --device", "", "a sound file, or an input device");
  checked("command line", "--takes", options.n_takes, 0, 10000);
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  checked("command line", "--longest-s", options.longest_s, 0.5, 3600.0);
  checked("command line", "--rings-s", options.rings_s, 0.3, fit::kLongestTakeS);
  std::vector<std::filesystem::path> inputs;
  audio::Signal recording;
  if (!options.input.empty()) {
    recording = audio::read_sound(options.input);
    inputs.emplace_back(options.input);
  }
  if (!options.specimens.empty()) inputs.emplace_back(options.specimens);
  OutputDirectory out(options.output);
  Session session(options, common, out);
  if (options.device.empty()) {
    for (const fit::TakeSound& take : fit::cut_takes(recording))
      if (!session.is_full()) session.hear(take, monitor);
    monitor.throw_if_stopped();
  } else {
    hear_device(session, options, monitor);
  }
  fit::ListenDocument& document = session.document;
  if (document.takes.empty()) {
    monitor.throw_if_stopped();
    throw NumericalError((options.input.empty() ? options.device : options.input) + ": no tap was heard");
  }
  session.finish();
  document.header =
      make_header("listen", "done", common, {{"takes", options.n_takes}, {"a4_hz", options.a4_hz}}, inputs);
  if (options.n_takes > 0 && !session.is_full())
    document.header.warnings.push_back("only " + std::to_string(document.takes.size()) + " of " +
                                       std::to_string(options.n_takes) + " takes were heard");
  const nlohmann::json json = json_of(document);
  write_file(out.staging() / "listen.json", json_text(json));
  if (!document.moduli.empty()) write_file(out.staging() / "iet.csv", csv_table(document.moduli));
  out.commit();
  write_json(common, json);
  for (const std::string& warning : document.header.warnings) warn(warning);
  return monitor.stop_requested() ? kInterrupted : kDone;
}

}  // namespace

Subcommand add_listen(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<ListenOptions>();
  CLI::App* app = program.add_subcommand("listen", "Taps as they come: each one's note, partials, and E of a specimen");
  app->add_option("--input", options->input, "Sound file instead of a device");
  app->add_option("--device", options->device, "Input device: a number, part of its name, or default");
  app->add_option("--takes", options->n_takes, "Stop after this many taps; 0: all that come")->capture_default_str();
  app->add_option("-o,--output", options->output, "Folder for listen.json, take-N.wav and, of a specimen, iet.csv")
      ->required();
  app->add_option(
      "--specimen", options->specimens,
      "CSV file of klang iet (its recordings may be missing): E and G of each tap by ASTM E1876 and full model");
  app->add_option("--name", options->specimen_name, "Of --specimen, where it has several");
  add_fields(*app, common, options->body,
             {{.field = "shape", .help = "Instead of --specimen: bar, rod or disc"},
              {"length_m"},
              {"width_m"},
              {"thickness_m"},
              {"diameter_m"},
              {"mass_kg"}});
  app->add_option("--a4-hz", options->a4_hz, "Frequency of A4, 300 to 600")->capture_default_str();
  app->add_option("--longest-s", options->longest_s, "A device is listened to for so long at most, 0.5 to 3600")
      ->capture_default_str();
  app->add_option("--rings-s", options->rings_s,
                  "A device's tap is analysed when it has died away or has rung for so long, 0.3 to 10")
      ->capture_default_str();
  app->footer(
      "Examples:\n"
      "  klang listen --device default --takes 3 -o taps\n"
      "  klang listen --device default --shape bar --length-m 0.15 --width-m 0.03 --thickness-m 0.01 --mass-kg 0.12 -o "
      "bar\n"
      "  klang listen --device default --specimen bars.csv --name B07 -o B07\n"
      "  klang listen --input session.wav -o taps");
  return {app,
          [options, app, &common] {
            options->has_shape = app->get_option("--shape")->count() > 0;
            return run_listen(*options, common);
          },
          {result_kind<fit::ListenDocument>("listen", "listen.json of `klang listen`")}};
}

}  // namespace klang::apps
