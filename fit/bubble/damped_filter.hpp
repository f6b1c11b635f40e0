#pragma once
#include <Eigen/Core>
#include <vector>

namespace klang::fit::bubble {

/// Correlations of white noise plus rings with decaying exponentials e^(-(beta + i omega) t) that begin at every sample, on
/// a grid of frequencies: the matched filter of a ring whose frequency stands still. One recursion backwards in time
/// per frequency.
class DampedFilterBank {
 public:
  struct Atom {
    double frequency_hz = 0.0, decay_per_s = 0.0;
  };
  DampedFilterBank(std::vector<Atom> atoms, double sample_rate_hz, Eigen::Index n_samples);

  /// Computes anew every best score that samples [first, last) reach.
  void update(const Eigen::VectorXf& whitened, Eigen::Index first, Eigen::Index last);

  struct Peak {
    double score = 0.0;  ///< |correlation|^2 / energy of the atom: exponential with mean 1 in unit white noise
    Eigen::Index sample = 0;
    std::size_t atom = 0;
  };
  /// Highest score among samples in [first, last) that stands above what was masked there.
  Peak highest(Eigen::Index first, Eigen::Index last) const;
  /// From now on scores up to this are nothing new for atoms in [low_hz, high_hz] that begin in the stretches of [first, last).
  void mask(Eigen::Index first, Eigen::Index last, double low_hz, double high_hz, double score);
  const Atom& atom(std::size_t i) const { return atoms_[i]; }

  /// Best scores are kept for each stretch of this many samples.
  static constexpr Eigen::Index kBlock = 64;

 private:
  std::vector<Atom> atoms_;
  double sample_rate_hz_;
  Eigen::Index n_samples_, n_blocks_, n_padded_;
  Eigen::ArrayXf pole_real_, pole_imag_, gain_;  // by atom, padded
  std::vector<Eigen::Index> reach_;              // samples until an atom has decayed to 1e-4
  Eigen::ArrayXXf best_, mask_;                  // atoms (padded) x blocks
  Eigen::Array<int, Eigen::Dynamic, Eigen::Dynamic> best_at_;
};

}  // namespace klang::fit::bubble
