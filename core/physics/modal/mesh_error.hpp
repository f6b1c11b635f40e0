#pragma once
#include <Eigen/Core>

#include "core/physics/modal/modal_model.hpp"
#include "core/physics/solid/assembly.hpp"

namespace klang::modal {

/// Estimate of (f_h - f) / f >= 0 of each mode (n_modes): how far above the exact frequencies those of the mesh lie
/// (elements of a conforming space give upper bounds), from one mesh alone.
///
/// The elements of the next degree add W to the space V of the mesh (solid/detail/enriched_space.hpp). With the
/// residual r(w) = a(u_h, w) - omega_h^2 m(u_h, w) of a mode on W,
///   omega_h^2 - omega^2 = r S^-1 r approximately,  S = K_WW - K_WV K_VV^-1 K_VW,
/// by steps of conjugate gradients (block Jacobi) on S, 3 to 6 for compact elements, 12 for flat ones: until the last
/// adds 3 % and a tenth is left to come, which is added. Keeping K_VV whole
/// is what makes it right for bending of thin walls too.
///
/// Measured against exact frequencies of ball, block, tile and thin tubes (quadratic elements, relative errors 8e-7 to
/// 1e-1) 0.86 to 1.17 times the true error; 0.65 where a clamped edge makes the stress singular,
/// and 0.64 to 0.95 of flat plates of one layer (1 : 100, errors 5e-4 to 5e-2). Above 3 % it may be a third of the truth. Not seen: the
/// distance between the mesh's surface and the true one. That is 5 to 12 % of the error of a ball of curved quadratic
/// elements, but half of it with linear elements on a curved body. Modes whose order differs from the exact one's
/// still get their own error, but under the index that they have on the mesh.
///
/// Factors the stiffness matrix anew; EigenOptions::estimate_mesh_error does the same with the factor at hand.
/// @param model      its mesh, material and modes as solve_modes() returned them
/// @param assembled  the matrices that they come from
Eigen::VectorXd estimate_frequency_error(const ModalModel& model, const solid::AssembledSolid& assembled);

}  // namespace klang::modal
