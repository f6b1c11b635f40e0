#include "core/foundation/la/gmres.hpp"

#include <cmath>
#include <complex>
#include <vector>

#include "core/foundation/base/check.hpp"

namespace klang::la {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

/// The Krylov space of one column: orthonormal vectors, the triangle that rotations make of the Hessenberg matrix.
class Space {
 public:
  explicit Space(const VectorXcd& residual) : start_(residual.norm()) {
    vectors_.resize(residual.size(), 16);
    if (start_ > 0.0) vectors_.col(0) = residual / start_;
    right_ = VectorXcd::Constant(1, start_);
  }
  double residual() const { return std::abs(right_[right_.size() - 1]); }
  bool grows() const { return start_ > 0.0 && !closed_; }
  VectorXcd last() const { return vectors_.col(n_vectors_ - 1); }

  /// With w = A M^-1 last().
  void add(VectorXcd w) {
    const Index k = n_vectors_;
    const auto all = vectors_.leftCols(k);
    VectorXcd h = VectorXcd::Zero(k + 1);
    const double before = w.norm();
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough
      const VectorXcd part = all.adjoint() * w;
      w -= all * part;
      h.head(k) += part;
    }
    const double norm = w.norm();
    h[k] = norm;
    for (Index i = 0; i + 1 < k; ++i) rotate(h, i);
    rotation_.push_back(makes_zero(h[k - 1], norm));
    rotate(h, k - 1);
    triangle_.conservativeResizeLike(MatrixXcd::Zero(k, k));
    triangle_.col(k - 1) = h.head(k);
    right_.conservativeResize(k + 1);
    right_[k] = 0.0;
    rotate(right_, k - 1);
    closed_ = !(norm > 1e-15 * before);
    if (closed_) return;
    if (vectors_.cols() == k) vectors_.conservativeResize(Eigen::NoChange, 2 * k);
    vectors_.col(n_vectors_++) = w / norm;
  }

  VectorXcd solution() const {
    const Index k = triangle_.cols();
    const VectorXcd y = triangle_.triangularView<Eigen::Upper>().solve(right_.head(k));
    return vectors_.leftCols(k) * y;
  }
  bool empty() const { return triangle_.cols() == 0; }

 private:
  struct Rotation {
    double c;
    Complex s;
  };
  static Rotation makes_zero(Complex a, double b) {
    const double r = std::hypot(std::abs(a), b);
    if (std::abs(a) == 0.0) return {0.0, 1.0};
    return {std::abs(a) / r, a / std::abs(a) * (b / r)};
  }
  void rotate(VectorXcd& v, Index i) const {
    const Rotation& g = rotation_[static_cast<std::size_t>(i)];
    const Complex a = v[i], b = v[i + 1];
    v[i] = g.c * a + g.s * b;
    v[i + 1] = g.c * b - std::conj(g.s) * a;
  }

  double start_;
  bool closed_ = false;
  Index n_vectors_ = 1;
  MatrixXcd vectors_, triangle_;
  VectorXcd right_;
  std::vector<Rotation> rotation_;
};

struct Method {
  const Product &matrix, &inverse;
  int max_steps;
  const std::function<bool()>& stopped;
};

/// One start of all columns: how x is to change.
MatrixXcd step(const Method& method, const MatrixXcd& residual, const Eigen::VectorXd& wanted, int& n_products) {
  std::vector<Space> spaces;
  for (Index c = 0; c < residual.cols(); ++c) spaces.emplace_back(residual.col(c));
  for (int k = 0; k < method.max_steps; ++k) {
    std::vector<Index> open;
    for (Index c = 0; c < residual.cols(); ++c) {
      const Space& space = spaces[static_cast<std::size_t>(c)];
      if (space.grows() && space.residual() > wanted[c]) open.push_back(c);
    }
    if (open.empty() || (method.stopped && method.stopped())) break;
    MatrixXcd v(residual.rows(), static_cast<Index>(open.size()));
    for (std::size_t i = 0; i < open.size(); ++i)
      v.col(static_cast<Index>(i)) = spaces[static_cast<std::size_t>(open[i])].last();
    const MatrixXcd w = method.matrix(method.inverse(v));
    ++n_products;
    for (std::size_t i = 0; i < open.size(); ++i)
      spaces[static_cast<std::size_t>(open[i])].add(w.col(static_cast<Index>(i)));
  }
  MatrixXcd change = MatrixXcd::Zero(residual.rows(), residual.cols());
  for (Index c = 0; c < residual.cols(); ++c)
    if (const Space& space = spaces[static_cast<std::size_t>(c)]; !space.empty()) change.col(c) = space.solution();
  return method.inverse(change);
}

}  // namespace

KrylovSolution gmres(const Product& matrix, const Product& inverse, const MatrixXcd& b, double tolerance, int max_steps,
                     const std::function<bool()>& stopped) {
  KLANG_CHECK(tolerance > 0.0 && max_steps > 0, "a tolerance and steps");
  KrylovSolution result;
  result.x = MatrixXcd::Zero(b.rows(), b.cols());
  const Eigen::VectorXd size = b.colwise().norm().transpose();
  MatrixXcd residual = b;
  double before = HUGE_VAL;
  for (;;) {
    double worst = 0.0;
    for (Index c = 0; c < b.cols(); ++c)
      if (size[c] > 0.0) worst = std::max(worst, residual.col(c).norm() / size[c]);
    result.relative_residual = worst;
    result.solved = worst <= tolerance;
    if (result.solved || !(worst < 0.5 * before) || (stopped && stopped())) return result;
    before = worst;
    result.x += step({matrix, inverse, max_steps, stopped}, residual, 0.5 * tolerance * size, result.n_products);
    residual = b - matrix(result.x);
    ++result.n_products;
  }
}

}  // namespace klang::la
