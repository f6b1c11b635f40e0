#include "core/physics/rigid/detail/link_contacts.hpp"

namespace klang::rigid::detail {

using Eigen::Vector3d;

std::vector<Contact> link_contacts(const std::vector<Link>& links, const std::vector<RigidBodySpec>& specs,
                                   const std::vector<BodyState>& bodies, double length, double slop) {
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const auto a = static_cast<std::size_t>(link.a), b = static_cast<std::size_t>(std::max(link.b, 0));
    if (!bodies[a].there || (link.b >= 0 && !bodies[b].there)) continue;  // it broke: its links are gone
    const Vector3d at_a = bodies[a].centre + bodies[a].turn * (length * (link.at_a_m - specs[a].centre_m));
    const Vector3d at_b =
        link.b >= 0 ? Vector3d(bodies[b].centre + bodies[b].turn * (length * (link.at_b_m - specs[b].centre_m)))
                    : Vector3d(length * link.at_b_m);
    const Vector3d way = at_b - at_a;
    const double distance = way.norm();
    Contact c;
    c.a = link.a;
    c.b = link.b;
    c.link = static_cast<int>(i);
    c.tied = !link.length_m;
    c.gap = length * link.length_m.value_or(0.0) - distance;
    if (!(c.gap <= slop)) continue;
    if (distance > 0.0) c.normal = way / distance;
    c.place = at_a;
    c.arm_a = at_a - bodies[a].centre;
    c.arm_b = link.b >= 0 ? Vector3d(at_b - bodies[b].centre) : Vector3d::Zero();
    contacts.push_back(c);
  }
  return contacts;
}

}  // namespace klang::rigid::detail
