#pragma once
#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace klang::stage {

/// Modes that sound as one partial: pairs of round bodies and square plates, multiplets of balls. Modes follow one another by
/// frequency in a group while they lie within the sum of their decays, or 0.2 % (a mesh parts what is equal by less).
/// @param omega_rad_s, decay_per_s  one per mode, in any order
/// @return groups of two modes or more, each by rising frequency
std::vector<std::vector<std::size_t>> modes_of_one_pitch(const Eigen::VectorXd& omega_rad_s,
                                                         const Eigen::VectorXd& decay_per_s);

/// u of modulus 1 with the largest sum of Re(p_i u*)^2: the phase that such modes have in common, up to the sign, which is that of
/// the loudest. 1 where all are silent.
std::complex<double> common_phase(std::span<const std::complex<double>> pressures);

}  // namespace klang::stage
