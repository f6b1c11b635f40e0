#include "core/sound/scene/scene_breaking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/physics/fracture/quasistatic/load_request.hpp"
#include "core/sound/scene/detail/breakable.hpp"

namespace klang::scene {
namespace {

using detail::Breakable;
using detail::UnmeshedPiece;
using Eigen::Vector3d;

constexpr double kAuthorsPerS = 1800.0;
constexpr double kRoundOff = 1e-14;

/// Whether a contact strains its bodies: not a place that does not approach and that others press on.
bool presses(const rigid::ContactImpulse& contact) {
  return contact.duration_s > 0.0 && (contact.kind != events::ImpulseKind::kImpact || contact.approach_m_s > 0.0);
}

/// How fast a body moves.
struct Speed {
  Vector3d velocity_m_s, spin_rad_s;
};

double pair_restitution(const rigid::RigidWorld& world, const Scene& scene, const rigid::ContactImpulse& contact) {
  const rigid::Skin& a = world.spec(contact.a).skin;
  return rigid::pair_restitution(a, contact.b >= 0 ? world.spec(contact.b).skin : *scene.solver.floor);
}

double kinetic_j(const rigid::RigidWorld& world, int body, const Speed& speed) {
  const rigid::RigidBodySpec& spec = world.spec(body);
  const Eigen::Matrix3d turn = world.pose(body).orientation().toRotationMatrix();
  const Vector3d own = turn.transpose() * speed.spin_rad_s;
  return 0.5 * (spec.mass_kg * speed.velocity_m_s.squaredNorm() + own.dot(spec.inertia_kg_m2 * own));
}

struct KeptStrain {
  double energy_j = 0.0;
  int n_unknown = 0;  ///< loaded pieces whose stress was not found
};

/// Strain that pieces keep under the forces that still act on them (erratum 51), each as a free body that its load accelerates.
KeptStrain kept_strain(const std::vector<fracture::FragmentBody>& pieces,
                       const std::vector<fracture::PointForce>& forces, const solid::Material& material) {
  std::vector<std::vector<fracture::PointForce>> on_piece(pieces.size());
  for (const fracture::PointForce& force : forces) {
    std::size_t nearest = 0;
    double distance_m = HUGE_VAL;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double d =
          (pieces[i].mesh.nodes_m.rowwise() - force.place_m.transpose()).rowwise().squaredNorm().minCoeff();
      if (!(d < distance_m)) continue;
      distance_m = d;
      nearest = i;
    }
    on_piece[nearest].push_back(force);
  }
  KeptStrain kept;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (on_piece[i].empty()) continue;
    fracture::FreeBodySolver solver(mesh::to_quadratic(pieces[i].mesh), material);
    if (!solver.usable()) {
      ++kept.n_unknown;
      continue;
    }
    fracture::ContactResponses responses(solver);
    try {
      kept.energy_j += responses.strain_energy_j(fracture::SurfacePlaces(solver.mesh()).at_nodes(on_piece[i]));
    } catch (const InputError&) {  // the nearest node is not near: the contact was on what a cut took away
      ++kept.n_unknown;
    }
  }
  return kept;
}

/// What acts at the moment of a request, as far as the energy allows.
std::vector<fracture::PointForce> allowed_forces(const fracture::LoadRequest& request, double scale) {
  std::vector<fracture::PointForce> forces = request.lasting;
  for (fracture::PointForce force : request.impacts) {
    force.force_n *= scale;
    forces.push_back(force);
  }
  return forces;
}

}  // namespace

struct Breaking::State {
  State(const Scene& s, std::uint64_t random_seed) : scene(s), seed(random_seed) {}
  const Scene& scene;
  std::uint64_t seed;
  std::map<int, std::unique_ptr<Breakable>> bodies;
  std::map<int, UnmeshedPiece> unmeshed;  ///< pieces that nothing has struck yet, by their number
  std::vector<BreakEvent> events;
  std::vector<ScenePiece> pieces;
  std::vector<std::string> warnings;
  std::set<int> unasked;  ///< pieces of which a warning says so
  /// Of bodies of the scene, by their number, whose stress reached their strength and which have not broken: the largest, and when.
  std::map<int, std::pair<double, double>> withstood;
  double contact_before_j = 0.0, claimed_j = 0.0;  ///< before this step; what breakages of this step got back
  std::int64_t n_solves = 0;
  /// Impulses of this step's contacts, by their number, before a breakage took back their rebounds: the body on the other side is
  /// asked for its stress by what struck it.
  std::map<std::size_t, Vector3d> with_rebound;
  /// Of contacts between two bodies that may break, by their number: the first body's share of the compression.
  std::map<std::size_t, double> share_of_a;

  void mesh_struck(const rigid::StepRecord& step);
  double strain_energy_j(const rigid::RigidWorld& world, const rigid::ContactImpulse& contact, int body);
  bool is_harmless(int body, double energy_j) const;
  void share_compression(const rigid::RigidWorld& world, const rigid::StepRecord& step);
  fracture::ContactLoad load_on(const rigid::RigidWorld& world, const rigid::ContactImpulse& contact, int body,
                                const Vector3d& impulse_n_s) const;
  std::vector<fracture::ContactLoad> loads_on(const rigid::RigidWorld& world, const rigid::StepRecord& step, int body,
                                              bool shared = true) const;
  fracture::ContactLoad as_modelled(fracture::ContactLoad load) const;
  std::map<int, Speed> without_rebound(const rigid::RigidWorld& world, const rigid::StepRecord& step, int body) const;
  std::optional<fracture::FractureResult> broken_by(int body, const fracture::LoadRequest& request, double budget_j);
  void cannot_ask(int body, const std::exception& error);
  bool breaks(rigid::RigidWorld& world, rigid::StepRecord& step, int body, rigid::Breakage& breakage);
  void take_back_rebound(rigid::RigidWorld& world, rigid::StepRecord& step, int body,
                         const std::map<int, Speed>& speeds);
  rigid::Breakage replace(rigid::RigidWorld& world, int body, fracture::FractureResult& result, double available_j,
                          double time_s);
};

std::vector<fracture::ContactLoad> Breaking::State::loads_on(const rigid::RigidWorld& world,
                                                             const rigid::StepRecord& step, int body,
                                                             bool shared) const {
  std::vector<fracture::ContactLoad> loads;
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    const rigid::ContactImpulse& contact = step.contacts[i];
    if ((contact.a != body && contact.b != body) || !presses(contact)) continue;
    const auto whole = with_rebound.find(i);
    const Vector3d& impulse_n_s = whole == with_rebound.end() ? contact.impulse_n_s : whole->second;
    loads.push_back(load_on(world, contact, body, impulse_n_s));
    const auto share = share_of_a.find(i);
    if (shared && share != share_of_a.end())
      loads.back().compression_energy_j *= contact.a == body ? share->second : 1.0 - share->second;
  }
  return loads;
}

fracture::ContactLoad Breaking::State::load_on(const rigid::RigidWorld& world, const rigid::ContactImpulse& contact,
                                               int body, const Vector3d& impulse_n_s) const {
  // As the body lay when it was touched: at the step's end it has turned on, by what depends on the step.
  const Eigen::Quaterniond turn = contact.a == body ? contact.turn_a : contact.turn_b;
  const double sign = contact.a == body ? 1.0 : -1.0;
  events::Impulse impulse = rigid::impulse_on(contact, body, world.pose(body));
  impulse.impulse_n_s = turn.conjugate() * (sign * impulse_n_s);
  return fracture::contact_load(impulse, turn.conjugate() * (sign * contact.normal), contact.approach_m_s,
                                pair_restitution(world, scene, contact));
}

/// With no more energy than that the body cannot break, whatever the load.
bool Breaking::State::is_harmless(int body, double energy_j) const {
  return scene.skip_harmless_loads && energy_j < bodies.at(body)->least_energy_j();
}

/// Of the body under this contact's largest force alone; 0 where a piece cannot be asked.
double Breaking::State::strain_energy_j(const rigid::RigidWorld& world, const rigid::ContactImpulse& contact,
                                        int body) {
  Breakable& breakable = *bodies.at(body);
  try {
    const fracture::ContactLoad load = load_on(world, contact, body, contact.impulse_n_s);
    const std::int64_t solved = breakable.responses().n_nodes_solved();
    const double energy_j = breakable.responses().strain_energy_j(
        breakable.surface().at_nodes({{load.place_m, fracture::force_n(load, load.time_s + 0.5 * load.duration_s)}}));
    n_solves += breakable.responses().n_nodes_solved() - solved;
    return energy_j;
  } catch (const InputError& error) {
    cannot_ask(body, error);
  } catch (const NumericalError& error) {
    cannot_ask(body, error);
  }
  return 0.0;
}

/// One force strains both bodies of a contact, each as it yields: before any breaks, so that their order does not matter.
void Breaking::State::share_compression(const rigid::RigidWorld& world, const rigid::StepRecord& step) {
  share_of_a.clear();
  std::map<int, double> whole_j;
  const auto is_safe = [&](int body) {
    if (scene.force_model != ForceModel::kHertz) return false;
    const auto [entry, is_new] = whole_j.try_emplace(body, 0.0);
    if (is_new)
      for (const fracture::ContactLoad& load : loads_on(world, step, body, false))
        entry->second += load.compression_energy_j;
    return is_harmless(body, entry->second);
  };
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    const rigid::ContactImpulse& contact = step.contacts[i];
    if (contact.kind != events::ImpulseKind::kImpact || !presses(contact)) continue;
    if (bodies.count(contact.a) == 0 || bodies.count(contact.b) == 0) continue;
    if (is_safe(contact.a) && is_safe(contact.b)) continue;  // neither is asked how much of it is its own
    const double a_j = strain_energy_j(world, contact, contact.a),
                 both_j = a_j + strain_energy_j(world, contact, contact.b);
    share_of_a[i] = both_j > 0.0 ? a_j / both_j : 0.5;
  }
}

/// Speeds of the body, of those that struck it and of what is tied to them, had the impacts ended at the largest compression.
std::map<int, Speed> Breaking::State::without_rebound(const rigid::RigidWorld& world, const rigid::StepRecord& step,
                                                      int body) const {
  std::map<int, Speed> speeds;
  const auto push = [&](int number, const Vector3d& place_m, const Vector3d& impulse_n_s) {
    if (number < 0 || world.spec(number).fixed) return;
    Speed& speed = speeds.try_emplace(number, Speed{world.velocity_m_s(number), world.angular_velocity_rad_s(number)})
                       .first->second;
    const Eigen::Matrix3d turn = world.pose(number).orientation().toRotationMatrix();
    speed.velocity_m_s += impulse_n_s / world.spec(number).mass_kg;
    speed.spin_rad_s += turn * world.spec(number).inertia_kg_m2.inverse() * turn.transpose() *
                        (place_m - world.centre_m(number)).cross(impulse_n_s);
  };
  std::vector<rigid::RigidWorld::Push> given;  // back by the rebounds
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    const rigid::ContactImpulse& contact = step.contacts[i];
    if (contact.kind != events::ImpulseKind::kImpact || (contact.a != body && contact.b != body) ||
        with_rebound.count(i) != 0)  // taken back already
      continue;
    const double e = pair_restitution(world, scene, contact);
    given.push_back({contact.a, contact.b, contact.place_m, contact.place_m, e / (1.0 + e) * contact.impulse_n_s});
  }
  for (const rigid::RigidWorld::Push& by_tie : world.answer_of_ties(given)) given.push_back(by_tie);
  for (const rigid::RigidWorld::Push& back : given)
    push(back.a, back.at_a_m, -back.impulse_n_s), push(back.b, back.at_b_m, back.impulse_n_s);
  return speeds;
}

void Breaking::State::take_back_rebound(rigid::RigidWorld& world, rigid::StepRecord& step, int body,
                                        const std::map<int, Speed>& speeds) {
  for (const auto& [number, speed] : speeds) {
    const double before_j = world.ledger().work_j;
    world.set_velocity(number, speed.velocity_m_s, speed.spin_rad_s);
    world.book(&rigid::EnergyLedger::contact_j, before_j - world.ledger().work_j);
  }
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    rigid::ContactImpulse& contact = step.contacts[i];
    if (contact.kind != events::ImpulseKind::kImpact || (contact.a != body && contact.b != body)) continue;
    if (!with_rebound.emplace(i, contact.impulse_n_s).second) continue;
    contact.impulse_n_s /= 1.0 + pair_restitution(world, scene, contact);
  }
}

/// @param time_s       when it broke: the peak of its load
/// @param available_j  what contacts took; a force model that strains the body more puts the rest in from outside
rigid::Breakage Breaking::State::replace(rigid::RigidWorld& world, int body, fracture::FractureResult& result,
                                         double available_j, double time_s) {
  const rigid::RigidBodySpec parent = world.spec(body);
  const int root = bodies.at(body)->root(), generation = bodies.at(body)->generation() + 1;
  const events::Pose pose = world.pose(body);
  const Eigen::Quaterniond turn = pose.orientation();
  const Vector3d velocity = world.velocity_m_s(body), spin = world.angular_velocity_rad_s(body);
  rigid::Breakage breakage;
  breakage.body = body;
  breakage.time_s = time_s;
  world.remove(body);
  withstood.erase(body);
  for (std::size_t i = 0; i < result.pieces.size(); ++i) {
    fracture::FragmentBody& piece = result.pieces[i];
    rigid::RigidBodySpec spec;
    spec.name = parent.name + "/" + std::to_string(i + 1);
    spec.mass_kg = piece.mass_kg;
    spec.centre_m = piece.centre_m;
    spec.inertia_kg_m2 = piece.inertia_kg_m2;
    spec.parts = piece.parts;
    spec.skin = parent.skin;
    spec.position_m = pose.position_m;
    spec.orientation = turn;
    spec.velocity_m_s = velocity + spin.cross(turn * (piece.centre_m - parent.centre_m));
    spec.angular_velocity_rad_s = spin;
    if (i < result.push.velocity_m_s.size()) {
      spec.velocity_m_s += turn * result.push.velocity_m_s[i];
      spec.angular_velocity_rad_s += turn * result.push.angular_velocity_rad_s[i];
    }
    breakage.pieces.push_back(world.add(spec));
    const double edge_m = 0.25 * std::cbrt(piece.volume_m3);
    pieces.push_back({breakage.pieces.back(), body, fracture::fragment_surface(piece, edge_m), {}});
    // Two cells need more room than their least distance.
    if (generation < scene.fracture.generations && spec.size_m() > scene.fracture.smallest_piece_m)
      unmeshed[breakage.pieces.back()] = {pieces.size() - 1, piece.parts, spec.name, piece.mass_kg, root, generation};
  }
  for (const fracture::CrackImpulse& crack : result.push.impulses) {
    for (const bool first : {true, false}) {
      events::Impulse row;
      row.time_s = time_s;
      row.duration_s = result.crack_duration_s;
      row.kind = events::ImpulseKind::kFracture;
      row.body = breakage.pieces[static_cast<std::size_t>(first ? crack.a : crack.b)];
      row.other = breakage.pieces[static_cast<std::size_t>(first ? crack.b : crack.a)];
      row.point_m = crack.centre_m;
      row.impulse_n_s = first ? crack.on_a_n_s : crack.on_b_n_s;
      breakage.impulses.push_back(row);
    }
  }
  const fracture::FractureEnergies& energies = result.energies;
  const double claim_j = std::min(energies.strain_j, available_j);
  claimed_j += claim_j;
  world.book(&rigid::EnergyLedger::contact_j, -claim_j);
  world.book(&rigid::EnergyLedger::fracture_j, energies.fracture_j);
  world.book(&rigid::EnergyLedger::vibration_j, energies.vibration_j + energies.residual_j);
  events.push_back(
      {time_s, body, static_cast<int>(result.pieces.size()), energies, result.crack_area_m2, result.largest_stress_pa});
  return breakage;
}

/// The same contact with SB's force or that of the authors' program at its peak, and no limit to what it may put in.
fracture::ContactLoad Breaking::State::as_modelled(fracture::ContactLoad load) const {
  if (scene.force_model == ForceModel::kHertz || load.lasting) return load;
  const double per_s = scene.force_model == ForceModel::kAuthorsCode ? kAuthorsPerS : scene.solver.rate_hz;
  load.impulse_n_s *= per_s * load.duration_s / fracture::hertz_peak_over_mean();
  load.compression_energy_j = std::numeric_limits<double>::max() / 1e6;
  return load;
}

/// What the body breaks into under a load that may strain it with no more than budget_j; nothing where it stays whole.
std::optional<fracture::FractureResult> Breaking::State::broken_by(int body, const fracture::LoadRequest& request,
                                                                   double budget_j) {
  Breakable& breakable = *bodies.at(body);
  const std::int64_t solved = breakable.responses().n_nodes_solved();
  const fracture::AllowedLoad load = fracture::allowed_load(breakable.responses(), breakable.surface(), request);
  n_solves += breakable.responses().n_nodes_solved() - solved;
  const double spendable_j = std::min(budget_j, load.strain_energy_j);
  if (!(load.strain_energy_j > 0.0) || is_harmless(body, spendable_j)) return {};
  const fracture::StressField field = breakable.responses().field(load.forces);
  int n_unknown = 0;
  const fracture::ResidualEnergy kept = [&](const std::vector<fracture::FragmentBody>& parts, double factor) {
    const KeptStrain strain = kept_strain(parts, allowed_forces(request, load.scale), breakable.material());
    n_unknown = strain.n_unknown;
    return factor * factor * strain.energy_j;
  };
  const Eigen::VectorXd breaking_pa =
      breakable.breaking_stress().by_element_pa(field, allowed_forces(request, load.scale), load.forces);
  fracture::FractureResult result =
      fracture::fracture_body(breakable.parent(), {field.energy_density_j_m3, field.stress_pa, breaking_pa},
                              scene.fracture, spendable_j, seed + static_cast<std::uint64_t>(body), kept);
  if (result.status != fracture::FractureStatus::kBroken || result.pieces.size() < 2) {
    if (result.status != fracture::FractureStatus::kBelowStrength && breakable.generation() == 0)
      withstood[body] = std::max(withstood[body], {result.largest_stress_pa, request.time_s});
    return {};
  }
  if (result.limit == fracture::PatternLimit::kCells)
    warnings.push_back("body " + breakable.parent().name + " broke at " + to_text(request.time_s) + " s into " +
                       std::to_string(result.n_cells) +
                       " cells, as many as fracture.most_pieces allows: there was energy for more");
  if (n_unknown > 0)
    warnings.push_back("body " + breakable.parent().name + " broke at " + to_text(request.time_s) + " s: what strain " +
                       std::to_string(n_unknown) +
                       " loaded pieces keep was not found; it is counted as released (erratum 51)");
  return result;
}

/// Of a piece, whose mesh is a mesher's and which collides as what its parent left of its convex parts, that may be.
/// To be called while the error is handled: that of a body of the scene goes on.
void Breaking::State::cannot_ask(int body, const std::exception& error) {
  const Breakable& breakable = *bodies.at(body);
  if (breakable.generation() == 0) throw;
  if (unasked.insert(body).second)
    warnings.push_back("piece " + breakable.parent().name +
                       " was struck and not asked whether it breaks: " + error.what());
}

/// Pieces that may break in their turn are meshed when they are first struck.
void Breaking::State::mesh_struck(const rigid::StepRecord& step) {
  for (const rigid::ContactImpulse& contact : step.contacts) {
    if (contact.kind != events::ImpulseKind::kImpact || !presses(contact)) continue;
    for (const int body : {contact.a, contact.b}) {
      const auto found = unmeshed.find(body);
      if (found == unmeshed.end()) continue;
      const std::string name = found->second.name;
      const mesh::SurfaceMesh& surface = pieces[found->second.piece].surface;
      try {
        bodies.emplace(body, std::make_unique<Breakable>(scene, std::move(found->second), surface));
      } catch (const InputError& error) {
        warnings.push_back("piece " + name + " does not break again, it cannot be meshed: " + error.what());
      }
      unmeshed.erase(found);
    }
  }
}

bool Breaking::State::breaks(rigid::RigidWorld& world, rigid::StepRecord& step, int body, rigid::Breakage& breakage) {
  std::vector<fracture::ContactLoad> loads = loads_on(world, step, body);
  double compression_j = 0.0, whole_j = 0.0;  // of this body, and with what those that struck it store
  for (const fracture::ContactLoad& load : loads) compression_j += load.compression_energy_j;
  const bool limited = scene.force_model == ForceModel::kHertz;
  if (!(compression_j > 0.0) || (limited && is_harmless(body, compression_j))) return false;
  for (const fracture::ContactLoad& load : loads_on(world, step, body, false)) whole_j += load.compression_energy_j;
  // No more than this body's contacts take up to their largest compression, and than its part of what contacts took in this step
  // (what broke before got back claimed_j of it) and would take beside that without rebound.
  const std::map<int, Speed> speeds = without_rebound(world, step, body);
  double taken_j = world.ledger().contact_j - contact_before_j;
  for (const auto& [number, speed] : speeds)
    taken_j += kinetic_j(world, number, {world.velocity_m_s(number), world.angular_velocity_rad_s(number)}) -
               kinetic_j(world, number, speed);
  taken_j -= kRoundOff * world.ledger().contact_j;  // so that no loss falls by a last digit
  const double available_j = std::min({compression_j, (taken_j + claimed_j) * (compression_j / whole_j), taken_j});
  if (!(available_j > 0.0)) return false;
  for (fracture::ContactLoad& load : loads) load = as_modelled(load);
  for (const fracture::LoadRequest& request : fracture::load_requests(loads)) {
    if (request.impacts.empty() || !(request.budget_j > 0.0)) continue;
    const double budget_j = limited ? std::min(available_j, request.budget_j) : HUGE_VAL;
    if (is_harmless(body, budget_j)) continue;
    std::optional<fracture::FractureResult> result;
    try {
      result = broken_by(body, request, budget_j);
    } catch (const InputError& error) {
      cannot_ask(body, error);
    } catch (const NumericalError& error) {
      cannot_ask(body, error);
    }
    if (!result) continue;
    take_back_rebound(world, step, body, speeds);
    breakage = replace(world, body, *result, available_j, request.time_s);
    return true;
  }
  return false;
}

// Of the middle of a disk and a pane of two layers the stress is 0 to 14, 25, 40 and 50 % low with edges of 1.5, 2, 3 and 4 walls.
std::vector<std::string> coarse_stress_warnings(const Scene& scene) {
  constexpr double kMostWalls = 1.5, kLowPerE = 0.36;
  std::vector<std::string> warnings;
  for (const SceneBody& body : scene.bodies) {
    if (body.model != BodyModel::kBreakable || !body.shape) continue;
    const double edge_m = detail::stress_edge_m(body), wall_m = detail::wall_m(*body.shape);
    if (edge_m <= kMostWalls * wall_m) continue;
    const double low = std::min(90.0, 100.0 * kLowPerE * std::log(edge_m / wall_m));
    warnings.push_back("body " + body.name + ": the mesh for its stress has edges of " + to_text(1e3 * edge_m) +
                       " mm, its wall is " + to_text(std::round(1e5 * wall_m) / 1e2) +
                       " mm: the tension across from a blow may come out up to " +
                       std::to_string(static_cast<int>(low)) + " % low, so that it holds what would break it");
  }
  return warnings;
}

Breaking::Breaking(const Scene& scene, std::uint64_t seed) : state_(std::make_unique<State>(scene, seed)) {
  state_->warnings = coarse_stress_warnings(scene);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.model != BodyModel::kBreakable) continue;
    auto breakable = located(body.place, [&] {
      auto made = std::make_unique<Breakable>(scene, static_cast<int>(i));
      made->factor();
      return made;
    });
    state_->bodies.emplace(static_cast<int>(i), std::move(breakable));
  }
}
Breaking::~Breaking() = default;

bool Breaking::has_bodies() const { return !state_->bodies.empty() || !state_->unmeshed.empty(); }
const std::vector<BreakEvent>& Breaking::events() const { return state_->events; }
std::vector<ScenePiece> Breaking::take_pieces() { return std::move(state_->pieces); }
std::int64_t Breaking::n_stress_solves() const { return state_->n_solves; }
std::vector<std::string> Breaking::warnings() const {
  std::vector<std::string> all = state_->warnings;
  for (const auto& [body, most] : state_->withstood)
    all.push_back("body " + state_->bodies.at(body)->parent().name +
                  " stayed whole, though its stress reached its strength (" +
                  to_text(std::round(most.first / 1e4) / 100) + " MPa at " + to_text(most.second) +
                  " s): its cells would keep more strain, or cost more, than there was energy for, or part nothing");
  return all;
}

std::vector<rigid::Breakage> Breaking::after_step(rigid::RigidWorld& world, rigid::StepRecord& step) {
  std::vector<rigid::Breakage> broken;
  std::vector<int> struck;
  state_->with_rebound.clear();
  state_->claimed_j = 0.0;
  state_->mesh_struck(step);
  state_->share_compression(world, step);
  for (const rigid::ContactImpulse& contact : step.contacts) {
    if (contact.kind != events::ImpulseKind::kImpact) continue;
    for (const int body : {contact.a, contact.b})
      if (state_->bodies.count(body) != 0 && std::find(struck.begin(), struck.end(), body) == struck.end())
        struck.push_back(body);
  }
  std::sort(struck.begin(), struck.end());
  for (const int body : struck) {
    rigid::Breakage breakage;
    if (!state_->breaks(world, step, body, breakage)) continue;
    state_->bodies.erase(body);
    broken.push_back(std::move(breakage));
  }
  state_->contact_before_j = world.ledger().contact_j;
  return broken;
}

}  // namespace klang::scene
