#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/dynamic/plasticity.hpp"

namespace klang::fracture {

/// Elements stand in blocks, field by field, so that as many are computed at once.
inline constexpr int kLanes = 8;
struct alignas(64) ElementBlock {
  double beta[9][kLanes];     ///< rows: gradients of the shape functions of corners 1, 2, 3 in the rest shape [1/m]
  double plastic[6][kLanes];  ///< eps_p, doubled measure
  double elastic[6][kLanes];  ///< eps - eps_p of the last step, where it flows
  double volume_m3[kLanes];   ///< at rest; 0: no element
  double damped_m3[kLanes];   ///< volume times the share of the viscosity that the element has
  int node[4][kLanes];
};

/// A face between two elements that a crack has parted, in the rest shape; one per pair.
struct PartedFace {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();  ///< normal: from - to +
  double area_m2 = 0.0, time_s = 0.0;
  std::array<int, 2> elements = {0, 0};              ///< of the - and the + side when it parted
  Eigen::Vector3d pull_n = Eigen::Vector3d::Zero();  ///< of the + side on the - side, in the world, that ended then
};

/// Linear tetrahedra that can be cut: edges are bisected in all elements around them, nodes doubled. Rest shape, places,
/// velocities and plastic strain belong together and stay what they were under every change. Lumped mass rho V / 4.
///
/// A bisection at x_m = (1-t) x_a + t x_b keeps mass, centre, momentum, volume and elastic energy. Kinetic energy of lumped masses falls by
/// rho V t (1-t) |v_a - v_b|^2 / 8 per element around the edge, because the new node has the mean velocity: lost_j() sums it up.
class CrackMesh {
 public:
  /// @throws InputError for an element that is inverted or flat, or none; a mesh with nodes in the middle of another element's edge or
  ///         face (hanging nodes)
  CrackMesh(const mesh::TetMesh& mesh, double density_kg_m3);

  int n_nodes() const { return static_cast<int>(rest_m.size()); }
  int n_elements() const { return n_elements_; }
  std::array<int, 4> nodes_of(int element) const;
  const std::vector<int>& star(int node) const { return stars_[static_cast<std::size_t>(node)]; }  ///< ascending
  Eigen::Matrix3d beta_of(int element) const;  ///< rows as in ElementBlock
  double volume_m3(int element) const;
  Sym plastic_of(int element) const;
  void set_plastic(int element, const Sym& strain);
  /// Share of the viscosity that the element has; 1 when it is made.
  void set_damping_share(int element, double share);
  /// F = sum of places times gradients.
  Eigen::Matrix3d gradient_of(int element) const;

  /// Puts a node on the edge a-b at (1-t) a + t b, in every element around the edge. Returns it.
  int bisect_edge(int a, int b, double t);
  /// Doubles a node: the elements of its star that are named get the copy, which is returned.
  int double_node(int node, const std::vector<int>& elements);
  /// One copy of the node for each part of its star that hangs together by faces. Returns the copies.
  std::vector<int> part_node(int node);
  /// Parts of the body that hang together by nodes: a number from 0 for each element, in the order of their first elements.
  std::vector<int> fragments(int& n_fragments) const;

  double density_kg_m3() const { return density_kg_m3_; }
  double mass_kg() const;
  double lost_j() const { return lost_j_; }
  int made_of(int node) const {
    return made_of_[static_cast<std::size_t>(node)];
  }                                             ///< an older node; an old one: itself
  int n_changes() const { return n_changes_; }  ///< grows with each change

  std::vector<Eigen::Vector3d> rest_m, place_m, velocity_m_s;  ///< of nodes
  std::vector<double> mass_kg_of;                              ///< of nodes
  std::vector<int> held;                                       ///< of nodes: number of what holds it, or -1
  std::vector<ElementBlock> blocks;

 private:
  int add_node_like(int node);
  int add_element();
  void set_element(int element, const std::array<int, 4>& nodes, const Eigen::Matrix3d& beta, double volume_m3);
  ElementBlock& block(int element) { return blocks[static_cast<std::size_t>(element / kLanes)]; }
  const ElementBlock& block(int element) const { return blocks[static_cast<std::size_t>(element / kLanes)]; }

  double density_kg_m3_ = 0.0, lost_j_ = 0.0;
  int n_elements_ = 0, n_changes_ = 0;
  std::vector<std::vector<int>> stars_;
  std::vector<int> made_of_;
};

}  // namespace klang::fracture
