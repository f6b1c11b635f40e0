#pragma once
#include <queue>
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"
#include "core/physics/fracture/dynamic/tet_overlap.hpp"

namespace klang::fracture {

/// What two elements do to each other.
struct ElementTouch {
  std::array<int, 2> elements = {0, 0};
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< in the world
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< on the first
};

/// Contact of a body with itself and of its pieces with one another, by the volume that pairs of elements have in common: each pair that shares
/// no node has the energy kappa V^2 / 2 and its exact gradient, so that energy, momentum and moment are kept. kappa follows from the two
/// rest shapes and a rate: as a spring between what the lighter one's corners weigh its rate is at most the one given. Coulomb's friction acts
/// at the centre of the common volume, along it, on both by their shape functions. Within a step it takes at most what slides there, counting what other
/// contacts of the same nodes do: all of them together never give energy.
///
/// Which pairs are near is known from a tree of boxes, made anew where elements have moved by its margin or were cut. A pair that lies apart by some
/// gap is not looked at again before nodes have moved far enough to close it. Only elements with a free face are asked.
class SelfContact {
 public:
  /// @param rate_sq_per_s2  largest squared angular frequency of a contact
  SelfContact(double rate_sq_per_s2, double friction) : rate_sq_per_s2_(rate_sq_per_s2), friction_(friction) {}

  struct Forces {
    std::vector<Eigen::Vector3d> normal_n, friction_n;  ///< of nodes
    double energy_j = 0.0;
    std::vector<ElementTouch> touches;
    bool any() const { return !touches.empty(); }
  };
  /// Forces at the present places. @param dt_s  friction at most stops what slides within it
  const Forces& forces(const CrackMesh& mesh, double dt_s);
  const Forces& last() const { return forces_; }
  std::size_t n_near() const { return pairs_.size(); }

 private:
  struct Pair {
    int first = 0, second = 0, axis = -1;
    double kappa = 0.0, spared_m3 = 0.0;  ///< common volume that a cut has left: not pushed
    double due_m = 0.0;
    bool is_new = true;
  };
  struct Due {
    double at_m = 0.0;
    std::size_t pair = 0;
    bool operator<(const Due& other) const { return at_m > other.at_m; }
  };
  void find_pairs(const CrackMesh& mesh);
  void read_elements(const CrackMesh& mesh);
  void wake();
  void push(const CrackMesh& mesh, const Pair& pair, const TetOverlap& overlap);
  void rub(const CrackMesh& mesh, double dt_s);

  double rate_sq_per_s2_, friction_;
  double travel_m_ = 0.0, valid_to_m_ = -1.0;  ///< sum of twice what any node moved beside the mean
  int changes_seen_ = -1;
  std::vector<Eigen::Vector3d> place_before_;
  std::vector<char> has_free_face_;   ///< of elements
  std::vector<double> area_, share_;  ///< of elements: largest face; mass of a corner
  double margin_m_ = 0.0;
  std::vector<Pair> pairs_;  ///< by first and second
  std::vector<std::size_t> awake_;
  std::priority_queue<Due> asleep_;
  Forces forces_;
  /// Nodes of a touch and the shape functions of its centre there.
  struct Rubbing {
    std::array<int, 8> nodes;
    std::array<double, 8> weight;
  };
  std::vector<Rubbing> rubbing_;     ///< of each of forces_.touches
  std::vector<double> weight_sums_;  ///< of nodes: over all touches; 0 between calls
  std::vector<int> pushed_;          ///< nodes that have forces
};

}  // namespace klang::fracture
