#include "core/physics/modal/reduced_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/la/block_mass.hpp"

namespace klang::modal {
namespace {

// Directions of the collected modes that carry less than this share of the largest are dropped: they change
// eigenvalues by its square.
constexpr double kBasisCut = 1e-6;
// Modes cross as Poisson's ratio changes: the trusted ones of one ratio are among the lowest of another only
// with some more than their number.
int with_margin(int count) { return count + 4 + count / 3; }
// Eigenvalues closer than this (relatively) share one derivative.
constexpr double kClusterTolerance = 1e-8;

solid::Material with_poissons_ratio(const solid::Material& material, double poissons_ratio) {
  solid::Material result = material;
  result.lame_lambda_pa = 2 * material.lame_mu_pa * poissons_ratio / (1 - 2 * poissons_ratio);
  return result;
}

Eigen::MatrixXd free_rows(const ModalModel& model, const solid::AssembledSolid& assembled) {
  Eigen::MatrixXd u(assembled.n_dofs(), model.n_modes());
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    u.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = model.shapes.middleRows<3>(3 * assembled.free_nodes[i]);
  }
  return u;
}

// Modes as they come, from 0 Hz, so that those below the band are part of the basis.
EigenOptions lowest(int count, bool prove) {
  EigenOptions options;
  options.count = count;
  options.band.low_hz = 0;
  options.prove_none_missing = prove;
  return options;
}

void drop_first(EigenResult& result, Eigen::Index n) {
  const Eigen::Index kept = result.model.n_modes() - n;
  result.model.angular_frequency_rad_s = result.model.angular_frequency_rad_s.tail(kept).eval();
  result.model.shapes = result.model.shapes.rightCols(kept).eval();
  result.relative_residual = result.relative_residual.tail(kept).eval();
  if (result.mesh_relative_error) result.mesh_relative_error = result.mesh_relative_error->tail(kept).eval();
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> reduced_pairs(const ReducedModel& model, double lambda, double mu) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(lambda * model.stiffness_lambda + mu * model.stiffness_mu);
}

void check(const ReducedModelOptions& options) {
  const char* place = "reduced model";
  if (options.count < 1) throw InputError(place, "count must be positive", std::to_string(options.count), "1 or more");
  checked(place, "band.low_hz", options.band.low_hz, 0, 1e12);
  if (options.anchor_poissons_ratios.empty()) throw InputError(place, "no anchor");
  for (const double ratio : options.anchor_poissons_ratios) {
    checked_open(place, "anchor_poissons_ratios", ratio, -1, 0.5);
  }
}

}  // namespace

ReducedModel reduce(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled, const solid::Material& nominal,
                    const solid::Support& support, const ReducedModelOptions& options, Monitor& monitor) {
  check(options);
  ReducedModel model;
  model.n_modes = options.count;
  std::vector<double> anchors = options.anchor_poissons_ratios;
  std::sort(anchors.begin(), anchors.end());
  model.poissons_ratio_low = anchors.front();
  model.poissons_ratio_high = anchors.back();

  const auto lowest_nominal = [&](int count) {
    EigenOptions eigen = lowest(count, true);
    eigen.estimate_mesh_error = options.estimate_mesh_error;
    return eigen;
  };
  model.nominal = solve_modes(mesh, assembled, nominal, support, lowest_nominal(options.count), monitor);
  if (!model.nominal.usable()) return model;
  const auto n_low = static_cast<int>((model.nominal.model.frequency_hz().array() < options.band.low_hz).count());
  const int n_all = options.count + n_low;
  if (n_low > 0) {
    model.nominal = solve_modes(mesh, assembled, nominal, support, lowest_nominal(n_all), monitor);
    if (!model.nominal.usable()) return model;
  }
  const auto n_dofs = static_cast<int>(assembled.n_dofs());
  const int n_anchor = std::max(n_all, std::min(with_margin(n_all), n_dofs - model.nominal.n_rigid_modes));
  model.n_skipped = n_low;

  std::vector<Eigen::MatrixXd> modes = {free_rows(model.nominal.model, assembled)};
  for (const double ratio : anchors) {
    const EigenResult anchor =
        solve_modes(mesh, assembled, with_poissons_ratio(nominal, ratio), support, lowest(n_anchor, false), monitor);
    if (!anchor.usable()) {
      model.nominal.status = anchor.status;
      model.nominal.message = "at Poisson's ratio " + to_text(ratio) + ": " + anchor.message;
      return model;
    }
    modes.push_back(free_rows(anchor.model, assembled));
  }
  drop_first(model.nominal, n_low);

  Eigen::Index n = 0;
  for (const auto& m : modes) n += m.cols();
  Eigen::MatrixXd collected(assembled.n_dofs(), n);
  n = 0;
  for (const auto& m : modes) {
    collected.middleCols(n, m.cols()) = m;
    n += m.cols();
  }
  const la::BlockMass unit_mass(assembled.mass_unit_density, 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(collected.transpose() * unit_mass.times(collected));
  const double cut = kBasisCut * kBasisCut * gram.eigenvalues().tail(1)(0);
  const Eigen::Index rank = (gram.eigenvalues().array() > cut).count();
  Eigen::MatrixXd basis = collected * (gram.eigenvectors().rightCols(rank) *
                                       gram.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal());
  model.stiffness_lambda = basis.transpose() * la::symmetric_times(assembled.stiffness_lambda, basis);
  model.stiffness_mu = basis.transpose() * la::symmetric_times(assembled.stiffness_mu, basis);
  // What is left of non-orthonormality after the division by small Gram eigenvalues is removed from both
  // exactly.
  const Eigen::MatrixXd left_gram = basis.transpose() * unit_mass.times(basis);
  const Eigen::LLT<Eigen::MatrixXd> factor(left_gram);
  const auto congruent = [&](const Eigen::MatrixXd& a) -> Eigen::MatrixXd {
    const Eigen::MatrixXd half = factor.matrixL().solve(a);
    const Eigen::MatrixXd both = factor.matrixL().solve(half.transpose());
    return 0.5 * (both + both.transpose());
  };
  model.stiffness_lambda = congruent(model.stiffness_lambda);
  model.stiffness_mu = congruent(model.stiffness_mu);

  if (options.measure_error) {
    for (std::size_t k = 0; k + 1 < anchors.size(); ++k) {
      const solid::Material midway = with_poissons_ratio(nominal, 0.5 * (anchors[k] + anchors[k + 1]));
      const EigenResult exact = solve_modes(mesh, assembled, midway, support, lowest(n_all, false), monitor);
      const auto reduced = reduced_eigenvalues(model, midway.lame_lambda_pa, midway.lame_mu_pa, midway.density_kg_m3);
      const Eigen::ArrayXd omega_sq = exact.model.angular_frequency_rad_s.tail(options.count).array().square();
      const double error = (reduced.angular_frequency_sq.array() / omega_sq - 1).abs().maxCoeff();
      model.max_relative_error = std::max(model.max_relative_error, error);
    }
  }
  return model;
}

ReducedEigenvalues reduced_eigenvalues(const ReducedModel& model, double lame_lambda_pa, double lame_mu_pa,
                                       double density_kg_m3) {
  solid::validate({lame_lambda_pa, lame_mu_pa, density_kg_m3, "", ""});
  const auto pairs = reduced_pairs(model, lame_lambda_pa, lame_mu_pa);
  ReducedEigenvalues result;
  result.angular_frequency_sq = pairs.eigenvalues().segment(model.n_skipped, model.n_modes) / density_kg_m3;
  const auto vectors = pairs.eigenvectors().leftCols(model.n_skipped + model.n_modes + 1 <= pairs.eigenvectors().cols()
                                                         ? model.n_skipped + model.n_modes + 1
                                                         : pairs.eigenvectors().cols());
  Eigen::MatrixXd derivative(vectors.cols(), 2);
  derivative.col(0) =
      vectors.cwiseProduct(model.stiffness_lambda * vectors).colwise().sum().transpose() / density_kg_m3;
  derivative.col(1) = vectors.cwiseProduct(model.stiffness_mu * vectors).colwise().sum().transpose() / density_kg_m3;
  const auto& value = pairs.eigenvalues();
  for (Eigen::Index first = 0; first < derivative.rows();) {
    Eigen::Index last = first;  // inclusive
    while (last + 1 < derivative.rows() && value[last + 1] - value[last] <= kClusterTolerance * value[last + 1]) ++last;
    const Eigen::RowVector2d mean = derivative.middleRows(first, last - first + 1).colwise().mean();
    derivative.middleRows(first, last - first + 1).rowwise() = mean;
    first = last + 1;
  }
  result.derivative = derivative.middleRows(model.n_skipped, model.n_modes);
  return result;
}

}  // namespace klang::modal
