#pragma once
#include <optional>

#include "core/physics/modal/damping/rayleigh.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "fit/proxy/proxy_sound.hpp"
#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

/// What a proxy is to sound like: a model's modes from the lowest up, or the partials of a recording.
struct ProxyTarget {
  Voice voice;                             ///< by frequency
  std::optional<Eigen::Vector3d> moments;  ///< principal moments over density, of a model
  double shear_speed_m_s = 0.0;            ///< of its material; 0: the bank's
  damping::RayleighDamping damping;        ///< a model's; zero: to be found by the decays
  /// Of a model with transfer: amplitudes are pressures, decays hold the radiation; a proxy is to have both from its bank.
  struct Radiation {
    acoustics::Medium medium;
    double solid_density_kg_m3 = 0.0;
  };
  std::optional<Radiation> radiation;
};

/// A struck body on the average over all places of the body for strike and microphone: mode k rings with amplitude 1 / omega_k, since the
/// mean square of a mass-normalised shape over the volume is 1 / m for every mode; relative to the lowest.
ProxyTarget target_of_model(const modal::ModalModel& model, const damping::RayleighDamping& damping);
/// The same as it sounds far away: amplitude [Pa] at 1 m, rms over directions, for unit modal velocity (a strike's mean square modal
/// velocity is J^2 / m for every mode): sqrt(2 rho c P / (4 pi)) with the radiated power P; decay plus radiation. Modes up to the first that has
/// no transfer. The strike's own spectrum takes no part.
/// @throws InputError for fewer than 3 modes with transfer
ProxyTarget target_of_model(const modal::ModalModel& model, const acoustics::TransferModel& transfer,
                            const damping::RayleighDamping& damping);
/// Pressure amplitude at 1 m of that power [Pa], rms over directions.
double far_amplitude_pa(double radiated_power_w, const acoustics::Medium& medium);
/// @throws InputError for partials without decay or amplitude
ProxyTarget target_of_partials(const PartialTable& table);

}  // namespace klang::fit
