// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/stereo_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/cloud/ply.h"
#include "collinea/dense/epipolar_pair.h"
#include "collinea/dense/level_disparities.h"
#include "collinea/jobs/internal/prepared_pair.h"
#include "collinea/math/median.h"
#include "collinea/project/json_text.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

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

Result<Matched> matched(const PreparedPair& ready, const DisparityRange& range, const StereoMatching& options,
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

Result<std::size_t> write_cloud(const fs::path& path, const PreparedPair& ready, const DisparityMap& map) {
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

StereoReport report_of(const PreparedPair& ready, const DisparityRange& range, const StereoMatching& options,
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
  COLLINEA_TRY(const PreparedPair ready, prepared_pair(left, right, pair, run));
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
