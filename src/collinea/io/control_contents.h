// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// What is assumed of rows that state no standard deviation.
struct ControlDefaults {
  double sigma_plan_m = 0.02;
  double sigma_height_m = 0.03;
  double sigma_px = 0.5;
};

/// A surveyed point as a file tells it. An axis that was not surveyed has an infinite sigma; its coordinate is then the
/// mean of the other points' (0 when there is none), so that conversions between frames stay sound.
struct ControlFilePoint {
  std::string name;
  Eigen::Vector3d position_in_map;  ///< easting, northing, height [m]
  Eigen::Vector3d sigma_m;          ///< east, north, height
  ControlRole role = ControlRole::kControl;
  Eigen::Vector3d correlation = Eigen::Vector3d::Zero();  ///< as ControlPoint::correlation
};

/// A surveyed point seen in an image.
struct ControlFileObservation {
  std::string point;  ///< the name of one of the points
  std::string file;   ///< the image, as the control file calls it: usually without its folder
  Eigen::Vector2d pixel;
  double sigma_px = 0.5;
  int line = 0;  ///< of the control file, for messages
  PixelShape shape;
};

struct ControlFile {
  std::string crs;                                   ///< what PROJ understands; empty: the file states none
  std::vector<ControlFilePoint> points;              ///< in the order of the file, names differ
  std::vector<ControlFileObservation> observations;  ///< in the order of the file
};

}  // namespace collinea
