#include "core/physics/rigid/detail/touch_finder.hpp"

#include <algorithm>

#include "core/physics/rigid/detail/contact_patches.hpp"
#include "core/physics/rigid/detail/link_contacts.hpp"

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

/// Columns: the normal and two tangents.
Eigen::Matrix3d axes_of(const Vector3d& normal) {
  Eigen::Matrix3d axes;
  axes.col(0) = normal;
  axes.col(1) = normal.unitOrthogonal();
  axes.col(2) = normal.cross(axes.col(1));
  return axes;
}

}  // namespace

void TouchFinder::complete(Contact& c, const BodyState& at_a, const BodyState& at_b) const {
  c.axes = axes_of(c.normal);
  c.turn_a = at_a.turn;
  if (c.b >= 0) c.turn_b = at_b.turn;
  if (c.link >= 0) return;
  c.arm_a = c.place - at_a.centre;
  c.arm_b = c.b >= 0 ? Vector3d(c.place - at_b.centre) : Vector3d::Zero();
  const Skin& a = specs[body_index(c.a)].skin;
  const Skin& other = c.b >= 0 ? specs[body_index(c.b)].skin : *options.floor;
  c.restitution = pair_restitution(a, other);
  c.friction = pair_friction(a, other);
}

/// Bodies that are tied together overlap where they are.
bool TouchFinder::tied(int a, int b) const {
  return b >= 0 && std::any_of(links.begin(), links.end(),
                               [&](const Link& link) { return !link.length_m && link.a == a && link.b == b; });
}

void TouchFinder::add_links(int a, int b, const BodyState& at_a, const BodyState& at_b, double slop,
                            std::vector<Contact>& contacts) const {
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].a != a || links[i].b != b) continue;
    if (auto c = link_contact(links[i], {specs[body_index(a)], at_a}, {specs[body_index(b)], at_b}, length, slop)) {
      c->link = static_cast<int>(i);
      contacts.push_back(*c);
    }
  }
}

std::vector<Contact> TouchFinder::bodies(const std::vector<BodyState>& where, double slop) const {
  std::vector<Contact> contacts = collisions.find(where, slop, options.floor.has_value());
  if (!links.empty()) std::erase_if(contacts, [&](const Contact& c) { return tied(c.a, c.b); });
  return contacts;
}

void TouchFinder::add_links(std::vector<Contact>& contacts, const std::vector<BodyState>& where, double slop,
                            const std::function<bool(const Link&)>& wanted) const {
  if (links.empty()) return;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const BodyState &a = where[body_index(link.a)], &b = where[body_index(link.b)];
    if (!a.there || (link.b >= 0 && !b.there) || !wanted(link)) continue;  // it broke: its links are gone
    if (auto c = link_contact(link, {specs[body_index(link.a)], a}, {specs[body_index(link.b)], b}, length, slop)) {
      c->link = static_cast<int>(i);
      contacts.push_back(*c);
    }
  }
  const auto pair = [](const Contact& c) { return std::pair(c.a, c.b); };
  std::stable_sort(contacts.begin(), contacts.end(),
                   [&](const Contact& x, const Contact& y) { return pair(x) < pair(y); });
}

std::vector<Contact> TouchFinder::all(const std::vector<BodyState>& where, double slop) const {
  std::vector<Contact> contacts = bodies(where, slop);
  add_links(contacts, where, slop, [](const Link&) { return true; });
  for (Contact& c : contacts) complete(c, where[body_index(c.a)], where[body_index(c.b)]);
  return contacts;
}

std::vector<Contact> TouchFinder::of_body(int body, const std::vector<int>& without,
                                          const std::vector<BodyState>& where, double slop) const {
  std::vector<Contact> contacts = collisions.of_body(body, without, where, options.floor.has_value());
  if (!links.empty()) std::erase_if(contacts, [&](const Contact& c) { return tied(c.a, c.b); });
  add_links(contacts, where, slop, [&](const Link& link) {
    const int other = link.a == body ? link.b : link.a;
    return (link.a == body || link.b == body) && std::find(without.begin(), without.end(), other) == without.end();
  });
  for (Contact& c : contacts) complete(c, where[body_index(c.a)], where[body_index(c.b)]);
  return contacts;
}

std::vector<Contact> TouchFinder::of_pair(int a, int b, const BodyState& at_a, const BodyState& at_b,
                                          double slop) const {
  std::vector<Contact> contacts;
  if (!tied(a, b) && (b >= 0 || options.floor)) contacts = collisions.find_pair(a, b, at_a, at_b, slop);
  add_links(a, b, at_a, at_b, slop, contacts);
  for (Contact& c : contacts) complete(c, at_a, at_b);
  return contacts;
}

std::vector<Contact> TouchFinder::of_pair(int a, int b, const std::vector<BodyState>& where, double slop) const {
  const BodyState &at_a = where[body_index(a)], &at_b = where[body_index(b)];
  std::vector<Contact> contacts;
  if (!tied(a, b) && (b >= 0 || options.floor))
    contacts = patch_corners(collisions.find_pair(a, b, at_a, at_b, slop), where, slop);
  add_links(a, b, at_a, at_b, slop, contacts);
  for (Contact& c : contacts) complete(c, at_a, at_b);
  return contacts;
}

std::vector<Contact> TouchFinder::ties(int a, int b, const std::vector<BodyState>& where, double slop) const {
  const BodyState &at_a = where[body_index(a)], &at_b = where[body_index(b)];
  std::vector<Contact> contacts;
  add_links(a, b, at_a, at_b, slop, contacts);
  for (Contact& c : contacts) complete(c, at_a, at_b);
  return contacts;
}

std::vector<int> TouchFinder::neighbours(int body) const {
  std::vector<int> near = collisions.neighbours(body);
  near.push_back(kFloor);
  for (const Link& link : links) {
    if (link.a == body) near.push_back(link.b);
    if (link.b == body) near.push_back(link.a);
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  return near;
}

}  // namespace klang::rigid::detail
