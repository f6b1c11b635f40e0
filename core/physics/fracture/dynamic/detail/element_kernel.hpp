#pragma once
#include <cstddef>
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"

namespace klang::fracture::detail {

struct KernelConstants {
  double lambda_pa = 0.0, mu_pa = 0.0;    ///< Lame
  double phi_pa_s = 0.0, psi_pa_s = 0.0;  ///< of viscosity
  double gamma1 = 0.0, gamma2 = 0.0;
};

/// Forces of elements on their corners 1 to 3; on corner 0 minus their sum. For each block, corner and lane, by place_of(), three numbers and a 0 of
/// the elastic force, and where there is viscosity the same of the viscous one beside it, in one line of the cache.
class CornerForces {
 public:
  static constexpr int place_of(int lane) { return kLanes / 2 * (lane % 2) + lane / 2; }  ///< as shuffles leave them
  void resize(std::size_t n_blocks, bool is_damped) {
    is_damped_ = is_damped;
    lines_.resize(n_blocks * 3 * kLanes / (is_damped ? 1 : 2));
  }
  bool is_damped() const { return is_damped_; }
  int stride() const { return is_damped_ ? 8 : 4; }
  double* of_block(std::size_t i) { return lines_.front().of + i * 3 * kLanes * static_cast<std::size_t>(stride()); }
  const double* begin() const { return lines_.front().of; }

 private:
  struct alignas(64) Line {
    double of[8];
  };
  std::vector<Line> lines_;
  bool is_damped_ = false;
};

/// What a block's elements have, lane by lane.
struct alignas(64) BlockSums {
  double elastic_j[kLanes];
  double dissipated_j[kLanes];
  double least_det[kLanes];
  double largest_strain_sq[kLanes];
};

struct KernelSums {
  double elastic_j = 0.0;
  double dissipated_j = 0.0;       ///< by plastic flow in this call: mean stress of the step's two ends times the flow
  double least_det = 1.0;          ///< of F
  double largest_strain_sq = 0.0;  ///< squared norm of eps
};

/// Where the results of blocks go, one each.
struct KernelResults {
  double* forces = nullptr;  ///< of the first block, in CornerForces
  bool is_damped = false;
  BlockSums* sums = nullptr;
  double* stress_sq = nullptr;  ///< |S|^2, kLanes per block
};

/// Forces of elements on their nodes: -V F S grad N with the true second Piola-Kirchhoff stress S = (lambda tr(eps_e) I + 2 mu eps_e)/2
/// (errata 17); viscous ones with phi, psi and the strain's rate. Moves the plastic strain.
void element_forces(ElementBlock* blocks, std::size_t n_blocks, const double* place, const double* velocity,
                    const KernelConstants& constants, const KernelResults& results);

/// In the blocks' order, whoever computed them.
KernelSums sum_of(const std::vector<BlockSums>& blocks);

/// What adds up to the force on each node, in the elements' order: numbers in CornerForces, doubled, plus 1 where it counts negative
/// (at corner 0, which has three).
struct NodeTerms {
  std::vector<int> first;  ///< of each node, and the end
  std::vector<int> terms;
  void read(const CrackMesh& mesh);
};

/// Sums of the terms of nodes begin to end, three numbers per node, from 0. Each on its own: any cut into ranges gives the same.
/// @param viscous  where there is viscosity
void gather_forces(const NodeTerms& nodes, std::size_t begin, std::size_t end, const CornerForces& forces,
                   double* elastic, double* viscous);

}  // namespace klang::fracture::detail
