#include "core/sound/scene/detail/held_damping.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "core/sound/scene/detail/modal_island.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kStill = 1e-6;  ///< of the body's lowest frequency, squared: a motion that no spring drives back

Matrix3d crossed(const Vector3d& r) {
  Matrix3d by;
  by << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return by;
}

}  // namespace

HeldDamping::HeldDamping(const ModalBody& body, const std::vector<ModalPlace>& held,
                         const std::function<double(double)>& decay_per_s)
    : turning_(Matrix3d(body.inertia.inverse()).llt().matrixL()) {
  const Index n_modes = body.modes.z.size(), n_held = static_cast<Index>(held.size());
  MatrixXd rows(3 * n_held, 6 + n_modes);
  for (Index i = 0; i < n_held; ++i) {
    const ModalPlace& place = held[static_cast<std::size_t>(i)];
    rows.middleRows(3 * i, 3) << Matrix3d::Identity() / std::sqrt(body.mass_kg), -crossed(place.rest_m) * turning_,
        place.shape;
  }
  VectorXd stiff = VectorXd::Zero(6 + n_modes);
  stiff.tail(n_modes) = body.modes.lambda();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> mobile(rows.transpose() * rows);
  const Index n_fixed = (mobile.eigenvalues().array() > kDependentHolds * mobile.eigenvalues().maxCoeff()).count();
  if (n_fixed == 6 + n_modes) {  // holds keep all of its motions
    motions_.resize(6 + n_modes, 0);
    follow_ = MatrixXd::Zero(6 + n_modes, 3 * n_held);
    return;
  }
  const MatrixXd left = mobile.eigenvectors().leftCols(6 + n_modes - n_fixed);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> swing(left.transpose() * stiff.asDiagonal() * left);
  const double still = n_modes > 0 ? kStill * body.modes.lambda().minCoeff() : HUGE_VAL;
  const Index n_swing = (swing.eigenvalues().array() > still).count();
  motions_ = left * swing.eigenvectors().rightCols(n_swing);
  omega_ = swing.eigenvalues().tail(n_swing).cwiseSqrt();
  decay_per_s_ = omega_.unaryExpr(decay_per_s);
  // Of least motion first, then of least strain.
  const auto fixed = mobile.eigenvectors().rightCols(n_fixed);
  follow_ =
      fixed * (mobile.eigenvalues().tail(n_fixed).cwiseInverse().asDiagonal() * (fixed.transpose() * rows.transpose()));
  follow_ -= motions_ *
             (omega_.cwiseAbs2().cwiseInverse().asDiagonal() * (motions_.transpose() * (stiff.asDiagonal() * follow_)));
}

void HeldDamping::apply(ModalBody& body, double dt, const VectorXd& held_m_s) const {
  const Index n_modes = body.modes.z.size();
  const double root = std::sqrt(body.mass_kg);
  const Eigen::Quaterniond back = body.turn.conjugate();
  VectorXd speed(6 + n_modes);
  speed << root * (back * body.velocity_m_s), turning_.transpose() * (back * body.angular_momentum), body.modes.v;
  VectorXd own_held(held_m_s.size());
  for (Index i = 0; i < held_m_s.size(); i += 3) own_held.segment<3>(i) = back * Vector3d(held_m_s.segment<3>(i));
  const VectorXd before = motions_.transpose() * speed;
  const VectorXd relative = before - motions_.transpose() * (follow_ * own_held);
  const Eigen::ArrayXd kept = (-2.0 * dt * decay_per_s_.array()).exp();  // of speeds: a swing has them half of the time
  const VectorXd change = (kept - 1.0) * relative.array();
  speed += motions_ * change;
  body.velocity_m_s = body.turn * Vector3d(speed.head<3>() / root);
  body.angular_momentum = body.turn * Vector3d(turning_.transpose().inverse() * speed.segment<3>(3));
  body.modes.v = speed.tail(n_modes);
  const double lost_j = 0.5 * (relative.array().square() * (1.0 - kept.square())).sum();
  body.ledger.viscous_j += lost_j;
  // In the frame of holds that move, what decays pushes the body as a whole: they bear that.
  body.ledger.work_j += lost_j + change.dot(before + 0.5 * change);
}

}  // namespace klang::scene::detail
