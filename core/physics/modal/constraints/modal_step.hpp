#pragma once
#include <Eigen/Core>
#include <vector>

namespace klang::modal {

/// z'' + c z' + lambda z = g over one step, exactly.
///   impulse J at the start: z += J h, z' += J h';  constant force g: z += g H, z' += g h
/// h = (e^{w+ t} - e^{w- t})/(w+ - w-), H its integral. lambda = 0 and critical damping by their limits.
struct ModalStep {
  double z_z = 1.0, z_v = 0.0, v_z = 0.0, v_v = 1.0;  ///< free motion: z <- z_z z + z_v z', z' <- v_z z + v_v z'
  double h = 0.0;                                     ///< H03's S_ii; negative from omega dt = pi on
  double h_integral = 0.0;                            ///< never negative
};
/// @param lambda  >= 0 [1/s^2]. @param damping  >= 0 [1/s]
ModalStep modal_step(double lambda, double damping, double dt_s);

/// Rigid and elastic modes of a body, mass-normalised, with exact steps of one length.
class ModalState {
 public:
  /// @param lambda  0 for rigid modes
  ModalState(const Eigen::VectorXd& lambda, const Eigen::VectorXd& damping);
  void set_step(double dt_s);
  double step_s() const { return dt_s_; }

  Eigen::VectorXd z, v;
  Eigen::VectorXd free_z() const;  ///< at the end of the step without forces (erratum 12: not the z of now)
  Eigen::VectorXd free_v() const;
  Eigen::VectorXd h() const { return h_; }
  Eigen::VectorXd h_integral() const { return h_integral_; }
  /// One step under modal forces g that are constant over it.
  void advance(const Eigen::VectorXd& g);
  double energy_j() const;
  const Eigen::VectorXd& lambda() const { return lambda_; }
  const Eigen::VectorXd& damping() const { return damping_; }

 private:
  Eigen::VectorXd lambda_, damping_, z_z_, z_v_, v_z_, v_v_, h_, h_integral_;
  double dt_s_ = 0.0;
};

/// Forces at constrained places that bring W z to the target at the end of the step, constant over it: f = (W H W^T)^+ (d* - W z_free).
/// H03 (15) as printed uses the z of now and a force with another unit (erratum 12). More constraints than modes: least squares.
Eigen::VectorXd position_forces(const ModalState& state, const Eigen::MatrixXd& w, const Eigen::VectorXd& target_m);
/// The same for velocities: f = (W h W^T)^+ (u* - W v_free), H03 (14) for forces that last the step.
Eigen::VectorXd velocity_forces(const ModalState& state, const Eigen::MatrixXd& w, const Eigen::VectorXd& target_m_s);
/// Forces now that give these accelerations: f = (W W^T)^+ (a* - W (g - lambda z - c v)), H03 (13). @param g  modal forces from elsewhere
Eigen::VectorXd acceleration_forces(const ModalState& state, const Eigen::MatrixXd& w, const Eigen::VectorXd& target,
                                    const Eigen::VectorXd& g);
/// H03's impulse form: an impulse dt f at the start of the step brings W z to the target: f = (1/dt) (W S W^T)^+ (d* - W z_free).
Eigen::VectorXd position_impulse_forces(const ModalState& state, const Eigen::MatrixXd& w,
                                        const Eigen::VectorXd& target_m);

/// Which modes a step of H03 keeps: those whose largest static deflection under a unit force at one node, max_i |w_i|^2 / lambda, is
/// above the limit. The printed sum over nodes grows with the mesh (erratum 73).
/// @param nodes  one row of three columns per node and axis: (3 n) x modes, mass-normalised
std::vector<int> kept_modes(const Eigen::MatrixXd& shapes, const Eigen::VectorXd& lambda, double least_m_per_n);

}  // namespace klang::modal
