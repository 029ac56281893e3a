// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "collinea/jobs/internal/pair_film.h"
#include "collinea/jobs/internal/pair_options.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// The images of a pair as they are worked on.
struct PairImages {
  GreyImage left, right;
  ColourImage left_colours;
  Camera left_camera, right_camera;  ///< of these images
  int shrink = 1;                    ///< against the files
  std::optional<PairFilm> film = {};
  std::array<std::filesystem::path, 2> files;
  std::array<Camera, 2> file_cameras;  ///< of the files
};
/// `folder`: where the ideal images of film are written.
[[nodiscard]] Result<PairImages> read_pair(const std::filesystem::path& left, const std::filesystem::path& right,
                                           const std::filesystem::path& folder, const PairChainOptions& options,
                                           const Run& run);

/// Points as the relative orientation takes them.
[[nodiscard]] std::vector<PairPoint> normalised(const std::vector<MatchedPoint>& points, const PairImages& images,
                                                double sigma_px);

/// Orients the pair by the points, and drops from them those that were rejected.
[[nodiscard]] Result<PairOrientation> oriented_by(const std::string& by, std::vector<MatchedPoint>& points,
                                                  const PairImages& images, const RelativeOptions& options,
                                                  std::uint64_t seed);

/// Right positions by least squares matching; points where it finds nothing are dropped.
[[nodiscard]] std::vector<MatchedPoint> refined(const std::vector<MatchedPoint>& points, const PairImages& images,
                                                const Run& run);

/// A position of the left or right image in the epipolar one.
[[nodiscard]] Eigen::Vector2d in_epipolar(const Camera& image, const Eigen::Quaterniond& epipolar_from_image,
                                          const Camera& epipolar, const Eigen::Vector2d& pixel);

/// The standard deviation of the row of an epipolar line at a position of the epipolar left image, by the covariance of
/// the orientation, for points of about that disparity (EpipolarLines::sigma).
[[nodiscard]] std::function<double(const Eigen::Vector2d&)> row_sigma(const EpipolarPair& epipolar,
                                                                      const RelativeOrientation& orientation,
                                                                      double disparity_px);

}  // namespace collinea
