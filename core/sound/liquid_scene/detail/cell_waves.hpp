#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/liquid/frames.hpp"
#include "core/sound/liquid_scene/detail/cell_kernel.hpp"

namespace klang::liquid_scene {

/// The cells in which a body of liquid is looked for: the box around its surface, and which of the sides are walls.
struct CellBox {
  Eigen::Vector3d low_m;
  std::array<int, 3> n{};
  double cell_m = 0.0;
  std::array<std::array<bool, 2>, 3> wall{};  ///< of each axis' lower and upper side
  bool with_solids = false;                   ///< they are looked for in the surface of each frame
  bool same_cells(const CellBox& other) const { return n == other.n && low_m == other.low_m && cell_m == other.cell_m; }
};
/// Whether solids, wet or dry, have more than a hundredth of a surface's area. Smaller ones (mouthpieces) are taken as liquid or air,
/// whatever phi says.
bool has_solids(const liquid::LiquidSurface& surface);
/// None: the surface has walls elsewhere, which these cells do not know.
std::optional<CellBox> cell_box(const liquid::LiquidSurface& surface, double cell_m);
/// The same box in cells 1.25 to 2 times as large. None: whole ones do not fit between its walls.
std::optional<CellBox> coarser_box(const CellBox& box);

/// Pass B of reciprocity (core/sound/dual_domain/reciprocal.hpp) on the cells of a frame: (nabla^2 + k^2) w = 0 in the largest body of liquid,
/// w = q where lines between centres cross its surface (Gibou et al. 2002, as the flow's pressure), dw/dn + give w = 0 on walls, dw/dn = 0 on
/// the faces of cells whose centre is in a solid. It
/// follows jets, sheets and craters as the flow does; no waves about one centre are asked to. Hollows below 27 cells are liquid; in larger
/// ones q is 0, as no sound of the ear gets there.
class LiquidCells {
 public:
  LiquidCells(const liquid::LiquidFrames& frames, std::size_t frame, const CellBox& box);
  std::size_t n_unknowns() const { return matrix_.n(); }
  /// Where q is asked for, 3 x n.
  const Eigen::Matrix3Xd& surface_m() const { return surface_m_; }
  bool holds(const Eigen::Vector3d& x_m) const;  ///< next to a cell of the body

  struct Question {
    std::complex<double> wavenumber_per_m, give_per_m;
    Eigen::VectorXcd q;                               ///< at surface_m
    const std::vector<std::complex<float>>* start{};  ///< of all cells of the box; nullptr: none
  };
  struct Waves {
    std::vector<std::complex<float>> w;  ///< of all cells of the box, 0 outside the body
    int iterations = 0;
    bool converged = false;
  };
  struct Limits {
    double tolerance = 1e-3;  ///< of the preconditioned residual, in units of the solution
    int iterations = 600;
  };
  /// Conjugate residuals, a handful of frequencies at a time in single precision, to the tolerance.
  /// @throws Interrupted between two iterations
  std::vector<Waves> solve(const std::vector<Question>& questions, const Limits& limits,
                           Monitor& monitor = silent_monitor()) const;
  /// By moving least squares of harmonic polynomials to the second degree on cells and crossings around.
  std::complex<double> at(const Eigen::Vector3d& x_m, const Waves& waves, const Eigen::VectorXcd& q) const;

 private:
  struct Crossing {
    int unknown;
    float weight;  ///< 1 / theta
    bool open;     ///< to the air around, not to a hollow
  };
  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(box_.n[0]) *
                                             (static_cast<std::size_t>(j) + static_cast<std::size_t>(box_.n[1]) * k);
  }
  std::vector<int> components(const std::vector<std::uint8_t>& member, std::vector<std::size_t>& sizes) const;
  /// What is at each cell's centre; open: air that is connected to the sides.
  struct Kinds {
    std::vector<std::uint8_t> liquid, open, solid;
  };
  void find_body(Kinds& kinds) const;
  void assemble(const std::vector<float>& phi, const Kinds& kinds);
  void load(const Question& question, std::size_t lane, detail::LaneValues& x, detail::LaneValues& right) const;
  void solve_lanes(const Question* questions, std::size_t n, const Limits& limits, Waves* waves,
                   const Monitor& monitor) const;

  CellBox box_;
  std::vector<int> number_;        ///< of the unknown; -1: none
  std::vector<std::size_t> cell_;  ///< of the unknown
  detail::CellMatrix matrix_;
  std::vector<Crossing> crossings_;         ///< in the order of their unknowns
  std::vector<std::size_t> crossing_from_;  ///< of the unknown; one more
  Eigen::Matrix3Xd surface_m_;
};

}  // namespace klang::liquid_scene
