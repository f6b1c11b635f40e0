#pragma once
#include <cmath>

#include "core/physics/events/event_log.hpp"

namespace klang::events {

/// A plate that falls, is struck and breaks into two, beside two bubbles; numbers that no decimal text shortens.
inline EventLog sample_log() {
  EventLog log;
  log.bodies = {{"plate", -1}, {"plate, piece 1", 0}, {"Stück 2", 0}};
  Impulse impact;
  impact.time_s = 1.0 / 3.0;
  impact.duration_s = std::sqrt(2.0) * 1e-4;
  impact.body = 0;
  impact.point_m = {0.1, -1.0 / 7.0, 0.0};
  impact.impulse_n_s = {0.0, 1e-300, -std::exp(1.0)};
  Impulse crack = impact;
  crack.time_s = 0.4;
  crack.shape = PulseShape::kGaussian;
  crack.kind = ImpulseKind::kFracture;
  crack.body = 2;
  log.impulses = {impact, crack};
  log.poses = {{0, 0.0, {0, 0, 1.0 / 3.0}, {1, 0, 0, 0}},
               {0, 0.1, {0, 0, 0.3}, {std::cos(0.3), 0, 0, std::sin(0.3)}},
               {1, 0.4, {0, 0, 0}, {0, 1, 0, 0}}};
  log.fractures = {{0.4, 0}};
  log.bubbles = {{0.01, 2e-3, 1.0, {0, 0, -0.02}}, {0.5, 1.0 / 900.0, 0.5, {0.1, 0, -0.03}}};
  log.bubble_points = {{1, 0.4, {0.1, 0, -0.03}, -0.031}, {1, 0.6, {0.1, 0, -0.02}, -0.019}};
  return log;
}

}  // namespace klang::events
