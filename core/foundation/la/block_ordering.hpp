#pragma once
#include <array>
#include <vector>

#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la {

/// Fill-reducing order of the degrees of freedom of a matrix made of 3 x 3 node blocks (lower triangle):
/// on the graph of nodes, which is nine times smaller than that of the matrix. Of AMD and METIS the one that needs fewer
/// operations is taken: AMD for thin walls, METIS for compact bodies. order[k] = dof that comes k-th.
std::vector<int> block_ordering(const SparseMatrix& lower);

/// The two nodes between which each node lies: {i, i} of node i for a corner of elements, its edge's ends for a mid-node of
/// quadratic elements, -1 for an end that the matrix has not (it is held).
using NodeEnds = std::vector<std::array<int, 2>>;

/// The same on the graph of corners, seven times smaller again; a mid-node follows the end that comes first, whose neighbours
/// are its own.
/// @param ends  one per node
std::vector<int> block_ordering(const SparseMatrix& lower, const NodeEnds& ends);

}  // namespace klang::la
