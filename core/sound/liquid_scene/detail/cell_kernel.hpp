#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace klang::liquid_scene::detail {

/// Frequencies that are solved side by side: they share the cells and the preconditioner, and an unknown of all of them is one vector of
/// the processor (4 real parts, 4 imaginary parts).
constexpr std::size_t kLanes = 4, kWide = 2 * kLanes;

/// Complex values of kLanes frequencies at n unknowns and, last, at one that is none: 0.
using LaneValues = std::vector<float>;

/// The liquid's cells as unknowns in the order of the grid: diagonal w - sum of neighbours' w + (n_wall give - shift) w.
struct CellMatrix {
  std::array<std::vector<int>, 3> before, next;  ///< number of the neighbour along each axis; n: none
  std::vector<float> diagonal;                   ///< faces to liquid, and 1 / theta of those to air
  std::vector<float> n_wall;                     ///< faces on walls
  std::vector<float> inverse;                    ///< of the incomplete factor: its diagonal's inverse square
  std::size_t n() const { return diagonal.size(); }
  void factor();  ///< modified incomplete Cholesky, level 0, of the matrix without give and shift
};

/// One complex number of each frequency.
struct LaneNumbers {
  std::array<float, kLanes> re{}, im{};
};

/// a = A x; give and shift as above.
void multiply(const CellMatrix& matrix, const LaneNumbers& give, const LaneNumbers& shift, const LaneValues& x,
              LaneValues& a);
/// z = M^-1 r
void precondition(const CellMatrix& matrix, const LaneValues& r, LaneValues& z);
/// Sums of a b, without conjugation.
void sums(const LaneValues& a, const LaneValues& b, std::array<double, kWide>& result);
/// Sums of |a|^2.
std::array<double, kLanes> norms_sq(const LaneValues& a);
/// y += s x
void add(const LaneNumbers& s, const LaneValues& x, LaneValues& y);
/// y = x + s y
void add_to(const LaneValues& x, const LaneNumbers& s, LaneValues& y);

}  // namespace klang::liquid_scene::detail
