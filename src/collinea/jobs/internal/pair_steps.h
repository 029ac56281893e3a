// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "collinea/dense/level_point.h"
#include "collinea/jobs/internal/given_pair.h"
#include "collinea/jobs/internal/pair_film.h"
#include "collinea/jobs/internal/pair_options.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// The photographs of a pair, without their pixels.
struct PairFiles {
  std::optional<PairFilm> film = {};
  std::array<std::filesystem::path, 2> files;
  std::array<Camera, 2> cameras;

  [[nodiscard]] double pixels() const;  ///< of the larger one
};
/// `folder`: where the ideal images of film are written.
[[nodiscard]] Result<PairFiles> open_pair(const std::filesystem::path& left, const std::filesystem::path& right,
                                          const std::filesystem::path& folder, const PairChainOptions& options,
                                          const Run& run);

/// By how much the images are reduced where points are looked for, and where they are measured and the surface is.
struct PairShrinks {
  int search = 1, surface = 1;
};
/// `area_px`: pixels of the files whose surface is found, where it is not all. Error: the resolution asked for takes
/// more memory than the machine has.
[[nodiscard]] Result<PairShrinks> shrinks_of(const PairFiles& pair, const PairChainOptions& options,
                                             std::optional<double> area_px = {});

/// The images of a pair as they are worked on.
struct PairImages {
  GreyImage left, right;
  Camera left_camera, right_camera;  ///< of these images
  int shrink = 1;                    ///< against the files
};
[[nodiscard]] Result<PairImages> read_pair(const PairFiles& pair, int shrink, const Run& run);

/// A pair in the frame of its left camera.
struct ModelOfPair {
  Camera left_camera, right_camera;  ///< of the images as they are worked on
  int shrink = 1;                    ///< of these against the files
  RelativeOrientation orientation;
  std::vector<MatchedPoint> points;
  EpipolarPair epipolar;
  std::vector<LevelPoint> in_epipolar;  ///< the points

  [[nodiscard]] Rigid3 right_from_left() const;  ///< with the base of the epipolar pair
};

/// Points as the relative orientation takes them; sigma_px is that of a point of the sigma 1.
[[nodiscard]] std::vector<PairPoint> normalised(const std::vector<MatchedPoint>& points, const Camera& left,
                                                const Camera& right, double sigma_px);

/// Orients the pair by the points, or tells what they say of an orientation that is given, and drops from them those
/// that were rejected. Error: most points are behind a camera of the given orientation.
[[nodiscard]] Result<PairOrientation> oriented_by(const std::string& by, std::vector<MatchedPoint>& points,
                                                  const PairImages& images, const RelativeOptions& options,
                                                  std::uint64_t seed, const std::optional<GivenPair>& given = {});

/// Right positions by least squares matching, with standard deviations such that the mean weight is 1; points where it
/// finds nothing are dropped.
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
