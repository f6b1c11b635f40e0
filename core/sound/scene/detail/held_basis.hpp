#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/physics/modal/eigen_solver.hpp"
#include "core/sound/scene/detail/held_nodes.hpp"

namespace klang::scene::detail {

/// Whether a region that is held keeps the body from turning about it: three places of one hold that are not in a line.
bool holds_a_face(const std::vector<HeldNodes>& holds, const mesh::TetMesh& mesh);

/// Three of some nodes that lie far from one another and from a line, or two where all lie in one: what nodes that move as one do follows from theirs.
std::vector<int> three_apart(const std::vector<int>& nodes, const mesh::TetMesh& mesh);

/// The elastic motions that a body whose holds keep it from turning is bent by, as modes beside its six rigid ones: all combinations of the rigid ones,
/// of the lowest modes of the body with what is held clamped, and, where several holds move, of what it does while one of them is moved slowly. What is
/// held is met by the rigid ones alone, so that any number of clamped modes gives those frequencies, from above (Craig and Bampton's basis with
/// holds that do not deform). The modes of the free body meet a face that is held only by bending each other still.
struct HeldBasis {
  Eigen::VectorXd lambda;  ///< ascending [1/s^2]
  Eigen::MatrixXd shapes;  ///< 3 n_nodes rows; orthogonal to one another and to rigid motions by the mass, u^T M u = 1
  std::optional<Eigen::VectorXd> mesh_error;  ///< of the clamped frequencies, by the mesh's estimate
};

/// @param count  clamped modes. @param without_mesh_error  their frequencies less what the mesh adds, by its estimate
/// @throws InputError: fewer are there; NumericalError where they are not found
HeldBasis held_basis(const mesh::TetMesh& mesh, const solid::Material& material, const std::vector<HeldNodes>& holds,
                     int count, bool without_mesh_error, Monitor& monitor);

}  // namespace klang::scene::detail
