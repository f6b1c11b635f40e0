#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/commands/synth_documents.hpp"
#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/strike_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/modal/damping/assumed_damping.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/sound_level.hpp"
#include "core/sound/instrument/modal_bank.hpp"
#include "core/sound/stage/listener_file.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/stage/radiating_voice.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"
#include "fit/instrument/banks.hpp"
#include "fit/instrument/fitted_body.hpp"

namespace klang::apps {
namespace {

struct SynthOptions {
  std::string model;
  std::string output;
  std::vector<std::string> strikes;
  DampingOptions damping;
  double sample_rate_hz = 48000.0;
  double duration_s = 3.0;
  double peak_db_re_full_scale = -3.0;
  std::string transfer;
  std::string listener;
  std::optional<double> ears_m;
  std::optional<std::string> device;
  std::string precision = "double";
  bool delay = false;
  bool unit_transfer = false;
  bool radiation_damping = false;
  std::string specimen, dims, material;
};

/// What is struck, and how fast each mode dies away.
struct Struck {
  modal::ModalModel model;
  Eigen::VectorXd decays;
  std::vector<std::filesystem::path> inputs;
  std::vector<std::string> warnings = {};
};

/// Damping by options goes first, then that of the fit; without either it is assumed, and that is said.
Struck struck_body(const SynthOptions& options, const std::string& kind, Monitor& monitor) {
  Struck struck;
  const bool damping_given = options.damping.given;
  std::optional<Eigen::VectorXd> fitted;
  if (kind == "fit") {
    fit::BodyChange change;
    if (!options.dims.empty()) change.dims = parse_assignments("--dims", options.dims);
    if (!options.material.empty()) change.material = parse_material(options.material);
    fit::FittedBody body =
        fit::fitted_body(fit::read_fit_document(options.model), options.model, options.specimen, change, monitor);
    struck.model = std::move(body.model);
    fitted = std::move(body.decay_per_s);
    struck.inputs = {options.model};
  } else {
    struck.model = modal::read_modal_model(options.model);
    struck.inputs = {options.model};
    if (const auto beside = fit::fit_beside(options.model); beside && !damping_given) {
      fitted = fit::fitted_body(fit::read_fit_document(beside->path), beside->path, beside->specimen, {}).decay_per_s;
      struck.inputs.push_back(beside->path);
    }
  }
  if (damping_given) {
    struck.decays = decay_per_s(options.damping, struck.model);
    if (!(struck.decays.array() > 0.0).any())
      struck.warnings.emplace_back("the damping that was given is 0: the modes ring on");
  } else if (fitted) {
    struck.decays = *fitted;
  } else {
    struck.decays = fit::assumed_decay_per_s(struck.model);
    struck.warnings.push_back(damping::assumed_damping_words(options.model) + "; " + damping_option_names() +
                              " say it");
  }
  return struck;
}

audio::Signal analysed_sound(const SynthOptions& options, std::vector<std::string>& warnings) {
  if (!options.strikes.empty() || !options.transfer.empty() || options.damping.any())
    throw InputError(options.model, "is a recording's analysis: it has its own strike and damping", "",
                     "no --strike, --transfer or damping");
  const fit::ReadBanks read = fit::bank_of(fit::read_analysis_document(options.model));
  const instrument::ModalBank& bank = read.banks.front();
  warnings = read.warnings;
  if (bank.partials.empty()) throw InputError(options.model, "no partial rings");
  audio::Signal sound;
  sound.sample_rate_hz = options.sample_rate_hz;
  sound.samples =
      instrument::bank_sound(bank, options.sample_rate_hz,
                             static_cast<Eigen::Index>(std::llround(options.duration_s * options.sample_rate_hz)));
  return sound;
}

/// What --transfer adds to the result.
struct EarSound {
  audio::Signal sound_pa;
  EarRecord record;
};

EarSound sound_at_ears(const SynthOptions& options, const modal::ModalModel& model,
                       const acoustics::TransferModel& transfer, const Eigen::VectorXd& decays,
                       const std::vector<events::Strike>& strikes) {
  const Eigen::Vector3d centre = transfer.modes.front().multipole.centre_m;
  stage::Listener listener = options.listener.empty()
                                 ? stage::listener_at(stage::default_listener_m(transfer, 1.0), options.ears_m, centre)
                                 : stage::read_listener(options.listener, options.ears_m, centre);
  listener.propagation_delay = options.delay;
  stage::TransferSynthesisOptions synthesis;
  synthesis.sample_rate_hz = options.sample_rate_hz;
  synthesis.duration_s = options.duration_s;
  synthesis.voice.unit_transfer = options.unit_transfer;
  if (options.device) {
    synthesis.voice.device = {
        true, *options.device == "default" ? std::string() : *options.device,
        options.precision == "single" ? acoustics::Precision::kSingle : acoustics::Precision::kDouble};
  }
  const stage::TransferSynthesisResult result =
      stage::synthesise_at_ears(model, transfer, decays, strikes, listener, synthesis);
  const stage::RadiatingVoice::Report& report = result.heard;
  if (!report.message.empty()) warn(report.message);
  if (report.n_modes_without_transfer > 0) {
    warn(std::to_string(report.n_modes_without_transfer) + " mode(s) of the model have no transfer and are silent");
  }
  EarSound sound{result.sound_pa, {}};
  const Eigen::Vector3d start = listener.centre_m(0.0);
  EarRecord& record = sound.record;
  record.file = options.transfer;
  record.device = report.device_name;
  record.delay = options.delay;
  record.unit_transfer = options.unit_transfer;
  record.n_ears = listener.stereo() ? 2 : 1;
  record.listener_moves = listener.moves();
  record.listener_at_start_m = {start.x(), start.y(), start.z()};
  record.n_modes_heard = report.n_modes_heard;
  record.n_modes_without_transfer = report.n_modes_without_transfer;
  record.n_modes_too_high = report.n_modes_too_high;
  if (!options.unit_transfer) record.peak_pressure_pa = result.sound_pa.samples.cwiseAbs().maxCoeff();
  return sound;
}

/// Without --strike the model sounds as its modal bank, to the bit what klang export writes: it starts at once, without the samples within
/// the pulse.
audio::Signal dry_sound(const SynthOptions& options, const modal::ModalModel& model, const Eigen::VectorXd& decays,
                        const std::vector<events::Strike>& strikes) {
  stage::SynthesisOptions synthesis;
  synthesis.sample_rate_hz = options.sample_rate_hz;
  synthesis.duration_s = options.duration_s;
  if (!options.strikes.empty()) return stage::synthesise(model, decays, strikes, synthesis);
  audio::Signal sound;
  sound.sample_rate_hz = options.sample_rate_hz;
  sound.samples =
      instrument::bank_sound(instrument::struck_bank(model, decays, strikes.front()), options.sample_rate_hz,
                             static_cast<Eigen::Index>(std::llround(options.duration_s * options.sample_rate_hz)));
  return sound;
}

/// Scales to --peak-db and writes; a pressure that nobody hears stays as quiet, with a warning. @return the gain
double write_scaled(const SynthOptions& options, audio::Signal& sound, bool in_pascals,
                    std::vector<std::string>& warnings) {
  const double peak = sound.samples.cwiseAbs().maxCoeff();
  if (!(peak > 0.0)) throw NumericalError("synth: the strikes excite no mode of this model");
  const double gain = in_pascals ? audio::file_gain(peak, options.peak_db_re_full_scale)
                                 : std::pow(10.0, options.peak_db_re_full_scale / 20.0) / peak;
  if (in_pascals && audio::is_inaudible(peak)) warnings.push_back(audio::inaudible_note(peak));
  sound.samples *= gain;
  audio::write_sound(options.output, sound);
  return gain;
}

int write_analysed(const SynthOptions& options, const CommonOptions& common) {
  std::vector<std::string> warnings;
  audio::Signal sound = analysed_sound(options, warnings);
  const double gain = write_scaled(options, sound, false, warnings);
  const nlohmann::json used = {{"duration_s", options.duration_s}, {"sample_rate_hz", options.sample_rate_hz}};
  SynthDocument document;
  document.header = make_header("synth", "done", common, used, {options.model});
  document.header.warnings = warnings;
  document.gain = gain;
  write_json(common, json_of(document));
  for (const std::string& warning : warnings) warn(warning);
  say(common, "%s: %.2f s of the partials that were measured\n", options.output.c_str(), options.duration_s);
  return kDone;
}

int run_synth(const SynthOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  options.damping.validate();
  checked("command line", "--duration-s", options.duration_s, 0.001, 3600.0);
  checked("command line", "--rate-hz", options.sample_rate_hz, 1000.0, 768000.0);
  checked("command line", "--peak-db", options.peak_db_re_full_scale, -120.0, 0.0);
  const bool is_json = std::filesystem::path(options.model).extension() == ".json";
  const std::string kind = is_json ? text_under(read_result_json(options.model), "kind") : "model";
  if (kind != "fit" && kind != "analysis" && kind != "model")
    throw InputError(options.model, "holds nothing to strike", kind, "a modal model (.vtu), fit.json or analysis.json");
  if (kind != "fit" && !(options.specimen + options.dims + options.material).empty())
    throw InputError("--specimen, --dims and --material", "belong to a fit.json", options.model);
  if (kind == "analysis") return write_analysed(options, common);
  const Struck struck = struck_body(options, kind, monitor);
  const modal::ModalModel& model = struck.model;
  const auto strikes = read_strikes(options.strikes, options.duration_s, model);
  Eigen::VectorXd decays = struck.decays;
  std::vector<std::filesystem::path> inputs = struck.inputs;
  EarSound at_ears;
  if (!options.transfer.empty()) {
    const acoustics::TransferModel transfer = acoustics::read_transfer_model(options.transfer);
    acoustics::check_belongs(transfer, model, options.transfer);
    if (transfer.modes.empty()) throw InputError(options.transfer, "has no mode");
    if (options.radiation_damping) {
      for (const acoustics::ModeTransfer& mode : transfer.modes) decays[mode.mode] += mode.decay_radiation_per_s;
    }
    inputs.emplace_back(options.transfer);
    if (!options.listener.empty()) inputs.emplace_back(options.listener);
    at_ears = sound_at_ears(options, model, transfer, decays, strikes);
  }
  audio::Signal sound = options.transfer.empty() ? dry_sound(options, model, decays, strikes) : at_ears.sound_pa;
  std::vector<std::string> warnings = struck.warnings;
  const double gain = write_scaled(options, sound, at_ears.record.peak_pressure_pa.has_value(), warnings);

  nlohmann::json used = {{"duration_s", options.duration_s},
                         {"sample_rate_hz", options.sample_rate_hz},
                         {"radiation_damping", options.radiation_damping}};
  options.damping.write(used);
  SynthDocument document;
  document.header = make_header("synth", "done", common, used, inputs);
  document.gain = gain;
  document.header.warnings = warnings;
  for (const std::string& warning : warnings) warn(warning);
  if (!options.transfer.empty()) document.transfer = at_ears.record;
  const Eigen::VectorXd frequency_hz = model.frequency_hz();
  for (Eigen::Index i = 0; i < frequency_hz.size(); ++i) {
    document.modes.push_back({static_cast<int>(i), frequency_hz[i], decays[i]});
  }
  write_json(common, json_of(document));
  say(common, "%s: %.2f s, %zu strike(s), %td modes\n", options.output.c_str(), options.duration_s, strikes.size(),
      model.n_modes());
  return kDone;
}

}  // namespace

Subcommand add_synth(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<SynthOptions>();
  CLI::App* app = program.add_subcommand("synth", "Sound of strikes on a modal model");
  app->add_option("model", options->model,
                  "Modal model (.vtu) from klang modes -o or klang fit; fit.json in its folder; analysis.json")
      ->required();
  app->add_option("-o,--output", options->output, "Sound file (.wav or .flac)")->required();
  app->add_option("--specimen", options->specimen, "fit.json: which of its specimens; its fitted damping is used");
  app->add_option("--dims", options->dims, "fit.json: the same thing of other dimensions: name_m=value,...");
  app->add_option("--material", options->material,
                  "fit.json: the same thing of other elasticity and density, as in klang modes");
  add_strike_option(*app, options->strikes);
  add_damping_options(*app, options->damping);
  app->add_option("--duration-s", options->duration_s, "Length of the sound")->capture_default_str();
  app->add_option("--rate-hz", options->sample_rate_hz, "Sample rate")->capture_default_str();
  app->add_option("--peak-db", options->peak_db_re_full_scale, "Level of the highest peak, dB re full scale")
      ->capture_default_str();
  auto* transfer = app->add_option("--transfer", options->transfer,
                                   "Transfer model (.vtu) from klang transfer: sound at the ear in Pa");
  app->add_option("--listener", options->listener,
                  "Path of the listener, CSV: time_s,x_m,y_m,z_m; then right_x_m,right_y_m,right_z_m (the first is the "
                  "left ear) or "
                  "facing_x,facing_y,facing_z. Without it: 1 m from the centre where the strongest mode is loudest")
      ->needs(transfer);
  app->add_option("--ears-m", options->ears_m,
                  "Two ears this far apart, with their phases (without facing columns: facing the body)")
      ->needs(transfer);
  app->add_flag("--delay", options->delay, "Sound takes distance / c to arrive: delay and Doppler shift")
      ->needs(transfer);
  app->add_flag("--unit-transfer", options->unit_transfer, "For comparison: every mode's |p| = 1")->needs(transfer);
  app->add_flag("--radiation-damping", options->radiation_damping, "Add the decay by radiation to each mode's damping")
      ->needs(transfer);
  app->add_option("--device", options->device,
                  "OpenCL device for the transfer: auto (a GPU where there is one, else the processor), cpu, an index "
                  "or part of a name "
                  "as in klang doctor")
      ->needs(transfer);
  app->add_option("--precision", options->precision, "Of the OpenCL device")
      ->check(CLI::IsMember({"single", "double"}))
      ->needs(transfer)
      ->capture_default_str();
  name_field(*app, common, "device", "--device");
  app->footer(
      "Examples:\n"
      "  klang synth plate.vtu -o plate.wav --transfer plate-transfer.vtu --listener walk.csv --ears-m 0.17 --delay\n"
      "  klang synth chimes/fit.json --specimen D5 --dims length_m=0.4 -o shorter.wav\n"
      "  klang synth tap.json -o tap-again.wav\n"
      "  klang synth tube.vtu -o tube.wav --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 1 \\\n"
      "    --strike time_s=0,x_m=0.0125,z_m=0.2,fx_n_s=0.01,contact_s=5e-5 --strike time_s=1,x_m=0.0125,fx_n_s=0.02");
  return {app,
          [options, &common] { return run_synth(*options, common); },
          {result_kind<SynthDocument>("synth", "the result of `klang synth`")}};
}

}  // namespace klang::apps
