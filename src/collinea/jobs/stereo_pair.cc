// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/stereo_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/base/file.h"
#include "collinea/cloud/ply.h"
#include "collinea/dense/epipolar_pair.h"
#include "collinea/dense/level_disparities.h"
#include "collinea/dense/working_images.h"
#include "collinea/import/image_names.h"
#include "collinea/io/colmap.h"
#include "collinea/math/median.h"
#include "collinea/project/fitted_camera.h"
#include "collinea/project/json_text.h"
#include "collinea/project/project.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr int kPartOfWidth =
    8;  // largest disparity of a rectified pair of which nothing is stated: width / kPartOfWidth

// Everything matching needs of a pair.
struct Prepared {
  GreyImage left, right;
  ColourImage colours;        // of the left image
  ColourImage right_colours;  // where the images are resampled
  std::optional<EpipolarPair> cameras;
  std::optional<DisparityRange> from_points;
  bool resampled = false;
  PairFrame frame{};  // of the cloud
};

Result<int> shrink_for(const Camera& camera, const StereoPairOptions& pair) {
  DenseOptions options;
  options.resolution = pair.resolution;
  return working_shrink(camera, options);
}

GreyImage without_zero(GreyImage image) {
  for (auto& grey : image.data) grey = std::max<std::uint8_t>(grey, 1);
  return image;
}

Result<Prepared> rectified_pair(const fs::path& left, const fs::path& right, const StereoPairOptions& pair) {
  Prepared ready;
  const int shrink = static_cast<int>(pair.resolution.value_or(Resolution::kFull));
  COLLINEA_TRY(GreyImage left_grey, read_grey(left, shrink));
  COLLINEA_TRY(GreyImage right_grey, read_grey(right, shrink));
  COLLINEA_TRY(ready.colours, read_colour(left, shrink));
  if (pair.focal_px.has_value() != pair.base_m.has_value())
    return fail(Errc::kBadInput, "a cloud needs both the focal length and the base",
                {"focal_px"_option, "base_m"_option});
  if (pair.focal_px)
    ready.cameras =
        epipolar_pair(*pair.focal_px / shrink, *pair.base_m, left_grey.width, right_grey.width, left_grey.height);
  ready.left = without_zero(std::move(left_grey));
  ready.right = without_zero(std::move(right_grey));
  ready.frame = PairFrame::kLeftCamera;
  return ready;
}

struct Side {
  ImageId image;
  fs::path file;
  Camera camera;  // of the image, shrunk
  int shrink = 1;
};

Result<Side> side_of(const Block& block, ImageId image, const fs::path& file, const StereoPairOptions& pair) {
  if (!is_oriented(block, image)) return fail(Errc::kIllPosed, file.string() + " is not oriented");
  COLLINEA_TRY(const ImageHeader header, read_image_header(file));
  COLLINEA_TRY(const Camera whole, fitted_to(block.camera_of(image), header.width_px, header.height_px, file.string()));
  COLLINEA_TRY(const int shrink, shrink_for(whole, pair));
  return Side{image, file, shrunk(whole, shrink), shrink};
}

std::vector<Eigen::Vector3d> points_seen_by_both(const Block& block, ImageId left, ImageId right) {
  std::set<PointId> seen_left;
  for (const Observation& seen : block.observations)
    if (seen.image == left) seen_left.insert(seen.point);
  std::vector<Eigen::Vector3d> points;
  for (const Observation& seen : block.observations)
    if (seen.image == right && seen_left.count(seen.point))
      points.push_back(block.points.at(seen.point).position_in_world);
  return points;
}

Result<Prepared> oriented_pair(const Block& block, const Side& left, const Side& right, const Run& run) {
  Prepared ready;
  COLLINEA_TRY(const EpipolarPair cameras,
               epipolar_pair(left.camera, pose_of(block, left.image), right.camera, pose_of(block, right.image)));
  COLLINEA_TRY(const ColourImage left_image, read_colour(left.file, left.shrink));
  COLLINEA_TRY(const ColourImage right_image, read_colour(right.file, right.shrink));
  COLLINEA_TRY(const GreyImage left_grey, read_grey(left.file, left.shrink));
  COLLINEA_TRY(const GreyImage right_grey, read_grey(right.file, right.shrink));
  const RayBend &left_bend = block.images.at(left.image).bend, &right_bend = block.images.at(right.image).bend;
  ready.colours = resampled(left_image, left.camera, cameras.left_from_image, cameras.left, run, left_bend);
  ready.right_colours = resampled(right_image, right.camera, cameras.right_from_image, cameras.right, run, right_bend);
  ready.left = resampled(left_grey, left.camera, cameras.left_from_image, cameras.left, run, left_bend);
  ready.right = resampled(right_grey, right.camera, cameras.right_from_image, cameras.right, run, right_bend);
  const auto points = points_seen_by_both(block, left.image, right.image);
  ready.from_points = range_of(cameras, points);
  ready.cameras = cameras;
  ready.resampled = true;
  ready.frame = PairFrame::kWorld;
  return ready;
}

Result<Prepared> prepared(const std::string& left, const std::string& right, const StereoPairOptions& pair,
                          const Run& run) {
  if (int(pair.rectified) + int(pair.project.has_value()) + int(pair.orientation.has_value()) != 1)
    return fail(Errc::kBadInput,
                "where is the orientation? Name one: a project, a model, or that the pair is rectified",
                {"project"_option, "orientation"_option, "rectified"_option});
  if (pair.rectified) return rectified_pair(left, right, pair);
  if (pair.focal_px || pair.base_m)
    return fail(Errc::kBadInput, "focal length and base are for a rectified pair; an orientation knows them",
                {"focal_px"_option, "base_m"_option, "rectified"_option});
  Block block;
  fs::path folder;
  if (pair.project) {
    COLLINEA_TRY(const Project project, open_project(*pair.project, run));
    COLLINEA_TRY(block, project.store.read_block());
    folder = project.settings.photos;
  } else {
    COLLINEA_TRY(block, read_colmap(*pair.orientation));
  }
  const ImageNames names(block);
  const auto side = [&](const std::string& asked) -> Result<Side> {
    COLLINEA_TRY(const ImageId image, names.find_image(asked));
    return side_of(block, image, pair.project ? folder / block.images.at(image).file : fs::path(asked), pair);
  };
  COLLINEA_TRY(const Side left_side, side(left));
  COLLINEA_TRY(const Side right_side, side(right));
  return oriented_pair(block, left_side, right_side, run);
}

Result<DisparityRange> range_for(const Prepared& ready, const StereoPairOptions& pair) {
  DisparityRange range;
  if (ready.from_points) {
    range = *ready.from_points;
  } else if (pair.rectified) {
    range = {0, std::max(ready.left.width / kPartOfWidth, 15)};
  } else if (!pair.min_disparity || !pair.max_disparity) {
    return fail(Errc::kBadInput, "too few tie points that both photographs show: give the range of disparities",
                {"min_disparity"_option, "max_disparity"_option});
  }
  if (pair.min_disparity) range.low = *pair.min_disparity;
  if (pair.max_disparity) range.high = *pair.max_disparity;
  return range;
}

Result<> check_options(const StereoMatching& options) {
  const StereoOptions& dense = options.dense;
  // What other matchers share of those of semi-global matching.
  StereoOptions shared;
  shared.fill = dense.fill;
  if (options.matcher == StereoMatcher::kLocal) {
    shared.max_left_right_px = dense.max_left_right_px;
    shared.min_patch_px = dense.min_patch_px;
  }
  if (options.matcher != StereoMatcher::kDense && dense != shared)
    return fail(Errc::kBadInput, "options of the dense matcher say nothing of another", {"matcher"_option});
  if (options.matcher != StereoMatcher::kLocal && options.local != LocalOptions{})
    return fail(Errc::kBadInput, "options of the local matcher say nothing of another", {"matcher"_option});
  if (options.matcher != StereoMatcher::kLevels && options.levels != LevelOptions{})
    return fail(Errc::kBadInput, "options of the levels say nothing of another matcher", {"matcher"_option});
  return {};
}

// Disparities, how many of them were measured, and what the levels did.
struct Matched {
  DisparityMap map;
  std::size_t measured = 0;
  std::vector<LevelCount> levels;
};

Result<Matched> matched(const Prepared& ready, const DisparityRange& range, const StereoMatching& options,
                        const Run& run) {
  Matched made;
  std::vector<LevelPoint> points;
  if (options.matcher == StereoMatcher::kLevels) {
    COLLINEA_TRY(LevelDisparities found,
                 match_rectified_by_levels(ready.left, ready.right, range, options.levels, run));
    made.map = std::move(found.map);
    made.levels = std::move(found.surface.levels);
    points = std::move(found.surface.points);
  } else if (options.matcher == StereoMatcher::kLocal) {
    COLLINEA_TRY(made.map, match_locally(ready.left, ready.right, range, options.local,
                                         {options.dense.max_left_right_px, options.dense.min_patch_px}, run));
  } else {
    StereoOptions dense = options.dense;
    dense.fill = false;
    COLLINEA_TRY(made.map, match_pair(ready.left, ready.right, range, dense, run));
  }
  for (const float disparity : made.map.disparity.data) made.measured += !std::isnan(disparity);
  if (!options.dense.fill) return made;
  if (options.matcher == StereoMatcher::kLevels) {
    fill_by_triangles(points, made.map.disparity, run);
    if (run.stopped()) return fail(Errc::kCancelled, "filling was stopped");
  }
  // Outside of all triangles, too.
  fill_disparities(made.map.disparity);
  return made;
}

// Blue is far, red is near.
std::array<std::uint8_t, 3> rainbow(double part) {
  const auto ramp = [&](double middle) {
    return std::uint8_t(255 * std::clamp(1.5 - std::abs(4 * part - middle), 0.0, 1.0));
  };
  return {ramp(3), ramp(2), ramp(1)};
}

ColourImage coloured(const FloatImage& disparity) {
  std::vector<float> values;
  for (const float value : disparity.data)
    if (!std::isnan(value)) values.push_back(value);
  ColourImage image(disparity.width, disparity.height, 3);
  if (values.empty()) return image;
  std::sort(values.begin(), values.end());
  const float low = values[values.size() / 50], high = values[values.size() - 1 - values.size() / 50];
  for (std::size_t i = 0; i < disparity.data.size(); ++i) {
    if (std::isnan(disparity.data[i])) continue;
    const auto colour = rainbow(std::clamp((disparity.data[i] - low) / std::max(high - low, 1e-6f), 0.0f, 1.0f));
    std::copy(colour.begin(), colour.end(), image.data.begin() + std::ptrdiff_t(3 * i));
  }
  return image;
}

Result<std::size_t> write_cloud(const fs::path& path, const Prepared& ready, const DisparityMap& map) {
  const auto fused = cloud_of(*ready.cameras, map, ready.colours);
  std::vector<CloudPoint> points;
  points.reserve(fused.size());
  for (const FusedPoint& p : fused)
    points.push_back({p.position_in_world, p.normal_in_world, p.colour, p.sigma, p.images, 0});
  COLLINEA_TRY(PlyWriter writer, PlyWriter::create(path, ready.frame == PairFrame::kLeftCamera ? kLeftCameraCloudComment
                                                                                               : kPairCloudComment));
  writer.write(points);
  COLLINEA_TRY(writer.finish());
  return points.size();
}

StereoReport report_of(const Prepared& ready, const DisparityRange& range, const StereoMatching& options,
                       const Matched& matched) {
  StereoReport report{.matcher = options.matcher,
                      .min_disparity_px = range.low,
                      .max_disparity_px = range.high,
                      .measured = matched.measured,
                      .levels = matched.levels,
                      .frame = ready.frame};
  for (const std::uint8_t grey : ready.left.data) report.pixels += grey != 0;
  std::vector<float> sigmas;
  for (const float sigma : matched.map.sigma.data)
    if (!std::isnan(sigma)) sigmas.push_back(sigma);
  if (!sigmas.empty()) report.median_sigma_px = median(sigmas);
  return report;
}

bool has_sigmas(const StereoMatching& options) {
  return options.matcher != StereoMatcher::kLocal ||
         (options.local.similarity != Similarity::kRank && options.local.similarity != Similarity::kCensus);
}

}  // namespace

Result<StereoReport> match_stereo(const std::string& left, const std::string& right, const fs::path& folder,
                                  const StereoPairOptions& pair, const StereoMatching& options, const Run& run) {
  COLLINEA_TRY(validate(pair));
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(check_options(options));
  COLLINEA_TRY(const Prepared ready, prepared(left, right, pair, run));
  COLLINEA_TRY(const DisparityRange range, range_for(ready, pair));
  run.say(fmt::format("{} x {} px, disparities {} to {}", ready.left.width, ready.left.height, range.low, range.high));
  COLLINEA_TRY(const Matched found, matched(ready, range, options, run));
  const DisparityMap& map = found.map;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  const auto written = [&]() -> Result<> {
    if (ready.resampled) {
      COLLINEA_TRY(write_png(folder / "left.png", ready.colours));
      COLLINEA_TRY(write_png(folder / "right.png", ready.right_colours));
    }
    COLLINEA_TRY(write_float_tiff(folder / "disparity.tif", map.disparity));
    COLLINEA_TRY(write_float_tiff(folder / "sigma.tif", map.sigma));
    return write_png(folder / "disparity.png", coloured(map.disparity));
  }();
  if (!written) return tl::unexpected(written.error());
  fs::remove(folder / "cloud.ply", error);  // of an earlier run
  StereoReport report = report_of(ready, range, options, found);
  if (ready.cameras) {
    std::size_t points = 0;
    if (has_sigmas(options)) {
      COLLINEA_TRY(points, write_cloud(folder / "cloud.ply", ready, map));
    }
    const EpipolarPair& known = *ready.cameras;
    report.cameras = {known.left, known.right, known.left_from_world, known.base_m, points};
  }
  COLLINEA_TRY(write_file(folder / "stereo.json", stereo_json(report)));
  return report;
}

}  // namespace collinea
