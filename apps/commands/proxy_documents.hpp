#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// Results of `klang proxy build | info | lookup`.
namespace klang::apps {

struct ProxyBuildDocument {
  ResultHeader header;
  std::uint64_t n_cells = 0, n_nodes = 0, bytes = 0;
  double max_interpolation_error = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_cells", "shapes with sound"}, self.n_cells);
    visit({"n_nodes", "shapes with frequencies"}, self.n_nodes);
    visit({"max_interpolation_error", "of the checked frequencies, at shapes that no refinement saw"},
          self.max_interpolation_error);
    visit({"bytes", "of the file"}, self.bytes);
  }
};

struct ProxyInfoDocument {
  ResultHeader header;
  std::uint64_t n_cells = 0, n_nodes = 0, n_modes = 0, n_modes_with_sound = 0, bytes = 0;
  double max_interpolation_error = 0.0, max_interpolation_error_all_modes = 0.0;
  int n_check_shapes = 0, n_checked_modes = 0, modes_per_cell = 0, highest_order = 0;
  double tolerance = 0.0, thinnest = 0.0, poissons_ratio = 0.0, youngs_modulus_pa = 0.0, density_kg_m3 = 0.0;
  double shear_speed_over_sound_speed = 0.0, air_density_kg_m3 = 0.0, air_sound_speed_m_s = 0.0,
         max_boundary_error = 0.0;
  JsonText built_by;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_cells", "shapes with sound"}, self.n_cells);
    visit({"n_nodes", "shapes with frequencies"}, self.n_nodes);
    visit({"max_interpolation_error", "of the first n_checked_modes, at shapes that no refinement saw"},
          self.max_interpolation_error);
    visit({"max_interpolation_error_all_modes", "of the first modes_per_cell there"},
          self.max_interpolation_error_all_modes);
    visit({"n_check_shapes", "shapes of that check"}, self.n_check_shapes);
    visit({"n_checked_modes", "frequencies of that check"}, self.n_checked_modes);
    visit({"tolerance", "that was asked for"}, self.tolerance);
    visit({"thinnest", "shortest over longest axis"}, self.thinnest);
    visit({"poissons_ratio", "of all shapes"}, self.poissons_ratio);
    visit({"youngs_modulus_pa", "at which they were made; frequencies scale"}, self.youngs_modulus_pa);
    visit({"density_kg_m3", "at which they were made"}, self.density_kg_m3);
    visit({"shear_speed_over_sound_speed", "that the sound was made with"}, self.shear_speed_over_sound_speed);
    visit({"air_density_kg_m3", "of the sound"}, self.air_density_kg_m3);
    visit({"air_sound_speed_m_s", "of the sound"}, self.air_sound_speed_m_s);
    visit({"modes_per_cell", "modes of each shape"}, self.modes_per_cell);
    visit({"n_modes", "in all"}, self.n_modes);
    visit({"n_modes_with_sound", "of these, with multipoles"}, self.n_modes_with_sound);
    visit({"highest_order", "of the multipoles"}, self.highest_order);
    visit({"max_boundary_error", "of the normal velocity, worst mode"}, self.max_boundary_error);
    visit({"bytes", "of the file"}, self.bytes);
    visit({"built_by", "provenance of the bank"}, self.built_by);
  }
};

struct ProxyCellRecord {
  int index = 0;
  std::vector<double> axes;
  double distance = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"index", "of the nearest shape with sound"}, self.index);
    visit({"axes", "its semi-axes, of unit length"}, self.axes);
    visit({"distance", "of the body's shape from it"}, self.distance);
  }
};

struct ProxyLookupDocument {
  ResultHeader header;
  std::vector<double> axes, axes_m, frequencies_hz, rotation_rows;
  double scale = 0.0;
  bool clamped = false;
  ProxyCellRecord cell;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"axes", "semi-axes of the ellipsoid, of unit length"}, self.axes);
    visit({"scale", "m: axes times this are the semi-axes"}, self.scale);
    visit({"axes_m", "semi-axes"}, self.axes_m);
    visit({"frequencies_hz", "lowest of the ellipsoid"}, self.frequencies_hz);
    visit({"clamped", "the body is thinner than the bank's thinnest shape, which is taken"}, self.clamped);
    visit({"rotation_rows", "3 x 3 by rows, which are the body's principal axes in its own frame"}, self.rotation_rows);
    visit({"cell", "whose sound is taken"}, self.cell);
  }
};

}  // namespace klang::apps
