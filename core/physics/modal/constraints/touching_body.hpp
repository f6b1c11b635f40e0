#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/physics/modal/constraints/contact_problem.hpp"
#include "core/physics/modal/constraints/modal_step.hpp"

namespace klang::modal {

/// A modal body with places that may touch fixed obstacles: gap_i = gap0_i + w_i z >= 0.
///
/// At a touch an impulse stops the approach (restitution e of the material there), solved as an LCP over all places that touch: the energy that goes is the
/// shock of the kept modes (erratum 72). While it lasts the places are held at zero velocity by forces that are constant over each step, an LCP again; a place
/// that would be pulled lets go. With residual flexibility the discarded modes lie between place and obstacle as a spring of their static
/// compliance: there is no shock then, and no energy goes.
class TouchingBody {
 public:
  /// @param w        one row per place: its modes along the outward normal of the obstacle
  /// @param gap0_m   gaps at z = 0
  /// @param residual compliance of the discarded modes at each place [m/N]; empty: none
  TouchingBody(ModalState state, Eigen::MatrixXd w, Eigen::VectorXd gap0_m, double restitution,
               Eigen::VectorXd residual_m_per_n = {});

  /// One step. Touches within it are found to 1e-12 of its length, contacts that end within it too.
  void step(double dt_s);

  const ModalState& state() const { return state_; }
  ModalState& state() { return state_; }
  double time_s() const { return time_s_; }
  Eigen::VectorXd gaps_m() const { return gap0_m_ + w_ * state_.z; }
  const std::vector<bool>& touching() const { return touching_; }
  double shock_j() const { return shock_j_; }            ///< lost at touches
  double spring_j() const;                               ///< in the discarded modes
  double largest_residual() const { return residual_; }  ///< of all contact problems
  double impulse_n_s() const { return impulse_n_s_; }    ///< sum over places and time
  std::optional<double> first_release_s() const { return first_release_s_; }

 private:
  double advance(double dt_s);
  void shock(const std::vector<int>& places);
  Eigen::VectorXd held_forces(const std::vector<int>& places);

  ModalState state_;
  Eigen::MatrixXd w_;
  Eigen::VectorXd gap0_m_, compliance_;
  double restitution_ = 0.0, time_s_ = 0.0, shock_j_ = 0.0, residual_ = 0.0, impulse_n_s_ = 0.0;
  std::vector<bool> touching_;
  std::optional<double> first_release_s_;
};

/// A free elastic bar of length L, mass m and wave speed c, with its first n longitudinal modes, of which one end flies at a wall:
/// rigid mode 1/sqrt(m), mode k sqrt(2/m) at its ends, omega_k = k pi c/L.
struct BarOnWall {
  int n_modes = 1;
  double length_m = 1.0, mass_kg = 1.0, wave_speed_m_s = 1.0, speed_m_s = 1.0;
  bool residual_flexibility = false;
  int steps_per_transit = 20000;  ///< of L/c
};
struct Rebound {
  double restitution = 0.0;                   ///< of the centre when the end first lets go
  double contact_s = 0.0, energy_lost = 0.0;  ///< over that at the start
  double residual = 0.0;
};
Rebound bar_on_wall(const BarOnWall& bar);

}  // namespace klang::modal
