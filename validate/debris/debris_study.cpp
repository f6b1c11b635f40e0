#include "validate/debris/debris_study.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/surface_point.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/modal/polynomial_modes.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/audio/spectral_distance.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/transfer/radiate.hpp"
#include "core/sound/transfer/transfer_evaluation.hpp"

namespace klang::validate {
namespace {

/// Processor time of this process, all threads [s].
double processor_time_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the time until it goes out of scope.
class StageClock {
 public:
  explicit StageClock(double& sum_s) : sum_s_(sum_s), start_s_(processor_time_s()) {}
  ~StageClock() { sum_s_ += processor_time_s() - start_s_; }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

 private:
  double& sum_s_;
  double start_s_;
};

/// How a piece is struck and heard, in its own frame.
struct Scene {
  events::Strike strike;
  Eigen::Vector3d listener_m;  ///< from the centre of mass
  double onset_s = 0.0;        ///< in the mix
};

/// What rings, a row for each mode by frequency, and how loud: |p_i| at the listener for unit modal velocity.
struct Ringing {
  Eigen::VectorXd omega, decay, pressure_pa;
  stage::ModalPush push;
};

Eigen::Vector3d random_direction(RandomStream& random) {
  const Eigen::Vector3d v(random.normal(), random.normal(), random.normal());
  return v.normalized();
}

Scene random_scene(const mesh::SurfaceMesh& surface, const DebrisStudyOptions& o, std::uint64_t stream) {
  RandomStream random(o.debris.seed, 1000 + stream);
  std::vector<double> upto;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const Eigen::Vector3d a = surface.vertices_m.row(surface.triangles(t, 0)),
                          b = surface.vertices_m.row(surface.triangles(t, 1)),
                          c = surface.vertices_m.row(surface.triangles(t, 2));
    upto.push_back((upto.empty() ? 0.0 : upto.back()) + (b - a).cross(c - a).norm());
  }
  const auto t = static_cast<Eigen::Index>(
      std::upper_bound(upto.begin(), upto.end() - 1, random.uniform() * upto.back()) - upto.begin());
  const Eigen::Vector3d a = surface.vertices_m.row(surface.triangles(t, 0)),
                        b = surface.vertices_m.row(surface.triangles(t, 1)),
                        c = surface.vertices_m.row(surface.triangles(t, 2));
  const double root = std::sqrt(random.uniform()), part = random.uniform();
  Scene scene;
  scene.strike.shape = events::PulseShape::kGaussian;
  scene.strike.duration_s = o.contact_duration_s;
  scene.strike.point_m = (1.0 - root) * a + root * (1.0 - part) * b + root * part * c;
  const Eigen::Vector3d inward = -(b - a).cross(c - a).normalized();
  const double tilt = o.friction_deg * kPi / 180.0 * std::sqrt(random.uniform()), turn = 2.0 * kPi * random.uniform();
  const Eigen::Vector3d e = inward.unitOrthogonal(), f = inward.cross(e);
  scene.strike.impulse_n_s =
      o.impulse_n_s * (std::cos(tilt) * inward + std::sin(tilt) * (std::cos(turn) * e + std::sin(turn) * f));
  scene.listener_m = o.listener_m * random_direction(random);
  scene.onset_s = o.mix_s * random.uniform();
  return scene;
}

/// SB eq. 8. @return Pa
Eigen::VectorXd sound_of(const Ringing& r, const events::Strike& strike, const DebrisStudyOptions& o) {
  stage::ModalVoice voice(0, {r.omega, r.decay, r.pressure_pa.cwiseProduct(r.omega), r.push});
  stage::Voice* const voices[] = {&voice};
  return stage::render(stage::log_of({strike}), voices, stage::Listener::without_place(),
                       {o.sample_rate_hz, o.duration_s})
      .samples;
}

fit::Voice voice_of(const Ringing& r, const events::Strike& strike) {
  const Eigen::VectorXd impulse = r.push(strike.point_m, strike.impulse_n_s);
  fit::Voice voice;
  for (Eigen::Index i = 0; i < r.omega.size(); ++i) {
    const double w = r.omega[i], damped = std::sqrt(std::max(w * w - r.decay[i] * r.decay[i], 0.0));
    const double pulse = std::exp(-0.5 * std::pow(w * strike.duration_s, 2));
    voice.push_back({damped / (2.0 * kPi), r.decay[i], r.pressure_pa[i] * w * impulse[i] * pulse / damped});
  }
  return voice;
}

bool sounds(const Eigen::VectorXd& sound) { return sound.cwiseAbs().maxCoeff() > 0.0; }

/// Edges of the elements: a part of the shortest wave, in bending as a plate of the body's smallest thickness or in
/// shear.
double element_edge_m(const mesh::MassProperties& body, const DebrisStudyOptions& o) {
  const Eigen::Vector3d moments = mesh::principal_moments(body);
  const double thickness = std::sqrt(12.0 * 0.5 * (moments[0] + moments[1] - moments[2]) / body.volume_m3);
  const solid::Material& m = o.material;
  const double omega = 2.0 * kPi * o.highest_hz, nu = m.poissons_ratio();
  const double bending_speed_m2_s =
      thickness * std::sqrt(m.youngs_modulus_pa() / (12.0 * (1.0 - nu * nu) * m.density_kg_m3));  // omega = c k^2
  const double bending = 2.0 * kPi * std::sqrt(bending_speed_m2_s / omega), shear = m.shear_speed_m_s() / o.highest_hz;
  return std::min(bending, shear) / o.elements_per_wavelength;
}

struct PieceSound {
  Ringing ringing;
  Eigen::VectorXd sound_pa;
};

class Study {
 public:
  Study(const soundbank::Soundbank& bank, const DebrisStudyOptions& options, Monitor& monitor)
      : bank_(bank), o_(options), finder_(bank), monitor_(monitor) {}
  DebrisStudyResult run(const std::vector<datasets::DebrisPiece>& pieces);

 private:
  /// What the bank needs once, before the first proxy: the polynomials of its shapes. @return processor time [s]
  double prepare() const;
  PieceSound direct(const datasets::DebrisPiece& piece, const Scene& scene, DebrisPieceResult& result);
  PieceSound proxy(const datasets::DebrisPiece& piece, const Scene& scene, DebrisPieceResult& result);
  void curve(DebrisStudyResult& result, const std::vector<Eigen::VectorXd>& direct,
             const std::vector<Eigen::VectorXd>& by_proxy) const;
  audio::Signal mix(const DebrisStudyResult& result, const std::vector<const Eigen::VectorXd*>& sounds) const;

  const soundbank::Soundbank& bank_;
  const DebrisStudyOptions& o_;
  const soundbank::ProxyFinder finder_;
  Monitor& monitor_;
};

PieceSound Study::direct(const datasets::DebrisPiece& piece, const Scene& scene, DebrisPieceResult& result) {
  PieceSound sound;
  mesh::TetMesh mesh;
  modal::EigenResult modes;
  {
    const StageClock clock(result.direct.mesh_s);
    mesh::TetgenOptions mesher;
    mesher.max_edge_m = element_edge_m(mesh::mass_properties(piece.surface), o_);
    mesh = mesh::mesh_surface(piece.surface, mesher, piece.name);
  }
  result.n_elements = mesh.n_elements();
  monitor_.throw_if_stopped();
  {
    const StageClock clock(result.direct.modes_s);
    modal::EigenOptions eigen;
    eigen.band.high_hz = o_.highest_hz;
    modes = modal::solve_modes(mesh, solid::assemble(mesh), o_.material, {}, eigen, monitor_);
  }
  if (!modes.usable()) throw NumericalError(piece.name + ": " + modes.message);
  monitor_.throw_if_stopped();
  const modal::ModalModel& model = modes.model;
  result.n_modes = static_cast<int>(model.n_modes());
  if (result.n_modes > 0) result.lowest_direct_hz = model.frequency_hz()[0];
  sound.sound_pa = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(std::llround(o_.duration_s * o_.sample_rate_hz)));
  if (result.n_modes == 0) return sound;
  Ringing& ringing = sound.ringing;
  {
    const StageClock clock(result.direct.transfer_s);
    acoustics::RadiateOptions radiate;
    radiate.medium = bank_.medium;
    const acoustics::RadiateResult transfer = acoustics::radiate(model, radiate, monitor_);
    if (!transfer.usable()) throw NumericalError(piece.name + ": " + transfer.message);
    Eigen::MatrixXcd pressure;
    acoustics::TransferEvaluator(transfer.transfer)
        .evaluate(mesh::mass_properties(piece.surface).centre_m + scene.listener_m, pressure);
    ringing.pressure_pa = Eigen::VectorXd::Zero(model.n_modes());
    for (std::size_t i = 0; i < transfer.transfer.modes.size(); ++i)
      ringing.pressure_pa[transfer.transfer.modes[i].mode] = std::abs(pressure(static_cast<Eigen::Index>(i), 0));
  }
  {
    const StageClock clock(result.direct.audio_s);
    ringing.omega = model.angular_frequency_rad_s;
    ringing.decay = o_.damping.decay_per_s(ringing.omega);
    const mesh::SurfacePoint place = mesh::nearest_surface_point(model.mesh, scene.strike.point_m);
    Eigen::VectorXd push = Eigen::VectorXd::Zero(model.n_modes());
    for (std::size_t k = 0; k < place.nodes.size(); ++k)
      push += place.weights[static_cast<Eigen::Index>(k)] * model.shapes.middleRows<3>(3 * place.nodes[k]).transpose() *
              scene.strike.impulse_n_s;
    ringing.push = [push](const Eigen::Vector3d&, const Eigen::Vector3d&) { return push; };
    sound.sound_pa = sound_of(ringing, scene.strike, o_);
  }
  return sound;
}

double Study::prepare() const {
  double spent_s = 0.0;
  {
    const StageClock clock(spent_s);
    const soundbank::EllipsoidModes modes = soundbank::cell_modes(bank_, 0, 1.0);
    if (!modes.shape_at(bank_.cells.front().modes.front().id, Eigen::Vector3d::UnitX()).allFinite())
      throw NumericalError("bank: shapes are not finite");
  }
  return spent_s;
}

PieceSound Study::proxy(const datasets::DebrisPiece& piece, const Scene& scene, DebrisPieceResult& result) {
  PieceSound sound;
  {
    const StageClock clock(result.proxy.lowest_s);
    result.lowest_hz = modal::lowest_frequency_hz(piece.surface, o_.material, {o_.polynomial_degree});
  }
  soundbank::PrincipalFrame frame;
  soundbank::Proxy found;
  mesh::MassProperties body;
  {
    const StageClock clock(result.proxy.retrieval_s);
    body = mesh::mass_properties(piece.surface);
    frame = soundbank::principal_frame(body.inertia_m5);
    found = finder_.find(frame.moments, result.lowest_hz, o_.material.shear_speed_m_s());
  }
  result.axes = found.axes;
  result.scale_m = found.scale;
  result.clamped = found.clamped;
  result.cell_distance = found.cell_distance;
  const soundbank::Cell& cell = bank_.cells[static_cast<std::size_t>(found.cell)];
  // The cell takes the size at which its own lowest mode has the body's frequency, so that kx is the right one; the
  // partials are those of the body's shape, between the cells.
  const double scale = cell.modes.front().angular_frequency_rad_s / (2.0 * kPi * result.lowest_hz);
  Ringing& ringing = sound.ringing;
  std::vector<std::size_t> kept;  // modes of the cell that are heard
  std::vector<double> omega;
  {
    const StageClock clock(result.proxy.transfer_s);
    const soundbank::ClassFrequencies unitless = soundbank::interpolated_frequencies(bank_, found.place);
    const auto omega_of = [&](std::size_t i) {
      const soundbank::ModeId id = cell.modes[i].id;
      return unitless[static_cast<std::size_t>(id.mode_class)][id.index] * o_.material.shear_speed_m_s() / found.scale;
    };
    for (std::size_t i = 0; i < cell.modes.size(); ++i)
      if (omega_of(i) <= 2.0 * kPi * o_.highest_hz) kept.push_back(i);
    // Between the cell's shape and the body's, classes cross.
    std::stable_sort(kept.begin(), kept.end(), [&](std::size_t i, std::size_t j) { return omega_of(i) < omega_of(j); });
    for (const std::size_t i : kept) omega.push_back(omega_of(i));
    acoustics::TransferModel transfer = soundbank::cell_transfer(bank_, found.cell, scale);
    std::vector<Eigen::Index> row(cell.modes.size(), -1);
    std::vector<acoustics::ModeTransfer> radiating;
    for (std::size_t k = 0; k < kept.size(); ++k) row[kept[k]] = static_cast<Eigen::Index>(k);
    for (acoustics::ModeTransfer& mode : transfer.modes)
      if (row[static_cast<std::size_t>(mode.mode)] >= 0) radiating.push_back(std::move(mode));
    transfer.modes = std::move(radiating);
    ringing.pressure_pa = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(kept.size()));
    Eigen::MatrixXcd pressure;
    acoustics::TransferEvaluator(transfer).evaluate(frame.rotation * scene.listener_m, pressure);
    for (std::size_t i = 0; i < transfer.modes.size(); ++i)
      ringing.pressure_pa[row[static_cast<std::size_t>(transfer.modes[i].mode)]] =
          std::abs(pressure(static_cast<Eigen::Index>(i), 0));
  }
  {
    const StageClock clock(result.proxy.audio_s);
    ringing.omega = Eigen::Map<const Eigen::VectorXd>(omega.data(), static_cast<Eigen::Index>(omega.size()));
    ringing.decay = o_.damping.decay_per_s(ringing.omega);
    const soundbank::EllipsoidModes modes = soundbank::cell_modes(bank_, found.cell, scale);
    const Eigen::Vector3d force = frame.rotation * scene.strike.impulse_n_s;
    const Eigen::Vector3d contact =
        o_.contact == ProxyContact::kNormal
            ? soundbank::point_of_normal(modes.axes_m(), -force)
            : soundbank::point_of_place(modes.axes_m(), frame.rotation * (scene.strike.point_m - body.centre_m),
                                        frame.moments, body.volume_m3);
    const Eigen::Vector3d xi = contact.cwiseQuotient(modes.axes_m());
    Eigen::VectorXd push(static_cast<Eigen::Index>(kept.size()));
    for (std::size_t k = 0; k < kept.size(); ++k)
      push[static_cast<Eigen::Index>(k)] = modes.shape_at(cell.modes[kept[k]].id, xi).col(0).dot(force);
    ringing.push = [push](const Eigen::Vector3d&, const Eigen::Vector3d&) { return push; };
    sound.sound_pa = sound_of(ringing, scene.strike, o_);
  }
  result.n_proxy_modes = static_cast<int>(kept.size());
  result.bank_too_short = kept.size() == cell.modes.size();
  return sound;
}

audio::Signal Study::mix(const DebrisStudyResult& result, const std::vector<const Eigen::VectorXd*>& sounds) const {
  audio::Signal signal;
  signal.sample_rate_hz = o_.sample_rate_hz;
  signal.samples = decltype(signal.samples)::Zero(
      static_cast<Eigen::Index>(std::ceil((o_.mix_s + o_.duration_s) * o_.sample_rate_hz)) + 1, 1);
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    const auto first = static_cast<Eigen::Index>(std::llround(result.pieces[i].onset_s * o_.sample_rate_hz));
    signal.samples.block(first, 0, sounds[i]->size(), 1) += *sounds[i];
  }
  return signal;
}

void Study::curve(DebrisStudyResult& result, const std::vector<Eigen::VectorXd>& direct,
                  const std::vector<Eigen::VectorXd>& by_proxy) const {
  // A threshold at the frequency of each piece replaces those above it; thinned evenly, both ends kept.
  std::vector<double> steps{0.0};
  double all_modes = 0.0;
  for (const DebrisPieceResult& piece : result.pieces) {
    steps.push_back(piece.lowest_hz);
    all_modes += piece.n_modes;
    result.direct_s += piece.direct.total_s();
    result.proxy_s += piece.proxy.total_s();
    result.proxy_without_lowest_s += piece.proxy.total_s() - piece.proxy.lowest_s;
  }
  result.proxy_s += result.preparation_s;
  result.proxy_without_lowest_s += result.preparation_s;
  std::sort(steps.begin(), steps.end());
  const std::size_t n = std::min<std::size_t>(static_cast<std::size_t>(o_.n_thresholds), steps.size());
  std::vector<const Eigen::VectorXd*> chosen;
  for (const Eigen::VectorXd& sound : direct) chosen.push_back(&sound);
  result.direct_mix = mix(result, chosen);
  for (std::size_t k = 0; k < n; ++k) {
    DebrisThreshold row;
    row.threshold_hz = steps[n == 1 ? 0 : (k * (steps.size() - 1) + (n - 1) / 2) / (n - 1)];
    row.direct_s = result.direct_s;
    for (std::size_t i = 0; i < result.pieces.size(); ++i) {
      const DebrisPieceResult& piece = result.pieces[i];
      const bool replaced = piece.lowest_hz > row.threshold_hz;
      chosen[i] = replaced ? &by_proxy[i] : &direct[i];
      row.with_proxies_s += replaced ? piece.proxy.total_s() : piece.direct.total_s() + piece.proxy.lowest_s;
      row.n_replaced += replaced ? 1 : 0;
      if (replaced && row.n_replaced == 1) row.with_proxies_s += result.preparation_s;
      if (replaced && all_modes > 0.0) row.modes_replaced_percent += 100.0 * piece.n_modes / all_modes;
    }
    const audio::Signal mixed = mix(result, chosen);
    if (k == 0) result.proxy_mix = mixed;
    const audio::SpectralDistance distance = audio::spectral_distance(result.direct_mix, mixed);
    row.log_spectral_distance_db = distance.log_spectral_db;
    row.mel_distance_db = distance.mel_db;
    row.third_octave_db = distance.third_octave_db;
    row.loudness_difference_db = distance.loudness_difference_db;
    result.thresholds.push_back(row);
  }
}

DebrisStudyResult Study::run(const std::vector<datasets::DebrisPiece>& pieces) {
  if (pieces.empty()) throw InputError("debris", "no pieces");
  DebrisStudyResult result;
  result.preparation_s = prepare();
  std::vector<Eigen::VectorXd> direct_sounds, proxy_sounds;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    monitor_.progress("debris", static_cast<double>(i) / static_cast<double>(pieces.size()));
    monitor_.throw_if_stopped();
    const datasets::DebrisPiece& piece = pieces[i];
    const double radius =
        (piece.surface.vertices_m.rowwise() - mesh::mass_properties(piece.surface).centre_m.transpose())
            .rowwise()
            .norm()
            .maxCoeff();
    if (!(o_.listener_m > 2.0 * radius))
      throw InputError("debris study", "listener_m", to_text(o_.listener_m),
                       "more than " + to_text(2.0 * radius) + ", twice the radius of " + piece.name);
    const Scene scene = random_scene(piece.surface, o_, i);
    DebrisPieceResult row;
    row.name = piece.name;
    row.volume_m3 = piece.volume_m3;
    row.onset_s = scene.onset_s;
    PieceSound by_proxy;
    for (int k = 0; k < o_.proxy_repeats; ++k) by_proxy = proxy(piece, scene, row);
    for (double* stage : {&row.proxy.lowest_s, &row.proxy.retrieval_s, &row.proxy.transfer_s, &row.proxy.audio_s})
      *stage /= o_.proxy_repeats;
    PieceSound directly = direct(piece, scene, row);
    if (sounds(directly.sound_pa) && by_proxy.sound_pa.size() > 0 && sounds(by_proxy.sound_pa))
      row.errors =
          fit::TargetSound(voice_of(directly.ringing, scene.strike), o_.n_partials, o_.duration_s, o_.sample_rate_hz)
              .errors(voice_of(by_proxy.ringing, scene.strike));
    direct_sounds.push_back(std::move(directly.sound_pa));
    proxy_sounds.push_back(std::move(by_proxy.sound_pa));
    result.pieces.push_back(std::move(row));
  }
  if (std::none_of(direct_sounds.begin(), direct_sounds.end(), sounds))
    throw InputError("debris", "no piece has a mode up to highest_hz", to_text(o_.highest_hz));
  curve(result, direct_sounds, proxy_sounds);
  result.status = DebrisStudyStatus::kDone;
  monitor_.progress("debris", 1.0);
  return result;
}

}  // namespace

void DebrisStudyOptions::validate() const {
  solid::validate(material);
  std::vector<Violation> violations = violations_of(*this);
  if (highest_hz > audio::highest_compared_hz(sample_rate_hz))
    violations.push_back(
        out_of_range("highest_hz", highest_hz, between(1000.0, audio::highest_compared_hz(sample_rate_hz))));
  if (damping.mass_per_s == 0.0 && damping.stiffness_s == 0.0)
    violations.push_back({"rayleigh_mass_per_s", "and rayleigh_stiffness_s must not both be 0", ""});
  throw_violations("debris study", std::move(violations));
  debris.validate();
}

DebrisStudyResult debris_study(const soundbank::Soundbank& bank, const DebrisStudyOptions& options, Monitor& monitor) {
  return debris_study(bank, datasets::debris(options.debris), options, monitor);
}

DebrisStudyResult debris_study(const soundbank::Soundbank& bank, const std::vector<datasets::DebrisPiece>& pieces,
                               const DebrisStudyOptions& options, Monitor& monitor) {
  options.validate();
  soundbank::check_poissons_ratio(bank, options.material.poissons_ratio(), "debris");
  const bool with_sound = std::any_of(bank.cells.begin(), bank.cells.end(), [](const soundbank::Cell& cell) {
    return std::any_of(cell.modes.begin(), cell.modes.end(),
                       [](const soundbank::CellMode& mode) { return !mode.packed_pa.empty(); });
  });
  if (!with_sound)
    throw InputError("bank", "has frequencies only, no sound", {}, "one that was built without --no-radiation");
  // The bank's sound holds for its own wave speed and density.
  const auto same = [](const char* name, double asked, double banks) {
    if (!(std::abs(asked / banks - 1.0) <= 0.02))
      throw InputError("debris", "the bank is of another material", std::string(name) + " " + to_text(asked),
                       to_text(banks) + " to 2 %");
  };
  same("shear speed [m/s]", options.material.shear_speed_m_s(), bank.material.shear_speed_m_s());
  same("density [kg/m^3]", options.material.density_kg_m3, bank.material.density_kg_m3);
  return Study(bank, options, monitor).run(pieces);
}

}  // namespace klang::validate
