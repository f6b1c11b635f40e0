#pragma once
#include <optional>
#include <set>
#include <vector>

#include "core/physics/fracture/dynamic/explicit_solid.hpp"
#include "core/physics/fracture/dynamic/separation.hpp"

namespace klang::fracture {

struct CrackOptions {
  std::optional<double> strength_pa;  ///< of the normalised separation tensor, or Rankine's
  std::optional<double>
      toughness_n;  ///< B99's tau: the tensor as printed, in newtons; depends on the mesh (erratum 64)
  CrackCriterion criterion = CrackCriterion::kSeparation;
  bool total_stress = false;      ///< B99: elastic and viscous; else elastic stress alone (erratum 67)
  double speed_limit = 0.6;       ///< of cracks, share of Rayleigh's wave speed; 0: none, as B99
  double snap = 0.25;             ///< of the shortest edge at the node: cuts nearer to a node go through it
  double snap_rad = 0.1;          ///< edges that lie this near to the plane are in it
  double smallest_height = 0.15;  ///< of the mean edge at the start: elements are not cut flatter
  /// While a crack runs in a piece, others start elsewhere in it only where the stress is this many times the strength: a body that is pulled
  /// evenly would else part at all its nodes at once, before the first crack has relieved it. 1: no such rule, as B99.
  double new_crack_factor = 1.3;
  /// Share of the present stress in the direction of a running crack; the rest is the direction it had. The plane of the first node, and of
  /// all in B99, is that of the present stress.
  double turning = 0.3;
  /// Direction from the mean stress of the elements within two edges of the node, and cuts that start from where the crack's plane is, not from the
  /// node that was taken into it: else each such node tilts the rest of the crack. false: B99's, the separation tensor's and the node's.
  bool follows_plane = true;

  void validate() const;  ///< InputError: neither or both of strength and toughness, not above 0
};

/// Opens cracks in a solid between its steps: B99 section 5, by bisecting edges.
///
/// A node whose separation exceeds the strength is parted by the plane through it: edges of its star that the plane cuts are
/// bisected in all elements around them, longest first; corners near the plane are taken to lie in it. Then every element of the star is on
/// one side. The node gets a copy for the upper side, and every node of the faces between the sides one for each part of its
/// star that still hangs together by faces: crack fronts, boundaries and what hung by an edge need no rules of their own.
class Cracker {
 public:
  Cracker(const ExplicitSolid& solid, const CrackOptions& options);

  /// Where it is time to look (a twentieth of what a pressure wave needs along a mean edge; B99: each step): looks at all nodes and parts those that are overstressed, worst first, one element wide. Returns how many.
  int open(ExplicitSolid& solid);
  const std::vector<PartedFace>& faces() const { return faces_; }
  int n_splits() const { return n_splits_; }
  /// The largest separation that was seen, over the strength.
  double highest() const { return highest_; }
  double last_over() const { return last_over_; }  ///< of the worst node that the last call parted

 private:
  /// What a crack that has come to a node goes on with, in rest coordinates: sums over the faces that parted there, weighted by their areas.
  struct Front {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double offset_m3 = 0.0, area_m2 = 0.0;  ///< of the crack's plane from the node along the normal
  };
  struct Plane {
    Eigen::Vector3d normal;
    double offset_m = 0.0;  ///< from the node, along the normal
  };
  /// What parts a node, in rest coordinates.
  Plane plane_at(const CrackMesh& mesh, int node, const Eigen::Vector3d& world_normal) const;
  void leave_front(const CrackMesh& mesh, int node, const Eigen::Vector3d& normal, double offset_m,
                   const std::vector<PartedFace>& faces, const std::vector<std::array<int, 2>>& far_nodes);
  void add_nodes(const CrackMesh& mesh, double now_s);
  bool part(ExplicitSolid& solid, int node, const Plane& plane);
  bool may_be_cut(const CrackMesh& mesh, const std::array<int, 2>& edge, double t, double shortest_m) const;

  CrackOptions options_;
  solid::Material material_;
  Viscosity viscosity_;
  double front_speed_m_s_ = 0.0, mean_edge_m_ = 0.0, smallest_height_m_ = 0.0, highest_ = 0.0, last_over_ = 0.0;
  int n_splits_ = 0;
  std::vector<double> ready_s_;        ///< of nodes: not before
  std::vector<char> on_crack_;         ///< of nodes
  std::vector<double> front_until_s_;  ///< of nodes that a crack has come to: how long it counts as its front; 0: none
  std::vector<Front> fronts_;          ///< of nodes
  std::vector<int> root_;              ///< of nodes: the first at that place
  std::vector<std::set<int>> slit_;    ///< of roots: corners of faces that parted there
  double running_s_ = -1.0, pause_s_ = 0.0, look_s_ = 0.0,
         next_look_s_ = 0.0;  ///< when a crack last grew; for how long it counts as running after that
  std::vector<PartedFace> faces_;
};

/// Rayleigh's wave speed over that of shear waves: root of x^6 - 8 x^4 + (24 - 16 k) x^2 - 16 (1 - k), k = (1 - 2 nu)/(2 - 2 nu).
double rayleigh_over_shear(double poissons_ratio);

}  // namespace klang::fracture
