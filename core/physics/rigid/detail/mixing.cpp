#include "core/physics/rigid/detail/mixing.hpp"

#include <algorithm>
#include <utility>

namespace klang::rigid::detail {

Mixing::Mixing(Eigen::VectorXd weights)
    : weights_(std::move(weights)), changes_(weights_.size(), kDepth), outcomes_(weights_.size(), kDepth) {}

void Mixing::remember(const Eigen::VectorXd& to) {
  newest_ = (newest_ + 1) % kDepth;
  n_kept_ = std::min(n_kept_ + 1, kDepth);
  changes_.col(newest_) = change_ - last_change_;
  outcomes_.col(newest_) = to - last_to_;
  for (Eigen::Index i = 0; i < n_kept_; ++i)
    products_(i, newest_) = products_(newest_, i) = changes_.col(newest_).dot(changes_.col(i));
}

const Eigen::VectorXd& Mixing::next(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  change_ = weights_.cwiseProduct(to - from);
  const double size_sq = change_.squaredNorm();
  if (has_last_ && size_sq <= 4 * last_size_sq_) {
    remember(to);
  } else {
    n_kept_ = 0;
    newest_ = -1;
  }
  last_change_ = change_;
  last_to_ = mixed_ = to;
  last_size_sq_ = size_sq;
  has_last_ = true;
  if (n_kept_ == 0) return mixed_;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kDepth, kDepth>;
  constexpr double kRidge = 1e-10;  // changes that are multiples of each other have no combination
  Small products = products_.topLeftCorner(n_kept_, n_kept_);
  products.diagonal() *= 1 + kRidge;
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kDepth, 1> shares =
      products.ldlt().solve(changes_.leftCols(n_kept_).transpose() * change_);
  if (shares.allFinite()) mixed_ -= outcomes_.leftCols(n_kept_) * shares;
  return mixed_;
}

}  // namespace klang::rigid::detail
