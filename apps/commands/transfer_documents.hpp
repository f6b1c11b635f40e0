#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// Results of the three forms of `klang transfer`.
namespace klang::apps {

struct PressureRecord {
  double re = 0.0, im = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"re", "Pa, time e^{+i w t}"}, self.re);
    visit({"im", "Pa"}, self.im);
  }
};

struct MultipoleRecord {
  int n = 0, m = 0;
  double re = 0.0, im = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n", "degree"}, self.n);
    visit({"m", "order, -n to n"}, self.m);
    visit({"re", "Pa: p = sum of c h_n^(2)(k r) Y_n^m"}, self.re);
    visit({"im", "Pa"}, self.im);
  }
};

/// What a solution by boundary elements says of itself.
struct SolutionRecord {
  double frequency_hz = 0.0;
  int bem_elements = 0, bem_unknowns = 0;
  std::optional<double> residual;
  double elements_per_wavelength = 0.0;
  std::string device;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frequency_hz", "of the vibration"}, self.frequency_hz);
    visit({"bem_elements", "triangles of the surface"}, self.bem_elements);
    visit({"bem_unknowns", "pressures that were solved for"}, self.bem_unknowns);
    visit({"residual", "||A x - b|| / ||b||"}, self.residual);
    visit({"elements_per_wavelength", "wavelength in air over the longest edge"}, self.elements_per_wavelength);
    visit({"device", "that made and solved the matrix: processor, or the OpenCL device's name"}, self.device);
  }
};

struct SphereTransferDocument {
  ResultHeader header;
  SolutionRecord solution;
  double surface_pressure_relative_error = 0.0, element_size_m = 0.0;
  double radiated_power_w = 0.0, exact_radiated_power_w = 0.0;
  MultipoleRecord exact_multipole;
  std::vector<MultipoleRecord> multipoles;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    SolutionRecord::describe(self.solution, visit);
    visit({"surface_pressure_relative_error", "||p - exact|| / ||exact|| over the surface"},
          self.surface_pressure_relative_error);
    visit({"element_size_m", "mean edge"}, self.element_size_m);
    visit({"radiated_power_w", "of the multipoles"}, self.radiated_power_w);
    visit({"exact_radiated_power_w", "of the exact solution"}, self.exact_radiated_power_w);
    visit({"exact_multipole", "the only one of the exact solution"}, self.exact_multipole);
    visit({"multipoles", "all that were found"}, self.multipoles);
  }
};

struct SurfaceTransferDocument {
  ResultHeader header;
  SolutionRecord solution;
  double radiated_power_w = 0.0;
  std::vector<PressureRecord> pressure;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    SolutionRecord::describe(self.solution, visit);
    visit({"radiated_power_w", "through the surface"}, self.radiated_power_w);
    visit({"pressure", "at the points, in their order"}, self.pressure);
  }
};

struct RadiatedModeRecord {
  int index = 0;
  double frequency_hz = 0.0;
  int order = 0;
  double radiated_power_w = 0.0, decay_radiation_per_s = 0.0, kept_power_fraction = 0.0;
  int bem_elements = 0;
  std::optional<double> residual;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"index", "of the mode in the model"}, self.index);
    visit({"frequency_hz", "of the mode"}, self.frequency_hz);
    visit({"order", "of its multipoles"}, self.order);
    visit({"radiated_power_w", "at a modal velocity of amplitude 1"}, self.radiated_power_w);
    visit({"decay_radiation_per_s", "of the amplitude, by what is radiated"}, self.decay_radiation_per_s);
    visit({"kept_power_fraction", "of the power, in the multipoles kept"}, self.kept_power_fraction);
    visit({"bem_elements", "triangles of the surface"}, self.bem_elements);
    visit({"residual", "||A x - b|| / ||b||"}, self.residual);
  }
};

struct TransferDocument {
  ResultHeader header;
  std::vector<RadiatedModeRecord> modes;
  std::string device;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"modes", "of the model, with their sound"}, self.modes);
    visit({"device", "that made and solved the matrices: processor, or the OpenCL device's name"}, self.device);
  }
};

}  // namespace klang::apps
