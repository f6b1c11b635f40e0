#include "core/physics/modal/modes_of.hpp"

#include <algorithm>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/geometry/shapes/section.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "core/physics/modal/box_modes.hpp"
#include "core/physics/modal/ellipsoid_solve.hpp"
#include "core/physics/modal/expected_modes.hpp"
#include "core/physics/modal/revolution_modes.hpp"

namespace klang::modal {

bool harmonics_apply(const ModesBody& body, solid::MassKind mass) {
  return body.shape && mesh::is_axisymmetric(*body.shape) && body.support.kind == solid::SupportKind::kFree &&
         body.element_order == 2 && mass == solid::MassKind::kConsistent;
}

std::string harmonics_apply_to() {
  std::string text;
  for (const mesh::ShapeKind* kind : mesh::registered_shapes())
    if (const std::string words = kind->axisymmetric_words(); !words.empty())
      text += (text.empty() ? "" : ", ") + words;
  return text;
}

bool polynomials_apply(const ModesBody& body, solid::MassKind mass) {
  if (!body.shape || body.element_order != 2 || mass != solid::MassKind::kConsistent) return false;
  if (ellipsoid_axes_m(*body.shape)) return body.support.kind == solid::SupportKind::kFree;
  return body.shape->kind == "box" && held_faces(body.support, box_half_lengths_m(*body.shape)).has_value();
}

std::string polynomials_apply_to() { return "box that is free or held at a whole face, free ellipsoid or sphere"; }

std::string to_text(ModesMethod method) {
  switch (method) {
    case ModesMethod::kPolynomial:
      return "polynomial";
    case ModesMethod::kHarmonics:
      return "harmonics";
    case ModesMethod::kTetrahedra:
      return "tetrahedra";
    case ModesMethod::kAuto:
      break;
  }
  return "auto";
}

ModesMethod chosen_method(const ModesBody& body, const ModesOptions& options) {
  if (options.method == ModesMethod::kTetrahedra) return ModesMethod::kTetrahedra;
  const bool by_harmonics = harmonics_apply(body, options.mass), by_polynomials = polynomials_apply(body, options.mass);
  const std::string kind = body.shape ? body.shape->kind : "";
  if (options.method == ModesMethod::kHarmonics && !by_harmonics)
    throw InputError("modes", "harmonics need a free body of revolution, quadratic elements and consistent mass", kind,
                     harmonics_apply_to());
  if (options.method == ModesMethod::kPolynomial && !by_polynomials)
    throw InputError("modes", "polynomials need one of a few bodies, quadratic elements and consistent mass", kind,
                     polynomials_apply_to());
  if (options.method != ModesMethod::kAuto) return options.method;
  if (options.mesh_is_wanted) return ModesMethod::kTetrahedra;
  return by_harmonics ? ModesMethod::kHarmonics : by_polynomials ? ModesMethod::kPolynomial : ModesMethod::kTetrahedra;
}

EigenResult modes_of(const ModesBody& body, const mesh::TetMesh& mesh, const solid::Material& material,
                     const ModesOptions& options, Monitor& monitor) {
  KLANG_CHECK(!body.shape || mesh.order() == body.element_order, "modes_of: the mesh is of another element order");
  const ModesMethod method = chosen_method(body, options);
  if (options.eigen.count == 0) {
    const double expected = expected_modes(size_of(mesh), material, options.eigen.band.high_hz);
    const double most = method == ModesMethod::kTetrahedra ? 3.0 * mesh.n_nodes() : expected;  // its unknowns
    check_expected_modes("the body", std::min(expected, most), options.eigen.band.high_hz);
  }
  const bool is_ellipsoid = body.shape && ellipsoid_axes_m(*body.shape);
  if (method == ModesMethod::kPolynomial && is_ellipsoid) {
    EigenResult result = solve_ellipsoid_modes(*body.shape, mesh, material, options.eigen, monitor);
    // Of hundreds of modes the highest want more than the polynomials have: unless they were asked for, the mesh gives them.
    if (result.usable() || options.method == ModesMethod::kPolynomial) return result;
  }
  if (method == ModesMethod::kPolynomial && !is_ellipsoid)
    return solve_box_modes(*body.shape, mesh, material, body.support, options.eigen, monitor);
  if (method == ModesMethod::kHarmonics)
    return solve_revolution_modes(*body.shape, mesh, material, options.eigen, monitor);
  monitor.progress("assembly", 0.0);
  const Stopwatch watch;
  const solid::AssembledSolid assembled = solid::assemble(mesh, body.support, options.mass);
  const double assembly_s = watch.seconds();
  EigenResult result = solve_modes(mesh, assembled, material, body.support, options.eigen, monitor);
  result.wall_time_s["assembly"] = assembly_s;
  return result;
}

}  // namespace klang::modal
