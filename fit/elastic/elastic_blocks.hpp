#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/physics/modal/eigen_solver.hpp"
#include "fit/elastic/reduced_spectrum.hpp"

namespace klang::fit::detail {

struct BlockMatrices {
  Eigen::MatrixXd stiffness_lambda, stiffness_mu, mass;  // mass: unit density
};

/// The lowest elastic modes of a body: as a result, and as vectors of each block.
struct BlockModes {
  modal::EigenResult result;             ///< all blocks together, ascending
  Eigen::VectorXd relative_error;        ///< of each mode's frequency by its mesh, >= 0, corrections made
  std::vector<Eigen::MatrixXd> vectors;  ///< by block: n_dofs x n, a few modes more than the result has
  /// By block, for each vector: by how much the matrices' frequency is too high (relative); empty: nothing. The result's
  /// frequencies are corrected.
  std::vector<Eigen::VectorXd> correction;
};

/// One discretised body as blocks that do not couple, whatever the material: tetrahedra make one block, a free body of
/// revolution one for each harmonic, whose modes above harmonic 0 come in pairs, a box one for each set of parities.
class ElasticBlocks {
 public:
  virtual ~ElasticBlocks() = default;
  virtual std::size_t n_blocks() const = 0;
  virtual int multiplicity(std::size_t block) const = 0;
  virtual double volume_m3() const = 0;
  virtual BlockModes lowest(const solid::Material& material, const ReducedSpectrumOptions& options, bool prove) = 0;
  /// The lowest counts[b] modes of each block.
  virtual std::vector<Eigen::MatrixXd> vectors(const solid::Material& material, const std::vector<int>& counts) = 0;
  virtual Eigen::MatrixXd projected_mass(std::size_t block, const Eigen::MatrixXd& basis) const = 0;
  /// Rigid motions that a basis has to hold beside the modes of bodies with other dimensions (n_dofs x n): where these move the centre
  /// of mass their modes are not free of them, and what is left of a rigid motion would look like a soft mode. None where symmetry
  /// keeps the modes of every dimension apart from them.
  virtual Eigen::MatrixXd rigid_motions(std::size_t /*block*/) const { return {}; }
  virtual BlockMatrices projected(std::size_t block, const Eigen::MatrixXd& basis) const = 0;
};

/// The section of a body of revolution where there is one and nothing holds it, the polynomials of a box that is free or held at a face,
/// else tetrahedra.
/// @param like_blocks  as many as this (0: as needed), so that bodies of changed dimensions go together
std::unique_ptr<ElasticBlocks> elastic_blocks(const Specimen& specimen, const SpecimenBody& body,
                                              std::size_t like_blocks = 0, Monitor& monitor = silent_monitor());

}  // namespace klang::fit::detail
