#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/strike_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/stage/listener_file.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/stage/radiating_voice.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

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
};

/// What --transfer adds to the result.
struct EarSound {
  audio::Signal sound_pa;
  nlohmann::json json;
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
  EarSound sound{result.sound_pa, nlohmann::json::object()};
  const Eigen::Vector3d start = listener.centre_m(0.0);
  sound.json = {{"file", options.transfer},
                {"device", report.device_name},
                {"delay", options.delay},
                {"unit_transfer", options.unit_transfer},
                {"n_ears", listener.stereo() ? 2 : 1},
                {"listener_moves", listener.moves()},
                {"listener_at_start_m", {start.x(), start.y(), start.z()}},
                {"n_modes_heard", report.n_modes_heard},
                {"n_modes_without_transfer", report.n_modes_without_transfer},
                {"n_modes_too_high", report.n_modes_too_high}};
  if (!options.unit_transfer) sound.json["peak_pressure_pa"] = result.sound_pa.samples.cwiseAbs().maxCoeff();
  return sound;
}

int run_synth(const SynthOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  options.damping.validate();
  checked("command line", "--duration-s", options.duration_s, 0.001, 3600.0);
  checked("command line", "--rate-hz", options.sample_rate_hz, 1000.0, 768000.0);
  checked("command line", "--peak-db", options.peak_db_re_full_scale, -120.0, 0.0);
  const modal::ModalModel model = modal::read_modal_model(options.model);
  const auto strikes = read_strikes(options.strikes, options.duration_s, model);
  stage::SynthesisOptions synthesis;
  synthesis.sample_rate_hz = options.sample_rate_hz;
  synthesis.duration_s = options.duration_s;
  Eigen::VectorXd decays = decay_per_s(options.damping, model);
  std::vector<std::filesystem::path> inputs = {options.model};
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
  audio::Signal sound =
      options.transfer.empty() ? stage::synthesise(model, decays, strikes, synthesis) : at_ears.sound_pa;
  const double peak = sound.samples.cwiseAbs().maxCoeff();
  if (!(peak > 0.0)) throw NumericalError("synth: the strikes excite no mode of this model");
  const double gain = std::pow(10.0, options.peak_db_re_full_scale / 20.0) / peak;
  sound.samples *= gain;
  audio::write_sound(options.output, sound);

  nlohmann::json used = {{"duration_s", options.duration_s},
                         {"sample_rate_hz", options.sample_rate_hz},
                         {"radiation_damping", options.radiation_damping}};
  options.damping.write(used);
  nlohmann::json json = result_header("synth", "done", common, used, inputs);
  json["gain"] = gain;
  if (!options.transfer.empty()) json["transfer"] = at_ears.json;
  const Eigen::VectorXd frequency_hz = model.frequency_hz();
  for (Eigen::Index i = 0; i < frequency_hz.size(); ++i) {
    json["modes"].push_back({{"index", i}, {"frequency_hz", frequency_hz[i]}, {"decay_per_s", decays[i]}});
  }
  write_json(common, json);
  say(common, "%s: %.2f s, %zu strike(s), %td modes\n", options.output.c_str(), options.duration_s, strikes.size(),
      model.n_modes());
  return kDone;
}

}  // namespace

Subcommand add_synth(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<SynthOptions>();
  CLI::App* app = program.add_subcommand("synth", "Sound of strikes on a modal model");
  app->add_option("model", options->model, "Modal model (.vtu) from klang modes -o or klang fit")->required();
  app->add_option("-o,--output", options->output, "Sound file (.wav or .flac)")->required();
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
      "  klang synth tube.vtu -o tube.wav --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 1 \\\n"
      "    --strike time_s=0,x_m=0.0125,z_m=0.2,fx_n_s=0.01,contact_s=5e-5 --strike time_s=1,x_m=0.0125,fx_n_s=0.02");
  return {app, [options, &common] { return run_synth(*options, common); }};
}

}  // namespace klang::apps
