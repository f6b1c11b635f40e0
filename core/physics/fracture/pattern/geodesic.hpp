#pragma once
#include <vector>

#include "core/physics/fracture/pattern/region_cut.hpp"
#include "core/physics/fracture/pattern/seeds.hpp"

namespace klang::fracture {

/// SB's regions: k_i dist(x, p_i) least, k_i = density_i^alpha, dist the length of the shortest path along edges of the mesh
/// (Dijkstra; from the seed, the centre of an element, straight to its corners), linear within tetrahedra. Paths along edges are longer
/// than straight ones, by up to about a third on coarse meshes; on a body that is not convex they go around its corners. Every seed's
/// distances reach the whole body; what of a region is not joined by faces becomes a body of its own (fragments_of).
RegionFields geodesic_fields(const mesh::TetMesh& mesh, const std::vector<Seed>& seeds, double alpha);

}  // namespace klang::fracture
