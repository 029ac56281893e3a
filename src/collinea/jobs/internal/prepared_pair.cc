// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/prepared_pair.h"

#include <algorithm>
#include <set>

#include "collinea/dense/working_images.h"
#include "collinea/import/image_names.h"
#include "collinea/io/colmap.h"
#include "collinea/project/fitted_camera.h"
#include "collinea/project/project.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr int kPartOfWidth =
    8;  // largest disparity of a rectified pair of which nothing is stated: width / kPartOfWidth

Result<int> shrink_for(const Camera& camera, const StereoPairOptions& pair) {
  DenseOptions options;
  options.resolution = pair.resolution;
  return working_shrink(camera, options);
}

GreyImage without_zero(GreyImage image) {
  for (auto& grey : image.data) grey = std::max<std::uint8_t>(grey, 1);
  return image;
}

Result<PreparedPair> rectified_pair(const fs::path& left, const fs::path& right, const StereoPairOptions& pair) {
  PreparedPair ready;
  const int shrink = static_cast<int>(pair.resolution.value_or(Resolution::kFull));
  COLLINEA_TRY(GreyImage left_grey, read_grey(left, shrink));
  COLLINEA_TRY(GreyImage right_grey, read_grey(right, shrink));
  COLLINEA_TRY(ready.colours, read_colour(left, shrink));
  if (pair.focal_px.has_value() != pair.base_m.has_value())
    return fail(Errc::kBadInput, "coordinates in space need both the focal length and the base",
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

Result<PreparedPair> oriented_pair(const Block& block, const Side& left, const Side& right, const Run& run) {
  PreparedPair ready;
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

}  // namespace

Result<PreparedPair> prepared_pair(const std::string& left, const std::string& right, const StereoPairOptions& pair,
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

Result<DisparityRange> range_for(const PreparedPair& ready, const StereoPairOptions& pair) {
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

}  // namespace collinea
