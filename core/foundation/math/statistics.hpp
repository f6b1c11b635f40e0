#pragma once
#include <Eigen/Core>

namespace klang {

/// 97.5 % quantile of Student's t distribution: half the width of a 95 % interval in standard deviations.
/// @param degrees_of_freedom >= 1; not an integer is fine; infinity gives 1.959964
double student_t_975(double degrees_of_freedom);

/// A variance component s^2 that makes residuals agree with their standard deviations (Paule and Mandel 1982):
///   sum w_i r_i^2 / (sigma_i^2 + s^2) + prior_dof prior_s^2 / s^2 = sum w_i - n_parameters + prior_dof
/// The second term is the pull of a scaled inverse chi-squared prior: s is worth prior_dof observations beforehand.
/// @param residual  measured minus model, n
/// @param sigma     standard deviations, n, >= 0
/// @param weight    robust weights in [0, 1], n
/// @return s >= 0; prior_s where nothing is left to estimate it from (n <= n_parameters and prior_dof = 0)
double scatter_estimate(const Eigen::VectorXd& residual, const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                        double n_parameters, double prior_s, double prior_dof);

/// Median of a scatter s given residuals that are normal with variance sigma_i^2 + s^2, when nothing but its size is known
/// beforehand: s is half-Student with prior_dof and median prior_s, which is flat towards zero, so that good data may say
/// that there is no scatter at all. n_parameters are taken off the log-determinant in proportion (restricted likelihood).
/// @return prior_s without data; weights as in scatter_estimate
double scatter_median(const Eigen::VectorXd& residual, const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                      double n_parameters, double prior_s, double prior_dof);

}  // namespace klang
