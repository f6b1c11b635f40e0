#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/foundation/config/named_numbers.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"
#include "fit/proxy/proxy_fit_document.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct ProxyFitCommand {
  std::string bank, target, transfer, output;
  damping::RayleighDamping damping{.stiffness_s = 1e-7, .mass_per_s = 10.0};
  fit::ProxyFitOptions fit;
};

void write_voice(const std::filesystem::path& path, const fit::Voice& voice, const fit::ProxyFitOptions& options) {
  audio::Signal sound = fit::voice_sound(voice, options.duration_s, options.sample_rate_hz);
  const double peak = sound.samples.cwiseAbs().maxCoeff();
  if (peak > 0.0) sound.samples *= 0.5 / peak;
  audio::write_sound(path, sound);
}

int run_proxy_fit(const ProxyFitCommand& o, const CommonOptions& common) {
  if (o.output.empty()) throw InputError("-o", "is missing", "", "a folder for the result");
  o.fit.validate();
  const soundbank::Soundbank bank = soundbank::read_soundbank(o.bank);
  TerminalMonitor monitor(common.quiet);
  fit::ProxyTarget target;
  const bool is_model = std::filesystem::path(o.target).extension() == ".vtu";
  if (is_model) {
    const modal::ModalModel model = modal::read_modal_model(o.target);
    soundbank::check_poissons_ratio(bank, model.material.poissons_ratio(), o.target);
    if (o.transfer.empty()) {
      target = fit::target_of_model(model, o.damping);
    } else {
      const acoustics::TransferModel transfer = acoustics::read_transfer_model(o.transfer);
      acoustics::check_belongs(transfer, model, o.transfer);
      target = fit::target_of_model(model, transfer, o.damping);
    }
  } else {
    if (!o.transfer.empty()) throw InputError("--transfer", "is of a modal model, not of a recording", o.transfer);
    const fit::RingdownResult ringdown = fit::identify_ringdown(audio::read_sound(o.target), {}, monitor);
    if (!ringdown.usable()) throw NumericalError(o.target + ": " + ringdown.message);
    target = fit::target_of_partials(ringdown.partials);
  }
  OutputDirectory folder(o.output);
  const fit::ProxyFitResult result = fit::fit_proxy(bank, target, o.fit, monitor);
  if (result.start_clamped)
    warn("the body is thinner than the bank's thinnest shape, 1:" + to_text(1.0 / bank.thinnest) +
         ": the start lies on the border");
  fit::ProxyFitDocument document = fit::proxy_fit_document(
      make_header("proxy_fit", "done", common,
                  {{"partials", o.fit.n_partials},
                   {"highest_hz", o.fit.highest_hz},
                   {"duration_s", o.fit.duration_s},
                   {"sample_rate_hz", o.fit.sample_rate_hz},
                   {"rayleigh_mass_per_s", o.damping.mass_per_s},
                   {"rayleigh_stiffness_s", o.damping.stiffness_s}},
                  o.transfer.empty() ? std::vector<std::filesystem::path>{o.bank, o.target}
                                     : std::vector<std::filesystem::path>{o.bank, o.target, o.transfer}),
      result);
  document.radiation = target.radiation.has_value();
  document.sound =
      target.radiation ? "far away, rms over directions: amplitudes from the radiated power, decays with the radiation"
      : is_model ? "strike and microphone on the body, averaged over all places: amplitudes 1 / omega, no radiation"
                 : "the recording's partials; the proxy's amplitudes 1 / omega, no radiation";
  document.target_kind = is_model ? "model" : "recording";
  const nlohmann::json json = json_of(document);
  write_file(folder.staging() / "fit.json", json_text(json));
  write_voice(folder.staging() / "target.wav", result.target, o.fit);
  write_voice(folder.staging() / "before.wav", result.start_voice, o.fit);
  write_voice(folder.staging() / "after.wav", result.fitted_voice, o.fit);
  for (const std::string& warning : reports::write_report(folder.staging() / "fit.json", {}, monitor).warnings)
    warn(warning);
  monitor.throw_if_stopped();
  folder.commit();
  write_json(common, json);
  say(common, "%-28s %12s %12s\n", "", "before", "after");
  const auto after = numbers_of(result.after);
  for (const auto& [name, before] : numbers_of(result.before))
    say(common, "%-28s %12.4g %12.4g\n", name.c_str(), before, after.at(name));
  if (!result.message.empty()) say(common, "%s\n", result.message.c_str());
  say(common, "report: %s\n", (std::filesystem::path(o.output) / "report.html").c_str());
  return kDone;
}

}  // namespace

Subcommand add_proxy_fit(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ProxyFitCommand>();
  CLI::App* app =
      group.add_subcommand("fit", "The ellipsoid that sounds most like a body, and how far it is off before and after");
  app->add_option("bank", options->bank, "Bank from klang proxy build")->required();
  app->add_option("target", options->target, "Modal model (.vtu, from klang modes -o) or a recording")->required();
  app->add_option("--transfer", options->transfer,
                  "Of a modal model, from klang transfer: compare the sound far away, radiation included");
  app->add_option("-o,--output", options->output, "Folder for fit.json, report.html and the three sounds")->required();
  add_fields(*app, common, options->fit,
             {{"n_partials", "--partials"}, {"highest_hz"}, {"search.n_generations", "--generations"}, {"duration_s"}});
  app->add_option("--rayleigh-mass-per-s", options->damping.mass_per_s, "Damping of a model: mass coefficient")
      ->capture_default_str();
  app->add_option("--rayleigh-stiffness-s", options->damping.stiffness_s, "Damping of a model: stiffness coefficient")
      ->capture_default_str();
  app->footer(
      "Examples:\n"
      "  klang modes --shape box --dims length_m=0.05,width_m=0.03,height_m=0.008 --material "
      "youngs_modulus_pa=6.2e10,poissons_ratio=0.2,density_kg_m3=2600 --count 20 -o shard.vtu\n"
      "  klang proxy fit glass.bank shard.vtu -o shard-proxy\n"
      "  klang proxy fit glass.bank strike.wav -o strike-proxy");
  return {app,
          [options, &common] { return run_proxy_fit(*options, common); },
          {result_kind<fit::ProxyFitDocument>("proxy_fit", "fit.json of `klang proxy fit`")}};
}

}  // namespace klang::apps
