#pragma once
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"

namespace klang::fracture::detail {

struct KernelConstants {
  double lambda_pa = 0.0, mu_pa = 0.0;    ///< Lame
  double phi_pa_s = 0.0, psi_pa_s = 0.0;  ///< of viscosity
  double gamma1 = 0.0, gamma2 = 0.0;
};

struct KernelSums {
  double elastic_j = 0.0;
  double dissipated_j = 0.0;       ///< by plastic flow in this call: mean stress of the step's two ends times the flow
  double least_det = 1.0;          ///< of F
  double largest_strain_sq = 0.0;  ///< squared norm of eps
};

/// Forces of all elements on their nodes (three numbers per node), added to what stands there: -V F S grad N with the true second
/// Piola-Kirchhoff stress S = (lambda tr(eps_e) I + 2 mu eps_e)/2 (errata 17); viscous ones with phi, psi and the strain's rate. Moves the
/// plastic strain. @param viscous  nullptr: none. @param stress_sq  nullptr, or |S|^2 of each element, kLanes per block
KernelSums element_forces(std::vector<ElementBlock>& blocks, const double* place, const double* velocity,
                          const KernelConstants& constants, double* elastic, double* viscous, double* stress_sq);

}  // namespace klang::fracture::detail
