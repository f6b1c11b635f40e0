#pragma once
#include <optional>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"

namespace klang::modal {

/// How a body's modes are computed. kAuto: harmonics or polynomials where they apply and the mesh was not chosen for its own sake.
enum class ModesMethod { kAuto, kPolynomial, kHarmonics, kTetrahedra };

/// A body, as far as the choice of the method goes.
struct ModesBody {
  std::optional<mesh::ShapeSpec> shape;  ///< empty: known by its mesh alone
  solid::Support support;
  int element_order = 2;  ///< of the shape's mesh, 1 or 2
};

struct ModesOptions {
  EigenOptions eigen;
  ModesMethod method = ModesMethod::kAuto;
  solid::MassKind mass = solid::MassKind::kConsistent;  ///< of tetrahedra
  bool mesh_is_wanted = false;  ///< the caller chose the mesh and wants to see that mesh's frequencies
};

/// Whether the harmonics of a section can give the modes: a free body of revolution given by its shape, quadratic elements
/// (to which shapes are sampled), consistent mass.
bool harmonics_apply(const ModesBody& body, solid::MassKind mass = solid::MassKind::kConsistent);

/// The bodies that harmonics_apply() to, in words: "tube, rod, ellipsoid with a_m = b_m, ...".
std::string harmonics_apply_to();

/// Whether polynomials can give the modes: a box that is free or held at one whole face (box_modes.hpp), a free ellipsoid
/// (ellipsoid_solve.hpp); quadratic elements, to which shapes are sampled, consistent mass.
bool polynomials_apply(const ModesBody& body, solid::MassKind mass = solid::MassKind::kConsistent);

/// The bodies that polynomials_apply() to, in words.
std::string polynomials_apply_to();

/// The word for a method: "polynomial", "harmonics", "tetrahedra", "auto".
std::string to_text(ModesMethod method);

/// kPolynomial, kHarmonics or kTetrahedra. The one place that decides it.
/// @throws InputError where one is asked for and does not apply
ModesMethod chosen_method(const ModesBody& body, const ModesOptions& options);

/// Elastic modes of a body on the nodes of its mesh, by solve_box_modes(), solve_ellipsoid_modes(), solve_revolution_modes(), or by assemble() and
/// solve_modes(), as
/// chosen_method() says; EigenResult::method_used tells which. wall_time_s["assembly"] is beside the solver's "total".
/// The lowest frequency of many small free bodies without a mesh is another task: polynomial_modes.hpp.
/// @param mesh  of the body; of a shape, with body.element_order
EigenResult modes_of(const ModesBody& body, const mesh::TetMesh& mesh, const solid::Material& material,
                     const ModesOptions& options = {}, Monitor& monitor = silent_monitor());

}  // namespace klang::modal
