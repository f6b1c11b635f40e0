#pragma once
#include <Eigen/Dense>

namespace klang::rigid::detail {

/// Anderson's mixing of an iteration x -> g(x) (Anderson 1965; as Walker and Ni 2011, type II): of the last outcomes the combination
/// whose changes, taken as linear, cancel best. Begins anew where a change is more than twice the one before it.
class Mixing {
 public:
  /// @param weights  of the components of x in the size of a change
  explicit Mixing(Eigen::VectorXd weights);

  /// @param from, to  x and g(x)
  /// @return          where to go on from; `to` as long as there is nothing to combine
  const Eigen::VectorXd& next(const Eigen::VectorXd& from, const Eigen::VectorXd& to);

 private:
  static constexpr Eigen::Index kDepth = 12;
  void remember(const Eigen::VectorXd& to);

  Eigen::VectorXd weights_, change_, last_change_, last_to_, mixed_;
  Eigen::MatrixXd changes_, outcomes_;  // differences of one call to the next, kDepth columns in a ring
  Eigen::Matrix<double, kDepth, kDepth> products_;
  Eigen::Index n_kept_ = 0, newest_ = -1;
  double last_size_sq_ = 0.0;
  bool has_last_ = false;
};

}  // namespace klang::rigid::detail
