// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_orientation.h"

namespace collinea {
namespace {

// Points of images that are larger by a whole number.
void enlarge(std::vector<MatchedPoint>& points, int times) {
  for (MatchedPoint& point : points) {
    point.left_px *= times;
    point.right_px *= times;
  }
}

}  // namespace

Result<OrientedPair> orient_pair(const PairFiles& pair, const PairShrinks& shrinks, const PairChainOptions& options,
                                 PairReport& report, const Run& run, const std::optional<GivenPair>& given) {
  COLLINEA_TRY(PairImages images, read_pair(pair, shrinks.search, run));
  COLLINEA_TRY(PairPoints found, find_pair_points(images.left, images.right, options.points, run));
  for (PairPointStage& stage : found.stages) {
    stage.shrink *= shrinks.search / shrinks.surface;
    stage.parallax_px *= shrinks.search / shrinks.surface;
  }
  report.search = found.stages;
  run.report("points", 1);
  std::vector<MatchedPoint> points = std::move(found.points);
  const auto orient = [&](const std::string& by) -> Result<> {
    COLLINEA_TRY(PairOrientation next, oriented_by(by, points, images, options.relative, run.seed, given));
    next.shrink = images.shrink;
    report.orientations.push_back(std::move(next));
    return {};
  };
  COLLINEA_TRY(orient("ncc"));
  if (options.refine) {
    points = refined(points, images, run);
    COLLINEA_TRY(orient("lsm"));
  }
  if (images.shrink > shrinks.surface) {
    enlarge(points, images.shrink / shrinks.surface);
    images = {};
    COLLINEA_TRY(images, read_pair(pair, shrinks.surface, run));
    if (options.refine) {
      points = refined(points, images, run);
      COLLINEA_TRY(orient("lsm"));
    }
  }
  return OrientedPair{std::move(images), std::move(points)};
}

Result<ModelOfPair> model_of(const OrientedPair& pair, const RelativeOrientation& orientation, double base) {
  const PairImages& images = pair.images;
  ModelOfPair model{images.left_camera, images.right_camera, images.shrink, orientation, pair.points, {}, {}};
  Rigid3 right_from_left = orientation.second_from_first;
  right_from_left.translation *= base;
  COLLINEA_TRY(model.epipolar, epipolar_pair(images.left_camera, Rigid3{}, images.right_camera, right_from_left));
  for (const MatchedPoint& point : model.points) {
    const Eigen::Vector2d left =
        in_epipolar(images.left_camera, model.epipolar.left_from_image, model.epipolar.left, point.left_px);
    const Eigen::Vector2d right =
        in_epipolar(images.right_camera, model.epipolar.right_from_image, model.epipolar.right, point.right_px);
    if (left.allFinite() && right.allFinite())
      model.in_epipolar.push_back({left, left.x() - right.x(), right.y() - left.y(), point.ncc, orientation.sigma0});
  }
  return model;
}

}  // namespace collinea
