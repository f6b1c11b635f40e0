#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "core/physics/events/motion.hpp"
#include "core/physics/rigid/contact.hpp"
#include "core/physics/rigid/energy_ledger.hpp"
#include "core/physics/rigid/link.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid {

/// A body that turns farther in a step [rad] is refused: its rotation is not resolved.
inline constexpr double kMostTurnPerStep = 2.0;

/// How impacts that happen in one step are solved.
enum class CollisionOrder {
  kPairwise,  ///< one pair after the other, in the order of their touch, one at most five times: what is seen in a cradle
  kSimultaneous  ///< all that hang together by touching at once, with v+ = -e v- at every point (Newton)
};
constexpr auto words_of(CollisionOrder) {
  return std::array{Word{CollisionOrder::kPairwise, "pairwise"}, Word{CollisionOrder::kSimultaneous, "simultaneous"}};
}

struct RigidWorldOptions {
  double rate_hz = 10000.0;
  int iterations = 200;  ///< most sweeps over the contacts that last, per step; it ends earlier where they are solved
  CollisionOrder collisions = CollisionOrder::kPairwise;
  Eigen::Vector3d gravity_m_s2 = {0.0, 0.0, -9.81};
  std::optional<Skin> floor;  ///< of the plane z = 0; none: no floor

  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"rate_hz", "steps per second", between(100.0, 1e6)}, self.rate_hz);
    visit({"iterations", "most sweeps over lasting contacts per step", between(1, 100000)}, self.iterations);
    visit({"collisions", "impacts in one step: pairwise (one pair after the other) or simultaneous"}, self.collisions);
  }
};

/// What one step did.
struct StepRecord {
  std::vector<ContactImpulse> contacts;  ///< one per point with an impulse
  double solver_residual_m_s = 0.0;      ///< worst violation of the conditions of lasting contacts, as a speed
  double deepest_m = 0.0;                ///< largest penetration at the step's begin
};

/// Rigid bodies that fall, touch, slide and roll.
///
/// A step of dt = 1/rate: bodies fly on a parabola to where they would be; collision detection there finds points that
/// would have touched, and the moment of touch in the step. As they lie there impacts are solved (Newton's restitution, Coulomb's
/// cone), then the contacts that last hold with a force over the rest of the step, whose mean velocity moves the body: in
/// flight, in an impact and in rest the energy that a contact takes is J . (u- + u+)/2 to the last bit. Free rotation keeps energy
/// and angular momentum (composition of implicit midpoint steps, order 4).
///
/// All is computed in units in which the bodies are about 1 long (lengths times 4^k, times times 2^k, gravity unchanged), so that a
/// scene of the same shape at 4^k times the size moves in the same bits (Froude).
class RigidWorld {
 public:
  explicit RigidWorld(const RigidWorldOptions& options);
  ~RigidWorld();
  RigidWorld(RigidWorld&&) noexcept;
  RigidWorld& operator=(RigidWorld&&) noexcept;

  /// Returns its number. What it brings of energy is booked as work. @throws InputError
  int add(const RigidBodySpec& body);
  void link(const Link& link);  ///< ties bodies that are there
  const std::vector<Link>& links() const;
  void remove(int body);  ///< numbers of the others stay; its energy leaves as work
  int n_bodies() const;   ///< with those that were removed
  bool is_there(int body) const;

  /// @throws InputError where a body moves by more than its smallest half-width in one step: the rate is too low
  StepRecord step();
  double time_s() const;

  const RigidBodySpec& spec(int body) const;  ///< as it was added
  events::Pose pose(int body) const;          ///< of its frame, now
  Eigen::Vector3d centre_m(int body) const;
  Eigen::Vector3d velocity_m_s(int body) const;  ///< of its centre
  Eigen::Vector3d angular_velocity_rad_s(int body) const;
  void set_velocity(int body, const Eigen::Vector3d& velocity_m_s, const Eigen::Vector3d& angular_velocity_rad_s);

  void shift(int body, const Eigen::Vector3d& by_m);  ///< moves it; what that takes in gravity's field is work

  /// An impulse on body a at a place of the world, its opposite on body b.
  struct Push {
    int a = 0, b = kFloor;
    Eigen::Vector3d at_a_m = Eigen::Vector3d::Zero(), at_b_m = Eigen::Vector3d::Zero(),
                    impulse_n_s = Eigen::Vector3d::Zero();
  };
  /// What hinges, and cords that these pull, add to impulses on bodies as they stand, so that what they tie stays together.
  std::vector<Push> answer_of_ties(const std::vector<Push>& pushes) const;

  const EnergyLedger& ledger() const;
  /// Says where energy went that the caller took out of, or put into, the bodies: adds it to an entry, and to the work, which
  /// set_velocity(), shift(), add() and remove() have lessened by as much.
  void book(double EnergyLedger::*entry, double joules);
  /// Deepest overlap of two bodies as they stand [m] and which; nothing: none deeper than tolerance_m.
  struct Overlap {
    int a = 0, b = -1;  ///< b = -1: the floor
    double depth_m = 0.0;
  };
  std::optional<Overlap> overlap(double tolerance_m) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace klang::rigid
