#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/commands/proxy_documents.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"

namespace klang::apps {
namespace {

std::vector<double> list(const Eigen::Ref<const Eigen::VectorXd>& values) { return {values.begin(), values.end()}; }

struct LookupOptions {
  std::string bank, inertia;
  double lowest_frequency_hz = 0.0;
  std::optional<double> poissons_ratio, youngs_modulus_pa, density_kg_m3;
  int modes = 10;
};

int run_proxy_lookup(const LookupOptions& o, const CommonOptions& common) {
  const std::vector<double> numbers = parse_numbers("--inertia", o.inertia, -1);
  if (numbers.size() != 3 && numbers.size() != 6)
    throw InputError("--inertia", "needs 3 principal moments or the 6 parts xx,yy,zz,xy,yz,zx of the matrix",
                     o.inertia);
  checked_open("command line", "--lowest-frequency-hz", o.lowest_frequency_hz, 0.0, 1e9);
  if (o.modes < 1 || o.modes > 100) throw InputError("command line", "--modes", std::to_string(o.modes), "1 to 100");
  const soundbank::Soundbank bank = soundbank::read_soundbank(o.bank);
  if (o.poissons_ratio) soundbank::check_poissons_ratio(bank, *o.poissons_ratio, "--poissons-ratio");
  const solid::Material material =
      solid::from_youngs_modulus(o.youngs_modulus_pa.value_or(bank.material.youngs_modulus_pa()), bank.poissons_ratio,
                                 o.density_kg_m3.value_or(bank.material.density_kg_m3));
  soundbank::PrincipalFrame frame;
  if (numbers.size() == 6) {
    Eigen::Matrix3d inertia;
    inertia << numbers[0], numbers[3], numbers[5], numbers[3], numbers[1], numbers[4], numbers[5], numbers[4],
        numbers[2];
    frame = soundbank::principal_frame(inertia);
  } else {
    frame = soundbank::principal_frame(Eigen::Vector3d(numbers[0], numbers[1], numbers[2]).asDiagonal());
  }
  const soundbank::ProxyFinder finder(bank);
  const double speed = material.shear_speed_m_s();
  const soundbank::Proxy proxy = finder.find(frame.moments, o.lowest_frequency_hz, speed);
  if (proxy.clamped)
    warn("the body is thinner than the bank's thinnest shape, 1:" + to_text(1.0 / bank.thinnest) + ", which is taken");
  const Eigen::VectorXd hz = soundbank::proxy_frequencies_hz(bank, proxy, o.modes, speed);

  ProxyLookupDocument document;
  document.header = make_header("proxy_lookup", "done", common,
                                {{"inertia", numbers},
                                 {"lowest_frequency_hz", o.lowest_frequency_hz},
                                 {"youngs_modulus_pa", material.youngs_modulus_pa()},
                                 {"poissons_ratio", bank.poissons_ratio},
                                 {"density_kg_m3", material.density_kg_m3}},
                                {o.bank});
  document.axes = list(proxy.axes);
  document.scale = proxy.scale;
  document.axes_m = list(proxy.scale * proxy.axes);
  document.frequencies_hz = list(hz);
  document.clamped = proxy.clamped;
  const Eigen::Matrix3d by_rows = frame.rotation.transpose();
  document.rotation_rows = list(by_rows.reshaped());
  const soundbank::Cell& cell = bank.cells[static_cast<std::size_t>(proxy.cell)];
  document.cell = {static_cast<int>(proxy.cell), list(soundbank::unit_axes(cell.shape)), proxy.cell_distance};
  write_json(common, json_of(document));
  say(common, "axes %.4g : %.4g : %.4g, scale %.4g m (semi-axes %.4g, %.4g, %.4g m)\n", proxy.axes[0], proxy.axes[1],
      proxy.axes[2], proxy.scale, proxy.scale * proxy.axes[0], proxy.scale * proxy.axes[1],
      proxy.scale * proxy.axes[2]);
  for (Eigen::Index i = 0; i < hz.size(); ++i) say(common, "%s%.6g", i == 0 ? "" : " ", hz[i]);
  say(common, " Hz\n");
  return kDone;
}

}  // namespace

Subcommand add_proxy_lookup(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<LookupOptions>();
  CLI::App* app =
      group.add_subcommand("lookup", "The ellipsoid that stands for a body, from its inertia and its lowest frequency");
  app->add_option("bank", options->bank, "Bank from klang proxy build")->required();
  app->add_option("--inertia", options->inertia,
                  "Principal moments I1,I2,I3, or the matrix xx,yy,zz,xy,yz,zx; any unit")
      ->required();
  app->add_option("--lowest-frequency-hz", options->lowest_frequency_hz, "Of the body's lowest elastic mode")
      ->required();
  app->add_option("--poissons-ratio", options->poissons_ratio, "Of the body: must be the bank's");
  app->add_option("--youngs-modulus-pa", options->youngs_modulus_pa, "Of the body; default: the bank's");
  app->add_option("--density-kg-m3", options->density_kg_m3, "Of the body; default: the bank's");
  app->add_option("--modes", options->modes, "Frequencies to list")->capture_default_str();
  app->footer(
      "Example:\n  klang proxy lookup glass.bank --inertia 1.64,1.36,1.0 --lowest-frequency-hz 5200 --json l.json");
  return {app,
          [options, &common] { return run_proxy_lookup(*options, common); },
          {result_kind<ProxyLookupDocument>("proxy_lookup", "the result of `klang proxy lookup`")}};
}

}  // namespace klang::apps
