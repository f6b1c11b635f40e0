#include "datasets-synthetic/body_modes.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "datasets-synthetic/ritz_box.hpp"
#include "datasets-synthetic/ritz_tube.hpp"

namespace klang::datasets {
namespace {

// Meshes of bodies of revolution split their pairs by up to 5e-4 (a bowl at its pole).
constexpr double kMeshPairTolerance = 1e-3;

BodyModes box_modes(const mesh::ShapeSpec& shape, const solid::Material& material, double highest_hz,
                    const std::vector<Eigen::Vector3d>& places) {
  const Eigen::Vector3d size(shape.dims.at("length_m"), shape.dims.at("width_m"), shape.dims.at("height_m"));
  const RitzBox box(size, material, {{}, highest_hz});
  BodyModes modes;
  modes.angular_frequency_rad_s = box.angular_frequency_rad_s();
  for (const Eigen::Vector3d& place : places) {
    modes.places_m.push_back(0.5 * place.cwiseProduct(size));
    modes.shapes.push_back(box.shapes_at(modes.places_m.back()));
  }
  for (Eigen::Index m = 0; m < box.n_modes(); ++m) {
    const auto p = box.parity(m);
    modes.labels.push_back("parity " + std::to_string(p[0]) + std::to_string(p[1]) + std::to_string(p[2]));
  }
  const auto o = box.orders();
  modes.method = "Ritz, Legendre products of degree " + std::to_string(o[0]) + ", " + std::to_string(o[1]) + ", " +
                 std::to_string(o[2]);
  return modes;
}

BodyModes tube_modes(const mesh::ShapeSpec& shape, const solid::Material& material, double highest_hz,
                     const std::vector<Eigen::Vector3d>& places) {
  const double length = shape.dims.at("length_m"), outer = shape.dims.at("outer_radius_m");
  const double wall = shape.dims.at("wall_m");
  const RitzTube tube(length, outer, wall, material, {0, 4, highest_hz});
  BodyModes modes;
  modes.angular_frequency_rad_s = tube.angular_frequency_rad_s();
  for (const Eigen::Vector3d& place : places) {
    // The nearest point of the wall; on the axis: that of angle 0.
    Eigen::Vector3d x = place.cwiseProduct(Eigen::Vector3d(outer, outer, 0.5 * length));
    const double r = std::hypot(x[0], x[1]), wanted = std::clamp(r, outer - wall, outer);
    if (r > 0) {
      x.head<2>() *= wanted / r;
    } else {
      x[0] = wanted;
    }
    modes.places_m.push_back(x);
    modes.shapes.push_back(tube.shapes_at(x));
  }
  for (Eigen::Index m = 0; m < tube.n_modes(); ++m) {
    const auto& label = tube.label(m);
    modes.labels.push_back((label.torsion ? "torsion" : "n=" + std::to_string(label.circumferential)) +
                           (label.odd_in_z ? " odd" : " even"));
  }
  modes.method = "Ritz, exact in the angle, axial degree " + std::to_string(tube.axial_order()) + ", wall degree 4";
  return modes;
}

// By the harmonics of a section or by polynomials where these apply, which are right to round-off or nearly; on the nodes of a mesh.
// Elsewhere by elements finer than what a fit takes, and what they are still too stiff is estimated and taken off.
BodyModes modes_on_nodes(const mesh::ShapeSpec& shape, const solid::Material& material, const solid::Support& support,
                         double highest_hz, const std::vector<Eigen::Vector3d>& places, Monitor& monitor) {
  const modal::ModesBody body{shape, support};
  modal::ModesOptions options;
  options.eigen.band = {20.0, highest_hz};
  options.method = modal::chosen_method(body, {});
  const auto solved = [&] {
    const bool elements = options.method == modal::ModesMethod::kTetrahedra;
    options.eigen.estimate_mesh_error = elements;
    const mesh::TetMesh mesh =
        elements ? mesh::mesh_shape(shape, mesh::reference_divisions(shape), 2) : mesh::mesh_shape(shape);
    return modal::modes_of(body, mesh, material, options, monitor);
  };
  auto result = solved();
  if (!result.usable() &&
      options.method == modal::ModesMethod::kPolynomial) {  // hundreds of modes want more than they have
    options.method = modal::ModesMethod::kTetrahedra;
    result = solved();
  }
  if (!result.usable()) throw NumericalError("true modes of " + shape.kind + ": " + result.message);
  const bool by_elements = options.method == modal::ModesMethod::kTetrahedra;

  BodyModes modes;
  modes.angular_frequency_rad_s = result.model.angular_frequency_rad_s;
  if (by_elements && result.mesh_relative_error)
    modes.angular_frequency_rad_s.array() *= 1.0 - result.mesh_relative_error->array();
  const mesh::Points& nodes = result.model.mesh.nodes_m;
  const Eigen::Vector3d low = nodes.colwise().minCoeff(), high = nodes.colwise().maxCoeff();
  std::vector<char> outside(static_cast<std::size_t>(nodes.rows()), 0);
  const mesh::SurfaceMesh surface = mesh::boundary_surface(result.model.mesh);
  for (Eigen::Index t = 0; t < surface.triangles.size(); ++t) {
    outside[static_cast<std::size_t>(surface.triangles.data()[t])] = 1;
  }
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector3d x = 0.5 * (low + high) + 0.5 * place.cwiseProduct(high - low);
    Eigen::Index nearest = 0;
    double distance_sq = HUGE_VAL;
    for (Eigen::Index i = 0; i < nodes.rows(); ++i) {
      const double d = (nodes.row(i).transpose() - x).squaredNorm();
      if (outside[static_cast<std::size_t>(i)] && d < distance_sq) {
        distance_sq = d;
        nearest = i;
      }
    }
    modes.places_m.push_back(nodes.row(nearest));
    modes.shapes.push_back(result.model.shapes.middleRows<3>(3 * nearest));
  }
  for (Eigen::Index m = 0; m < result.model.n_modes(); ++m) modes.labels.push_back("mode " + std::to_string(m));
  if (!by_elements) {
    modes.method = modal::to_text(options.method) + ", shapes on " + std::to_string(nodes.rows()) + " nodes";
    return modes;
  }
  modes.method =
      "quadratic finite elements, " + std::to_string(nodes.rows()) + " nodes, estimated mesh error taken off";
  if (mesh::find_shape(shape.kind).facts().modes_in_pairs) modes.pair_tolerance = kMeshPairTolerance;
  return modes;
}

}  // namespace

BodyModes body_modes(const mesh::ShapeSpec& shape, const solid::Material& material, const solid::Support& support,
                     double highest_hz, const std::vector<Eigen::Vector3d>& places, Monitor& monitor) {
  if (support.kind == solid::SupportKind::kFree) {
    static const std::map<std::string, decltype(&box_modes)> ritz{{"box", &box_modes}, {"tube", &tube_modes}};
    if (const auto found = ritz.find(shape.kind); found != ritz.end())
      return found->second(shape, material, highest_hz, places);
  }
  return modes_on_nodes(shape, material, support, highest_hz, places, monitor);
}

void split_pairs(BodyModes& modes, double relative_detuning, double angle_rad) {
  Eigen::VectorXd& omega = modes.angular_frequency_rad_s;
  for (Eigen::Index m = 0; m + 1 < omega.size(); ++m) {
    if (!(omega[m + 1] - omega[m] <= modes.pair_tolerance * omega[m])) continue;
    const double mean = 0.5 * (omega[m] + omega[m + 1]);
    omega[m] = mean * (1.0 - 0.5 * relative_detuning);
    omega[m + 1] = mean * (1.0 + 0.5 * relative_detuning);
    for (Eigen::MatrixXd& shape : modes.shapes) {
      const Eigen::Vector3d first = shape.col(m), second = shape.col(m + 1);
      shape.col(m) = std::cos(angle_rad) * first + std::sin(angle_rad) * second;
      shape.col(m + 1) = std::cos(angle_rad) * second - std::sin(angle_rad) * first;
    }
    ++m;
  }
}

}  // namespace klang::datasets
