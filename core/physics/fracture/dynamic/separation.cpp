#include "core/physics/fracture/dynamic/separation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/fracture/dynamic/detail/at.hpp"

namespace klang::fracture {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using detail::at;

/// True second Piola-Kirchhoff stress: elastic, and viscous where asked for.
Matrix3d stress_of(const CrackMesh& mesh, int element, const Matrix3d& f, const solid::Material& material,
                   const Viscosity* extra) {
  Matrix3d strain = f.transpose() * f - Matrix3d::Identity();
  const Sym plastic = mesh.plastic_of(element);
  strain -= (Matrix3d() << plastic[0], plastic[3], plastic[5], plastic[3], plastic[1], plastic[4], plastic[5],
             plastic[4], plastic[2])
                .finished();
  Matrix3d stress =
      material.lame_mu_pa * strain + 0.5 * material.lame_lambda_pa * strain.trace() * Matrix3d::Identity();
  if (extra != nullptr) {
    const std::array<int, 4> nodes = mesh.nodes_of(element);
    Matrix3d speeds;
    for (int k = 0; k < 3; ++k)
      speeds.col(k) = mesh.velocity_m_s[at(nodes[at(k + 1)])] - mesh.velocity_m_s[at(nodes[0])];
    const Matrix3d rate_half = f.transpose() * (speeds * mesh.beta_of(element));
    const Matrix3d rate = rate_half + rate_half.transpose();
    stress += extra->psi_pa_s * rate + 0.5 * extra->phi_pa_s * rate.trace() * Matrix3d::Identity();
  }
  return stress;
}

Matrix3d outer(const Vector3d& a) {
  const double size = a.norm();
  return size > 0.0 ? Matrix3d(a * a.transpose() / size) : Matrix3d::Zero();
}

Vector3d gradient_at(const CrackMesh& mesh, int element, int node) {
  const std::array<int, 4> nodes = mesh.nodes_of(element);
  const Matrix3d beta = mesh.beta_of(element);
  const auto corner = std::find(nodes.begin(), nodes.end(), node) - nodes.begin();
  return corner == 0 ? Vector3d(-beta.colwise().sum().transpose()) : Vector3d(beta.row(corner - 1).transpose());
}

/// Cauchy stress F S F^T / det F, weighted by the present volumes.
Matrix3d mean_stress(const CrackMesh& mesh, const std::vector<int>& elements, const solid::Material& material,
                     const Viscosity* extra) {
  Matrix3d mean = Matrix3d::Zero();
  double volume = 0.0;
  for (const int element : elements) {
    const Matrix3d f = mesh.gradient_of(element);
    mean += mesh.volume_m3(element) * (f * stress_of(mesh, element, f, material, extra) * f.transpose());
    volume += mesh.volume_m3(element) * f.determinant();
  }
  return mean / volume;
}

SplitStresses::Parts split_stress(const CrackMesh& mesh, int element, const solid::Material& material,
                                  const Viscosity* extra) {
  const Matrix3d f = mesh.gradient_of(element);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(stress_of(mesh, element, f, material, extra));
  SplitStresses::Parts parts{Matrix3d::Zero(), Matrix3d::Zero(), true};
  for (int k = 0; k < 3; ++k) {
    const Vector3d v = solver.eigenvectors().col(k);
    (solver.eigenvalues()[k] > 0.0 ? parts.pulled : parts.pressed) += solver.eigenvalues()[k] * v * v.transpose();
  }
  for (Matrix3d* part : {&parts.pulled, &parts.pressed}) *part = -mesh.volume_m3(element) * (f * *part).eval();
  return parts;
}

}  // namespace

Vector3d pull_through(const CrackMesh& mesh, int element, const Vector3d& rest_area_m2,
                      const solid::Material& material) {
  const Matrix3d f = mesh.gradient_of(element);
  return f * (stress_of(mesh, element, f, material, nullptr) * rest_area_m2);
}

Vector3d mean_normal(const CrackMesh& mesh, const std::vector<int>& elements, const solid::Material& material) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(mean_stress(mesh, elements, material, nullptr));
  return solver.eigenvectors().col(2);
}

Matrix3d separation_tensor(const CrackMesh& mesh, int node, const solid::Material& material, const Viscosity* extra,
                           SplitStresses* split) {
  Vector3d tension = Vector3d::Zero(), compression = Vector3d::Zero();
  Matrix3d tensor = Matrix3d::Zero();
  SplitStresses::Parts own;
  for (const int element : mesh.star(node)) {
    SplitStresses::Parts& parts = split != nullptr ? split->of(element) : own;
    if (split == nullptr || !parts.known) parts = split_stress(mesh, element, material, extra);
    const Vector3d gradient = gradient_at(mesh, element, node);
    const Vector3d pulled = parts.pulled * gradient, pressed = parts.pressed * gradient;
    tension += pulled;
    compression += pressed;
    tensor += outer(pulled) - outer(pressed);
  }
  return 0.5 * (tensor - outer(tension) + outer(compression));
}

double shown_area_m2(const CrackMesh& mesh, int node, const Vector3d& normal) {
  double area = 0.0;
  for (const int element : mesh.star(node)) {
    Vector3d corner[3];
    int n = 0;
    for (const int other : mesh.nodes_of(element))
      if (other != node) corner[n++] = mesh.place_m[at(other)];
    area += 0.25 * std::abs((corner[1] - corner[0]).cross(corner[2] - corner[0]).dot(normal));
  }
  return area;
}

Separation separation_at(const CrackMesh& mesh, int node, const solid::Material& material, CrackCriterion criterion,
                         const Viscosity* extra, SplitStresses* split) {
  Separation result;
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  if (criterion == CrackCriterion::kRankine) {
    solver.compute(mean_stress(mesh, mesh.star(node), material, extra));
    result.stress_pa = std::max(0.0, solver.eigenvalues()[2]);
    result.normal = solver.eigenvectors().col(2);
    return result;
  }
  solver.compute(separation_tensor(mesh, node, material, extra, split));
  if (!(solver.eigenvalues()[2] > 0.0)) return result;
  result.force_n = solver.eigenvalues()[2];
  result.normal = solver.eigenvectors().col(2);
  const double area = shown_area_m2(mesh, node, result.normal);
  if (area > 0.0) result.stress_pa = 3.0 * result.force_n / area;
  return result;
}

std::vector<Separation> separations_at(const CrackMesh& mesh, const std::vector<int>& nodes,
                                       const solid::Material& material, CrackCriterion criterion,
                                       const Viscosity* extra) {
  constexpr std::size_t kAtOnce = 32;
  SplitStresses split(mesh.n_elements());
  if (criterion == CrackCriterion::kSeparation) {
    std::vector<char> needed(at(mesh.n_elements()), 0);
    for (const int node : nodes)
      for (const int element : mesh.star(node)) needed[at(element)] = 1;
    parallel_for(needed.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e)
        if (needed[e] != 0) split.of(static_cast<int>(e)) = split_stress(mesh, static_cast<int>(e), material, extra);
    });
  }
  std::vector<Separation> separations(nodes.size());
  parallel_for(nodes.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      separations[k] = separation_at(mesh, nodes[k], material, criterion, extra, &split);
  });
  return separations;
}

}  // namespace klang::fracture
