#pragma once
#include <optional>

#include "core/modal/modal_model.hpp"
#include "fit/partial_table.hpp"
#include "fit/proxy/proxy_sound.hpp"

namespace klang::fit {

/// What a proxy is to sound like: a model's modes from the lowest up, or the partials of a recording.
struct ProxyTarget {
  Voice voice;                             ///< by frequency
  std::optional<Eigen::Vector3d> moments;  ///< principal moments over density, of a model
  double shear_speed_m_s = 0.0;            ///< of its material; 0: the bank's
  double rayleigh_mass_per_s = 0.0, rayleigh_stiffness_s = 0.0;  ///< a model's damping: decay = (mass + stiffness omega^2) / 2
};

/// A struck body on the average over all places of strike and microphone: mode k rings with amplitude 1 / (m omega_k), its mean square shape
/// being 1 / m.
ProxyTarget target_of_model(const modal::ModalModel& model, double rayleigh_mass_per_s, double rayleigh_stiffness_s);
/// @throws InputError for partials without decay or amplitude
ProxyTarget target_of_partials(const PartialTable& table);

}  // namespace klang::fit
