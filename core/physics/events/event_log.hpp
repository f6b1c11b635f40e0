#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/physics/events/impulse.hpp"
#include "core/physics/events/motion.hpp"

namespace klang::events {

/// A body that is pushed, moves or breaks; others call it by its row. A piece of a broken body names that body.
struct Body {
  std::string name;
  int parent = -1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "one line of text"}, self.name);
    visit({"parent", "the body that broke into this one and others: an earlier row, or -1", between(-1, 999999)},
          self.parent);
  }
};

/// A body breaks: from now on there are the bodies whose parent it is, in its stead.
struct FractureEvent {
  double time_s = 0.0;
  int body = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "when it has broken", kTimesS, true}, self.time_s);
    visit({"body", "that broke: a row of bodies with at least one piece", kBodyNumbers, true}, self.body);
  }
};

/// A bubble is cut off in the liquid and begins to ring.
struct BubbleBirth {
  double time_s = 0.0;
  double radius_m = 1e-3;
  double strength = 1.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "of its birth", kTimesS, true}, self.time_s);
    visit({"radius_m", "of a ball of its volume", between(1e-6, 1.0), true}, self.radius_m);
    visit({"strength", "times the excitation by the Laplace pressure", between(-1e100, 1e100)}, self.strength);
    visit({"position_m", "of its centre at birth, in the world", kPlacesM, true}, self.position_m);
  }
};

/// A sample of a bubble's path. A bubble without samples stays where it was born.
struct BubblePoint {
  int bubble = 0;
  double time_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double phi_m = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"bubble", "a row of bubbles", between(0, 99999999), true}, self.bubble);
    visit({"time_s", "rising within a bubble; the first at its birth or before", kTimesS, true}, self.time_s);
    visit({"position_m", "of its centre, in the world", kPlacesM, true}, self.position_m);
    visit({"phi_m", "signed distance of its centre to the surface, negative in the liquid", kPlacesM, true},
          self.phi_m);
  }
};

/// What happened, as every room that lets things move says it and as every voice reads it (docs/event-log.md). SI
/// units, one clock for all times; z is up in the world.
struct EventLog {
  std::vector<Body> bodies;
  std::vector<Impulse> impulses;
  std::vector<Pose> poses;
  std::vector<FractureEvent> fractures;
  std::vector<BubbleBirth> bubbles;
  std::vector<BubblePoint> bubble_points;

  /// Names each table once: visit(name, meaning, rows). The file and docs/event-log.md come from that.
  template <class Self, class Visitor>
  static void describe_tables(Self& self, Visitor&& visit) {
    visit("bodies", "who takes part; numbered from 0", self.bodies);
    visit("impulses", "pushes on bodies", self.impulses);
    visit("poses", "where bodies are over time", self.poses);
    visit("fractures", "bodies that break", self.fractures);
    visit("bubbles", "births of bubbles; numbered from 0", self.bubbles);
    visit("bubble_points", "where bubbles are over time", self.bubble_points);
  }

  /// Sorts impulses and fractures by time, poses by body and time, points by bubble and time; equals keep their order.
  void sort();
  /// @throws InputError that names the first row that is out of range, refers to a row that is not there, or whose time
  ///         does not rise where it must. A log need not be sorted, but poses of one body and points of one bubble must
  ///         rise in time.
  void validate() const;

  Motion motion_of(int body) const;
  std::vector<int> pieces_of(int body) const;
  std::optional<double> broken_s(int body) const;              ///< when it broke
  std::vector<std::vector<BubblePoint>> bubble_paths() const;  ///< of each bubble, in its order
};

/// The tables of a log's file as Markdown: part of docs/event-log.md.
std::string event_log_markdown();

}  // namespace klang::events
