#include "core/physics/fracture/event/fracture_body.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/tet_geometry.hpp"

namespace klang::fracture {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d tensor(const Eigen::Matrix<double, 6, 1>& s) {
  Matrix3d t;
  t << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  return t;
}

/// The load as it can be spent, and where it is above the strength.
struct Load {
  Eigen::VectorXd density;
  Eigen::Matrix<double, 6, Eigen::Dynamic> stress;
  double energy_j = 0.0, factor = 1.0;
  double largest_pa = -HUGE_VAL;
  int largest_element = -1;
  bool breaks = false, breaks_outside_score = false;
};

bool runs_through(const HalfSpace& plane, const mesh::TetMesh& mesh, int e) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (int c = 0; c < 4; ++c) {
    const double height = mesh.nodes_m.row(mesh.elements(e, c)).dot(plane.normal) - plane.offset_m;
    low = std::min(low, height);
    high = std::max(high, height);
  }
  return low <= 0.0 && high >= 0.0;
}

Load load_of(const ParentBody& parent, const mesh::TetMesh& mesh, const StressInput& stress, double available_j) {
  if (stress.energy_density_j_m3.size() != mesh.n_elements() || stress.stress_pa.cols() != mesh.n_elements() ||
      (stress.breaking_pa.size() != 0 && stress.breaking_pa.size() != mesh.n_elements()))
    throw InputError("body " + parent.name, "stress and energy density are not those of its mesh");
  if (!stress.energy_density_j_m3.allFinite() || !stress.stress_pa.allFinite() || !stress.breaking_pa.allFinite())
    throw InputError("body " + parent.name, "stress or energy density is not finite");
  Load load{stress.energy_density_j_m3, stress.stress_pa};
  for (int e = 0; e < mesh.n_elements(); ++e) load.energy_j += load.density[e] * mesh::tet_volume_m3(mesh, e);
  if (load.energy_j > available_j) {
    load.factor = std::sqrt(available_j / load.energy_j);
    load.density *= available_j / load.energy_j;
    load.stress *= load.factor;
    load.energy_j = available_j;
  }
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const double principal = stress.breaking_pa.size() > 0 ? load.factor * stress.breaking_pa[e]
                                                           : Eigen::SelfAdjointEigenSolver<Matrix3d>(
                                                                 tensor(load.stress.col(e)), Eigen::EigenvaluesOnly)
                                                                 .eigenvalues()[2];
    if (principal > load.largest_pa) {
      load.largest_pa = principal;
      load.largest_element = e;
    }
    const bool scored = parent.score && runs_through(parent.score->plane, mesh, e);
    const double strength = parent.tensile_strength_pa * (scored ? parent.score->strength_factor : 1.0);
    if (!(principal >= strength)) continue;
    load.breaks = true;
    if (!scored || principal >= parent.tensile_strength_pa) load.breaks_outside_score = true;
  }
  return load;
}

std::vector<CrackFace> crack_faces(const Fragments& fragments, const Load& load) {
  std::vector<CrackFace> faces;
  for (const CrackTriangle& crack : fragments.cracks) {
    const mesh::Points& nodes = fragments.cut.mesh.nodes_m;
    const Vector3d p = nodes.row(crack.nodes[0]), q = nodes.row(crack.nodes[1]), r = nodes.row(crack.nodes[2]);
    const Vector3d doubled = (q - p).cross(r - p);
    if (!(doubled.norm() > 0.0)) continue;
    faces.push_back({crack.a, crack.b, crack.area_m2, doubled.normalized(), (p + q + r) / 3.0,
                     tensor(load.stress.col(crack.element_a)), tensor(load.stress.col(crack.element_b))});
  }
  return faces;
}

double crack_duration_s(const ParentBody& parent, const mesh::TetMesh& mesh, const FractureOptions& options,
                        const std::vector<CrackFace>& cracks, int from_element) {
  Vector3d from = Vector3d::Zero();
  for (int c = 0; c < 4; ++c) from += 0.25 * mesh.nodes_m.row(mesh.elements(from_element, c)).transpose();
  double farthest = 0.0;
  for (const CrackFace& crack : cracks) farthest = std::max(farthest, (crack.centre_m - from).norm());
  const double shear_m_s =
      std::sqrt(parent.youngs_modulus_pa / (2.0 * (1.0 + parent.poissons_ratio) * parent.density_kg_m3));
  return farthest / (options.crack_speed_over_rayleigh * rayleigh_speed_ratio(parent.poissons_ratio) * shear_m_s);
}

PatternRules rules_of(const ParentBody& parent, const FractureOptions& options, const Load& load) {
  PatternRules rules;
  rules.geodesic =
      options.pattern == PatternKind::kGeodesic || (options.pattern == PatternKind::kAuto && parent.parts.size() > 1);
  rules.alpha = options.alpha;
  rules.toughness_j_m2 = parent.toughness_j_m2;
  rules.spendable_j = options.eta * load.energy_j;
  rules.smallest_piece_m = options.smallest_piece_m;
  rules.most_cells = options.most_pieces;
  rules.merge_enclosed = options.merge_enclosed;
  rules.score = parent.score;
  rules.score_alone = parent.score && !load.breaks_outside_score;
  return rules;
}

struct TriedPattern {
  FracturePattern pattern;
  std::vector<FragmentBody> pieces;  ///< without what collides
  double kept_j = 0.0;
};

/// The pattern of most cells whose cracks, with the strain that loaded pieces keep, cost no more than there is: one fewer at a time from what the
/// cracks alone allow, as it is near by when anything pays; after four, in strides that double, and then between the last two.
/// Nothing where not even the fewest pay.
std::optional<TriedPattern> most_that_pays(PatternMaker& maker, int fewest, double energy_j,
                                           const std::function<TriedPattern(const FracturePattern&)>& tried) {
  constexpr int kOneByOne = 4;
  const auto pays = [&](const TriedPattern& t) { return t.pattern.fracture_energy_j + t.kept_j <= energy_j; };
  FracturePattern first = maker.affordable();
  if (first.n_cells == 0) return {};
  int too_many = first.n_cells, stride = 1;
  TriedPattern best = tried(first);
  if (pays(best)) return best;
  int good = 0;
  const auto try_with = [&](int n) {
    FracturePattern pattern = maker.with_cells(n);
    if (pattern.fragments.n_fragments < 2) return false;
    pattern.limit = PatternLimit::kEnergy;
    TriedPattern now = tried(pattern);
    if (!pays(now)) return false;
    best = std::move(now);
    good = n;
    return true;
  };
  for (int k = 1; too_many > fewest; ++k) {
    const int n = std::max(fewest, too_many - stride);
    if (try_with(n)) break;
    too_many = n;
    if (k >= kOneByOne) stride *= 2;
  }
  if (good == 0) return {};
  bool is_last = true;  // what `tried` notes besides is that of the last call
  while (too_many - good > 1) {
    const int n = (good + too_many) / 2;
    is_last = try_with(n);
    if (!is_last) too_many = n;
  }
  return is_last ? best : tried(best.pattern);
}

/// The push, and where each joule went.
void share_energy(FractureResult& result, const FractureOptions& options) {
  std::vector<PieceMass> masses;
  Vector3d centre = Vector3d::Zero();
  double mass = 0.0;
  for (const FragmentBody& piece : result.pieces) {
    masses.push_back({piece.mass_kg, piece.centre_m, piece.inertia_kg_m2});
    centre += piece.mass_kg * piece.centre_m;
    mass += piece.mass_kg;
  }
  ImpulseForm form;
  if (options.literature == Literature::kPaper)
    form = paper_form();
  else
    form.crack_friction = options.crack_friction;
  FractureEnergies& e = result.energies;
  const double left = e.strain_j - e.residual_j - e.fracture_j;
  result.push = fracture_impulses(result.cracks, masses, options.impulses ? left : 0.0, form, {centre / mass});
  e.kinetic_j = result.push.kinetic_j;
  e.vibration_j = left - e.kinetic_j;
  // All of it went into motion, to the last bits: those are the motion's.
  if (result.push.status == PushStatus::kPushed) {
    e.kinetic_j = left;
    e.vibration_j = 0.0;
  }
}

}  // namespace

void FractureOptions::validate() const { validate_fields("fracture", *this); }

void ParentBody::validate() const {
  const std::string place = "body " + name;
  checked_open(place, "density_kg_m3", density_kg_m3, 0.0, 1e6);
  checked_open(place, "toughness_j_m2", toughness_j_m2, 0.0, 1e9);
  checked_open(place, "tensile_strength_pa", tensile_strength_pa, 0.0, 1e15);
  checked_open(place, "youngs_modulus_pa", youngs_modulus_pa, 0.0, 1e15);
  checked_open(place, "poissons_ratio", poissons_ratio, -1.0, 0.5);
  if (mesh.n_elements() == 0) throw InputError(place, "its mesh has no elements");
  if (!mesh.nodes_m.allFinite()) throw InputError(place, "a node of its mesh is not finite");
  if (!score) return;
  checked_open(place, "strength_factor", score->strength_factor, 0.0, 1.0 + 1e-12);
  checked_open(place, "toughness_factor", score->toughness_factor, 0.0, 1.0 + 1e-12);
  if (!(std::abs(score->plane.normal.norm() - 1.0) <= 1e-9) || !std::isfinite(score->plane.offset_m))
    throw InputError(place, "the scored plane's normal is not of length 1");
}

FractureResult fracture_body(const ParentBody& parent, const StressInput& stress, const FractureOptions& options,
                             double available_energy_j, std::uint64_t seed, const ResidualEnergy& residual) {
  parent.validate();
  options.validate();
  if (!(available_energy_j >= 0.0))
    throw InputError("body " + parent.name, "the energy available is negative or not a number");
  const mesh::TetMesh mesh = mesh::to_linear(parent.mesh);
  const Load load = load_of(parent, mesh, stress, available_energy_j);
  FractureResult result;
  result.largest_stress_pa = load.largest_pa;
  result.largest_element = load.largest_element;
  result.load_factor = load.factor;
  result.status = FractureStatus::kBelowStrength;
  if (!load.breaks) return result;
  result.status = FractureStatus::kTooLittleEnergy;
  if (!(load.energy_j > 0.0)) return result;
  PatternMaker maker(mesh, load.density, rules_of(parent, options, load), seed);
  std::optional<TriedPattern> found =
      most_that_pays(maker, parent.score ? 1 : 2, load.energy_j, [&](const FracturePattern& pattern) {
        TriedPattern tried{pattern, fragment_bodies(pattern, parent.density_kg_m3), 0.0};
        tried.kept_j = residual ? residual(tried.pieces, load.factor) : 0.0;
        return tried;
      });
  if (!found) return result;
  const FracturePattern& pattern = found->pattern;
  const double kept_j = found->kept_j;
  result.pieces = std::move(found->pieces);
  give_parts(pattern, parent.parts, result.pieces);
  result.status = FractureStatus::kBroken;
  result.cracks = crack_faces(pattern.fragments, load);
  result.crack_area_m2 = pattern.fragments.crack_area_m2;
  result.n_cells = pattern.n_cells;
  result.n_merged = pattern.fragments.n_merged;
  result.n_enclosed = static_cast<int>(pattern.fragments.enclosed.size());
  result.limit = pattern.limit;
  result.next_fracture_energy_j = pattern.next_fracture_energy_j;
  result.energies = {load.energy_j, pattern.fracture_energy_j, 0.0, 0.0, kept_j};
  result.crack_duration_s = crack_duration_s(parent, mesh, options, result.cracks, load.largest_element);
  share_energy(result, options);
  return result;
}

}  // namespace klang::fracture
