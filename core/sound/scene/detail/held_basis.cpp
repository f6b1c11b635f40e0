#include "core/sound/scene/detail/held_basis.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/la/block_ordering.hpp"
#include "core/foundation/la/sparse_cholesky.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInALine = 1e-9;    ///< of the body's size, squared: no farther apart across
constexpr double kDependent = 1e-8;  ///< of a motion's mass: no more is left beside rigid ones

/// Rows of a matrix on the free nodes, put where they belong; zero elsewhere.
MatrixXd on_all(const MatrixXd& free, const solid::AssembledSolid& clamped) {
  MatrixXd all = MatrixXd::Zero(3 * static_cast<Index>(clamped.n_mesh_nodes), free.cols());
  for (std::size_t i = 0; i < clamped.free_nodes.size(); ++i)
    all.middleRows<3>(3 * clamped.free_nodes[i]) = free.middleRows<3>(3 * static_cast<Index>(i));
  return all;
}

/// What the body does while one hold at a time is moved slowly by a metre along each axis, the first stands still.
MatrixXd moved_slowly(const std::vector<HeldNodes>& holds, const solid::AssembledSolid& clamped,
                      const la::SparseMatrix& stiffness, const solid::Material& material) {
  MatrixXd moved = MatrixXd::Zero(stiffness.rows(), 3 * static_cast<Index>(holds.size() - 1));
  for (std::size_t h = 1; h < holds.size(); ++h)
    for (const int node : holds[h].nodes) moved.block<3, 3>(3 * node, 3 * static_cast<Index>(h - 1)).setIdentity();
  if (moved.cols() == 0) return moved;
  const MatrixXd pull = stiffness.selfadjointView<Eigen::Lower>() * moved;
  MatrixXd load(clamped.n_dofs(), moved.cols());
  for (std::size_t i = 0; i < clamped.free_nodes.size(); ++i)
    load.middleRows<3>(3 * static_cast<Index>(i)) = -pull.middleRows<3>(3 * clamped.free_nodes[i]);
  const la::SparseMatrix inner = solid::stiffness(clamped, material.lame_lambda_pa, material.lame_mu_pa);
  la::SparseCholesky factor;
  if (!factor.factor(inner, la::block_ordering(inner)))
    throw NumericalError(std::string("holds: the body has no stiffness between them: ") + factor.message());
  return moved + on_all(factor.solve(load), clamped);
}

/// Mass-normalised translations and turns.
MatrixXd rigid_motions(const mesh::TetMesh& mesh, const la::SparseMatrix& mass) {
  MatrixXd rigid = MatrixXd::Zero(3 * static_cast<Index>(mesh.n_nodes()), 6);
  const Eigen::RowVector3d middle = mesh.nodes_m.colwise().mean();
  for (Index i = 0; i < mesh.n_nodes(); ++i) {
    const Eigen::Vector3d x = (mesh.nodes_m.row(i) - middle).transpose();
    for (int axis = 0; axis < 3; ++axis) {
      rigid(3 * i + axis, axis) = 1.0;
      rigid.block<3, 1>(3 * i, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(x);
    }
  }
  const MatrixXd gram = rigid.transpose() * (mass.selfadjointView<Eigen::Lower>() * rigid);
  const Eigen::LLT<MatrixXd> factor(gram);
  return factor.matrixU().solve<Eigen::OnTheRight>(rigid);
}

}  // namespace

bool holds_a_face(const std::vector<HeldNodes>& holds, const mesh::TetMesh& mesh) {
  const Eigen::Vector3d size = mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff();
  return std::any_of(holds.begin(), holds.end(), [&](const HeldNodes& hold) {
    if (hold.nodes.size() < 3) return false;
    Eigen::MatrixX3d places = mesh.nodes_m(hold.nodes, Eigen::all);
    places.rowwise() -= places.colwise().mean().eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(places.transpose() * places);
    return spread.eigenvalues()[1] > kInALine * size.squaredNorm();
  });
}

std::vector<int> three_apart(const std::vector<int>& nodes, const mesh::TetMesh& mesh) {
  if (nodes.size() <= 2) return nodes;
  const auto place = [&](int node) -> Eigen::Vector3d { return mesh.nodes_m.row(node).transpose(); };
  const auto farthest = [&](const auto& distance) {
    int found = nodes.front();
    double most = -1.0;
    for (const int node : nodes)
      if (const double here = distance(place(node)); here > most) most = here, found = node;
    return found;
  };
  const Eigen::Vector3d any = place(nodes.front());
  const int first = farthest([&](const Eigen::Vector3d& x) { return (x - any).norm(); });
  const Eigen::Vector3d origin = place(first);
  const int second = farthest([&](const Eigen::Vector3d& x) { return (x - origin).norm(); });
  const Eigen::Vector3d along = place(second) - origin;
  const int third = farthest([&](const Eigen::Vector3d& x) { return along.cross(x - origin).norm(); });
  if (!(along.cross(place(third) - origin).norm() > std::sqrt(kInALine) * along.squaredNorm())) return {first, second};
  return {first, second, third};
}

HeldBasis held_basis(const mesh::TetMesh& mesh, const solid::Material& material, const std::vector<HeldNodes>& holds,
                     int count, bool without_mesh_error, Monitor& monitor) {
  mesh::TetMesh named = mesh;
  std::vector<int>& set = named.node_sets["what is held"];
  for (const HeldNodes& hold : holds) set.insert(set.end(), hold.nodes.begin(), hold.nodes.end());
  std::sort(set.begin(), set.end());
  const solid::Support support{solid::SupportKind::kClamped, "set:what is held"};
  const solid::AssembledSolid clamped = solid::assemble(named, support), free = solid::assemble(named);
  modal::EigenOptions options;
  options.count = count;
  options.estimate_mesh_error = true;
  const modal::EigenResult found = modal::solve_modes(named, clamped, material, support, options, monitor);
  if (!found.usable()) throw NumericalError("modes of what is held: " + found.message);
  if (found.model.n_modes() < count)
    throw InputError("n_modes", "is more than the held body has", std::to_string(count),
                     "up to " + std::to_string(found.model.n_modes()));
  VectorXd omega = found.model.angular_frequency_rad_s;
  if (found.mesh_relative_error && without_mesh_error) omega.array() /= 1.0 + found.mesh_relative_error->array();
  const la::SparseMatrix stiffness = solid::stiffness(free, material.lame_lambda_pa, material.lame_mu_pa),
                         mass = material.density_kg_m3 * free.mass_unit_density;
  const MatrixXd slow = moved_slowly(holds, clamped, stiffness, material);
  MatrixXd motions(slow.rows(), count + slow.cols());
  motions << found.model.shapes, slow;
  // Clamped modes with their frequencies; slow motions do no work with them.
  MatrixXd stiff = MatrixXd::Zero(motions.cols(), motions.cols());
  stiff.diagonal().head(count) = omega.cwiseAbs2();
  stiff.bottomRightCorner(slow.cols(), slow.cols()) =
      slow.transpose() * (stiffness.selfadjointView<Eigen::Lower>() * slow);
  const MatrixXd rigid = rigid_motions(named, mass);
  const MatrixXd massive = mass.selfadjointView<Eigen::Lower>() * motions;
  const MatrixXd share = rigid.transpose() * massive;
  const MatrixXd whole = motions.transpose() * massive;
  // Scaled to mass 1 each; what is rigid but for round-off goes.
  const VectorXd scale = whole.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd left = scale.asDiagonal() * (whole - share.transpose() * share) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> mobile(left);
  const Index kept = (mobile.eigenvalues().array() > kDependent).count();
  const MatrixXd white = scale.asDiagonal() * mobile.eigenvectors().rightCols(kept) *
                         mobile.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(white.transpose() * stiff * white);
  const MatrixXd mix = white * ritz.eigenvectors();
  return {ritz.eigenvalues(), motions * mix - rigid * (share * mix), found.mesh_relative_error};
}

}  // namespace klang::scene::detail
