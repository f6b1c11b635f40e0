#pragma once
#include <Eigen/Core>

#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

/// Coefficients of the field turned with the body: the result's field at R x is the given one's at x, for coefficients about
/// the origin. Exact for any field of the basis (regular, singular, or plain harmonics), degree by degree:
///   M'_n^m = sum_m' D^n_mm'(R) M_n^m',  D^n_mm' = e^{-i m alpha} d^n_mm'(beta) e^{-i m' gamma}  (z-y-z Euler angles)
/// Wigner's d by the three-term recurrence in n, stable at any angle (Kostelec and Rockmore 2008, J. Fourier Anal. Appl. 14,
/// 145-179). Cost O(order^3).
/// @param rotation  proper and orthogonal to 1e-9; a reflection (det -1) is refused (errata 40: make V_I^T proper first)
/// @throws InputError
Eigen::VectorXcd rotated(const Eigen::VectorXcd& coefficients, const Eigen::Matrix3d& rotation);

/// The body, its centre and its field turned about the origin.
Multipole rotated(const Multipole& multipole, const Eigen::Matrix3d& rotation);

/// What has amplitude 1 when a mode is said to sound: decides the power law of the size.
enum class ModalUnit {
  kVelocity,      ///< the modal velocity (ModeTransfer): M -> gamma^-3/2 M
  kDisplacement,  ///< the modal coordinate (SB eq. 9): M -> gamma^-5/2 M
};

/// The same body gamma times as large, of the same material: x -> gamma x, omega -> omega / gamma, k -> k / gamma, shapes U ->
/// gamma^-3/2 U, kx unchanged, and M by the power of the unit. SB appendix E has ik (gamma^-1) dp/dn dS, with dp/dn ~ omega^2 U
/// (gamma^-7/2) for unit displacement, ~ omega U (gamma^-5/2) for unit velocity, dS (gamma^2).
/// Listening (errata 40): evaluate the result at the listener's true place; or the given multipole at place / gamma and then
/// multiply by the power of gamma. The two are identical; SB's v -> gamma R v is not.
Multipole with_size_factor(const Multipole& multipole, double gamma, ModalUnit unit);

}  // namespace klang::acoustics
