#include "core/physics/rigid/detail/ways_apart.hpp"

#include <algorithm>
#include <cmath>

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

constexpr double kShare = 0.2;  // of an overlap, per step
constexpr double kSameNormal = 1e-3;
constexpr int kSweeps = 200, kFewestSweeps = 10, kRounds = 12;
constexpr double kSettled = 1e-4, kDeeper = 1e-3;  // of the farthest way that is asked for

/// Points of a pair with one normal.
struct Side {
  int a = 0, b = -1;
  Vector3d normal;
  double want = 0.0;                  // way apart; negative: may come so much nearer
  double give_a = 0.0, give_b = 0.0;  // inverse masses
  bool active = false;
  double give = 0.0, push = 0.0, ahead = 0.0, got = 0.0;
};

std::vector<Side> sides_of(const std::vector<Contact>& contacts, const std::vector<double>& gaps, double slop,
                           const std::vector<BodyState>& bodies) {
  std::vector<Side> sides;
  std::size_t first = 0;  // of the pair's
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    if (!sides.empty() && (sides.back().a != c.a || sides.back().b != c.b)) first = sides.size();
    const bool asks = gaps[i] < -2 * slop;
    if (!(gaps[i] < HUGE_VAL) || (c.tied && !asks)) continue;
    const double over = -gaps[i] - slop, want = asks ? kShare * over : std::min(0.0, over);
    const auto same = std::find_if(sides.begin() + static_cast<std::ptrdiff_t>(first), sides.end(), [&](const Side& s) {
      return (s.normal - c.normal).squaredNorm() <= kSameNormal * kSameNormal;
    });
    if (same == sides.end()) {
      const double give_a = bodies[body_index(c.a)].inverse_mass,
                   give_b = c.b >= 0 ? bodies[body_index(c.b)].inverse_mass : 0.0;
      if (give_a + give_b > 0) sides.push_back({c.a, c.b, c.normal, want, give_a, give_b});
    } else if (want > same->want) {
      same->want = want;
      same->normal = c.normal;
    }
  }
  for (Side& side : sides) side.active = side.want > 0;
  return sides;
}

class WaysApart {
 public:
  WaysApart(std::vector<Side> sides, std::size_t n_bodies)
      : sides_(std::move(sides)), ways_(n_bodies, Vector3d::Zero()) {
    for (const Side& side : sides_) farthest_ = std::max(farthest_, side.want);
  }
  /// Until what was left out is kept, too, and nothing goes deeper.
  std::vector<Vector3d> solved() {
    for (int round = 0; round < kRounds; ++round) {
      solve();
      bool fits = true;
      for (Side& side : sides_) {
        if (side.active || !(way_of(side) < side.want - kDeeper * farthest_)) continue;
        side.active = true;
        fits = false;
      }
      if (fits && !ask_less()) break;
    }
    return std::move(ways_);
  }

 private:
  double way_of(const Side& side) const {
    Vector3d way = ways_[body_index(side.a)];
    if (side.b >= 0) way -= ways_[body_index(side.b)];
    return side.normal.dot(way);
  }
  /// Ways by pushes.
  void go(double Side::*push) {
    for (const Side* side : active_) {
      ways_[body_index(side->a)].setZero();
      if (side->b >= 0) ways_[body_index(side->b)].setZero();
    }
    for (const Side* side : active_) {
      ways_[body_index(side->a)] += side->give_a * side->*push * side->normal;
      if (side->b >= 0) ways_[body_index(side->b)] -= side->give_b * side->*push * side->normal;
    }
  }
  void share_masses() {
    std::vector<int> n_sides(ways_.size(), 0);
    active_.clear();
    for (Side& side : sides_) {
      if (!side.active) continue;
      active_.push_back(&side);
      ++n_sides[body_index(side.a)];
      if (side.b >= 0) ++n_sides[body_index(side.b)];
    }
    for (Side* side : active_) {
      side->give = n_sides[body_index(side->a)] * side->give_a;
      if (side->b >= 0) side->give += n_sides[body_index(side->b)] * side->give_b;
      side->push = side->ahead = side->got = 0.0;
    }
  }
  void solve() {
    share_masses();
    double momentum = 1.0;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      go(&Side::ahead);
      double change = 0.0, uphill = 0.0;
      for (Side* side : active_) {
        const double got = way_of(*side), before = side->push;
        change = std::max(change, std::abs(got - side->got));
        side->got = got;
        side->push = std::max(0.0, side->ahead + (side->want - got) / side->give);
        uphill += side->give * (side->ahead - side->push) * (side->push - before);
        side->ahead = side->push - before;  // until it is known how far on
      }
      if (uphill > 0) momentum = 1.0;
      const double next = 0.5 * (1 + std::sqrt(1 + 4 * momentum * momentum));
      for (Side* side : active_) side->ahead = side->push + (momentum - 1) / next * side->ahead;
      momentum = next;
      if (sweep >= kFewestSweeps && change <= kSettled * farthest_) break;
    }
    go(&Side::push);
  }
  /// Where something goes deeper half of what is asked of its bodies.
  bool ask_less() {
    std::vector<char> caught(ways_.size(), 0);
    bool any = false;
    for (const Side* side : active_) {
      if (!(way_of(*side) < std::min(0.0, side->want) - kDeeper * farthest_)) continue;
      any = true;
      if (side->give_a > 0) caught[body_index(side->a)] = 1;
      if (side->give_b > 0) caught[body_index(side->b)] = 1;
    }
    for (Side& side : sides_)
      if (side.want > 0 && (caught[body_index(side.a)] != 0 || (side.b >= 0 && caught[body_index(side.b)] != 0)))
        side.want *= 0.5;
    return any;
  }

  std::vector<Side> sides_;
  std::vector<Side*> active_;
  std::vector<Vector3d> ways_;
  double farthest_ = 0.0;
};

}  // namespace

std::vector<Vector3d> ways_apart(const std::vector<Contact>& contacts, const std::vector<double>& gaps, double slop,
                                 const std::vector<BodyState>& bodies) {
  if (std::none_of(gaps.begin(), gaps.end(), [&](double gap) { return gap < -2 * slop; })) return {};
  return WaysApart(sides_of(contacts, gaps, slop, bodies), bodies.size()).solved();
}

}  // namespace klang::rigid::detail
