#pragma once
#include <functional>
#include <map>
#include <queue>
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"
#include "core/physics/fracture/dynamic/tet_overlap.hpp"

namespace klang::fracture {

/// What two elements do to each other.
struct ElementTouch {
  std::array<int, 2> meshes = {0, 0}, elements = {0, 0};
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< in the world
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< on the first
};

/// Forces of contact on the nodes of one mesh.
struct NodeForces {
  std::vector<Eigen::Vector3d> normal_n, friction_n;
};

/// Contact of elements by the volume that pairs of them have in common, of a body with itself and of its pieces with one another, or of
/// several bodies, with an energy and its exact gradient, so that energy, momentum and moment are kept.
///
/// Within a body each pair that shares no node has the energy kappa V^2 / 2. kappa follows from the two
/// rest shapes and a rate: as a spring between what the lighter one's corners weigh its rate is at most the one given. Between bodies each element has
/// k V^2 / (4 A), V what it has in common with all of other bodies, A its largest free face: pressed flat on each other, V/A is the depth whatever
/// the meshes, and nothing pushes sideways but at rims. k is the same for all elements of the start, less for what cuts leave.
/// Coulomb's friction acts at the centre of the common volume, along it, on both by their shape functions. Within a step it takes at most what slides there, counting what other
/// contacts of the same nodes do: all of them together never give energy.
///
/// Which pairs are near is known from trees of boxes, made anew where elements have moved by their margin or were cut. A pair that lies apart by some
/// gap is not looked at again before nodes have moved far enough to close it. Only elements with a free face are asked.
class ElementContact {
 public:
  enum class Pairs { kOwn, kOfOthers };  ///< within each mesh, or between meshes
  /// Coefficient of Coulomb's friction of two meshes, by their numbers.
  using Friction = std::function<double(int, int)>;
  /// @param rate_sq_per_s2  largest squared angular frequency of a contact
  ElementContact(Pairs which, double rate_sq_per_s2, Friction friction);

  struct Forces {
    std::vector<NodeForces> of;  ///< of meshes
    double energy_j = 0.0;
    std::vector<ElementTouch> touches;
    bool any() const { return !touches.empty(); }
  };
  /// Forces at the present places. @param meshes  the same at each call  @param dt_s  friction at most stops what slides within it
  const Forces& forces(const std::vector<const CrackMesh*>& meshes, double dt_s);
  const Forces& last() const { return forces_; }
  std::size_t n_near() const { return pairs_.size(); }

 private:
  struct Pair {
    std::array<int, 4> key;  ///< meshes, elements
    int axis = -1;
    double kappa = 0.0, spared_m3 = 0.0;  ///< common volume that a cut has left: not pushed
    double due_m = 0.0;
    bool is_new = true;
  };
  struct Due {
    double at_m = 0.0;
    std::size_t pair = 0;
    bool operator<(const Due& other) const { return at_m > other.at_m; }
  };
  /// What is known of one mesh's elements, as it was cut last.
  struct Elements {
    int changes_seen = -1;
    std::vector<char> has_free_face;
    std::vector<double> area, free_area, share;  ///< largest face, largest free one; mass of a corner
    double size_m = 0.0;                         ///< mean
    void read(const CrackMesh& mesh);
  };
  using Meshes = std::vector<const CrackMesh*>;
  void find_pairs(const Meshes& meshes);
  std::vector<std::array<int, 4>> near_pairs(const Meshes& meshes) const;
  void note_travel(const Meshes& meshes);
  void clear(const Meshes& meshes);
  void wake();
  double look_at(const Meshes& meshes, Pair& pair);
  void push(const Meshes& meshes, const Pair& pair, const TetOverlap& overlap, double pressure_pa);
  void push_bodies(const Meshes& meshes);
  double modulus_pa_m(int mesh, int element) const;
  void rub(const Meshes& meshes, double dt_s);

  Pairs which_;
  double rate_sq_per_s2_;
  Friction friction_;
  double travel_m_ = 0.0, valid_to_m_ = -1.0;  ///< sum of twice what any node moved beside the mean
  std::vector<std::vector<Eigen::Vector3d>> place_before_;
  std::vector<Elements> elements_;
  double margin_m_ = 0.0;
  std::vector<Pair> pairs_;  ///< by their keys
  std::vector<std::size_t> awake_;
  std::priority_queue<Due> asleep_;
  Forces forces_;
  double modulus_pa_m_ = 0.0;  ///< k between bodies, at the start
  /// Pairs of bodies' elements that have something in common now, and how much each element has.
  std::vector<std::pair<std::size_t, TetOverlap>> common_;
  std::map<std::array<int, 2>, double> common_m3_;
  /// Nodes of a touch and the shape functions of its centre there.
  struct Rubbing {
    std::array<int, 8> nodes;
    std::array<double, 8> weight;
  };
  std::vector<Rubbing> rubbing_;                    ///< of each of forces_.touches
  std::vector<std::vector<double>> weight_sums_;    ///< of nodes: over all touches; 0 between calls
  std::vector<std::array<std::size_t, 2>> pushed_;  ///< mesh and node that have forces
};

}  // namespace klang::fracture
