#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/foundation/config/fields.hpp"

namespace klang::fracture {

/// A plane piece of a crack between two pieces of a body.
struct CrackFace {
  int a = 0, b = 0;  ///< pieces
  double area_m2 = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of length 1, out of a
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d stress_a_pa = Eigen::Matrix3d::Zero();  ///< Cauchy, of the element on a's side before it broke
  Eigen::Matrix3d stress_b_pa = Eigen::Matrix3d::Zero();
};

struct PieceMass {
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre
};

/// The motion of the body that broke, just before.
struct ParentMotion {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
};

enum class TractionSides {
  kMean,  ///< of the two elements: the same for both pieces, so momentum is kept (errata 59)
  kOwn    ///< each piece that of its own element, as SB's eq. 4 says
};
enum class TractionSign {
  kReleased,  ///< -P n with n out of the piece: what the neighbour no longer holds (errata 43)
  kPrinted    ///< +P n, SB's eq. 4: pulls pieces under tension together
};
enum class ArmFrom {
  kPiece,  ///< the piece's own centre (errata 42)
  kParent  ///< the centre of the body that broke, as SB says: angular momentum is not kept
};

/// Which of SB 3.3 is mended. paper_form() is the print.
struct ImpulseForm {
  TractionSides sides = TractionSides::kMean;
  TractionSign sign = TractionSign::kReleased;
  ArmFrom arm = ArmFrom::kPiece;
  /// A crack under compression does not open: its normal traction pushes nobody, and of the traction along it only what
  /// friction does not hold is released, (1 - friction |p| / |t|) t.
  bool closed_cracks_hold = true;
  double crack_friction = 0.4;
};
ImpulseForm paper_form();

/// Force and moment on each piece while cracks open; times tau they are its impulse.
struct PieceForce {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();     ///< S
  Eigen::Vector3d moment_n_m = Eigen::Vector3d::Zero();  ///< J, about the piece's centre (or the parent's: ImpulseForm)
};

/// On piece a where its crack face is; b gets the opposite.
struct CrackImpulse {
  int a = 0, b = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d on_a_n_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d on_b_n_s = Eigen::Vector3d::Zero();
};

enum class PushStatus {
  kNotRun,
  kPushed,
  kNothingTensile,  ///< all cracks are held shut: no push, the energy stays as vibration
  kNoEnergy         ///< nothing was left for motion
};
constexpr auto words_of(PushStatus) {
  return std::array{Word{PushStatus::kNotRun, "not_run"}, Word{PushStatus::kPushed, "pushed"},
                    Word{PushStatus::kNothingTensile, "nothing_tensile"}, Word{PushStatus::kNoEnergy, "no_energy"}};
}

struct FractureImpulses {
  PushStatus status = PushStatus::kNotRun;
  double tau_s = 0.0;                                   ///< how long the crack's forces act
  std::vector<PieceForce> forces;                       ///< by piece
  std::vector<Eigen::Vector3d> velocity_m_s;            ///< by piece: what its centre gains
  std::vector<Eigen::Vector3d> angular_velocity_rad_s;  ///< by piece: what it gains
  std::vector<CrackImpulse> impulses;                   ///< by crack face that pushes
  double kinetic_j = 0.0;  ///< of rigid motion, gained (with ArmFrom::kParent: as the print books it)
  double modal_j = 0.0;    ///< of vibration, gained
};

/// Forces of each crack face on both of its pieces, summed.
/// t = -P n_a on a and +P n_a on b with P the mean stress of the two sides.
std::vector<PieceForce> crack_forces(const std::vector<CrackFace>& faces, const std::vector<PieceMass>& pieces,
                                     const ImpulseForm& form, const ParentMotion& motion = {});

/// SB 3.3: forces s = a P n of released stress act for a time tau, v+ = v- + tau S/m, w+ = w- + tau I^-1 J, such that kinetic energy grows by
/// energy_j: tau is the positive root of 1/2 D tau^2 + L tau = energy_j with
///   D = sum (|S|^2/m + J . I^-1 J) + modal_g_sq,  L = sum (S . v- + J . w-),
/// v-, w- those of the rigid body before. With the defaults L = 0 (forces are pairs at one place), tau = sqrt(2 energy_j / D).
/// @param modal_g_sq  sum over pieces and modes of (U_k^T s)^2 [N^2/kg] for impulses that also excite modes at once (errata 52); 0
///        where they are played over the crack's duration
FractureImpulses fracture_impulses(const std::vector<CrackFace>& faces, const std::vector<PieceMass>& pieces,
                                   double energy_j, const ImpulseForm& form = {}, const ParentMotion& motion = {},
                                   double modal_g_sq = 0.0);

/// Speed of Rayleigh's waves over that of shear waves, the root of x^3 - 8 x^2 + (24 - 16 q) x - 16 (1 - q) = 0, x = (c_R/c_s)^2,
/// q = (1 - 2 nu)/(2 (1 - nu)), that lies in (0, 1).
/// @throws InputError unless -1 < nu < 0.5
double rayleigh_speed_ratio(double poissons_ratio);

}  // namespace klang::fracture
