#include "core/sound/scene/scene_proxies.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/modal/polynomial_modes.hpp"
#include "core/sound/scene/detail/held_nodes.hpp"
#include "core/sound/scene/scene_frames.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "core/sound/waves/multipole_transforms.hpp"

namespace klang::scene {
namespace {

using Eigen::Vector3d;

constexpr double kSameSpeedRatio = 0.01;
constexpr double kSurelyAbove = 1.05;  // polynomials say a lowest frequency some percent too high
constexpr double kSameSize = 2.0;      // an ellipsoid so much larger than its body has eight times its mass

/// Root of the sum of squares of the semi-axes of the ellipsoid with this inertia and volume.
double size_m(const mesh::MassProperties& mass) { return std::sqrt(2.5 * mass.inertia_m5.trace() / mass.volume_m3); }

double lowest_hz(const Scene& scene, const SceneProxies::Body& body, Monitor& monitor) {
  const solid::Material& material = scene.material_of(*body.of).elastic;
  const modal::ModesBody what{body.surface ? std::optional<mesh::ShapeSpec>() : body.of->shape, {}, 2};
  const bool convex = body.of->shape && mesh::convex_parts(*body.of->shape).size() <= 1;
  if (convex && !modal::harmonics_apply(what) && !modal::polynomials_apply(what)) {
    // Flat triangles hold less than the body that they stand for.
    const mesh::SurfaceMesh flat = straight_surface(body.surface ? *body.surface : mesh::boundary_surface(body.mesh));
    const double share = mesh::mass_properties(flat).volume_m3 / mesh::mass_properties(body.mesh).volume_m3;
    return std::cbrt(share) * modal::lowest_frequency_hz(flat, material, {8});
  }
  modal::ModesOptions options;
  options.eigen.count = 1;
  options.eigen.band = {0.0, HUGE_VAL};
  options.eigen.prove_none_missing = false;
  const modal::EigenResult modes = modal::modes_of(what, body.mesh, material, options, monitor);
  if (!modes.usable() || modes.model.n_modes() == 0)
    throw NumericalError("lowest mode of " + body.name + ": " + modes.message);
  return modes.model.frequency_hz()[0];
}

}  // namespace

struct SceneProxies::Bank {
  explicit Bank(const std::filesystem::path& path) : bank(soundbank::read_soundbank(path)), finder(bank) {}
  soundbank::Soundbank bank;
  soundbank::ProxyFinder finder;
};

SceneProxies::SceneProxies(const Scene& scene) : scene_(scene) {
  if (scene.sound.bank.empty()) return;
  soundbank::Soundbank read = soundbank::read_soundbank(scene.sound.bank);
  bool sounds = false;
  for (const soundbank::Cell& cell : read.cells)
    for (const soundbank::CellMode& mode : cell.modes) sounds |= mode.radiated_power_w > 0.0;
  if (!sounds) throw InputError("sound.bank", "has no sound", scene.sound.bank.string(), "a bank built with radiation");
  for (const SceneBody& body : scene.bodies)
    if (may_stand_for(body))
      soundbank::check_poissons_ratio(read, scene.material_of(body).elastic.poissons_ratio(),
                                      body.place + ": body " + body.name + ", " + scene.sound.bank.string());
  bank_ = std::make_unique<const Bank>(scene.sound.bank);
}
SceneProxies::~SceneProxies() = default;

bool SceneProxies::may_stand_for(const SceneBody& body) const {
  return body.sounds() && (body.sound == BodySound::kProxy ||
                           (body.sound == BodySound::kAuto && scene_.sound.proxy_above_hz.has_value() &&
                            detail::kept_by(scene_, body) != detail::KeptBy::kStillPlaces));
}

std::optional<SoundModel> SceneProxies::stand_in(const Body& body, const SceneNotes& notes, Monitor& monitor) const {
  if (!bank_ || !may_stand_for(*body.of)) return {};
  const double lowest = located(body.of->place, [&] { return lowest_hz(scene_, body, monitor); });
  if (body.of->sound != BodySound::kProxy && !(lowest > *scene_.sound.proxy_above_hz)) return {};
  if (body.surface && lowest > kSurelyAbove * scene_.sound.high_hz) {
    SoundModel silent;
    silent.proxy = true;
    return silent;
  }
  const soundbank::Soundbank& bank = bank_->bank;
  const solid::Material& material = scene_.material_of(*body.of).elastic;
  const mesh::MassProperties mass = mesh::mass_properties(body.mesh);
  const soundbank::PrincipalFrame frame = soundbank::principal_frame(mass.inertia_m5);
  const double speed_m_s = material.shear_speed_m_s();
  const soundbank::Proxy proxy = bank_->finder.find(frame.moments, lowest, speed_m_s);
  const double speed_ratio = speed_m_s / bank.material.shear_speed_m_s();
  const double ratio = proxy.scale / size_m(mass);
  if (!(ratio <= kSameSize && ratio >= 1.0 / kSameSize)) {
    if (notes.warning)
      notes.warning("body " + body.name + ": the ellipsoid with its lowest frequency would be " +
                    to_text(std::round(10.0 * ratio) / 10.0) +
                    " times its size (it is thin or hollow): " + "its own modes are heard");
    return {};
  }
  if (notes.warning && !(std::abs(speed_ratio - 1.0) <= kSameSpeedRatio) &&
      warned_speed_.insert(body.of->material).second)
    notes.warning("bodies of " + scene_.material_of(*body.of).name +
                  ": the bank's radiation is that of a shear speed " + to_text(1.0 / speed_ratio) +
                  " times theirs; their level is approximate");
  if (notes.note && proxy.clamped)
    notes.note("body " + body.name + ": thinner than the bank's thinnest shape, which is taken");

  // The body's nodes on the unit ball of the proxy.
  const Eigen::Index n_nodes = body.mesh.nodes_m.rows();
  Eigen::Matrix3Xd xi(3, n_nodes);
  for (Eigen::Index i = 0; i < n_nodes; ++i) {
    const Vector3d r = frame.rotation * (body.mesh.nodes_m.row(i).transpose() - mass.centre_m);
    xi.col(i) = soundbank::point_of_place(Vector3d::Ones(), r, frame.moments, mass.volume_m3);
  }
  const soundbank::Cell& cell = bank.cells[static_cast<std::size_t>(proxy.cell)];
  const soundbank::EllipsoidModes shapes = soundbank::cell_modes(bank, proxy.cell, proxy.scale);
  const soundbank::ClassFrequencies frequencies = soundbank::interpolated_frequencies(bank, proxy.place);
  const double by_density = std::sqrt(bank.material.density_kg_m3 / material.density_kg_m3);
  struct Heard {
    double omega;
    std::size_t cell_mode;
  };
  std::vector<Heard> heard;
  for (std::size_t i = 0; i < cell.modes.size(); ++i) {
    const soundbank::ModeId id = cell.modes[i].id;
    if (id.index >= frequencies[id.mode_class].size()) continue;
    const double omega = frequencies[id.mode_class][id.index] * speed_m_s / proxy.scale;
    if (omega >= 2.0 * kPi * scene_.sound.low_hz && omega <= 2.0 * kPi * scene_.sound.high_hz)
      heard.push_back({omega, i});
  }
  std::stable_sort(heard.begin(), heard.end(), [](const Heard& a, const Heard& b) { return a.omega < b.omega; });
  if (heard.empty() && notes.warning)
    notes.warning("body " + body.name + ": its ellipsoid has no mode of the bank in the band that is heard" +
                  (body.of->sound == BodySound::kProxy ? "; its own modes are heard" : ""));
  if (heard.empty()) return {};
  const double highest = heard.back().omega / (2.0 * kPi);
  if (notes.warning && heard.back().cell_mode + 1 == cell.modes.size() && highest < 0.9 * scene_.sound.high_hz)
    notes.warning("body " + body.name + ": the bank's modes end at " + to_text(std::round(highest)) + " Hz of the " +
                  to_text(scene_.sound.high_hz) +
                  " Hz that are heard: a bank of more modes (klang proxy build --modes)");

  SoundModel model;
  model.proxy = true;
  model.modes.mesh = body.mesh;
  model.modes.material = material;
  model.modes.angular_frequency_rad_s.resize(static_cast<Eigen::Index>(heard.size()));
  model.modes.shapes.resize(3 * n_nodes, static_cast<Eigen::Index>(heard.size()));
  const acoustics::TransferModel transfer = soundbank::cell_transfer(bank, proxy.cell, 1.0);
  model.transfer.medium = transfer.medium;
  for (std::size_t k = 0; k < heard.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const auto& [omega, number] = heard[k];
    model.modes.angular_frequency_rad_s[column] = omega;
    const Eigen::Matrix3Xd shape = by_density * frame.rotation.transpose() * shapes.shape_at(cell.modes[number].id, xi);
    model.modes.shapes.col(column) = shape.reshaped();
    for (const acoustics::ModeTransfer& mode : transfer.modes) {
      if (mode.mode != static_cast<int>(number)) continue;
      // The size at which the cell's mode has this frequency; the displacements stay those of the proxy's size.
      const double size = cell.modes[number].angular_frequency_rad_s / omega;
      const double level = by_density * std::pow(size / proxy.scale, 1.5);
      acoustics::ModeTransfer turned = acoustics::with_size_factor(mode, size);
      turned.mode = static_cast<int>(k);
      turned.frequency_hz = omega / (2.0 * kPi);
      turned.multipole = acoustics::rotated(turned.multipole, frame.rotation.transpose());
      turned.multipole.centre_m = mass.centre_m;
      turned.multipole.coefficients_pa *= level;
      turned.radiated_power_w *= level * level;
      turned.decay_radiation_per_s *= level * level;
      model.transfer.modes.push_back(std::move(turned));
    }
  }
  return model;
}

}  // namespace klang::scene
