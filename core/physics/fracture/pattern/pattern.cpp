#include "core/physics/fracture/pattern/pattern.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"

namespace klang::fracture {
namespace {

constexpr double kInScore = 1e-9;  // of the body's size

RegionCut uncut(const mesh::TetMesh& mesh) {
  RegionCut cut;
  cut.mesh.nodes_m = mesh.nodes_m;
  cut.mesh.elements = mesh.elements;
  cut.region.assign(static_cast<std::size_t>(mesh.n_elements()), 0);
  cut.element.resize(static_cast<std::size_t>(mesh.n_elements()));
  for (int e = 0; e < mesh.n_elements(); ++e) cut.element[e] = e;
  return cut;
}

/// Region 0 where the plane's height is below zero, 1 above.
RegionCut cut_by_plane(const mesh::TetMesh& mesh, const HalfSpace& plane) {
  RegionFields fields{Eigen::MatrixXd::Zero(2, mesh.n_nodes()), Eigen::MatrixXd::Ones(2, 2)};
  fields.values.row(0) = (mesh.nodes_m * plane.normal).transpose().array() - plane.offset_m;
  return cut_regions(mesh, fields);
}

/// The next number of cells to try between one that is affordable and one that is not: where E_F is what there is if it grows with the root of
/// the number, as plates' cracks do; every third time the middle, so that it ends soon whatever E_F does.
int between(int good, double good_j, int bad, double bad_j, double spendable_j, int step) {
  if (step % 3 == 2) return (good + bad) / 2;
  const double low = std::sqrt(good), share = (spendable_j - good_j) / (bad_j - good_j);
  const double root = low + share * (std::sqrt(bad) - low);
  return std::clamp(static_cast<int>(root * root), good + 1, bad - 1);
}

}  // namespace

PatternMaker::PatternMaker(const mesh::TetMesh& mesh, const Eigen::VectorXd& energy_density, PatternRules rules,
                           std::uint64_t seed)
    : mesh_(mesh),
      rules_(std::move(rules)),
      sampler_(mesh, energy_density, rules_.smallest_piece_m, seed),
      paths_(mesh, rules_.alpha) {
  KLANG_CHECK(mesh.order() == 1, "a body that breaks has straight tetrahedra");
  size_m_ = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  base_ = rules_.score ? cut_by_plane(mesh, rules_.score->plane) : uncut(mesh);
}

int PatternMaker::n_places(int wanted) {
  return static_cast<int>(std::min<std::size_t>(sampler_.first(wanted).size(), static_cast<std::size_t>(wanted)));
}

FracturePattern PatternMaker::with_cells(int n) {
  FracturePattern pattern;
  n = n_places(n);
  pattern.n_cells = n;
  pattern.seeds.assign(sampler_.first(n).begin(), sampler_.first(n).begin() + n);
  RegionCut cut = base_;
  std::vector<std::vector<HalfSpace>> cells(static_cast<std::size_t>(n));
  if (n >= 2) {
    // Distances along edges are those of the body as it was.
    const PowerCells power(pattern.seeds, rules_.alpha);
    if (!rules_.geodesic)
      for (int c = 0; c < n; ++c) cells[c] = power.half_spaces(c);
    if (rules_.geodesic && rules_.score) {
      cut = cut_regions(mesh_, paths_.fields(pattern.seeds));
      const RegionCut twice = cut_by_plane(cut.mesh, rules_.score->plane);
      std::vector<int> region, element;
      for (std::size_t e = 0; e < twice.region.size(); ++e) {
        region.push_back(2 * cut.region[twice.element[e]] + twice.region[e]);
        element.push_back(cut.element[twice.element[e]]);
      }
      cut = {twice.mesh, std::move(region), std::move(element)};
    } else {
      RegionCut twice =
          cut_regions(base_.mesh, rules_.geodesic ? paths_.fields(pattern.seeds) : power.fields(base_.mesh));
      for (std::size_t e = 0; e < twice.region.size(); ++e) {
        if (rules_.score) twice.region[e] = 2 * twice.region[e] + base_.region[twice.element[e]];
        twice.element[e] = base_.element[twice.element[e]];
      }
      cut = std::move(twice);
    }
  }
  for (const auto& cell : cells) {
    pattern.half_spaces.push_back(cell);
    if (!rules_.score) continue;
    const HalfSpace& plane = rules_.score->plane;
    pattern.half_spaces.push_back(cell);
    if (rules_.geodesic) continue;
    (pattern.half_spaces.end() - 2)->push_back(plane);
    pattern.half_spaces.back().push_back({-plane.normal, -plane.offset_m});
  }
  const double small = rules_.smallest_piece_m;
  pattern.fragments = fragments_of(std::move(cut), {small * small * small / 8.0, rules_.merge_enclosed});
  pattern.fracture_energy_j = cost_j(pattern.fragments);
  return pattern;
}

double PatternMaker::cost_j(const Fragments& fragments) const {
  if (!rules_.score) return rules_.toughness_j_m2 * fragments.crack_area_m2;
  double scored = 0.0, other = 0.0;
  for (const CrackTriangle& crack : fragments.cracks) {
    bool inside = true;
    for (const int node : crack.nodes)
      inside = inside && std::abs(fragments.cut.mesh.nodes_m.row(node).dot(rules_.score->plane.normal) -
                                  rules_.score->plane.offset_m) <= kInScore * size_m_;
    (inside ? scored : other) += crack.area_m2;
  }
  return rules_.toughness_j_m2 * (other + rules_.score->toughness_factor * scored);
}

FracturePattern PatternMaker::affordable() {
  const int fewest = rules_.score ? 1 : 2;
  const int most = n_places(rules_.score_alone ? 1 : rules_.most_cells);
  FracturePattern best;
  std::optional<double> too_much;
  int good = 0, bad = most + 1;
  for (int n = fewest, step = 0; n < bad; ++step) {
    FracturePattern tried = with_cells(n);
    if (tried.fracture_energy_j <= rules_.spendable_j) {
      good = n;
      best = std::move(tried);
    } else {
      bad = n;
      too_much = tried.fracture_energy_j;
    }
    if (good == 0 || good + 1 >= bad) break;
    n = too_much ? between(good, best.fracture_energy_j, bad, *too_much, rules_.spendable_j, step)
                 : std::min(2 * good, bad - 1);
  }
  if (best.fragments.n_fragments < 2) return {};
  best.next_fracture_energy_j = too_much;
  best.limit = too_much                            ? PatternLimit::kEnergy
               : rules_.score_alone                ? PatternLimit::kScore
               : best.n_cells == rules_.most_cells ? PatternLimit::kCells
                                                   : PatternLimit::kDistance;
  return best;
}

}  // namespace klang::fracture
