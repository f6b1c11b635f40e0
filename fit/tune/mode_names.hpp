#pragma once
#include <string>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/modal_model.hpp"

namespace klang::fit {

/// A mode by what it is called: its index from 0; "bending N" of a long body; of a body of revolution "ring M,K", the K-th (1: may be
/// left out) with M nodal diameters, or what a bell's are called: hum (ring 2,1), prime (ring 2,2), tierce (ring 3,1), quint
/// (ring 3,2), nominal (ring 4,1). Of a pair the first.
/// @throws InputError: an unknown name, or a mode that is not among those of the model
int named_mode(const std::string& mode, const mesh::ShapeSpec& shape, const modal::ModalModel& model);

}  // namespace klang::fit
