#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "reports/report/report.hpp"
#include "validate/debris/debris_document.hpp"

namespace klang::apps {
namespace {

struct ProxyStudyCommand {
  std::string bank, output, slab;
  bool shards_only = false;
  double youngs_modulus_pa = 6.2e10, poissons_ratio = 0.2, density_kg_m3 = 2600.0;  // glass of SB Table 1
  validate::DebrisStudyOptions study;
};

nlohmann::json options_json(const ProxyStudyCommand& o) {
  const validate::DebrisStudyOptions& s = o.study;
  return {{"pieces", s.debris.n_shards},
          {"shards_only", o.shards_only},
          {"slab_m", {s.debris.slab_m[0], s.debris.slab_m[1], s.debris.slab_m[2]}},
          {"tilt_deg", s.debris.largest_tilt_deg},
          {"youngs_modulus_pa", o.youngs_modulus_pa},
          {"poissons_ratio", o.poissons_ratio},
          {"density_kg_m3", o.density_kg_m3},
          {"highest_hz", s.highest_hz},
          {"elements_per_wavelength", s.elements_per_wavelength},
          {"polynomial_degree", s.polynomial_degree},
          {"rayleigh_mass_per_s", s.damping.mass_per_s},
          {"rayleigh_stiffness_s", s.damping.stiffness_s},
          {"impulse_n_s", s.impulse_n_s},
          {"contact_duration_s", s.contact_duration_s},
          {"contact", to_text(s.contact)},
          {"friction_deg", s.friction_deg},
          {"listener_m", s.listener_m},
          {"duration_s", s.duration_s},
          {"mix_s", s.mix_s},
          {"partials", s.n_partials},
          {"thresholds", s.n_thresholds},
          {"repeats", s.proxy_repeats}};
}

/// Both mixes at one gain.
void write_mixes(const std::filesystem::path& folder, const validate::DebrisStudyResult& result) {
  const double peak =
      std::max(result.direct_mix.samples.cwiseAbs().maxCoeff(), result.proxy_mix.samples.cwiseAbs().maxCoeff());
  for (const auto& [name, mix] : {std::pair{"direct.wav", &result.direct_mix}, {"proxy.wav", &result.proxy_mix}}) {
    audio::Signal sound = *mix;
    if (peak > 0.0) sound.samples *= 0.5 / peak;
    audio::write_sound(folder / name, sound);
  }
}

int run_proxy_study(ProxyStudyCommand o, const CommonOptions& common) {
  if (o.output.empty()) throw InputError("-o", "is missing", "", "a folder for the result");
  validate::DebrisStudyOptions& study = o.study;
  if (study.debris.n_shards < 1)
    throw InputError("command line", "--pieces", std::to_string(study.debris.n_shards), "1 to 500");
  if (!o.slab.empty()) {
    const std::vector<double> sizes = parse_numbers("--slab", o.slab, 3);
    study.debris.slab_m = {sizes[0], sizes[1], sizes[2]};
  }
  if (o.shards_only) {
    study.debris.box_m.setZero();
    study.debris.plate_thicknesses_m.clear();
  }
  study.debris.seed = common.seed;
  study.material = solid::from_youngs_modulus(o.youngs_modulus_pa, o.poissons_ratio, o.density_kg_m3);
  study.validate();
  const soundbank::Soundbank bank = soundbank::read_soundbank(o.bank);
  TerminalMonitor monitor(common.quiet);
  OutputDirectory folder(o.output);
  const validate::DebrisStudyResult result = validate::debris_study(bank, study, monitor);
  const validate::DebrisDocument document =
      validate::debris_document(make_header("proxy_study", "done", common, options_json(o), {o.bank}), result);
  const nlohmann::json json = json_of(document);
  write_file(folder.staging() / "study.json", json_text(json));
  write_file(folder.staging() / "study.csv", validate::thresholds_csv(document));
  write_mixes(folder.staging(), result);
  const auto report = reports::write_report(folder.staging() / "study.json", {}, monitor);
  monitor.throw_if_stopped();
  folder.commit();
  write_json(common, json);
  for (const std::string& warning : report.warnings) warn(warning);
  say(common, "%12s %9s %9s %10s %12s %13s %9s\n", "proxy [Hz]", "replaced", "modes [%]", "direct [s]", "proxies [s]",
      "spectral [dB]", "[dB(A)]");
  for (const validate::DebrisThreshold& t : result.thresholds)
    say(common, "%12.0f %9d %9.1f %10.3g %12.3g %13.2f %9.2f\n", t.threshold_hz, t.n_replaced, t.modes_replaced_percent,
        t.direct_s, t.with_proxies_s, t.log_spectral_distance_db, t.loudness_difference_db);
  say(common, "proxies: %.3g times cheaper, %.3g times without the single-frequency calculation\nreport: %s\n",
      *document.timings.speedup, *document.timings.speedup_without_lowest,
      (std::filesystem::path(o.output) / "report.html").c_str());
  return kDone;
}

}  // namespace

Subcommand add_proxy_study(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ProxyStudyCommand>();
  CLI::App* app =
      group.add_subcommand("study", "Debris directly and by proxies: error and time over the threshold of replacement");
  validate::DebrisStudyOptions& study = options->study;
  app->add_option("bank", options->bank, "Bank from klang proxy build, with sound")->required();
  app->add_option("-o,--output", options->output, "Folder for study.json, study.csv, report.html and the two mixes")
      ->required();
  add_fields(*app, common, study, {{"debris.n_shards", "--pieces", {}, between(1, 500)}});
  app->add_flag("--shards-only", options->shards_only, "Leave out the box and the three plates");
  app->add_option("--slab", options->slab, "Length, width and thickness of the slab [m]: 0.2,0.2,0.006");
  add_fields(*app, common, study,
             {{"debris.largest_tilt_deg", "--tilt-deg"}, {"n_thresholds", "--thresholds"}, {"highest_hz"}});
  app->add_option("--youngs-modulus-pa", options->youngs_modulus_pa, "Of the pieces; must be the bank's")
      ->capture_default_str();
  app->add_option("--poissons-ratio", options->poissons_ratio, "Of the pieces; must be the bank's")
      ->capture_default_str();
  app->add_option("--density-kg-m3", options->density_kg_m3, "Of the pieces; must be the bank's")
      ->capture_default_str();
  add_fields(*app, common, study,
             {{"rayleigh_mass_per_s"},
              {"rayleigh_stiffness_s"},
              {"contact"},
              {"friction_deg"},
              {"listener_m"},
              {"duration_s"},
              {"mix_s"},
              {"n_partials", "--partials"},
              {"polynomial_degree", "--degree"},
              {"elements_per_wavelength"},
              {"proxy_repeats", "--repeats"}});
  name_field(*app, common, "debris.slab_m", "--slab");
  app->footer(
      "Examples:\n"
      "  klang proxy study glass.bank -o debris --threads 1\n"
      "  klang proxy study glass.bank -o shards --shards-only --pieces 6 --slab 0.12,0.12,0.008 --seed 3");
  return {app,
          [options, &common] { return run_proxy_study(*options, common); },
          {result_kind<validate::DebrisDocument>("proxy_study", "study.json of `klang proxy study`")}};
}

}  // namespace klang::apps
