#include "core/physics/rigid/detail/link_contacts.hpp"

namespace klang::rigid::detail {

using Eigen::Vector3d;

std::optional<Contact> link_contact(const Link& link, const LinkEnd& a, const LinkEnd& b, double length, double slop) {
  const Vector3d end_a = a.at.centre + a.at.turn * (length * (link.at_a_m - a.spec.centre_m));
  const Vector3d end_b = link.b >= 0 ? Vector3d(b.at.centre + b.at.turn * (length * (link.at_b_m - b.spec.centre_m)))
                                     : Vector3d(length * link.at_b_m);
  const Vector3d way = end_b - end_a;
  const double distance = way.norm();
  Contact c;
  c.a = link.a;
  c.b = link.b;
  c.tied = !link.length_m;
  c.gap = length * link.length_m.value_or(0.0) - distance;
  if (!(c.gap <= slop)) return std::nullopt;
  if (distance > 0.0) c.normal = way / distance;
  c.place = end_a;
  c.arm_a = end_a - a.at.centre;
  c.arm_b = link.b >= 0 ? Vector3d(end_b - b.at.centre) : Vector3d::Zero();
  return c;
}

}  // namespace klang::rigid::detail
