#include "core/physics/modal/detail/eigen_problem.hpp"

#include <Spectra/SymGEigsShiftSolver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/la/block_lanczos.hpp"
#include "core/foundation/la/lapack.hpp"
#include "core/foundation/la/same_pattern.hpp"
#include "core/foundation/la/sturm_count.hpp"
#include "core/physics/solid/node_ends.hpp"
#include "core/physics/solid/rigid_modes.hpp"

namespace klang::modal::detail {

namespace {

// K - shift M, lower triangle: the two share a pattern.
solid::SparseMatrix shifted(const solid::SparseMatrix& stiffness, const solid::SparseMatrix& unit_mass,
                            double density_kg_m3, double shift) {
  KLANG_CHECK(stiffness.nonZeros() == unit_mass.nonZeros(), "K and M share one pattern");
  solid::SparseMatrix result = la::same_pattern(stiffness);
  double* value = result.valuePtr();
  const double *stiff = stiffness.valuePtr(), *mass = unit_mass.valuePtr();
  const double factor = -shift * density_kg_m3;
  parallel_for(static_cast<std::size_t>(result.nonZeros()), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) value[k] = stiff[k] + factor * mass[k];
  });
  return result;
}

Eigen::MatrixXd m_orthonormal(Eigen::MatrixXd basis, const la::BlockMass& mass) {
  if (basis.cols() == 0) return basis;
  for (int pass = 0; pass < 2;
       ++pass) {  // twice: the first leaves the square root of round-off where the basis is oblique
    const Eigen::MatrixXd gram = basis.transpose() * mass.times(basis);
    const Eigen::LLT<Eigen::MatrixXd> factor(gram);
    basis = factor.matrixL().solve(basis.transpose()).transpose().eval();
  }
  return basis;
}

}  // namespace

Pairs merged(const Pairs& a, const Pairs& b) {
  std::vector<std::pair<double, Eigen::Index>> order;
  for (Eigen::Index i = 0; i < a.size() + b.size(); ++i) {
    order.emplace_back(i < a.size() ? a.value[i] : b.value[i - a.size()], i);
  }
  std::sort(order.begin(), order.end());
  Pairs result;
  result.converged = a.converged && b.converged;
  result.message = a.converged ? b.message : a.message;
  result.value.resize(static_cast<Eigen::Index>(order.size()));
  result.vector.resize(a.vector.rows(), result.value.size());
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    const auto [value, i] = order[static_cast<std::size_t>(k)];
    result.value[k] = value;
    if (i < a.size())
      result.vector.col(k) = a.vector.col(i);
    else
      result.vector.col(k) = b.vector.col(i - a.size());
  }
  return result;
}

// y = P s (K - shift M)^-1 x with P the M-orthogonal projection off the known vectors. s makes the operator's
// eigenvalues of order one, which Spectra's stopping test takes for granted.
class ShiftInvert {
 public:
  using Scalar = double;
  ShiftInvert(EigenProblem& problem, const Eigen::MatrixXd& known, double scale) : problem_(problem), scale_(scale) {
    vectors_.resize(problem.n_dofs(), problem.n_rigid() + known.cols());
    vectors_ << problem.rigid_, known;
    mass_vectors_.resize(vectors_.rows(), vectors_.cols());
    mass_vectors_ << problem.mass_rigid_, problem.mass_.times(known);
  }
  Eigen::Index rows() const { return problem_.n_dofs(); }
  Eigen::Index cols() const { return rows(); }
  void set_shift(const double&) {}
  void perform_op(const double* x, double* y) const {
    problem_.factor_.solve(x, y);
    ++problem_.n_operations_;
    Eigen::Map<Eigen::VectorXd> out(y, rows());
    if (vectors_.cols() > 0) out.noalias() -= vectors_ * (mass_vectors_.transpose() * out).eval();
    out *= scale_;
  }

 private:
  EigenProblem& problem_;
  double scale_;
  Eigen::MatrixXd vectors_, mass_vectors_;
};

namespace {

class MassProduct {
 public:
  using Scalar = double;
  explicit MassProduct(const la::BlockMass& mass) : mass_(mass) {}
  Eigen::Index rows() const { return mass_.n_dofs(); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const { mass_.multiply(x, y); }

 private:
  const la::BlockMass& mass_;
};

}  // namespace

EigenProblem::EigenProblem(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled,
                           const solid::Material& material)
    : stiffness_(solid::stiffness(assembled, material.lame_lambda_pa, material.lame_mu_pa)),
      unit_mass_(assembled.mass_unit_density),
      density_kg_m3_(material.density_kg_m3),
      mass_(assembled.mass_unit_density, material.density_kg_m3),
      ends_(solid::node_ends(mesh, assembled)) {
  rigid_ = m_orthonormal(solid::rigid_modes(mesh, assembled), mass_);
  mass_rigid_ = mass_.times(rigid_);
  if (n_rigid() > 0) {
    // A free body is singular at 0. Far below its first mode for compact bodies, and never so low that the
    // factor loses its definiteness to round-off: 5 % of the frequency at which a shear wave crosses the
    // body.
    const double size_m = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
    shift_ = -std::pow(2 * kPi * 0.05 * material.shear_speed_m_s() / size_m, 2);
  }
}

const la::FactorPattern& EigenProblem::pattern() {
  if (!pattern_) pattern_.emplace(stiffness_, la::block_ordering(stiffness_, ends_));
  return *pattern_;
}

bool EigenProblem::factor(std::string& message) {
  const Stopwatch watch;
  bool done = false;
  for (int attempt = 0; attempt < 3 && !done; ++attempt) {
    if (attempt > 0) {
      if (shift_ == 0) break;
      shift_ *= 100;
    }
    done = factor_.factor(shifted(stiffness_, unit_mass_, density_kg_m3_, shift_), pattern());
  }
  seconds_factor += watch.seconds();
  if (!done) message = factor_.message();
  return done;
}

Pairs EigenProblem::lowest(Eigen::Index n, double tolerance, int max_restarts, const Eigen::MatrixXd& known,
                           int attempt) {
  // An eigenvalue's size for the scale: that of the shift, or, for a held body, one inverse step on a vector
  // of ones.
  RandomStream random(20021, static_cast<std::uint64_t>(attempt));
  Eigen::VectorXd start(n_dofs());
  for (double& value : start) value = random.uniform(-1, 1);
  const MassProduct mass_product(mass_);
  Eigen::VectorXd forced(n_dofs());
  mass_.multiply(start.data(), forced.data());
  const ShiftInvert unscaled(*this, known, 1.0);
  unscaled.perform_op(forced.data(), start.data());
  mass_.multiply(start.data(), forced.data());
  Eigen::VectorXd next(n_dofs());
  unscaled.perform_op(forced.data(), next.data());
  const double scale = start.dot(forced) / next.dot(forced);  // Rayleigh quotient of K - shift M, about the lowest
  start = next;

  const Eigen::Index room = n_dofs() - n_rigid() - known.cols();
  const Eigen::Index ncv = std::min(room, std::max<Eigen::Index>(2 * n, n + 16) + 10 * attempt);
  Pairs pairs;
  KLANG_CHECK(n >= 1 && n < ncv, "fewer pairs wanted than there are");
  ShiftInvert op(*this, known, scale);
  MassProduct b_op(mass_);
  Spectra::SymGEigsShiftSolver<ShiftInvert, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
      op, b_op, static_cast<int>(n), static_cast<int>(ncv), 0.0);
  solver.init(start.data());
  const Eigen::Index n_converged = solver.compute(Spectra::SortRule::LargestAlge, max_restarts, tolerance);
  pairs.converged = solver.info() == Spectra::CompInfo::Successful;
  if (!pairs.converged) {
    pairs.message = "Lanczos: " + std::to_string(n_converged) + " of " + std::to_string(n) + " modes after " +
                    std::to_string(max_restarts) + " restarts";
  }
  // Spectra's value is 1 / theta with theta = scale / (omega^2 - shift).
  const Eigen::VectorXd value = solver.eigenvalues();
  const Eigen::MatrixXd vector = solver.eigenvectors();
  std::vector<Eigen::Index> by_value(value.size());
  std::iota(by_value.begin(), by_value.end(), Eigen::Index{0});
  std::sort(by_value.begin(), by_value.end(), [&](auto a, auto b) { return value[a] < value[b]; });
  pairs.value.resize(value.size());
  pairs.vector.resize(n_dofs(), value.size());
  for (Eigen::Index k = 0; k < value.size(); ++k) {
    pairs.value[k] = value[by_value[k]] * scale + shift_;
    pairs.vector.col(k) = vector.col(by_value[k]);
  }
  return pairs;
}

Pairs EigenProblem::lowest_block(Eigen::Index n, Eigen::Index block, double tolerance, int max_restarts,
                                 const Watch& watch) {
  RandomStream random(20021, 0);
  Eigen::MatrixXd start(n_dofs(), block);
  for (double& value : start.reshaped()) value = random.uniform(-1, 1);
  const auto apply = [&](const Eigen::MatrixXd& mass_x) { return solve(mass_x); };
  start = apply(mass_.times(start));
  la::BlockLanczosOptions options{n, tolerance, max_restarts, {}};
  if (watch)
    options.watch = [&](const Eigen::VectorXd& theta, const Eigen::VectorXd& residual) {
      const Eigen::VectorXd shifted_value = theta.cwiseInverse();
      watch(shifted_value.array() + shift_, shifted_value.cwiseProduct(residual));
    };
  la::BlockLanczosResult found = la::block_lanczos(apply, mass_, std::move(start), options);
  Pairs pairs;
  pairs.converged = found.converged;
  if (!found.converged)
    pairs.message = "block Lanczos did not converge in " + std::to_string(max_restarts) + " restarts";
  pairs.value = found.theta.cwiseInverse().array() + shift_;
  pairs.vector = std::move(found.vector);
  return pairs;
}

Pairs EigenProblem::lowest_dense(Eigen::Index wanted) const {
  const int n = static_cast<int>(n_dofs());
  Eigen::MatrixXd a = stiffness_;
  Eigen::MatrixXd b = density_kg_m3_ * Eigen::MatrixXd(unit_mass_);
  // The rigid motions are moved above every elastic mode: K + top (M R)(M R)^T leaves the others as they are.
  // top bounds the largest eigenvalue: that of the assembled matrix does not exceed trace(K) / min diag(M)...
  // which the consistent mass satisfies up to a small factor.
  const double top = a.diagonal().maxCoeff() / b.diagonal().minCoeff() * 10;
  if (n_rigid() > 0) a.triangularView<Eigen::Lower>() += top * mass_rigid_ * mass_rigid_.transpose();
  const int itype = 1, first = 1, last = static_cast<int>(std::min<Eigen::Index>(wanted, n_elastic()));
  const double none = 0, abstol = 0;
  Pairs pairs;
  Eigen::VectorXd value(n);
  pairs.vector.resize(n, last);
  std::vector<int> iwork(5 * static_cast<std::size_t>(n)), ifail(n);
  int found = 0, info = 0, lwork = -1;
  double work_size = 0;
  const auto call = [&](double* work) {
    dsygvx_(&itype, "V", "I", "L", &n, a.data(), &n, b.data(), &n, &none, &none, &first, &last, &abstol, &found,
            value.data(), pairs.vector.data(), &n, work, &lwork, iwork.data(), ifail.data(), &info);
  };
  call(&work_size);
  lwork = static_cast<int>(work_size);
  std::vector<double> work(lwork);
  call(work.data());
  pairs.converged = info == 0 && found == last;
  if (!pairs.converged) pairs.message = "LAPACK dsygvx returned " + std::to_string(info);
  pairs.value = value.head(found);
  pairs.vector.conservativeResize(n, found);
  return pairs;
}

Eigen::MatrixXd EigenProblem::solve(const Eigen::MatrixXd& force) {
  Eigen::MatrixXd y = factor_.solve(force);
  n_operations_ += static_cast<int>(force.cols());
  if (n_rigid() > 0) y -= rigid_ * (mass_rigid_.transpose() * y);
  return y;
}

void EigenProblem::polish(Pairs& pairs) {
  if (pairs.size() == 0) return;
  const Eigen::MatrixXd force = mass_.times(pairs.vector);
  Eigen::MatrixXd y = solve(force);
  y *= (pairs.value.array() - shift_).matrix().asDiagonal();
  const Eigen::MatrixXd gram = y.transpose() * mass_.times(y);
  // (K - shift M) y = force (omega^2 - shift), and K R = 0, so that no product with K is needed.
  Eigen::MatrixXd energy = y.transpose() * force * (pairs.value.array() - shift_).matrix().asDiagonal();
  energy = 0.5 * (energy + energy.transpose()).eval();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> small(energy, gram);
  pairs.value = small.eigenvalues().array() + shift_;
  pairs.vector = y * small.eigenvectors();
}

bool EigenProblem::factor_and_count(double omega_sq, std::string& message) {
  pattern();  // both need it
  bool done = false;
  for_each_job(2, [&](std::size_t job) {
    if (job == 0)
      done = factor(message);
    else
      n_below(omega_sq);
  });
  return done;
}

void EigenProblem::polish_and_count(Pairs& pairs, double omega_sq) {
  for_each_job(2, [&](std::size_t job) {
    if (job == 0)
      n_below(omega_sq);
    else
      polish(pairs);
  });
}

std::optional<long> EigenProblem::n_below(double omega_sq) {
  if (omega_sq == counted_at_) return counted_;
  const Stopwatch watch;
  auto count = la::n_negative_eigenvalues(shifted(stiffness_, unit_mass_, density_kg_m3_, omega_sq), pattern());
  seconds_sturm += watch.seconds();
  counted_at_ = omega_sq;
  counted_ = count;
  return count;
}

void EigenProblem::residuals(const Pairs& pairs, Eigen::VectorXd& relative, Eigen::VectorXd& round_off) const {
  const Eigen::MatrixXd stiffness_u = la::symmetric_times(stiffness_, pairs.vector);
  const Eigen::MatrixXd mass_u = mass_.times(pairs.vector);
  const Eigen::VectorXd diagonal = stiffness_.diagonal();
  relative.resize(pairs.size());
  round_off.resize(pairs.size());
  for (Eigen::Index k = 0; k < pairs.size(); ++k) {
    const double scale = pairs.value[k] * mass_u.col(k).norm();
    relative[k] = (stiffness_u.col(k) - pairs.value[k] * mass_u.col(k)).norm() / scale;
    // Rows of |K| sum to a few times their diagonal: what rounding u and the products makes of K u.
    const double products = diagonal.cwiseProduct(pairs.vector.col(k)).norm();
    round_off[k] = 8 * std::numeric_limits<double>::epsilon() * products / scale;
  }
}

double gap_above(const Pairs& pairs, Eigen::Index wanted) {
  double widest = 1e-7, middle = 0;
  for (Eigen::Index i = std::max<Eigen::Index>(wanted, 1); i < pairs.size(); ++i) {
    const double gap = pairs.value[i] / pairs.value[i - 1] - 1;
    if (gap > widest) {
      widest = gap;
      middle = std::sqrt(pairs.value[i] * pairs.value[i - 1]);
    }
  }
  return middle;
}

double sure_gap_above(const Eigen::VectorXd& value, const Eigen::VectorXd& error, Eigen::Index wanted) {
  double widest = 1e-7, middle = 0;
  for (Eigen::Index i = std::max<Eigen::Index>(wanted, 1); i < value.size(); ++i) {
    const double gap = value[i] / value[i - 1] - 1;
    if (gap > widest && 10 * std::max(error[i - 1], error[i]) <= value[i] - value[i - 1]) {
      widest = gap;
      middle = std::sqrt(value[i] * value[i - 1]);
    }
  }
  return middle;
}

Proof prove(EigenProblem& problem, Pairs& pairs, double omega_sq, double tolerance, int max_restarts,
            int max_searches) {
  Proof proof;
  proof.omega_sq = omega_sq;
  proof.sturm_count = problem.n_below(omega_sq);
  if (!proof.sturm_count) return proof;
  for (int search = 1;; ++search) {
    proof.n_found_below = (pairs.value.array() < omega_sq).count();
    const long missing = *proof.sturm_count - problem.n_rigid() - proof.n_found_below;
    proof.none_missing = missing == 0;
    if (missing <= 0 || search > max_searches) return proof;
    Pairs more = problem.lowest(missing, tolerance, max_restarts, pairs.vector, search);
    const Eigen::Index n_below = (more.value.array() < omega_sq).count();
    if (n_below == 0) return proof;
    more.value.conservativeResize(n_below);
    more.vector.conservativeResize(more.vector.rows(), n_below);
    more.converged = true;
    pairs = merged(pairs, more);
  }
}

}  // namespace klang::modal::detail
