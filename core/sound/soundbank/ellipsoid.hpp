#pragma once
#include "core/physics/modal/ellipsoid_modes.hpp"

/// The bodies of a soundbank vibrate as core/physics/modal has it.
namespace klang::soundbank {

using modal::EllipsoidModeOptions;
using modal::EllipsoidModes;
using modal::kModeClasses;
using modal::lowest_modes;
using modal::mode_shape_size;
using modal::ModeId;
using modal::rigid_motions;

}  // namespace klang::soundbank
