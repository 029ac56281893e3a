// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_cloud.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/file_text.h"
#include "collinea/math/median.h"
#include "collinea/raster/cubic.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

Eigen::Vector3d point_of(const EpipolarPair& cameras, const LevelPoint& point) {
  const double depth = cameras.depth_at(point.disparity_px);
  return inverse(cameras.left_from_world) * (depth * normalized(cameras.left, point.left_px).homogeneous());
}

// The standard deviation of a depth by that of its disparity.
double sigma_z(const EpipolarPair& cameras, const LevelPoint& point) {
  const double depth = cameras.depth_at(point.disparity_px);
  return depth * depth / (cameras.left.focal_px() * cameras.base_m) * point.sigma_px;
}

// Of the middle half of the values.
double middle_half(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 3 / 4] - values[values.size() / 4];
}

double median_or(std::vector<double> values, double otherwise) { return values.empty() ? otherwise : median(values); }

}  // namespace

Similarity3 map_from_model(const std::optional<AbsoluteOrientation>& absolute) {
  return absolute ? absolute->ground_from_model : Similarity3{.rotation = Eigen::Quaterniond(0, 1, 0, 0)};
}

PairCloud::PairCloud(const ModelOfPair& model, const std::optional<AbsoluteOrientation>& absolute,
                     const PairOrientationSigma& by_orientation, Raster<std::uint8_t> image, ResamplingLattice lattice,
                     PlyWriter writer, RecordSpool matching_sigmas)
    : model_(model),
      by_orientation_(by_orientation),
      map_from_model_(map_from_model(absolute)),
      left_from_map_(moved(Rigid3{}, map_from_model_)),
      image_(std::move(image)),
      lattice_(std::move(lattice)),
      writer_(std::move(writer)),
      matching_sigmas_(std::move(matching_sigmas)) {
  if (absolute) ground_from_model_ = absolute->ground_from_model;
}

Result<PairCloud> PairCloud::create(const fs::path& folder, const PairFiles& pair, const ModelOfPair& model,
                                    const std::optional<AbsoluteOrientation>& absolute,
                                    const PairOrientationSigma& by_orientation, const Run& run) {
  COLLINEA_TRY(const int channels, channels_of(pair.files[0]));
  COLLINEA_TRY(Raster<std::uint8_t> image,
               channels == 1 ? read_grey(pair.files[0], model.shrink) : read_colour(pair.files[0], model.shrink));
  COLLINEA_TRY(PlyWriter writer,
               PlyWriter::create(folder / "cloud.ply",
                                 absolute ? std::string(kPairCloudComment) : std::string(kLeftCameraCloudComment)));
  COLLINEA_TRY(RecordSpool matching_sigmas, RecordSpool::create(folder / "cloud.ply"));
  return PairCloud(model, absolute, by_orientation, std::move(image),
                   ResamplingLattice(model.left_camera, model.epipolar.left_from_image, model.epipolar.left, run),
                   std::move(writer), std::move(matching_sigmas));
}

std::array<std::uint8_t, 3> PairCloud::colour_at(const LevelPoint& point) const {
  const int x = std::clamp(int(point.left_px.x()), 0, model_.epipolar.left.width_px - 1);
  const int y = std::clamp(int(point.left_px.y()), 0, model_.epipolar.left.height_px - 1);
  const Eigen::Vector2f at = lattice_.sample_of(x, y);
  std::array<std::uint8_t, 3> colour;
  if (image_.channels == 1)
    colour.fill(cubic<1>(image_, at.x(), at.y()));
  else
    for (int c = 0; c < 3; ++c) colour[std::size_t(c)] = cubic<3>(image_, at.x(), at.y(), c);
  return colour;
}

PairCloud::Piece PairCloud::piece_of(std::span<const LevelPoint> points) const {
  Piece piece;
  const Similarity3 to_file = ground_from_model_.value_or(Similarity3{});
  const Eigen::Vector3d view =
      to_file.rotation * model_.epipolar.left_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  piece.points.reserve(points.size());
  piece.matching_sigmas_m.reserve(points.size());
  piece.sigmas_px.reserve(points.size());
  piece.sigmas_z.reserve(points.size());
  for (const LevelPoint& point : points) {
    const double sigma = sigma_z(model_.epipolar, point);
    piece.sigmas_px.push_back(float(point.sigma_px));
    piece.sigmas_z.push_back(float(sigma));
    CloudPoint made;
    made.position = point_of(model_.epipolar, point);
    if (!made.position.allFinite() || !(model_.epipolar.depth_at(point.disparity_px) > 0)) continue;
    if (ground_from_model_) made.position = *ground_from_model_ * made.position;
    made.colour = colour_at(point);
    const double matching = to_file.scale * sigma;
    piece.matching_sigmas_m.push_back(float(matching));
    made.sigma_m = float(std::sqrt(matching * matching +
                                   view.dot(by_orientation_.covariance(point.left_px, point.disparity_px) * view)));
    made.images = 2;
    piece.points.push_back(made);
  }
  return piece;
}

void PairCloud::add(const Piece& piece) {
  for (const float sigma : piece.sigmas_px) sigmas_px_.add(double(sigma));
  for (const float sigma : piece.sigmas_z) sigmas_z_.add(double(sigma));
  for (const CloudPoint& point : piece.points) {
    const Eigen::Vector3d on_map = ground_from_model_ ? point.position : map_from_model_ * point.position;
    x_m_.add(on_map.x());
    y_m_.add(on_map.y());
    sizes_m_.add((left_from_map_ * on_map).z() / model_.left_camera.focal_px());
  }
  points_ += piece.points.size();
  writer_.write(piece.points);
  matching_sigmas_.append(
      {reinterpret_cast<const char*>(piece.matching_sigmas_m.data()), piece.matching_sigmas_m.size() * sizeof(float)});
}

// The map is the ground, or the frame of the left camera turned half about x.
std::vector<PositionSigma> PairCloud::position_sigmas() const {
  constexpr std::size_t kPositions = 400;
  const std::vector<LevelPoint>& points = model_.in_epipolar;
  std::vector<PositionSigma> sigmas;
  for (std::size_t i = 0; i < points.size(); i += points.size() / kPositions + 1) {
    const Eigen::Vector3d at = map_from_model_ * point_of(model_.epipolar, points[i]);
    const double variance = by_orientation_.covariance(points[i].left_px, points[i].disparity_px)(2, 2);
    if (at.allFinite()) sigmas.push_back({at.x(), at.y(), std::sqrt(variance)});
  }
  return sigmas;
}

Result<PairCloudSummary> PairCloud::finish() {
  COLLINEA_TRY(writer_.finish());
  PairCloudSummary summary{.points = points_,
                           .median_sigma_px = median_or(sigmas_px_.values(), 0),
                           .median_sigma_z = median_or(sigmas_z_.values(), 0),
                           .pixel_m = median_or(sizes_m_.values(), 1),
                           .matching_sigmas = std::move(matching_sigmas_),
                           .by_orientation = position_sigmas()};
  if (points_ > 0)
    summary.distance_m = std::sqrt(middle_half(x_m_.values()) * middle_half(y_m_.values()) / (0.25 * double(points_)));
  return summary;
}

}  // namespace collinea
