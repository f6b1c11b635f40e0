#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/commands/proxy_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"

namespace klang::apps {
namespace {

int run_proxy_info(const std::string& file, const CommonOptions& common) {
  const soundbank::Soundbank bank = soundbank::read_soundbank(file);
  ProxyInfoDocument document;
  document.header = make_header("proxy_info", "done", common, {}, {file});
  std::size_t n_modes = 0, n_sounding = 0;
  int highest_order = 0;
  double worst = 0.0;
  for (const soundbank::Cell& cell : bank.cells)
    for (const soundbank::CellMode& mode : cell.modes) {
      ++n_modes;
      n_sounding += mode.packed_pa.empty() ? 0 : 1;
      highest_order = std::max(highest_order, mode.order);
      worst = std::max(worst, mode.boundary_error);
    }
  document.n_cells = bank.cells.size();
  document.n_nodes = bank.nodes.size();
  document.max_interpolation_error = bank.max_interpolation_error;
  document.max_interpolation_error_all_modes = bank.max_interpolation_error_all;
  document.n_check_shapes = bank.n_check_shapes;
  document.n_checked_modes = bank.n_checked_modes;
  document.tolerance = bank.tolerance;
  document.thinnest = bank.thinnest;
  document.poissons_ratio = bank.poissons_ratio;
  document.youngs_modulus_pa = bank.material.youngs_modulus_pa();
  document.density_kg_m3 = bank.material.density_kg_m3;
  document.shear_speed_over_sound_speed = bank.speed_ratio();
  document.air_density_kg_m3 = bank.medium.density_kg_m3;
  document.air_sound_speed_m_s = bank.medium.sound_speed_m_s;
  document.modes_per_cell = bank.modes_per_cell;
  document.n_modes = n_modes;
  document.n_modes_with_sound = n_sounding;
  document.highest_order = highest_order;
  document.max_boundary_error = worst;
  document.bytes = std::filesystem::file_size(file);
  document.built_by = {bank.provenance_json};
  write_json(common, json_of(document));
  say(common, "%s: Poisson's ratio %g, axes to 1:%g, %zu cells of %d modes, multipoles to order %d\n", file.c_str(),
      bank.poissons_ratio, 1.0 / bank.thinnest, bank.cells.size(), bank.modes_per_cell, highest_order);
  say(common, "first %d frequencies within %.3g %% at %d unseen shapes (asked %.3g %%)\n", bank.n_checked_modes,
      100.0 * bank.max_interpolation_error, bank.n_check_shapes, 100.0 * bank.tolerance);
  return kDone;
}

}  // namespace

Subcommand add_proxy_info(CLI::App& group, CommonOptions& common) {
  auto file = std::make_shared<std::string>();
  CLI::App* app = group.add_subcommand("info", "What a bank holds, how exact it is");
  app->add_option("bank", *file, "Bank from klang proxy build")->required();
  app->footer("Example:\n  klang proxy info glass.bank --json i.json");
  return {app,
          [file, &common] { return run_proxy_info(*file, common); },
          {result_kind<ProxyInfoDocument>("proxy_info", "the result of `klang proxy info`")}};
}

}  // namespace klang::apps
