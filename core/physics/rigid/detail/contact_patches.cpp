#include "core/physics/rigid/detail/contact_patches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace klang::rigid::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSameNormal = 1e-6;
constexpr double kNear = 1e-3;  // of the slop
constexpr int kMostCorners = 8;
constexpr double kFirstTurn = 0.1;  // off the corners of what is made in even shares of a turn

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Corner {
  Vector2d at = Vector2d::Zero();
  std::size_t contact = 0;
};

/// Contacts of one pair with one normal in one plane, within a slop: bodies that touch may tilt by that much.
struct Patch {
  Vector3d normal, origin;
  std::vector<std::size_t> contacts;
};

std::vector<Patch> patches_of(const std::vector<Contact>& contacts, std::size_t first, std::size_t last, double flat) {
  std::vector<Patch> patches;
  for (std::size_t i = first; i < last; ++i) {
    const Contact& c = contacts[i];
    const auto holds = [&](const Patch& patch) {
      return (patch.normal - c.normal).squaredNorm() <= kSameNormal * kSameNormal &&
             std::abs(patch.normal.dot(c.place - patch.origin)) <= flat;
    };
    const auto found = std::find_if(patches.begin(), patches.end(), holds);
    if (found != patches.end())
      found->contacts.push_back(i);
    else
      patches.push_back({c.normal, c.place, {i}});
  }
  return patches;
}

/// How far a point is to the right of the way from one to another.
double outside(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const Vector2d way = to - from;
  return -cross(way, point - from) / way.norm();
}

/// Half of a convex hull: turns to the left only.
void add_chain(const std::vector<Corner>& points, bool forward, double near, std::vector<Corner>& hull) {
  const std::size_t begin = hull.size();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Corner& next = forward ? points[k] : points[points.size() - 1 - k];
    while (hull.size() >= begin + 2 && !(outside(hull.back().at, hull[hull.size() - 2].at, next.at) > near))
      hull.pop_back();
    hull.push_back(next);
  }
  hull.pop_back();  // the other half begins there
}

/// Of many corners those that lie farthest in directions that turn with the body, so that they are the same from step to step, and
/// what is deeper than these.
std::vector<Corner> farthest(const std::vector<Corner>& hull, const Vector2d& ahead, double slop,
                             const std::vector<Contact>& contacts) {
  std::vector<char> chosen(hull.size(), 0);
  double deepest = HUGE_VAL;
  for (int k = 0; k < kMostCorners; ++k) {
    const Vector2d way = Eigen::Rotation2Dd(kFirstTurn + 2 * M_PI * k / kMostCorners) * ahead;
    std::size_t best = 0;
    for (std::size_t i = 1; i < hull.size(); ++i)
      if (way.dot(hull[i].at) > way.dot(hull[best].at)) best = i;
    chosen[best] = 1;
    deepest = std::min(deepest, contacts[hull[best].contact].gap);
  }
  std::vector<Corner> kept;
  for (std::size_t i = 0; i < hull.size(); ++i)
    if (chosen[i] != 0 || contacts[hull[i].contact].gap < deepest - 0.5 * slop) kept.push_back(hull[i]);
  return kept;
}

std::vector<std::size_t> corners_of(const std::vector<Contact>& contacts, const Patch& patch,
                                    const std::vector<BodyState>& bodies, double slop) {
  const double near = kNear * slop;
  const Vector3d x = patch.normal.unitOrthogonal(), y = patch.normal.cross(x);
  std::vector<Corner> points;
  for (const std::size_t i : patch.contacts) {
    const Vector3d arm = contacts[i].place - patch.origin;
    const Vector2d at(x.dot(arm), y.dot(arm));
    const bool known = std::any_of(points.begin(), points.end(),
                                   [&](const Corner& p) { return (p.at - at).squaredNorm() <= near * near; });
    if (!known) points.push_back({at, i});
  }
  std::sort(points.begin(), points.end(), [](const Corner& p, const Corner& q) {
    return p.at.x() < q.at.x() || (p.at.x() == q.at.x() && p.at.y() < q.at.y());
  });
  std::vector<Corner> hull;
  if (points.size() < 3) {
    hull = points;
  } else {
    add_chain(points, true, near, hull);
    add_chain(points, false, near, hull);
    // Where a side stands upright the last digits choose the chains' ends, which need not be corners.
    for (std::size_t i = 0; hull.size() > 2 && i < hull.size();) {
      const Corner &before = hull[(i + hull.size() - 1) % hull.size()], &after = hull[(i + 1) % hull.size()];
      if (std::abs(outside(hull[i].at, before.at, after.at)) <= near)
        hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(i));
      else
        ++i;
    }
  }
  if (hull.size() > kMostCorners) {
    const BodyState& body = bodies[static_cast<std::size_t>(contacts[patch.contacts.front()].a)];
    Vector2d ahead = Vector2d::Zero();  // of the body's axes the one that lies most in the patch, along the patch
    for (int i = 0; i < 3; ++i) {
      const Vector3d axis = body.turn * Vector3d::Unit(i);
      const Vector2d along(x.dot(axis), y.dot(axis));
      if (along.norm() > ahead.norm() + 1e-3) ahead = along;
    }
    hull = farthest(hull, ahead.normalized(), slop, contacts);
  }
  std::vector<std::size_t> kept;
  for (const Corner& corner : hull) kept.push_back(corner.contact);
  return kept;
}

}  // namespace

std::vector<Contact> patch_corners(const std::vector<Contact>& contacts, const std::vector<BodyState>& bodies,
                                   double slop) {
  std::vector<Contact> kept;
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    const auto pair = [](const Contact& c) { return std::pair(c.a, c.b); };
    while (last < contacts.size() && pair(contacts[last]) == pair(contacts[first])) ++last;
    std::vector<std::size_t> chosen;
    if (contacts[first].b < 0) {
      for (std::size_t i = first; i < last; ++i) chosen.push_back(i);
    } else {
      for (const Patch& patch : patches_of(contacts, first, last, slop))
        for (const std::size_t i : corners_of(contacts, patch, bodies, slop)) chosen.push_back(i);
      std::sort(chosen.begin(), chosen.end());
    }
    for (const std::size_t i : chosen) kept.push_back(contacts[i]);
  }
  return kept;
}

}  // namespace klang::rigid::detail
