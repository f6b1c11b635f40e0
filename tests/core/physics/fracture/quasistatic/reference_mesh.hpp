#pragma once
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/material.hpp"
#include "tests/places.hpp"

namespace klang::test {

/// tests/reference/quasistatic.json: material, mesh and cases, by dense pseudo-inverse (1e-10).
inline nlohmann::json quasistatic_reference() {
  std::ifstream file(klang::test::source_dir() + "/tests/reference/quasistatic.json");
  return nlohmann::json::parse(file);
}

inline solid::Material reference_glass() { return solid::from_youngs_modulus(62e9, 0.2, 2600); }

/// 24 nodes, 36 linear tetrahedra.
inline mesh::TetMesh reference_mesh(const nlohmann::json& reference) {
  mesh::TetMesh mesh;
  const auto& nodes = reference["mesh"]["nodes_m"];
  const auto& elements = reference["mesh"]["tetrahedra"];
  mesh.nodes_m.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  mesh.elements.resize(static_cast<Eigen::Index>(elements.size()), 4);
  for (Eigen::Index i = 0; i < mesh.nodes_m.rows(); ++i)
    for (Eigen::Index a = 0; a < 3; ++a)
      mesh.nodes_m(i, a) = nodes[static_cast<std::size_t>(i)][static_cast<std::size_t>(a)];
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e)
    for (Eigen::Index c = 0; c < 4; ++c)
      mesh.elements(e, c) = elements[static_cast<std::size_t>(e)][static_cast<std::size_t>(c)];
  return mesh;
}

inline Eigen::VectorXd nodal_force(const mesh::TetMesh& mesh, const nlohmann::json& forces) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(3 * mesh.n_nodes());
  for (const auto& [node, force] : forces.items())
    for (int a = 0; a < 3; ++a) all[3 * std::stoi(node) + a] = force[static_cast<std::size_t>(a)];
  return all;
}

/// 3 n_nodes x 6: translations, and turns about the origin.
inline Eigen::MatrixXd rigid_motions(const mesh::TetMesh& mesh) {
  Eigen::MatrixXd rigid(3 * mesh.n_nodes(), 6);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const Eigen::Vector3d x = mesh.nodes_m.row(i).transpose();
    rigid.middleRows<3>(3 * i) << 1, 0, 0, 0, x[2], -x[1], 0, 1, 0, -x[2], 0, x[0], 0, 0, 1, x[1], -x[0], 0;
  }
  return rigid;
}

}  // namespace klang::test
