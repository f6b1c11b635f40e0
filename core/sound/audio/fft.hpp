#pragma once
#include <Eigen/Core>
#include <filesystem>

namespace klang::audio {

/// Smallest 2^a 3^b 5^c that is >= n (n >= 1), where the transforms are fast.
Eigen::Index good_fft_size(Eigen::Index n);
/// Largest such number <= n.
Eigen::Index good_fft_size_below(Eigen::Index n);

/// X[k] = sum_m x[m] exp(-2 pi i k m / n_fft), k = 0..n_fft/2; x is cut or padded with zeros to n_fft.
/// Plans are made once a size (one mutex for the process: FFTW's planner is not thread safe) and never by
/// timing, so that every run gives the same bits.
Eigen::VectorXcd real_spectrum(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Index n_fft);

/// The inverse of real_spectrum: n_fft real samples (divided by n_fft) from n_fft/2 + 1 coefficients.
Eigen::VectorXd real_from_spectrum(const Eigen::VectorXcd& spectrum, Eigen::Index n_fft);

/// x[m] = (1/n) sum_k X[k] exp(2 pi i k m / n).
Eigen::VectorXcd complex_from_spectrum(const Eigen::VectorXcd& spectrum);

/// From here on plans are timed (FFTW_MEASURE) and their wisdom is kept in this file: faster on repeated
/// runs, and the last bits may then differ between machines. Without a call nothing is read or written.
/// @throws InputError when the file exists and is not FFTW wisdom.
void use_fft_wisdom(const std::filesystem::path& file);
/// Writes what was learnt since use_fft_wisdom; nothing when it was not called.
void save_fft_wisdom();

}  // namespace klang::audio
