#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "core/geometry/mesh/surface_repair.hpp"

/// The result of `klang modes`.
namespace klang::modal {

struct ModeRecord {
  int index = 0;
  double frequency_hz = 0.0;
  std::optional<double> relative_residual, mesh_relative_error, relative_error_bound;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"index", "of the elastic mode, from 0"}, self.index);
    visit(needed({"frequency_hz", "of the mode"}), self.frequency_hz);
    visit({"relative_residual", "of the eigenpair"}, self.relative_residual);
    visit({"mesh_relative_error",
           "estimate of (f_h - f)/f >= 0 against an infinitely fine mesh of the same surface, or null"},
          self.mesh_relative_error);
    visit(
        {"relative_error_bound",
         "how much too high the frequency may be: for polynomial what the last raise of the degrees took off, twice; "
         "for harmonics "
         "the estimate; for tetrahedra twice the estimate, none where that is above 3 %; null: not asked for, or none"},
        self.relative_error_bound);
  }
};

struct ModeFiles {
  std::optional<std::string> modes;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"modes", "modal model (.vtu)"}, self.modes);
  }
};

struct ModesDocument {
  ResultHeader header;
  JsonText shape;
  std::optional<int> n_nodes, n_elements;
  std::string element, method;
  std::optional<int> n_rigid_modes;
  std::optional<int> n_below_band, n_left_out;
  std::optional<bool> none_missing;
  std::optional<mesh::SurfaceRepairs> repairs;
  std::optional<mesh::SurfaceDecimation> decimation;
  std::vector<ModeRecord> modes;
  std::optional<double> mass_kg;
  std::optional<std::uint64_t> peak_memory_bytes;
  std::optional<ModeFiles> files;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit(absent_if_empty({"shape", "kind and dimensions, where someone adds them for the page"}), self.shape);
    visit({"n_nodes", "of the mesh"}, self.n_nodes);
    visit({"n_elements", "of the mesh"}, self.n_elements);
    visit({"element", "p1 or p2"}, self.element);
    visit({"method", "polynomial, harmonics or tetrahedra"}, self.method);
    visit({"n_rigid_modes", "that were left out"}, self.n_rigid_modes);
    visit(absent_if_empty({"n_below_band", "elastic modes below the band, which are not listed"}), self.n_below_band);
    visit(absent_if_empty({"n_left_out", "modes within the band above those listed, where nobody asked for a band"}),
          self.n_left_out);
    visit({"none_missing", "true: a Sturm count proves it; null: not checked"}, self.none_missing);
    visit(absent_if_empty({"repairs", "of a surface file: what was mended"}), self.repairs);
    visit(absent_if_empty({"decimation", "of a surface file that was made coarser"}), self.decimation);
    visit({"modes", "ascending in frequency"}, self.modes);
    visit(absent_if_empty({"mass_kg", "where someone adds it for the page"}), self.mass_kg);
    visit({"peak_memory_bytes", "of the program"}, self.peak_memory_bytes);
    visit(absent_if_empty({"files", "where someone adds them for the page's pictures"}), self.files);
  }
};

}  // namespace klang::modal
