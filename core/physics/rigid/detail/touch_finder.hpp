#pragma once
#include <functional>
#include <vector>

#include "core/physics/rigid/detail/collisions.hpp"
#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/link.hpp"
#include "core/physics/rigid/rigid_body.hpp"
#include "core/physics/rigid/rigid_world.hpp"

namespace klang::rigid::detail {

/// Bodies of a world and what ties them, as the search for contacts sees them.
struct TouchFinder {
  const RigidWorldOptions& options;
  const std::vector<RigidBodySpec>& specs;
  const std::vector<Link>& links;
  Collisions& collisions;
  const std::vector<double>& radius;  ///< of each body's farthest point from its centre, inner length
  double length = 1.0;                ///< inner lengths per metre

  /// Points with a gap of at most slop where all bodies are, links that are taut among them, sorted by pairs; complete.
  std::vector<Contact> all(const std::vector<BodyState>& where, double slop) const;
  /// Without links, and not complete.
  std::vector<Contact> bodies(const std::vector<BodyState>& where, double slop) const;
  /// All of one pair, patches not thinned.
  std::vector<Contact> of_pair(int a, int b, const BodyState& at_a, const BodyState& at_b, double slop) const;
  /// What of these two bodies' pair, as they stand among all, is solved.
  std::vector<Contact> of_pair(int a, int b, const std::vector<BodyState>& where, double slop) const;
  /// Links alone that are taut between two bodies.
  std::vector<Contact> ties(int a, int b, const std::vector<BodyState>& where, double slop) const;
  /// Those of one body with the others, sorted by pairs. @param without  leaves out those with these bodies
  std::vector<Contact> of_body(int body, const std::vector<int>& without, const std::vector<BodyState>& where,
                               double slop) const;
  /// Bodies that may touch that one, tied ones among them, and kFloor; sorted. Collisions::move() says where it is.
  std::vector<int> neighbours(int body) const;

 private:
  void add_links(std::vector<Contact>& contacts, const std::vector<BodyState>& where, double slop,
                 const std::function<bool(const Link&)>& wanted) const;
  bool tied(int a, int b) const;
  void add_links(int a, int b, const BodyState& at_a, const BodyState& at_b, double slop,
                 std::vector<Contact>& contacts) const;
  void complete(Contact& contact, const BodyState& at_a, const BodyState& at_b) const;
};

}  // namespace klang::rigid::detail
