#pragma once
#include <map>
#include <utility>
#include <vector>

#include "core/physics/rigid/detail/impact_group.hpp"
#include "core/physics/rigid/detail/touch_finder.hpp"

namespace klang::rigid::detail {

struct ImpactRules {
  Eigen::Vector3d gravity;
  double dt = 0.0;
  double rest_speed = 0.0;  ///< slower touches are no impacts: the lasting contacts hold them
  double slop = 0.0;        ///< points this near take part
  bool simultaneous = false;
};

/// The impacts of a step, one pair after the other in the order of their touch: both bodies fly, and turn, to the moment at which a
/// point that approaches faster than rest_speed has no gap left, collide as they lie there, with what is tied to them, and what they strike
/// next in the step is looked for anew. A pair strikes five times in a step at most. With simultaneous, all bodies that hang together by touching then are solved at once.
class StepImpacts {
 public:
  /// @param bodies  at the step's begin; each ends at the time of its last impact (BodyState::clock), as it then lies and moves
  /// @param there   where they would be at the step's end without contacts; ends as where they would be after the impacts
  /// @param at_end  contacts there, sorted by pairs
  StepImpacts(const TouchFinder& finder, const ImpactRules& rules, std::vector<BodyState>& bodies,
              std::vector<BodyState>& there, std::vector<Contact> at_end);
  void solve();

  const std::vector<Contact>& impacts() const { return impacts_; }  ///< points with an impulse, in the order of time
  std::vector<Contact> at_end() const;  ///< contacts where the bodies would be now, sorted by pairs
  ImpactLosses losses() const { return losses_; }
  /// The bodies with their inertia as they lie.
  Bodies& view() { return view_; }

 private:
  using Pair = std::pair<int, int>;
  /// The deepest of a pair's points that approach fast enough.
  struct Striking {
    double gap = HUGE_VAL, approach = 0.0, pull = 0.0;
  };
  Striking striking(const std::vector<Contact>& contacts, const BodyState& a, const BodyState& b) const;
  void expect(const Pair& pair);
  void keep(const Pair& pair, std::vector<Contact> contacts);
  double touch_of(const Pair& pair, const Striking& at_end) const;
  void collide(const Pair& pair, double time);
  void find_gives(std::vector<Contact>& points) const;
  std::vector<Contact> touching(const Pair& pair, double time);
  void add_tied(const Pair& pair, double time, std::vector<Contact>& points);
  void fly(int body, double time);
  void forget(int body);
  void go_on(const std::vector<int>& changed);

  const TouchFinder& finder_;
  ImpactRules rules_;
  std::vector<BodyState>& bodies_;
  Bodies view_;
  std::vector<BodyState>& there_;
  std::map<Pair, std::vector<Contact>> at_end_;
  std::vector<std::vector<int>> partners_;  // of each body among these
  std::map<Pair, double> due_;              // times of touch to come
  std::map<Pair, int> struck_;              // how often
  std::vector<Contact> impacts_;
  ImpactLosses losses_;
};

}  // namespace klang::rigid::detail
