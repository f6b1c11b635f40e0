#pragma once
#include <string>
#include <vector>

#include "core/physics/modal/modal_model.hpp"
#include "reports/pages/mode_shapes.hpp"

namespace klang::reports::detail {

/// What the modes of a long body (three times as long as it is wide) are called: "2nd bending", "1st torsion", "1st
/// longitudinal", where more than half of the motion is that of whole cross-sections; the strong direction of a flat bar is
/// "2nd bending edgewise". Empty for others. A mode with its twin counts once.
std::vector<std::string> mode_names(const modal::ModalModel& model);

/// The body turning and moving in its modes: its surface and shapes for the script that draws them, with a list of the modes.
/// Empty where the file is not there, cannot be read, or is no mesh.
/// @param n_bodies  that share the page's room
std::string shape_view_html(const BodyModes& body, std::size_t n_bodies, ReportFolder& folder);

}  // namespace klang::reports::detail
