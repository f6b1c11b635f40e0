#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/physics/fracture/dynamic/crack_mesh.hpp"

namespace klang::fracture {

enum class CrackCriterion {
  kSeparation,  ///< B99's separation tensor, of the forces of tension and compression at a node
  kRankine      ///< largest principal stress, mean over the node's elements by volume
};
constexpr auto words_of(CrackCriterion) {
  return std::array{Word{CrackCriterion::kSeparation, "separation"}, Word{CrackCriterion::kRankine, "rankine"}};
}

/// What would part a node.
struct Separation {
  double force_n = 0.0;  ///< largest eigenvalue of the separation tensor [N]; 0: none is positive
  double stress_pa =
      0.0;  ///< force_n over a third of the area that the star shows along the normal; Rankine: the stress
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the plane, in the world
};

/// Eigenvalues of B99 (32), which the force formula (31) builds from the stress sigma = 2 PK2 split by its principal values (29)(30):
/// m(f+ sum) etc. with m(a) = a a^T/|a|. As printed the eigenvalue is a force (erratum 19), and a node on a face, whose star is
/// half a one, sees half of it, on an edge a quarter: it is divided by A/3 with A = sum |a . n| / 2 over the star's far faces, which in
/// uniaxial tension gives the stress itself, to round-off, at every node of any mesh (erratum 61). It is not Rankine's: an isotropic star
/// counts equibiaxial tension as pi/4, hydrostatic as 2/3 of uniaxial (erratum 62).
/// @param extra  viscous stress is counted too, of these constants [Pa s] (B99: total stress); nullptr: elastic stress alone
struct Viscosity {
  double phi_pa_s = 0.0, psi_pa_s = 0.0;
};
/// The split stresses of elements, each made once for all its corners: 20 of them meet at a node. Of places that do not change, and of one
/// material and viscosity.
class SplitStresses {
 public:
  explicit SplitStresses(int n_elements) : parts_(static_cast<std::size_t>(n_elements)) {}
  /// -V F sigma+ and -V F sigma-: what they make of a corner's gradient are its forces (31).
  struct Parts {
    Eigen::Matrix3d pulled, pressed;
    bool known = false;
  };
  Parts& of(int element) { return parts_[static_cast<std::size_t>(element)]; }

 private:
  std::vector<Parts> parts_;
};
/// @param split  of all elements; nullptr: none is kept
Separation separation_at(const CrackMesh& mesh, int node, const solid::Material& material, CrackCriterion criterion,
                         const Viscosity* extra = nullptr, SplitStresses* split = nullptr);

/// The same of several nodes, on all threads; each split stress is made once.
std::vector<Separation> separations_at(const CrackMesh& mesh, const std::vector<int>& nodes,
                                       const solid::Material& material, CrackCriterion criterion,
                                       const Viscosity* extra);

/// Direction of the largest principal Cauchy stress, elastic, of the mean of elements by their volume.
Eigen::Vector3d mean_normal(const CrackMesh& mesh, const std::vector<int>& elements, const solid::Material& material);

/// Elastic force through a face of an element: F S A, A the face's area in the rest shape along its normal [N, world].
Eigen::Vector3d pull_through(const CrackMesh& mesh, int element, const Eigen::Vector3d& rest_area_m2,
                             const solid::Material& material);

/// The tensor (32) itself.
Eigen::Matrix3d separation_tensor(const CrackMesh& mesh, int node, const solid::Material& material,
                                  const Viscosity* extra = nullptr, SplitStresses* split = nullptr);

/// A = sum |a . n| / 2 over the faces of the star that lie opposite to the node, as they are now.
double shown_area_m2(const CrackMesh& mesh, int node, const Eigen::Vector3d& normal);

}  // namespace klang::fracture
