#pragma once
#include <Eigen/Core>

#include "core/physics/modal/modal_model.hpp"

namespace klang::stage {

/// S02 section 3.4: sum over the surface of |normal displacement| times area, times the frequency in Hz; n_modes.
Eigen::VectorXd surface_coupling(const modal::ModalModel& model);

/// What a body's modes are heard with where no listener has a place: surface_coupling; for modes of one pitch (one_pitch.hpp) that of
/// the shape into which the hardest blow sets them all, times each one's share in it with its sign. So it does not matter how
/// a round body's pairs stand to the blow (moduli would make them silent for one blow in four).
/// @param push  n_modes x n_blows, modal impulses
Eigen::VectorXd heard_coupling(const modal::ModalModel& model, const Eigen::VectorXd& decay_per_s,
                               const Eigen::MatrixXd& push);

}  // namespace klang::stage
