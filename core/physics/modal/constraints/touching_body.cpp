#include "core/physics/modal/constraints/touching_body.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::modal {

TouchingBody::TouchingBody(ModalState state, Eigen::MatrixXd w, Eigen::VectorXd gap0_m, double restitution,
                           Eigen::VectorXd residual_m_per_n)
    : state_(std::move(state)),
      w_(std::move(w)),
      gap0_m_(std::move(gap0_m)),
      compliance_(std::move(residual_m_per_n)),
      restitution_(restitution),
      touching_(static_cast<std::size_t>(gap0_m_.size()), false) {
  checked("modal contact", "restitution", restitution_, 0.0, 1.0);
  if (compliance_.size() > 0 && !((compliance_.array() > 0.0).all()))
    throw InputError("modal contact", "residual flexibility is not positive", to_text(compliance_.minCoeff()));
}

double TouchingBody::spring_j() const {
  if (compliance_.size() == 0) return 0.0;
  const Eigen::VectorXd in = (-gaps_m()).cwiseMax(0.0);
  return 0.5 * in.dot(in.cwiseQuotient(compliance_));
}

void TouchingBody::shock(const std::vector<int>& places) {
  const Eigen::MatrixXd w = w_(places, Eigen::all);
  const Eigen::VectorXd approach = w * state_.v;
  const double before_j = state_.energy_j();
  const ContactForces solved = solve_lcp(w * w.transpose(), (1.0 + restitution_) * approach);
  residual_ = std::max(residual_, solved.residual);
  state_.v += w.transpose() * solved.forces;
  impulse_n_s_ += solved.forces.sum();
  shock_j_ += before_j - state_.energy_j();
  for (std::size_t k = 0; k < places.size(); ++k)
    touching_[static_cast<std::size_t>(places[k])] =
        restitution_ == 0.0 && solved.forces[static_cast<Eigen::Index>(k)] > 0.0;
}

Eigen::VectorXd TouchingBody::held_forces(const std::vector<int>& places) {
  const Eigen::MatrixXd w = w_(places, Eigen::all);
  const ContactForces solved = solve_lcp(w * state_.h().asDiagonal() * w.transpose(), w * state_.free_v());
  residual_ = std::max(residual_, solved.residual);
  return solved.forces;
}

/// Goes on by dt at most, up to the first touch or release; returns how far.
double TouchingBody::advance(double dt_s) {
  state_.set_step(dt_s);
  if (compliance_.size() > 0) {  // springs: kick, drift with the exact modes, kick
    const auto forces = [&]() -> Eigen::VectorXd { return (-gaps_m()).cwiseMax(0.0).cwiseQuotient(compliance_); };
    const Eigen::VectorXd first = forces();
    state_.v += 0.5 * dt_s * (w_.transpose() * first);
    state_.advance(Eigen::VectorXd::Zero(state_.z.size()));
    const Eigen::VectorXd last = forces();
    state_.v += 0.5 * dt_s * (w_.transpose() * last);
    impulse_n_s_ += 0.5 * dt_s * (first + last).sum();
    for (Eigen::Index i = 0; i < first.size(); ++i) {
      touching_[static_cast<std::size_t>(i)] = last[i] > 0.0;
      if (first[i] > 0.0 && !(last[i] > 0.0) && !first_release_s_) first_release_s_ = time_s_ + dt_s;
    }
    return dt_s;
  }
  std::vector<int> held;
  for (std::size_t i = 0; i < touching_.size(); ++i)
    if (touching_[i]) held.push_back(static_cast<int>(i));
  const ModalState start = state_;
  const Eigen::VectorXd now = gaps_m();
  const auto push = [&](double part_s) -> Eigen::VectorXd {
    state_ = start;
    state_.set_step(part_s);
    Eigen::VectorXd f = held.empty() ? Eigen::VectorXd() : held_forces(held);
    state_.advance(held.empty() ? Eigen::VectorXd(Eigen::VectorXd::Zero(state_.z.size()))
                                : Eigen::VectorXd(w_(held, Eigen::all).transpose() * f));
    return f;
  };
  Eigen::VectorXd f = push(dt_s);
  // The first place that comes down in this step.
  const auto down = [&] {
    const Eigen::VectorXd gaps = gaps_m();
    for (Eigen::Index i = 0; i < gaps.size(); ++i)
      if (!touching_[static_cast<std::size_t>(i)] && gaps[i] < 0.0 && now[i] >= gaps[i]) return true;
    return false;
  };
  double gone_s = dt_s;
  if (down()) {
    double low = 0.0, high = dt_s;
    for (int k = 0; k < 45; ++k) {
      const double middle = 0.5 * (low + high);
      f = push(middle);
      (down() ? high : low) = middle;
    }
    gone_s = high;
    f = push(high);
  }
  impulse_n_s_ += gone_s * f.sum();
  for (std::size_t k = 0; k < held.size(); ++k)
    if (!(f[static_cast<Eigen::Index>(k)] > 0.0)) {
      touching_[static_cast<std::size_t>(held[k])] = false;
      if (!first_release_s_) first_release_s_ = time_s_ + gone_s;
    }
  if (gone_s < dt_s) {
    std::vector<int> places;
    const Eigen::VectorXd gaps = gaps_m(), speeds = w_ * state_.v;
    for (Eigen::Index i = 0; i < gaps.size(); ++i)
      if (touching_[static_cast<std::size_t>(i)] || (gaps[i] <= 0.0 && speeds[i] < 0.0))
        places.push_back(static_cast<int>(i));
    shock(places);
  }
  return gone_s;
}

void TouchingBody::step(double dt_s) {
  double left_s = dt_s;
  for (int k = 0; k < 1000 && left_s > 1e-13 * dt_s; ++k) {
    const double gone_s = advance(left_s);
    time_s_ += gone_s;
    left_s -= gone_s;
  }
}

Rebound bar_on_wall(const BarOnWall& bar) {
  const int n = bar.n_modes + 1;
  Eigen::VectorXd lambda(n);
  Eigen::MatrixXd w(1, n);
  double kept = 0.0;
  for (int k = 0; k < n; ++k) {
    const double omega = k * kPi * bar.wave_speed_m_s / bar.length_m;
    lambda[k] = omega * omega;
    w(0, k) = std::sqrt((k == 0 ? 1.0 : 2.0) / bar.mass_kg) * 1.0;
    if (k > 0) kept += w(0, k) * w(0, k) / lambda[k];
  }
  ModalState state(lambda, Eigen::VectorXd::Zero(n));
  state.v[0] = -bar.speed_m_s * std::sqrt(bar.mass_kg);
  Eigen::VectorXd residual;
  // Static compliance of a free bar's end under inertia relief: L/(3 E A) = L^2/(3 m c^2).
  if (bar.residual_flexibility) {
    const double all = bar.length_m * bar.length_m / (3.0 * bar.mass_kg * bar.wave_speed_m_s * bar.wave_speed_m_s);
    residual = Eigen::VectorXd::Constant(1, all - kept);
  }
  const double start_j = state.energy_j(), transit_s = bar.length_m / bar.wave_speed_m_s,
               dt_s = transit_s / bar.steps_per_transit;
  TouchingBody body(std::move(state), w, Eigen::VectorXd::Zero(1), 0.0, residual);
  const auto end = [&] { return body.time_s() > 3.0 * transit_s; };
  while (!body.first_release_s() && !end()) body.step(dt_s);
  Rebound rebound;
  rebound.restitution = body.state().v[0] / (bar.speed_m_s * std::sqrt(bar.mass_kg));
  rebound.contact_s = body.first_release_s().value_or(0.0);
  rebound.energy_lost = body.shock_j() / start_j;
  rebound.residual = body.largest_residual();
  return rebound;
}

}  // namespace klang::modal
