// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/plan/planned_block.h"

namespace collinea {

/// A flight of few small images, for tests.
inline FlightOptions small_flight() {
  FlightOptions flight;
  flight.east_m = 90;
  flight.north_m = 60;
  flight.width_px = 1600;
  flight.height_px = 1200;
  flight.gsd_m = 0.04;
  flight.forward_overlap = 0.7;
  flight.side_overlap = 0.5;
  flight.relief_m = 6;
  return flight;
}

inline MeasurementOptions small_measurements() {
  MeasurementOptions measurements;
  measurements.points_per_image = 60;
  measurements.map_cell_m = 15;
  return measurements;
}

}  // namespace collinea
