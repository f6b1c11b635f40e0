#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "core/sound/scene/heard_document.hpp"
#include "core/sound/scene/scene.hpp"

/// scene.json of `klang scene run`.
namespace klang::scene {

struct FinalRecord {
  std::array<double, 3> position_m{}, velocity_m_s{}, angular_velocity_rad_s{};
  std::array<double, 4> orientation_wxyz{1.0, 0.0, 0.0, 0.0};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"position_m", "of the centre of mass, in the world"}, self.position_m);
    visit({"orientation_wxyz", "unit quaternion that turns the body's frame into the world's"}, self.orientation_wxyz);
    visit({"velocity_m_s", "of the centre of mass"}, self.velocity_m_s);
    visit({"angular_velocity_rad_s", "about the world's axes"}, self.angular_velocity_rad_s);
  }
};

/// Where a body's sound comes from.
struct SoundRecord {
  std::string modes, transfer;  ///< files beside scene.json
  std::string damping;          ///< law
  std::vector<double> damping_parameters;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"modes", "file of its modes"}, self.modes);
    visit({"transfer", "file of their radiation"}, self.transfer);
    visit({"damping", "law by which modes decay"}, self.damping);
    visit({"damping_parameters", "of the law, in its order"}, self.damping_parameters);
  }
};

struct BodyRecord {
  std::string name;
  double mass_kg = 0.0;
  std::optional<std::string> parent;
  std::string material;
  bool fixed = false;
  int n_impacts = 0;
  std::optional<double> hardest_impact_n_s;
  int n_modes = 0;
  bool proxy = false;
  std::optional<SoundRecord> sound;
  FinalRecord final;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "as in the scene"}, self.name);
    visit({"mass_kg", "its mass"}, self.mass_kg);
    visit({"parent", "the body that broke into this one and others; null: a body of the scene"}, self.parent);
    visit({"material", "as in the scene"}, self.material);
    visit({"fixed", "it does not move"}, self.fixed);
    visit({"n_impacts", "impacts on it"}, self.n_impacts);
    visit({"hardest_impact_n_s", "largest impulse of one of them; null without one"}, self.hardest_impact_n_s);
    visit({"n_modes", "elastic ones that a modal body moves with; of others those that are heard; 0: none"},
          self.n_modes);
    visit({"proxy", "heard by an ellipsoid of a soundbank"}, self.proxy);
    visit({"sound", "where its sound comes from; null: silent"}, self.sound);
    visit({"final", "how it ended"}, self.final);
  }
};

struct SceneEventRecord {
  double time_s = 0.0;
  std::string kind, body;
  int pieces = 0;
  std::optional<double> strain_energy_j, fracture_energy_j, kinetic_energy_j, vibration_energy_j;
  double crack_area_m2 = 0.0;
  std::optional<double> largest_stress_pa, viscous_energy_j = {}, plastic_energy_j = {};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "when"}, self.time_s);
    visit({"kind", "fracture; split: a step in which a cracking body parted at nodes"}, self.kind);
    visit({"body", "that broke"}, self.body);
    visit({"pieces", "into how many; split: of how many the body consists then"}, self.pieces);
    visit({"strain_energy_j", "that was in it; split: that is in it and its pieces then"}, self.strain_energy_j);
    visit({"fracture_energy_j", "spent on cracks; null of a split, whose faces take no energy of their own"},
          self.fracture_energy_j);
    visit({"kinetic_energy_j", "given to the pieces; split: of the body and its pieces then"}, self.kinetic_energy_j);
    visit(
        {"vibration_energy_j", "left to ring in them, and heat; null of a split, which leaves it in strain and motion"},
        self.vibration_energy_j);
    visit({"crack_area_m2", "of one side"}, self.crack_area_m2);
    visit({"largest_stress_pa",
           "tension at a node of the stress mesh without the contacts' own (docs/scenes.md), when it broke; split: "
           "what parted the worst node, by the "
           "criterion; null with toughness_n"},
          self.largest_stress_pa);
    visit({"viscous_energy_j", "split: that the body lost to viscous stress until then; null of a fracture"},
          self.viscous_energy_j);
    visit({"plastic_energy_j", "split: that the body lost to plastic flow until then; null of a fracture"},
          self.plastic_energy_j);
  }
};

struct LedgerRecord {
  double residual_relative = 0.0, energy_scale_j = 0.0, limit = 1e-9;
  double contact_j = 0.0, friction_j = 0.0, fracture_j = 0.0, correction_j = 0.0;
  double viscous_j = 0.0, plastic_j = 0.0, work_j = 0.0, most_strain_j = 0.0;
  std::optional<double> vibration_j;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"residual_relative", "largest part of the energy that does not close, over energy_scale_j"},
          self.residual_relative);
    visit({"limit", "above which the run does not pass"}, self.limit);
    visit({"energy_scale_j",
           "kinetic energy at the start, and potential energy there above its lowest value in the run, at least what "
           "lifts every movable body by half its smallest width; with cracking or modal bodies also the larger of most "
           "strain and most work"},
          self.energy_scale_j);
    visit({"contact_j", "lost along the normals of contacts"}, self.contact_j);
    visit({"friction_j", "lost across them"}, self.friction_j);
    visit({"fracture_j", "in new surfaces"}, self.fracture_j);
    visit({"vibration_j", "left in pieces as vibration and heat when bodies broke"}, self.vibration_j);
    visit({"correction_j", "less what the solver put in"}, self.correction_j);
    visit({"viscous_j", "lost to viscous stress and damping in bodies that deform"}, self.viscous_j);
    visit({"plastic_j", "lost to plastic flow in them"}, self.plastic_j);
    visit({"work_j", "put in from outside, by what is held: all of it less what it took back"}, self.work_j);
    visit({"most_strain_j", "largest strain energy of bodies under load at the end of a step"}, self.most_strain_j);
  }
};

struct ImpactRecord {
  double time_s = 0.0;
  std::string body, other;
  double impulse_n_s = 0.0, duration_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "of first touch"}, self.time_s);
    visit({"body", "that was hit"}, self.body);
    visit({"other", "by which; floor"}, self.other);
    visit({"impulse_n_s", "its size"}, self.impulse_n_s);
    visit({"duration_s", "of contact, by Hertz"}, self.duration_s);
  }
};

struct ImpulsesRecord {
  int n_impacts = 0, n_lasting = 0;
  double largest_impact_n_s = 0.0, total_impact_n_s = 0.0;
  std::optional<double> shortest_contact_s, longest_contact_s;
  std::vector<ImpactRecord> hardest;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_impacts", "points that touched anew, one row per body"}, self.n_impacts);
    visit({"n_lasting", "points of lasting contacts in steps, one row per body"}, self.n_lasting);
    visit({"largest_impact_n_s", "of one point"}, self.largest_impact_n_s);
    visit({"total_impact_n_s", "sum of their sizes"}, self.total_impact_n_s);
    visit({"shortest_contact_s", "of an impact, by Hertz"}, self.shortest_contact_s);
    visit({"longest_contact_s", "of an impact, by Hertz"}, self.longest_contact_s);
    visit({"hardest", "impacts on bodies, the hardest 1000 in the order of time"}, self.hardest);
  }
};

struct SceneFiles {
  std::string ledger = "ledger.csv", events = "events.h5";

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"ledger", "energies, a row per step"}, self.ledger);
    visit({"events", "impulses and poses (docs/event-log.md)"}, self.events);
  }
};

struct CracksRecord {
  int n_splits = 0, n_elements_start = 0, n_elements_end = 0;
  double new_area_m2 = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_splits", "nodes that were parted"}, self.n_splits);
    visit({"n_elements_start", "tetrahedra of all cracking bodies"}, self.n_elements_start);
    visit({"n_elements_end", "at the end, cut by cracks"}, self.n_elements_end);
    visit({"new_area_m2", "of cracks, one side, in the rest shape: the sum of crack_faces.csv"}, self.new_area_m2);
  }
};

struct PlasticRecord {
  double dissipation_j = 0.0, max_strain = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"dissipation_j", "by plastic flow"}, self.dissipation_j);
    visit({"max_strain", "largest norm of Green's plastic strain at the end, the measure of plastic_strain_limit"},
          self.max_strain);
  }
};

struct ContactRecord {
  double residual = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"residual", "worst of all contact problems of modal bodies, over their largest speed and impulse"},
          self.residual);
  }
};

/// A row of crack_faces.csv.
struct CrackFaceRow {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0, nx = 0.0, ny = 0.0, nz = 0.0, area_m2 = 0.0, time_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"x_m", "centre in the rest shape, the body's frame"}, self.x_m);
    visit({"y_m", "centre"}, self.y_m);
    visit({"z_m", "centre"}, self.z_m);
    visit({"nx", "unit normal"}, self.nx);
    visit({"ny", "unit normal"}, self.ny);
    visit({"nz", "unit normal"}, self.nz);
    visit({"area_m2", "of one side"}, self.area_m2);
    visit({"time_s", "when it opened"}, self.time_s);
  }
};

struct SceneDocument {
  ResultHeader header;
  std::string name;
  double end_s = 0.0, rate_hz = 0.0;
  int n_steps = 0;
  std::vector<BodyRecord> bodies;
  std::vector<SceneEventRecord> events;
  LedgerRecord ledger;
  ImpulsesRecord impulses_summary;
  double solver_residual_m_s = 0.0, deepest_overlap_m = 0.0;
  int n_stress_solves = 0;
  std::optional<CracksRecord> cracks;
  std::optional<PlasticRecord> plastic;
  std::optional<ContactRecord> contact;
  std::optional<HeardRecord> sound;
  std::optional<FloorRecord> floor;
  std::optional<DrawsRecord> draws;
  std::optional<FramesRecord> frames;
  SceneFiles files;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the scene"}, self.name);
    visit({"end_s", "when the motion ended"}, self.end_s);
    visit({"rate_hz", "steps per second"}, self.rate_hz);
    visit({"n_steps", "that were made"}, self.n_steps);
    visit({"bodies", "in the scene's order, then pieces"}, self.bodies);
    visit({"events", "what broke"}, self.events);
    visit({"ledger", "whether every joule is accounted for"}, self.ledger);
    visit({"impulses_summary", "of all impulses"}, self.impulses_summary);
    visit({"solver_residual_m_s", "worst violation of the conditions of lasting contacts, as a speed"},
          self.solver_residual_m_s);
    visit({"n_stress_solves", "nodes whose stress responses were solved"}, self.n_stress_solves);
    visit({"deepest_overlap_m", "of two bodies in any step"}, self.deepest_overlap_m);
    visit({"cracks", "of cracking bodies; null: none"}, self.cracks);
    visit({"plastic", "of cracking bodies; null: none"}, self.plastic);
    visit({"contact", "of modal bodies; null: none"}, self.contact);
    visit({"sound", "null: not asked for"}, self.sound);
    visit({"floor", "the sound of the floor; null: it is silent"}, self.floor);
    visit({"draws", "how sure the sound is; null: not asked for"}, self.draws);
    visit({"frames", "null: not asked for"}, self.frames);
    visit({"files", "beside scene.json"}, self.files);
  }
};

/// Above this the run's exit code is 1.
inline constexpr double kLedgerLimit = 1e-9;
/// The same with cracking bodies, whose steps are of order two.
inline constexpr double kCrackingLedgerLimit = 1e-3;

}  // namespace klang::scene
