#include "core/geometry/shapes/profile_dimensions.hpp"

#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/profile_change.hpp"
#include "core/geometry/shapes/shape_registry.hpp"

namespace klang::mesh {

std::map<std::string, double> drawn_dimensions_m(const ShapeSpec& spec) {
  validate(spec);
  if (!find_shape(spec.kind).facts().has_profile) return {};
  return detail::ProfileChange::drawn_dimensions_m(detail::read_profile(spec.profile_csv));
}

std::string profile_csv(const ShapeSpec& spec) {
  validate(spec);
  if (!find_shape(spec.kind).facts().has_profile) throw InputError("shape " + spec.kind, "has no profile");
  const detail::ProfileChange change(detail::read_profile(spec.profile_csv), spec.dims);
  const detail::Profile& profile = change.changed();
  std::string text = "r_m,z_m,zone\n";
  for (std::size_t i = 0; i < profile.points_m.size(); ++i)
    text += to_text(profile.points_m[i].x()) + "," + to_text(profile.points_m[i].y()) + "," +
            std::to_string(profile.zones[i]) + "\n";
  return text;
}

}  // namespace klang::mesh
