#include "core/sound/scene/detail/link_reader.hpp"

#include <limits>

#include "core/foundation/base/nearest_word.hpp"

namespace klang::scene::detail {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostLinks = 10000;
constexpr double kStretch = 1e-9;    // of a cord's length
constexpr double kHingeShare = 0.1;  // of the first body's size: half the distance of the places that a hinge ties

SceneLink read_link(const TomlTable& table, const Scene& scene) {
  const auto rigid_body = [&](const char* key, const std::string& name) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].name != name) continue;
      const BodyModel model = scene.bodies[i].model;
      if (model != BodyModel::kRigid && model != BodyModel::kBreakable)
        throw InputError(table.place(key), "deforms and is not tied this way", name,
                         "model = \"rigid\" or \"breakable\"");
      return static_cast<int>(i);
    }
    throw unknown_word(table.place(key), "unknown body", name, name, body_names(scene));
  };
  SceneLink link;
  link.place = table.place();
  link.body = rigid_body("body", table.text("body"));
  if (table.has("other") && table.text("other") != "world") link.other = rigid_body("other", table.text("other"));
  if (link.other == link.body) throw InputError(table.place("other"), "is tied to itself", table.text("body"));
  const auto moves = [&](int body) { return body >= 0 && !scene.bodies[static_cast<std::size_t>(body)].fixed; };
  if (!moves(link.body) && !moves(link.other))
    throw InputError(table.place("body"), "ties what does not move", table.text("body"), "a body that is not fixed");
  link.at_m = table.vector("at_m");
  return link;
}

}  // namespace

std::vector<std::string> body_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneBody& body : scene.bodies) names.push_back(body.name);
  return names;
}

std::vector<TomlField> link_fields() {
  using enum TomlType;
  return {
      {"cord", "body", kText, "required", -kNoEnd, kNoEnd, "a rigid or breakable body"},
      {"cord", "other", kText, "`world`", -kNoEnd, kNoEnd, "another such body, or `world`"},
      {"cord", "at_m", kVector, "required", -1e4, 1e4, "one end, in the first body's frame"},
      {"cord", "to_m", kVector, "required", -1e4, 1e4, "the other end, in the other's frame"},
      {"cord", "length_m", kNumber, "as the ends are at the start", 0, 1e4,
       "the ends are never farther apart; without mass, stretch and sound", true},
      {"hinge", "body", kText, "required", -kNoEnd, kNoEnd, "a rigid or breakable body"},
      {"hinge", "other", kText, "`world`", -kNoEnd, kNoEnd,
       "another such body, with which it then does not collide, or `world`"},
      {"hinge", "at_m", kVector, "required", -1e4, 1e4,
       "in the first body's frame: that place, and what is there of the other, stay together"},
      {"hinge", "axis", kVector, "none: it turns every way", -1e6, 1e6,
       "about which alone it turns, in the first body's frame"},
  };
}

std::vector<SceneLink> read_links(const TomlTable& root, const Scene& scene) {
  std::vector<SceneLink> links;
  for (const TomlTable& table : root.tables("cord", kMostLinks)) {
    SceneLink link = read_link(table, scene);
    link.cord = true;
    link.to_m = table.vector("to_m");
    link.length_m = table.optional_number("length_m");
    links.push_back(std::move(link));
  }
  for (const TomlTable& table : root.tables("hinge", kMostLinks)) {
    SceneLink link = read_link(table, scene);
    if (table.has("axis")) {
      link.axis = table.vector("axis");
      if (!(link.axis->norm() > 0.0)) throw InputError(table.place("axis"), "has no direction", "0, 0, 0");
    }
    links.push_back(std::move(link));
  }
  return links;
}

std::vector<rigid::Link> rigid_links(const std::vector<SceneLink>& links,
                                     const std::function<events::Pose(int body)>& pose_of,
                                     const std::function<double(int body)>& size_m) {
  const auto in_world = [&](int body, const Eigen::Vector3d& place_m) {
    return body < 0 ? place_m : pose_of(body).to_world(place_m);
  };
  const auto in_body = [&](int body, const Eigen::Vector3d& world_m) {
    return body < 0 ? world_m : pose_of(body).to_body(world_m);
  };
  std::vector<rigid::Link> list;
  for (const SceneLink& link : links) {
    if (link.cord) {
      const double apart_m = (in_world(link.body, link.at_m) - in_world(link.other, link.to_m)).norm();
      list.push_back({link.body, link.other, link.at_m, link.to_m, link.length_m.value_or(apart_m)});
      continue;
    }
    const double half_m = link.axis ? kHingeShare * size_m(link.body) : 0.0;
    const Eigen::Vector3d along =
        link.axis ? Eigen::Vector3d(half_m * link.axis->normalized()) : Eigen::Vector3d::Zero();
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d tied_m = link.at_m + side * along;
      list.push_back({link.body, link.other, tied_m, in_body(link.other, in_world(link.body, tied_m)), {}});
      if (!link.axis) break;
    }
  }
  return list;
}

void add_links(const std::vector<SceneLink>& links, rigid::RigidWorld& world) {
  const auto pose_of = [&](int body) { return world.pose(body); };
  for (const SceneLink& link : links) {
    if (!link.cord) continue;
    const Eigen::Vector3d to_m = link.other < 0 ? link.to_m : pose_of(link.other).to_world(link.to_m);
    const double apart_m = (pose_of(link.body).to_world(link.at_m) - to_m).norm(),
                 length_m = link.length_m.value_or(apart_m);
    if (!(length_m > 0.0)) throw InputError(link.place, "a cord without length", "", "length_m, or ends apart");
    if (!(apart_m <= length_m * (1.0 + kStretch)))
      throw InputError(link.place, "its ends are farther apart than the cord is long", to_text(apart_m) + " m",
                       "up to " + to_text(length_m) + " m");
  }
  for (const rigid::Link& link : rigid_links(links, pose_of, [&](int body) { return world.spec(body).size_m(); }))
    world.link(link);
}

}  // namespace klang::scene::detail
