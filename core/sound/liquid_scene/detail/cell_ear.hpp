#pragma once
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/liquid/frames.hpp"
#include "core/sound/dual_domain/reciprocal.hpp"
#include "core/sound/liquid_scene/cell_ear_state.hpp"
#include "core/sound/liquid_scene/detail/cell_waves.hpp"

namespace klang::liquid_scene {

/// The largest body of liquid, and whether solids are in or near the liquid.
struct CellBody {
  liquid::LiquidSurface surface;
  bool with_solids = false;
};

/// The ear's field in a moving liquid at the pitch of each bubble: boundary elements in the air, the frame's own cells in the liquid. The air is
/// solved at bins of frequency and anew when it has changed; what it does between them is smooth but for the way to the ear. The liquid
/// resonates, and is solved at each pitch: from its waves of the frame before, and as exactly as these do not hold any more.
class CellEar {
 public:
  /// All are kept by reference.
  CellEar(const liquid::LiquidFrames& frames, const bubble::ReciprocalOptions& options, int bins_per_octave,
          Monitor& monitor);

  /// Whether the air's elements are too old at a time. They live 0.08 s at first; twice as long, to 0.64 s, where their successors changed
  /// what the free surface hears by less than 10 %, half as long where by more than 20 % (at the highest frequency at which the coarsest
  /// elements are enough).
  bool due(double time_s) const;
  /// @return false: the surface has walls that are no sides of its box; the cells do not know them
  bool renew(const bubble::LiquidBoundary& boundary, const CellBody& body, const Eigen::Vector3d& ear_m, double time_s);
  /// Between two frames, the second of which has been solved.
  CellEarState state() const;
  /// Goes on from there. @param boundary, body  of the frame in which that air was made
  bool restore(CellEarState state, const bubble::LiquidBoundary& boundary, const CellBody& body,
               const Eigen::Vector3d& ear_m);
  void enter(std::size_t frame);  ///< to be called for each frame before what follows
  bool holds(const Eigen::Vector3d& x_m) const { return cells_->holds(x_m); }
  /// All bubbles of the frame at once, by any number of theirs; the work is shared between threads.
  void solve(const std::map<std::size_t, double>& pitch_of_bubble);
  std::complex<double> pressure(std::size_t bubble, const bubble::SwingingBubble& at) const;
  bool converged(std::size_t bubble) const { return waves_.at(bubble).waves.converged; }
  int iterations(std::size_t bubble) const { return waves_.at(bubble).waves.iterations; }
  struct Error {
    double bins = 0.0, air = 0.0, cells = 0.0, age = 0.0;
    double all() const { return bins + air + cells + age; }
  };
  /// Relative error of a pressure: by finer elements of the air (coarser ones of the finest) and, with the same field on the surface, by coarser
  /// cells, both taken to err as the square of their size; by the air solved at this very pitch; by half of what the air changed when it was
  /// last solved anew, as the pitch.
  /// None: no coarser cells fit between the walls. All of it (1) where the liquid's waves did not converge.
  std::optional<Error> error(std::size_t bubble, const bubble::SwingingBubble& at,
                             const bubble::LiquidBoundary& boundary, std::size_t frame);
  /// At the pitch of a bubble, with q_coarse.
  bubble::EarField air_field(std::size_t bubble, const bubble::LiquidBoundary& boundary) const;

 private:
  struct Wave {
    double frequency_hz = 0.0;
    Eigen::VectorXcd heard;    ///< q at the crossings of this frame
    LiquidCells::Waves waves;  ///< of this frame or the one before
  };
  using Elements = std::unique_ptr<const bubble::EarElements>;
  double bin_hz(int bin) const;
  void make_elements(const bubble::LiquidBoundary& boundary);
  static constexpr std::size_t kLevels = 4;
  /// 0 where the first elements are enough for the wavelength; each next one has twice as many vertices.
  std::size_t level(double frequency_hz) const;
  Eigen::MatrixXcd field(const bubble::EarElements& elements, double frequency_hz) const;
  const Eigen::VectorXcd& heard_in_bin(int bin);
  Eigen::VectorXcd heard(double frequency_hz);  ///< at the crossings, between two bins
  const std::vector<std::complex<float>>* start(std::size_t bubble, double frequency_hz) const;
  int compared_bin() const;
  void note_change();
  std::complex<double> strength(const Wave& wave, const bubble::SwingingBubble& at) const;
  LiquidCells::Question question(double frequency_hz, Eigen::VectorXcd q,
                                 const std::vector<std::complex<float>>* start) const;
  const bubble::EarElements::Carrier& carrier(std::size_t level);  ///< to the crossings of this frame
  /// q of finer elements, or coarser ones where there are none, and the share of the difference that is the error of ours.
  std::pair<Eigen::VectorXcd, double> other_air(double frequency_hz, const bubble::LiquidBoundary& boundary,
                                                const Eigen::Matrix3Xd& points_m) const;

  const liquid::LiquidFrames& frames_;
  const bubble::ReciprocalOptions& options_;
  const int bins_per_octave_;
  Monitor& monitor_;
  std::array<Elements, kLevels> elements_;
  Elements old_elements_;                      ///< of level 0
  std::map<int, Eigen::MatrixXcd> q_, old_q_;  ///< of bins, at the vertices of their elements
  std::map<int, Eigen::VectorXcd> heard_;      ///< of bins, at the crossings of this frame
  std::optional<CellBox> box_;
  std::optional<LiquidCells> cells_;
  std::array<std::optional<bubble::EarElements::Carrier>, kLevels> carriers_;
  Eigen::Vector3d ear_m_ = Eigen::Vector3d::Zero();
  double made_s_ = -1e300, life_s_ = 0.0, change_ = 0.0, changed_hz_ = 0.0;
  std::map<std::size_t, Wave> waves_;
};

}  // namespace klang::liquid_scene
