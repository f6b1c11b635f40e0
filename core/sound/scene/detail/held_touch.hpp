#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/physics/events/event_log.hpp"
#include "core/physics/rigid/held_mobility.hpp"
#include "core/physics/rigid/link.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene::detail {

/// Places of a pair that touch at one moment, by rows of a log's bodies.
struct PairPlaces {
  int a = 0, b = -1;  ///< -1: the floor
  double time_s = 0.0;
  rigid::PushedBody answer_a, answer_b;         ///< each in its own frame
  std::vector<Eigen::Vector3d> at_a_m, at_b_m;  ///< each in its own frame; of the floor: not read
  std::vector<Eigen::Vector3d> impulse_n_s;     ///< on a, in its frame
};

/// What the cords and hinges of a scene hold while bodies of its log touch.
class HeldTouches {
 public:
  /// How the body of a row answers, in its own frame; none: not known.
  using AnswerOf = std::function<std::optional<rigid::PushedBody>(int row)>;
  HeldTouches(const Scene& scene, const events::EventLog& log, const AnswerOf& answer_of);
  /// rigid::held_mobility() of the pushes [1/kg]; none: nothing ties the pair then.
  std::optional<Eigen::MatrixXd> mobility_per_kg(const PairPlaces& touch) const;

 private:
  struct Tied {
    events::Motion motion;
    rigid::PushedBody answer;
    std::optional<double> broken_s;
  };
  bool is_there(int row, double time_s) const;
  std::vector<rigid::Link> links_;  // by rows
  std::map<int, Tied> bodies_;
  const events::EventLog& log_;
};

}  // namespace klang::scene::detail
