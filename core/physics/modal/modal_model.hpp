#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/material.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::modal {

/// Elastic modes of a body, in order of frequency; rigid modes are left out. Damping is no part of it.
struct ModalModel {
  Eigen::VectorXd angular_frequency_rad_s;  ///< n_modes
  Eigen::MatrixXd shapes;                   ///< 3 n_nodes x n_modes, row 3 node + axis; u^T M u = 1, unit 1/sqrt(kg)
  mesh::TetMesh mesh;
  solid::Material material;
  solid::Support support;

  Eigen::Index n_modes() const { return angular_frequency_rad_s.size(); }
  Eigen::VectorXd frequency_hz() const;
};

/// Writes and reads a .vtu that ParaView opens: point vectors "mode_0000" ... in 1/sqrt(kg), frequencies,
/// material and provenance as field data. Reading gives back every bit.
void write_modal_model(const std::filesystem::path& path, const ModalModel& model,
                       const std::string& provenance_json = "{}");
/// @throws InputError: not such a file, or parts that do not fit together: cells that are no mesh, missing or short arrays, values
/// that are not finite, frequencies above 1e9 rad/s, shapes above 1e12
ModalModel read_modal_model(const std::filesystem::path& path);
ModalModel read_modal_model_bytes(std::string bytes, const std::string& name);

/// The same body of another density: omega and shapes scale by sqrt(rho / new rho) (S02, errata 6).
ModalModel with_density(const ModalModel& model, double density_kg_m3);
/// lambda and mu times one factor: omega scales by its square root, shapes stay.
ModalModel with_stiffness_factor(const ModalModel& model, double factor);
/// Every length times one factor: omega scales by 1/factor, shapes by factor^-3/2.
ModalModel with_size_factor(const ModalModel& model, double factor);

}  // namespace klang::modal
