#include "core/physics/fracture/impulse/fracture_impulse.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;

constexpr double kNothing = 1e-12;  // of what the forces would be if closed cracks pushed

/// Forces of one face on its two pieces.
struct FaceForces {
  Vector3d on_a = Vector3d::Zero(), on_b = Vector3d::Zero();
};

/// What of a traction P n is released.
Vector3d released(const Vector3d& traction, const Vector3d& normal, const ImpulseForm& form) {
  const double tension = traction.dot(normal);
  if (!form.closed_cracks_hold || tension >= 0.0) return traction;
  const Vector3d along = traction - tension * normal;
  const double size = along.norm(), held = form.crack_friction * -tension;
  return size > held ? Vector3d((1.0 - held / size) * along) : Vector3d(Vector3d::Zero());
}

FaceForces forces_of(const CrackFace& face, const ImpulseForm& form) {
  Eigen::Matrix3d of_a = face.stress_a_pa, of_b = face.stress_b_pa;
  if (form.sides == TractionSides::kMean) of_a = of_b = 0.5 * (face.stress_a_pa + face.stress_b_pa);
  const double sign = form.sign == TractionSign::kReleased ? -1.0 : 1.0;
  return {sign * face.area_m2 * released(of_a * face.normal, face.normal, form),
          -sign * face.area_m2 * released(of_b * face.normal, face.normal, form)};
}

/// sum |S|^2/m + J . I^-1 J
double response(const std::vector<PieceForce>& forces, const std::vector<PieceMass>& pieces) {
  double sum = 0.0;
  for (std::size_t d = 0; d < pieces.size(); ++d)
    sum += forces[d].force_n.squaredNorm() / pieces[d].mass_kg +
           forces[d].moment_n_m.dot(pieces[d].inertia_kg_m2.ldlt().solve(forces[d].moment_n_m));
  return sum;
}

}  // namespace

ImpulseForm paper_form() { return {TractionSides::kOwn, TractionSign::kPrinted, ArmFrom::kParent, false, 0.0}; }

std::vector<PieceForce> crack_forces(const std::vector<CrackFace>& faces, const std::vector<PieceMass>& pieces,
                                     const ImpulseForm& form, const ParentMotion& motion) {
  std::vector<PieceForce> forces(pieces.size());
  const auto add = [&](int piece, const Vector3d& force, const Vector3d& at) {
    const Vector3d& from = form.arm == ArmFrom::kPiece ? pieces[piece].centre_m : motion.centre_m;
    forces[piece].force_n += force;
    forces[piece].moment_n_m += (at - from).cross(force);
  };
  for (const CrackFace& face : faces) {
    KLANG_CHECK(face.a >= 0 && face.b >= 0 && face.a < static_cast<int>(pieces.size()) &&
                    face.b < static_cast<int>(pieces.size()),
                "a crack lies between two of the pieces");
    const FaceForces both = forces_of(face, form);
    add(face.a, both.on_a, face.centre_m);
    add(face.b, both.on_b, face.centre_m);
  }
  return forces;
}

FractureImpulses fracture_impulses(const std::vector<CrackFace>& faces, const std::vector<PieceMass>& pieces,
                                   double energy_j, const ImpulseForm& form, const ParentMotion& motion,
                                   double modal_g_sq) {
  FractureImpulses out;
  out.forces = crack_forces(faces, pieces, form, motion);
  out.velocity_m_s.assign(pieces.size(), Vector3d::Zero());
  out.angular_velocity_rad_s.assign(pieces.size(), Vector3d::Zero());
  if (!(energy_j > 0.0)) {
    out.status = PushStatus::kNoEnergy;
    return out;
  }
  ImpulseForm open = form;
  open.closed_cracks_hold = false;
  const double rigid = response(out.forces, pieces);
  if (!(rigid > kNothing * response(crack_forces(faces, pieces, open, motion), pieces))) {
    out.status = PushStatus::kNothingTensile;
    return out;
  }
  double linear = 0.0;
  if (form.arm == ArmFrom::kParent || form.sides == TractionSides::kOwn)
    for (std::size_t d = 0; d < pieces.size(); ++d) {
      const Vector3d velocity =
          motion.velocity_m_s + motion.angular_velocity_rad_s.cross(pieces[d].centre_m - motion.centre_m);
      linear += out.forces[d].force_n.dot(velocity) + out.forces[d].moment_n_m.dot(motion.angular_velocity_rad_s);
    }
  const double all = rigid + modal_g_sq, root = std::sqrt(linear * linear + 2.0 * all * energy_j);
  // The positive root in the form that does not cancel.
  out.tau_s = linear > 0.0 ? 2.0 * energy_j / (root + linear) : (root - linear) / all;
  out.status = PushStatus::kPushed;
  for (std::size_t d = 0; d < pieces.size(); ++d) {
    out.velocity_m_s[d] = out.tau_s / pieces[d].mass_kg * out.forces[d].force_n;
    out.angular_velocity_rad_s[d] = out.tau_s * pieces[d].inertia_kg_m2.ldlt().solve(out.forces[d].moment_n_m);
  }
  for (const CrackFace& face : faces) {
    const FaceForces both = forces_of(face, form);
    if (both.on_a.isZero(0.0) && both.on_b.isZero(0.0)) continue;
    out.impulses.push_back({face.a, face.b, face.centre_m, out.tau_s * both.on_a, out.tau_s * both.on_b});
  }
  out.kinetic_j = 0.5 * rigid * out.tau_s * out.tau_s + linear * out.tau_s;
  out.modal_j = 0.5 * modal_g_sq * out.tau_s * out.tau_s;
  return out;
}

double rayleigh_speed_ratio(double poissons_ratio) {
  const double nu = checked_open("material", "poissons_ratio", poissons_ratio, -1.0, 0.5);
  const double q = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu));
  const auto f = [q](double x) { return ((x - 8.0) * x + 24.0 - 16.0 * q) * x - 16.0 * (1.0 - q); };
  double low = 0.0, high = 1.0;  // f(0) < 0 < f(1) = 1
  for (double middle = 0.5; low < middle && middle < high; middle = 0.5 * (low + high))
    (f(middle) < 0.0 ? low : high) = middle;
  return std::sqrt(high);
}

}  // namespace klang::fracture
