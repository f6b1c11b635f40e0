#pragma once
#include <array>
#include <vector>

#include "core/physics/fracture/pattern/region_cut.hpp"

namespace klang::fracture {

/// A triangle of a crack: two fragments face each other there.
struct CrackTriangle {
  int a = 0, b = 0;            ///< fragments, a < b
  std::array<int, 3> nodes{};  ///< of the cut mesh, counter-clockwise seen from b: the normal points out of a
  int element_a = 0,
      element_b = 0;     ///< of the mesh that was cut, on either side; equal where the crack runs through one
  double area_m2 = 0.0;  ///< of one side
};

/// What a cut mesh falls into.
struct Fragments {
  RegionCut cut;
  int n_fragments = 0;
  std::vector<int> fragment;  ///< by element of the cut mesh
  std::vector<int> region;    ///< by fragment: that of its largest part
  std::vector<CrackTriangle> cracks;
  double crack_area_m2 = 0.0;  ///< of one side
  int n_merged = 0;            ///< parts that were too small or enclosed and stay with a neighbour
  std::vector<int>
      enclosed;  ///< fragments without outer surface and with one neighbour (only where they are not merged)
};

struct FragmentRules {
  double least_volume_m3 = 0.0;  ///< smaller parts stay with the neighbour that they share most area with
  bool merge_enclosed = true;    ///< parts that lie wholly inside another cannot come apart from it: they stay with it
};

/// Fragments are regions, each cut into what is joined by faces: parts that hang by an edge or a vertex alone are bodies of their
/// own (else a body could bend about that edge without any force: errata 57). Numbered by region, then by lowest element.
/// The crack area is that of one side (G_c is energy per crack area, not per surface).
Fragments fragments_of(RegionCut cut, const FragmentRules& rules);

/// The fragment as a mesh of its own; element_of says which element of the cut mesh each is.
mesh::TetMesh fragment_mesh(const Fragments& fragments, int fragment, std::vector<int>* element_of = nullptr);

}  // namespace klang::fracture
