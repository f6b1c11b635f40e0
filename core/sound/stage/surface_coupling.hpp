#pragma once
#include <Eigen/Core>

#include "core/physics/modal/modal_model.hpp"

namespace klang::stage {

/// S02 section 3.4: sum over the surface of |normal displacement| times area, times the frequency in Hz; n_modes.
Eigen::VectorXd surface_coupling(const modal::ModalModel& model);

}  // namespace klang::stage
