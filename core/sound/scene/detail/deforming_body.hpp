#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/sound/scene/detail/rigid_push.hpp"
#include "core/sound/scene/detail/shape_keeper.hpp"
#include "core/sound/scene/scene_motion.hpp"

namespace klang::scene::detail {

inline constexpr int kMostElements = 2'000'000;  ///< of a cracking body

/// Frame of a set of nodes: x = position + R X, least squares weighted by mass, R proper.
struct FittedFrame {
  events::Pose pose;
  FinalState state;  ///< of the centre of mass
  double mass_kg = 0.0;
};
FittedFrame fitted_frame(const fracture::CrackMesh& mesh, const std::vector<int>& nodes);

/// The linear mesh of a cracking body, its nodes moved by the seed's random numbers by up to a tenth of their shortest edge:
/// inside in all directions, those of faces along them, those of sharp edges not.
/// @throws InputError also for more elements than can be stepped, for shapes before they are meshed
mesh::TetMesh crack_mesh_of(const SceneBody& body, std::uint64_t seed, const SceneNotes& notes, Monitor& monitor);

/// One cracking body of a scene.
class DeformingBody {
 public:
  DeformingBody(const Scene& scene, int row, const rigid::RigidBodySpec& spec, std::uint64_t seed,
                const SceneNotes& notes, Monitor& monitor);
  ~DeformingBody();
  /// From the last time to that one, pressing on bodies.
  void advance(double until_s, std::vector<PressedBody>& pressed);
  /// The same in parts, for bodies that press on one another: begin, then small steps, each of go, arrive and open, then end. Pressed bodies are
  /// advanced between go and arrive.
  void begin(double until_s, std::vector<PressedBody>& pressed);
  double step_limit_s() const;  ///< @throws NumericalError: too small
  void go(double dt_s);
  void arrive();
  bool open();  ///< cracks; true: some did
  void end();
  const fracture::ExplicitSolid& solid() const { return *solid_; }
  fracture::ExplicitSolid& solid() { return *solid_; }
  const fracture::Cracker& cracker() const { return *cracker_; }
  const rigid::Skin& skin() const;
  int row() const { return row_; }
  int n_elements_start() const { return n_elements_start_; }
  int n_pieces() const { return n_pieces_; }
  double lumped_j() const { return lumped_j_; }  ///< of its spin at the start, that its shape would not have
  Eigen::AlignedBox3d box() const;
  const std::vector<CrackSummary::Split>& splits() const { return splits_; }
  ShapeKeeper& shapes() { return shapes_; }
  const ShapeKeeper& shapes() const { return shapes_; }
  /// Keeps the frames of all pieces at this time where it is due, or where something pressed since the last call.
  void keep_frames(double pose_rate_hz);
  void note_pressed() { pressed_ = true; }
  int piece_of(int node) const;  ///< now
  /// Rows of impulses and poses, and its pieces, which become bodies of the motion. Returns the bodies of its pieces; itself where it is whole.
  std::vector<int> add_to(const Scene& scene, SceneMotion& motion) const;
  /// An impulse on a node in a step of the world.
  struct Contact {
    double time_s = 0.0, duration_s = 0.0;
    int node = 0, other = -1;
    int other_node = -1;  ///< of another piece of this body, in place of other
    bool is_new = false;
    Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();
  };
  /// On the piece that has the node, in its frame. @param rows  as add_to() gave them
  std::optional<events::Impulse> impulse_of(const Contact& contact, const std::vector<int>& rows) const;

 private:
  struct Pressing;
  struct Version {
    double time_s = 0.0;
    int n_pieces = 1;
    std::vector<int> piece_of_node;
  };
  struct Kept {
    std::size_t version = 0;
    int piece = 0;
    events::Pose pose;
  };
  /// Pulls through faces that parted, on the pieces at either side: each rises over some steps before and ends with the face.
  void add_pulls(const std::vector<int>& row_of_piece, const std::vector<int>& piece_of_element,
                 SceneMotion& motion) const;
  /// When it parted; of one that is heard and that cracks stay in, when the first of them came: it rings by its slit mesh then.
  std::optional<double> broken_s() const { return broken_s_ || !heard_ ? broken_s_ : cracked_s_; }
  const Kept* frame_at(double time_s, int node) const;
  void note_splits(int n, double area_before_m2);
  void note_pieces(double until_s);
  void note_pushes(double dt_s);
  void add_own_contacts(std::vector<char>& touched);
  int piece_then(const Version& version, int node) const;

  int row_ = 0, n_elements_start_ = 0, n_pieces_ = 1, changes_seen_ = -1;
  std::string name_;
  ShapeKeeper shapes_;
  std::optional<double> broken_s_, cracked_s_;  ///< ends of steps: in pieces; first split
  std::optional<double> strength_;
  double next_pose_s_ = 0.0;
  std::unique_ptr<Pressing> pressing_;
  std::unique_ptr<fracture::ExplicitSolid> solid_;
  std::unique_ptr<fracture::Cracker> cracker_;
  std::vector<CrackSummary::Split> splits_;
  std::vector<Contact> contacts_;
  std::vector<PressedBody>* pressing_on_ = nullptr;           ///< in this step of the world
  std::map<std::pair<int, int>, Eigen::Vector3d> pushes_;     ///< impulses in this step, by node and other body
  std::map<std::array<int, 2>, Eigen::Vector3d> own_pushes_;  ///< of pairs of its elements
  std::vector<std::array<double, 2>> steps_s_;                ///< of the world: begin and end
  double lumped_j_ = 0.0;
  bool heard_ = false;
  bool pressed_ = false;  ///< by others, since frames were kept
  std::vector<char> touched_;
  std::vector<Version> versions_;
  std::vector<Kept> frames_;
};

}  // namespace klang::scene::detail
