#include "core/physics/solid/support.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/physics/solid/support_doubt.hpp"

namespace klang::solid {
namespace {

constexpr std::string_view kAllowedPlaces =
    "free, clamped:WHERE or pinned:WHERE with WHERE one of x=min, x=max, x=0.05, x<0.01, x>0.01 (also y, z; metres), "
    "box:x0,y0,z0:x1,y1,z1, set:NAME";

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

struct Region {
  enum class Kind { kPlane, kLeast, kMost, kBelow, kAbove, kBox, kSet } kind = Kind::kPlane;
  int axis = 0;
  double value_m = 0;
  Eigen::Vector3d low_m, high_m;
  std::string set_name;
};

std::optional<Eigen::Vector3d> triple(std::string_view text) {
  Eigen::Vector3d values;
  for (int axis = 0; axis < 3; ++axis) {
    const auto comma = text.find(',');
    if ((comma == std::string_view::npos) != (axis == 2)) return std::nullopt;
    const auto value = number(text.substr(0, comma));
    if (!value) return std::nullopt;
    values[axis] = *value;
    if (axis < 2) text.remove_prefix(comma + 1);
  }
  return values;
}

Region parse_region(std::string_view where) {
  const auto fail = [&](std::string_view problem) { throw InputError("support", problem, where, kAllowedPlaces); };
  Region region;
  if (where.starts_with("set:")) {
    region.kind = Region::Kind::kSet;
    region.set_name = where.substr(4);
    if (region.set_name.empty()) fail("the node set has no name");
    return region;
  }
  if (where.starts_with("box:")) {
    const auto body = where.substr(4);
    const auto colon = body.find(':');
    const auto low = colon == std::string_view::npos ? std::nullopt : triple(body.substr(0, colon));
    const auto high = colon == std::string_view::npos ? std::nullopt : triple(body.substr(colon + 1));
    if (!low || !high) fail("a box needs two corners of three numbers");
    if (!((*low).array() <= (*high).array()).all()) fail("the box's first corner must not exceed its second");
    region.kind = Region::Kind::kBox;
    region.low_m = *low;
    region.high_m = *high;
    return region;
  }
  if (where.size() < 3 || where[0] < 'x' || where[0] > 'z') fail("region not understood");
  region.axis = where[0] - 'x';
  if (where[1] == '=')
    region.kind = Region::Kind::kPlane;
  else if (where[1] == '<')
    region.kind = Region::Kind::kBelow;
  else if (where[1] == '>')
    region.kind = Region::Kind::kAbove;
  else
    fail("region not understood");
  if (where.substr(1) == "=min" || where.substr(1) == "=max") {
    region.kind = where.ends_with("min") ? Region::Kind::kLeast : Region::Kind::kMost;
    return region;
  }
  const auto value = number(where.substr(2));
  if (!value) fail("not a number");
  region.value_m = *value;
  return region;
}

}  // namespace

Support parse_support(std::string_view text) {
  if (text == "free") return {};
  const auto colon = text.find(':');
  const auto kind = text.substr(0, colon);
  Support support;
  if (kind == "clamped")
    support.kind = SupportKind::kClamped;
  else if (kind == "pinned")
    support.kind = SupportKind::kPinned;
  else
    throw InputError("support", "unknown kind", text,
                     std::string(kAllowedPlaces) + did_you_mean(kind, {"free", "clamped", "pinned"}));
  if (colon == std::string_view::npos) throw InputError("support", "says not where", text, kAllowedPlaces);
  support.where = text.substr(colon + 1);
  parse_region(support.where);
  return support;
}

std::string to_text(const Support& support) {
  if (support.kind == SupportKind::kFree) return "free";
  return (support.kind == SupportKind::kClamped ? "clamped:" : "pinned:") + support.where;
}

std::string support_doubt(const Support& support, const mesh::TetMesh& mesh) {
  if (support.kind == SupportKind::kFree) return {};
  const Region region = parse_region(support.where);
  if (region.kind != Region::Kind::kPlane) return {};
  const auto along = mesh.nodes_m.col(region.axis);
  const double low_m = along.minCoeff(), high_m = along.maxCoeff(), slack_m = 1e-3 * (high_m - low_m);
  if (region.value_m <= low_m + slack_m || region.value_m >= high_m - slack_m) return {};
  const std::string axis(1, static_cast<char>('x' + region.axis));
  return "the plane " + support.where + " cuts through the body, which reaches from " + axis + " = " +
         klang::to_text(low_m) + " to " + klang::to_text(high_m) + " m: was " + axis + "=min or " + axis +
         "=max meant?";
}

std::vector<int> held_nodes(const Support& support, const mesh::TetMesh& mesh) {
  if (support.kind == SupportKind::kFree) return {};
  const Region region = parse_region(support.where);
  std::vector<int> nodes;
  if (region.kind == Region::Kind::kSet) {
    const auto found = mesh.node_sets.find(region.set_name);
    if (found == mesh.node_sets.end()) {
      std::string names;
      for (const auto& [name, members] : mesh.node_sets) names += (names.empty() ? "" : ", ") + name;
      throw InputError("support", "the mesh has no such node set", region.set_name, names.empty() ? "none" : names);
    }
    nodes = found->second;
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    if (!nodes.empty() && (nodes.front() < 0 || nodes.back() >= mesh.n_nodes())) {
      throw InputError("support", "the node set names nodes that the mesh has not", region.set_name);
    }
  } else {
    const Eigen::Vector3d low_m = mesh.nodes_m.colwise().minCoeff().transpose(),
                          high_m = mesh.nodes_m.colwise().maxCoeff().transpose();
    const double slack_m = 1e-6 * (high_m - low_m).norm();
    for (int i = 0; i < mesh.n_nodes(); ++i) {
      const Eigen::Vector3d x = mesh.nodes_m.row(i).transpose();
      bool inside = false;
      switch (region.kind) {
        case Region::Kind::kPlane:
          inside = std::abs(x[region.axis] - region.value_m) <= slack_m;
          break;
        case Region::Kind::kLeast:
          inside = x[region.axis] <= low_m[region.axis] + slack_m;
          break;
        case Region::Kind::kMost:
          inside = x[region.axis] >= high_m[region.axis] - slack_m;
          break;
        case Region::Kind::kBelow:
          inside = x[region.axis] < region.value_m;
          break;
        case Region::Kind::kAbove:
          inside = x[region.axis] > region.value_m;
          break;
        default:
          inside = ((x - region.low_m).array() >= -slack_m).all() && ((region.high_m - x).array() >= -slack_m).all();
      }
      if (inside) nodes.push_back(i);
    }
  }
  if (nodes.empty()) throw InputError("support", "the region holds no node", support.where);
  return nodes;
}

}  // namespace klang::solid
