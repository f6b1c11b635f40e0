#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/fracture/dynamic/cracker.hpp"
#include "core/physics/fracture/event/fracture_body.hpp"
#include "core/physics/modal/damping/assumed_damping.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "core/physics/solid/material.hpp"

/// Scenes in which solid bodies move, strike and sound: one file, docs/scenes.md.
namespace klang::scene {

/// How sure a fit is of its constants.
struct FitSpread {
  std::vector<std::string> names;  ///< of elastic constants: fit.json's correlation.names
  Eigen::MatrixXd covariance;
  std::vector<double> damping_std;  ///< of the law's parameters, in its order; empty: the scene gives the damping
};

struct SceneMaterial {
  std::string name;
  solid::Material elastic;
  double restitution = 0.5;                  ///< 0 to 1
  double friction = 0.4;                     ///< Coulomb's
  std::optional<damping::LawValue> damping;  ///< none: what sounds of it rings by damping_heard()
  std::optional<double> tensile_strength_pa, fracture_energy_j_m2;
  std::vector<std::filesystem::path> inputs;  ///< files that it was read from
  std::optional<FitSpread> spread;            ///< of a fit that says how sure it is
  std::optional<std::string> contradiction;   ///< of a fit that contradicts itself: what to say
  double roughness = 0.0;                     ///< rough_contacts.hpp; 0: smooth
  double roughness_length_m = 5e-4;

  damping::LawValue damping_heard() const { return damping ? *damping : damping::assumed_damping(); }
};

/// How a body is heard.
enum class BodySound {
  kAuto,   ///< by its modes, or a proxy by SceneSoundOptions::proxy_above_hz, unless it is fixed
  kModes,  ///< its own modes and their radiation
  kProxy,  ///< an ellipsoid of the bank
  kNone
};
constexpr auto words_of(BodySound) {
  return std::array{Word{BodySound::kAuto, "auto"}, Word{BodySound::kModes, "modes"}, Word{BodySound::kProxy, "proxy"},
                    Word{BodySound::kNone, "none"}};
}

enum class BodyModel {
  kRigid,
  kBreakable,  ///< breaks where an impact strains it enough (SB section 3)
  kCracking,   ///< deforms, flows and cracks (B99, D02)
  kModal       ///< a rigid frame with modes that is held and touches (H03)
};
constexpr auto words_of(BodyModel) {
  return std::array{Word{BodyModel::kRigid, "rigid"}, Word{BodyModel::kBreakable, "breakable"},
                    Word{BodyModel::kCracking, "cracking"}, Word{BodyModel::kModal, "modal"}};
}

/// How a cracking body flows and cracks.
struct CrackSettings {
  fracture::CrackOptions crack;
  fracture::PlasticityInput plasticity;
  fracture::Integrator integrator = fracture::Integrator::kLeapfrog;
  double viscosity_lambda_pa_s = 0.0, viscosity_mu_pa_s = 0.0;
  bool self_contact = false;  ///< of its pieces with one another and of it with itself; costs up to 30 times the rest
};

/// How a modal body moves.
struct ModalSettings {
  int n_modes = 20;                   ///< elastic ones, from the lowest
  bool residual_flexibility = false;  ///< discarded modes are springs between body and floor, not stiff
  bool linear_program = false;        ///< H03's contact, which is not the contact problem (erratum 71)
};

/// How impulses become forces that strain a breakable body; SB does not say (erratum 49).
enum class ForceModel {
  kHertz,            ///< the peak of Hertz' pulse, with at most the energy of the compression
  kImpulseOverStep,  ///< J / step: strain energy grows as 1 / step^2, without a limit
  kAuthorsCode       ///< J times 1800 per s, as in the authors' published program, without a limit
};
constexpr auto words_of(ForceModel) {
  return std::array{Word{ForceModel::kHertz, "hertz"}, Word{ForceModel::kImpulseOverStep, "impulse_over_step"},
                    Word{ForceModel::kAuthorsCode, "authors_code"}};
}

/// A place of a body that is moved from outside.
struct SceneHold {
  int body = 0;
  std::string place;                    ///< in the file
  std::string where;                    ///< as of supports, in the body's frame; "": at_m
  std::optional<Eigen::Vector3d> at_m;  ///< the nearest node
  fracture::HoldPath path;
  std::filesystem::path csv;
};

/// Two modal bodies, or one and the world, that share a place and turn freely about it.
struct SceneJoint {
  int body = 0, other = -1;                        ///< -1: the world
  std::string place;                               ///< in the file
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();  ///< the nearest corner of the surface, in the first body's frame
};

/// What ties two rigid or breakable bodies, or one and the world.
struct SceneLink {
  int body = 0, other = -1;                        ///< -1: the world
  std::string place;                               ///< in the file
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();  ///< in the first body's frame
  bool cord = false;                               ///< else a hinge
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();  ///< of a cord: its other end, in the other's frame
  std::optional<double> length_m;                  ///< of a cord; none: taut at the start
  std::optional<Eigen::Vector3d> axis;             ///< of a hinge, in the first body's frame; none: it turns every way
};

struct SceneBody {
  std::string name;
  std::string place;  ///< in the file, for messages: "scene.toml:12: body[1]"
  std::optional<mesh::ShapeSpec> shape;
  std::filesystem::path mesh;  ///< where there is no shape
  double unit_m = 1.0;         ///< of the mesh
  int material = 0;            ///< row of materials
  BodyModel model = BodyModel::kRigid;
  double stress_edge_m = 0.0;  ///< of a breakable body's mesh for stress; 0: its wall
  std::optional<fracture::ScoredPlane> score;
  CrackSettings crack;  ///< of a cracking body
  ModalSettings modal;  ///< of a modal body
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();  ///< about the world's x, then y, then z
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  bool fixed = false;
  double max_edge_m = 0.0;            ///< of the mesh for modes; 0: the default of `klang modes`
  std::optional<double> modes_to_hz;  ///< highest of its own modes that is computed, below the sound's band's end
  BodySound sound = BodySound::kAuto;
  /// Its frames show it deformed.
  bool deforms() const { return model == BodyModel::kCracking || (model == BodyModel::kModal && modal.n_modes > 0); }
  bool sounds() const { return sound != BodySound::kNone && (sound != BodySound::kAuto || !fixed); }
};

/// Where a listener who walks is at a time, and where the nose points.
struct ListenerKey {
  double time_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero(), facing = Eigen::Vector3d::Zero();
};

struct SceneListener {
  Eigen::Vector3d position_m{0.0, -2.0, 1.6}, facing{0.0, 1.0, 0.0};  ///< of a path: at its start
  bool stereo = false;
  std::vector<ListenerKey> path;  ///< rising times, straight lines between; empty: at rest
};

struct SceneSoundOptions {
  double low_hz = 20.0, high_hz = 20000.0;
  double sample_rate_hz = 48000.0;
  double peak_db_re_full_scale = -3.0;
  double longest_tail_s = 5.0;  ///< after the motion has ended, where the scene has no length of its own
  bool radiation_damping = false;
  double elements_per_wavelength = 6.0;  ///< of the boundary elements for radiation
  SceneListener listener;
  std::filesystem::path bank;            ///< a soundbank; empty: none
  std::optional<double> proxy_above_hz;  ///< lowest frequency above which bodies are heard by ellipsoids of the bank
};

/// A floor that rings: a slab, pinned along its edges, that is struck off its centre.
struct FloorSound {
  Eigen::Vector3d slab_m{9.0, 9.0, 0.9};
  double low_hz = 20.0, high_hz = 4000.0;
  int n_modes = 1000;  ///< at most, from low_hz up
};

/// Pictures of the motion.
struct SceneFrames {
  double rate_hz = 60.0;
  bool glb = true, vtp = true;
  /// No key of a file: of what all cracking bodies look like, and of modal ones; where it is reached, one of two pictures goes.
  std::size_t most_shape_bytes = std::size_t{256} << 20;
  bool wanted() const { return glb || vtp; }
};

struct Scene {
  std::string name;
  std::filesystem::path file;
  std::optional<double> duration_s;  ///< none: until all rests
  double longest_s = 60.0;           ///< within which it must come to rest
  double pose_rate_hz = 1000.0;
  rigid::RigidWorldOptions solver;
  std::optional<int> floor_material;
  std::vector<SceneMaterial> materials;
  std::vector<SceneBody> bodies;
  SceneSoundOptions sound;
  std::optional<FloorSound> floor_sound;
  SceneFrames frames;
  fracture::FractureOptions fracture;
  ForceModel force_model = ForceModel::kHertz;
  bool skip_harmless_loads =
      true;  ///< no key of a file: off, every load is solved, whether it has the energy to break or not
  std::vector<SceneHold> holds;
  std::vector<SceneJoint> joints;
  std::vector<SceneLink> links;

  bool has_deforming_bodies() const;
  const SceneMaterial& material_of(const SceneBody& body) const {
    return materials[static_cast<std::size_t>(body.material)];
  }
  std::vector<std::filesystem::path> inputs() const;  ///< the scene and every file that it names
};

/// Reads and checks a scene. @throws InputError with file, line, key, value and what is allowed
Scene read_scene(const std::filesystem::path& toml);
Scene parse_scene(std::string_view toml, const std::filesystem::path& file);

/// The keys of a scene as Markdown tables: part of docs/scenes.md.
std::string scene_schema_markdown();

/// Rotations about the world's x, then y, then z axis.
Eigen::Quaterniond orientation_of(const Eigen::Vector3d& rotation_deg);

/// Skin of a body of this material: what touches it feels.
rigid::Skin skin_of(const SceneMaterial& material);

}  // namespace klang::scene
