#pragma once
#include <map>
#include <vector>

#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/held_mobility.hpp"

namespace klang::rigid::detail {

/// Contacts as pushes of a few bodies, with the ties that hold these, in inner units.
class TiedBodies {
 public:
  explicit TiedBodies(const Bodies& all) : all_(all) {}
  /// Along the contact's normal.
  PairPush push_of(const Contact& contact);
  void add_tie(const Contact& link);  ///< in all directions that it holds
  int number_of(int body);            ///< among `bodies`; kFloor stays

  std::vector<PushedBody> bodies;
  std::vector<int> known;  ///< the world's numbers of these
  std::vector<PairPush> ties;

 private:
  const Bodies& all_;
  std::map<int, int> numbers_;
};

}  // namespace klang::rigid::detail
