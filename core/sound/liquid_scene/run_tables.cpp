#include "core/sound/liquid_scene/run_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/physics/liquid/level_set.hpp"
#include "core/sound/liquid_scene/bubbles_stage.hpp"

namespace klang::liquid_scene {
namespace {

constexpr std::size_t kMostFrames = 200;
constexpr int kDraws = 20000, kBinsPerOctave = 3;

/// The room that solids and the inlets' mouthpieces leave. Frames of other programs have none.
class OpenRoom {
 public:
  explicit OpenRoom(const StageRun& run) : shape_(run.scene.setup.shape) {
    if (!run.document.imported) solids_ = run.scene.setup.all_solids();
    field_ = liquid::solid_field(shape_, solids_);
    if (!run.folder.has("solids.csv")) return;
    CsvFile file(run.folder.file("solids.csv"));
    for (file.next(); file.next();) {
      if (file.cells().size() < 6) throw InputError(file.place(), "is no row of a solid");
      const auto number = [&](std::size_t column) { return csv_number(file.cells()[column], file.place()); };
      const double n = number(1);
      if (!(n >= 1.0 && n <= static_cast<double>(solids_.size())))
        throw InputError(file.place(), "is no solid of the scene", to_text(n));
      places_.push_back({number(0), static_cast<std::size_t>(n) - 1, {number(3), number(4), number(5)}});
    }
  }

  /// At a frame's time, at which a step ends; asked for in rising order.
  const liquid::SolidField& at(double time_s) {
    constexpr double kSameS = 1e-9;
    const std::size_t before = next_;
    for (; next_ < places_.size() && places_[next_].time_s <= time_s + kSameS; ++next_)
      solids_[places_[next_].solid].position_m = places_[next_].position_m;
    if (next_ > before) field_ = liquid::solid_field(shape_, solids_);
    return field_;
  }

 private:
  struct Place {
    double time_s;
    std::size_t solid;
    Eigen::Vector3d position_m;
  };
  liquid::GridShape shape_;
  std::vector<liquid::Solid> solids_;
  std::vector<Place> places_;
  std::size_t next_ = 0;
  liquid::SolidField field_;
};

/// Cells cut by phi's plane and by solids, as volumes are measured.
EnergyRow energy_of(const FrameFields& fields, const liquid::SolidField& room, double time_s,
                    const liquid::LiquidOptions& liquid) {
  const double density = liquid.density_kg_m3, gravity = liquid.gravity_m_s2;
  const liquid::GridShape& s = fields.shape;
  const double h = s.cell_m, cell = h * h * h;
  EnergyRow row;
  row.time_s = time_s;
  if (fields.u) row.kinetic_j = 0.0;
  for (int k = 0; k < s.nz; ++k)
    for (int j = 0; j < s.ny; ++j)
      for (int i = 0; i < s.nx; ++i) {
        const double share = liquid::wet_share(fields.phi_m, room, h, {i, j, k});
        if (!(share > 0.0)) continue;
        row.volume_m3 += share * cell;
        row.potential_j += share * cell * density * gravity * (k + 0.5) * h;
        if (!fields.u) continue;
        const liquid::MacGrid& u = *fields.u;
        const double x = u[0](i, j, k) * u[0](i, j, k) + u[0](i + 1, j, k) * u[0](i + 1, j, k),
                     y = u[1](i, j, k) * u[1](i, j, k) + u[1](i, j + 1, k) * u[1](i, j + 1, k),
                     z = u[2](i, j, k) * u[2](i, j, k) + u[2](i, j, k + 1) * u[2](i, j, k + 1);
        *row.kinetic_j += share * cell * 0.25 * density * (x + y + z);
      }
  return row;
}

std::vector<RadiusRow> radius_rows(const std::vector<double>& asked, const std::vector<double>& made,
                                   const std::vector<double>& recorded) {
  double low = HUGE_VAL, high = 0.0;
  for (const auto* list : {&asked, &made, &recorded})
    for (const double r : *list) {
      low = std::min(low, r);
      high = std::max(high, r);
    }
  const auto bin_of = [](double r) { return static_cast<int>(std::floor(kBinsPerOctave * std::log2(r / 1e-3))); };
  std::vector<RadiusRow> rows;
  for (int bin = bin_of(low); bin <= bin_of(high); ++bin) {
    const auto share = [&](const std::vector<double>& list) {
      return static_cast<double>(std::count_if(list.begin(), list.end(), [&](double r) { return bin_of(r) == bin; })) /
             static_cast<double>(list.size());
    };
    RadiusRow row{1e-3 * std::exp2(static_cast<double>(bin) / kBinsPerOctave),
                  1e-3 * std::exp2(static_cast<double>(bin + 1) / kBinsPerOctave), std::nullopt, std::nullopt,
                  std::nullopt};
    if (!asked.empty()) row.asked = share(asked);
    if (!made.empty()) row.made = share(made);
    if (!recorded.empty()) row.recorded = share(recorded);
    rows.push_back(row);
  }
  return rows;
}

bool is_left_to_itself(const StageRun& run) {
  const liquid::LiquidSetup& setup = run.scene.setup;
  return !run.document.imported && setup.inlets.empty() && setup.outlets.empty() &&
         std::none_of(setup.solids.begin(), setup.solids.end(), [](const liquid::Solid& s) { return s.moves(); });
}

}  // namespace

std::optional<double> energy_gain(const std::vector<EnergyRow>& rows) {
  constexpr std::size_t kQuarters = 4, kLeastRows = 16;
  if (rows.size() < kLeastRows) return std::nullopt;
  std::array<double, kQuarters> kinetic{}, sum{};
  for (std::size_t q = 0; q < kQuarters; ++q) {
    const std::size_t begin = q * rows.size() / kQuarters, end = (q + 1) * rows.size() / kQuarters;
    for (std::size_t i = begin; i < end; ++i) {
      if (!rows[i].kinetic_j) return std::nullopt;
      kinetic[q] += *rows[i].kinetic_j / static_cast<double>(end - begin);
      sum[q] += (*rows[i].kinetic_j + rows[i].potential_j) / static_cast<double>(end - begin);
    }
  }
  const auto least = static_cast<std::size_t>(std::min_element(sum.begin(), sum.end()) - sum.begin());
  if (least + 1 == kQuarters || !(kinetic[least] > 0.0)) return 0.0;
  return std::min(kinetic.back() - kinetic[least], sum.back() - sum[least]) / kinetic[least];
}

void write_run_tables(const StageRun& run) {
  const auto n_frames = static_cast<std::size_t>(std::max<std::int64_t>(run.document.n_frames, 0));
  std::vector<EnergyRow> rows;
  OpenRoom room(run);
  const std::size_t stride = std::max<std::size_t>(1, (n_frames + kMostFrames - 1) / kMostFrames);
  for (std::size_t k = 0; k < n_frames; k += stride) {
    run.monitor.throw_if_stopped();
    const double time_s = run.scene.frame_s(k);
    rows.push_back(
        energy_of(read_fields_file(run.folder.field_file(k)), room.at(time_s), time_s, run.scene.setup.options));
  }
  if (!rows.empty()) write_file(run.folder.file("energy.csv"), csv_table(rows));
  constexpr double kGained = 0.1;
  if (const double gain = energy_gain(rows).value_or(0.0); gain > kGained && is_left_to_itself(run))
    run.warn("the liquid gains energy that nothing gives it, " + std::to_string(std::lround(100.0 * gain)) +
             " % of its motion's (energy.csv): its late motion is not to be trusted");
  if (run.document.n_bubbles == 0 || !run.folder.has("bubbles.trk")) return;
  std::vector<double> made;
  for (const entrainment::BubblePath& path : entrainment::read_tracked_bubbles(run.folder.file("bubbles.trk")).paths)
    made.push_back(path.radius_m);
  const entrainment::RadiusDistribution asked_for = radii_of(run.scene.entrainment);
  std::vector<double> asked;
  RandomStream random(1, 0);
  if (run.scene.entrainment.given)
    for (int draw = 0; draw < kDraws; ++draw) asked.push_back(asked_for.draw(random));
  write_file(run.folder.file("radii.csv"), csv_table(radius_rows(asked, made, asked_for.recorded_m)));
}

}  // namespace klang::liquid_scene
