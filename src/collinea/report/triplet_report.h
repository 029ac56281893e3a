// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/epipolar/image_bundles.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/epipolar/three_images.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// Three images joined from two pairs, as found from a table.
struct TripletReport {
  /// The relative orientation of images 1-2 and 2-3 by itself.
  struct Pair {
    std::size_t points = 0;
    double sigma0 = 0;
    std::vector<std::string> rejected;
    std::array<int, 4> in_front{};  ///< of the four orientations A, B, C, D: points in front of both images
  };
  struct Image {
    std::string name;
    std::vector<Estimate> exterior;  ///< X, Y, Z, omega, phi, kappa in the model
    /// Of these, in their units; of the first image 0.
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  };
  struct Point {
    std::string name;
    Eigen::Vector3d position;
    Eigen::Matrix3d covariance;
    int rays = 0;
  };
  struct Mark {
    std::string image, point;
    BundleMarkTest test;  ///< in the axes of the table; w by VarianceTest::factor()
    bool is_rejected = false;
  };
  PhotoFrame frame;
  std::array<Pair, 2> pairs;
  std::size_t common = 0;  ///< points measured in all three images, and not rejected
  ThreeImages joined;
  Estimate base_ratio;  ///< second base over the first one, adjusted
  std::array<Image, 3> images;
  std::vector<Point> points;
  std::vector<Mark> marks;
  std::vector<std::string> without_position;  ///< rays parallel or meeting behind an image
  double base = 1;                            ///< of images 1 and 2
  bool base_is_given = false;                 ///< then it is in m
  double conditioning = 0;                    ///< AdjustedBundles::conditioning
  int iterations = 0;
  VarianceTest variance;
  std::vector<Finding> findings;
};

/// For a terminal: both pairs, the sixteen combinations and the choice, orientation, residuals with tests.
[[nodiscard]] std::string triplet_text(const TripletReport& report);
/// combinations, exterior, model, residuals.
[[nodiscard]] std::vector<NamedTable> triplet_tables(const TripletReport& report);

}  // namespace collinea
