#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/commands/transfer_documents.hpp"

/// Results of `klang bubble transfer`: of one boundary, and of a series of them.
namespace klang::apps {

struct TankModeRecord {
  double frequency_hz = 0.0;
  int m = 0, n = 0, p = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frequency_hz", "of a box as wide as the liquid and as deep as its volume makes it, between rigid walls"},
          self.frequency_hz);
    visit({"m", "half waves along x"}, self.m);
    visit({"n", "half waves along y"}, self.n);
    visit({"p", "half waves along z"}, self.p);
  }
};

struct BubblePressureRecord {
  PressureRecord pressure;
  std::optional<double> error_estimate;
  std::optional<PressureRecord> uncorrected;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    PressureRecord::describe(self.pressure, visit);
    visit(absent_if_empty({"error_estimate", "relative"}), self.error_estimate);
    visit(absent_if_empty({"uncorrected", "reciprocal: before the correction by the weighted residual"}),
          self.uncorrected);
  }
};

/// A number for each of the two domains.
struct DomainCounts {
  int fluid = 0, air = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"fluid", "in the liquid"}, self.fluid);
    visit({"air", "in the air"}, self.air);
  }
};

struct BubbleTransferDocument {
  ResultHeader header;
  std::string method;
  std::vector<BubblePressureRecord> pressure;
  std::optional<double> error_estimate;
  double radius_m = 0.0, volume_m3 = 0.0;
  int n_samples = 0;
  std::vector<TankModeRecord> tank_modes;
  double fit_error_fluid = 0.0;
  // forward
  std::optional<double> source_strength_kg_m_s2, fit_error_air, alpha_m;
  std::optional<DomainCounts> n_sources, n_unknowns, n_steps;
  std::optional<int> n_images;
  // reciprocal
  std::optional<int> n_elements;
  std::optional<double> elements_per_wavelength;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"method", "forward or reciprocal"}, self.method);
    visit({"pressure", "at the points, in their order, for a wall that swings by 1 m"}, self.pressure);
    visit({"error_estimate", "largest of the points, relative; null with the printed method"}, self.error_estimate);
    visit({"radius_m", "of the bubble at rest"}, self.radius_m);
    visit({"volume_m3", "inside the boundary"}, self.volume_m3);
    visit({"n_samples", "places on the boundary at which conditions are met"}, self.n_samples);
    visit({"tank_modes", "resonances of the vessel near the bubble's pitch"}, self.tank_modes);
    visit({"fit_error_fluid", "relative, of the conditions on the liquid"}, self.fit_error_fluid);
    visit(absent_if_empty({"source_strength_kg_m_s2", "forward: of the bubble"}), self.source_strength_kg_m_s2);
    visit(absent_if_empty({"fit_error_air", "forward: relative, of the conditions on the air"}), self.fit_error_air);
    visit(absent_if_empty({"alpha_m", "forward: weight of pressures against slopes"}), self.alpha_m);
    visit(absent_if_empty({"n_sources", "forward: source points"}), self.n_sources);
    visit(absent_if_empty({"n_unknowns", "forward: coefficients"}), self.n_unknowns);
    visit(absent_if_empty({"n_steps", "forward: of the iteration"}), self.n_steps);
    visit(absent_if_empty({"n_images", "forward: of the bubble in surfaces close to it"}), self.n_images);
    visit(absent_if_empty({"n_elements", "reciprocal: triangles of the surface in the air"}), self.n_elements);
    visit(
        absent_if_empty({"elements_per_wavelength", "reciprocal: wavelength in air over the free surface's mean edge"}),
        self.elements_per_wavelength);
  }
};

struct BubbleTransferStepRecord {
  double time_s = 0.0, re = 0.0, im = 0.0, fit_error_fluid = 0.0;
  std::optional<double> fit_error_air;
  bool frozen = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "of the frame"}, self.time_s);
    visit({"re", "Pa at the listener for a wall that swings by 1 m, time e^{+i w t}"}, self.re);
    visit({"im", "Pa"}, self.im);
    visit({"fit_error_fluid", "relative, of the conditions on the liquid"}, self.fit_error_fluid);
    visit({"fit_error_air", "relative, of the conditions on the air; null with the reciprocal method"},
          self.fit_error_air);
    visit({"frozen", "the bubble has left the liquid: the last value"}, self.frozen);
  }
};

struct BubbleTransferSeriesDocument {
  ResultHeader header;
  std::string method;
  std::optional<double> error_estimate;
  std::vector<TankModeRecord> tank_modes;
  int n_frames = 0, n_solves = 0, fluid_sources_used = 0, air_sources_used = 0, n_replaced_sources = 0;
  double decay_per_s = 0.0;
  std::vector<BubbleTransferStepRecord> transfer;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"method", "forward or reciprocal"}, self.method);
    visit({"error_estimate", "relative, at the first time; null with the printed method"}, self.error_estimate);
    visit({"tank_modes", "resonances of the vessel near the bubble's pitch, in the first frame"}, self.tank_modes);
    visit({"n_frames", "of the series"}, self.n_frames);
    visit({"n_solves", "frames that were solved; others lie between them"}, self.n_solves);
    visit({"fluid_sources_used", "source points of the liquid that the coarsest frame carries"},
          self.fluid_sources_used);
    visit({"air_sources_used", "source points of the air that the coarsest frame carries"}, self.air_sources_used);
    visit({"n_replaced_sources", "that a moving boundary passed over"}, self.n_replaced_sources);
    visit({"decay_per_s", "of the bubble, by which the steps grow"}, self.decay_per_s);
    visit({"transfer", "over time"}, self.transfer);
  }
};

}  // namespace klang::apps
