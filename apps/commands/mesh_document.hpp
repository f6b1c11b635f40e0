#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/foundation/config/result_header.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "core/geometry/mesh/surface_repair.hpp"

/// The result of `klang mesh`.
namespace klang::apps {

struct MeshDocument {
  ResultHeader header;
  mesh::MeshQuality quality;
  std::string element;
  std::optional<double> mass_kg, n_expected_elements;
  std::optional<mesh::SurfaceRepairs> repairs;
  std::optional<mesh::SurfaceDecimation> decimation;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_nodes", "of the mesh"}, self.quality.n_nodes);
    visit({"n_elements", "tetrahedra"}, self.quality.n_elements);
    visit({"element", "p1 (linear) or p2 (quadratic)"}, self.element);
    visit({"min_dihedral_deg", "smallest angle between faces; 70.53 in a regular tetrahedron"},
          self.quality.min_dihedral_deg);
    visit({"max_dihedral_deg", "largest"}, self.quality.max_dihedral_deg);
    visit({"radius_ratio_min", "3 x inscribed over circumscribed radius, of the worst element: 1 regular, 0 flat"},
          self.quality.radius_ratio_min);
    visit({"radius_ratio_mean", "of all elements"}, self.quality.radius_ratio_mean);
    visit({"worst_element", "number of the worst, from 0"}, self.quality.worst_element);
    visit({"min_scaled_jacobian", "smallest det J over its mean in the element: 1 straight, 0 and below folded"},
          self.quality.min_scaled_jacobian);
    visit({"volume_m3", "of the curved elements"}, self.quality.volume_m3);
    visit({"surface_area_m2", "of the curved boundary"}, self.quality.surface_area_m2);
    visit({"shortest_edge_m", "of all elements"}, self.quality.shortest_edge_m);
    visit({"longest_edge_m", "of all elements"}, self.quality.longest_edge_m);
    visit(absent_if_empty({"mass_kg", "with --density-kg-m3"}), self.mass_kg);
    visit(absent_if_empty({"n_expected_elements", "of a surface file: estimate before it was filled"}),
          self.n_expected_elements);
    visit(absent_if_empty({"repairs", "of a surface file: what was mended"}), self.repairs);
    visit(absent_if_empty({"decimation", "of a surface file that was made coarser"}), self.decimation);
  }
};

}  // namespace klang::apps
