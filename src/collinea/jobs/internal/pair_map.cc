// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/ortho/orthophoto.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/hillshade.h"
#include "collinea/raster/image_file.h"
#include "collinea/surface/dsm.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBatch = 100'000;  // points handed out at once
constexpr double kLeastPart = 0.5;       // of the mean distance of points, that a cell must have

Block block_of(const MappedPair& pair) {
  Block block;
  for (std::size_t i = 0; i < 2; ++i) {
    const CameraId camera{std::uint32_t(i)};
    const ImageId id{std::uint32_t(i)};
    block.cameras.emplace(camera, pair.cameras[i]);
    Image image;
    image.file = pair.files[i].string();
    image.camera = camera;
    block.images.emplace(id, image);
    set_pose(block, id, pair.cam_from_ground[i]);
  }
  return block;
}

PointSource points_of(const std::vector<CloudPoint>& cloud) {
  return [&cloud, next = std::size_t{0}](std::vector<SurfacePoint>& batch) mutable -> Result<> {
    batch.clear();
    for (; next < cloud.size() && batch.size() < kBatch; ++next)
      batch.push_back({cloud[next].position, cloud[next].sigma_m, cloud[next].images});
    return {};
  };
}

// What a point has to itself on the map, as the side of a square: of the middle half of the points in each direction.
double distance_m(const std::vector<CloudPoint>& cloud) {
  double side[2];
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const CloudPoint& point : cloud) values.push_back(point.position[axis]);
    std::sort(values.begin(), values.end());
    side[axis] = values[values.size() * 3 / 4] - values[values.size() / 4];
  }
  return std::sqrt(side[0] * side[1] / (0.25 * double(cloud.size())));
}

}  // namespace

Result<std::optional<PairMap>> map_pair(const MappedPair& pair, const std::vector<CloudPoint>& cloud,
                                        const std::vector<PositionSigma>& by_orientation, double gsd_m,
                                        std::optional<double> cell_m, const fs::path& folder, const Run& run) {
  const Block block = block_of(pair);
  if (cloud.size() < 4 || !looks_down(block)) return std::optional<PairMap>();
  const double distance = distance_m(cloud);
  if (cell_m && *cell_m < kLeastPart * distance)
    return fail(Errc::kBadInput,
                fmt::format("cells of {:.3g} m would hardly hold a point: points of the surface are {:.3g} m apart",
                            *cell_m, distance),
                {"cell_m"_option});
  PairMap map;
  map.cell_m = cell_m.value_or(tidy_cell_m(std::max(gsd_m, distance)));
  const DsmFiles files{folder / "dsm.tif", folder / "dsm_sigma.tif", folder / "dsm_state.tif", folder / "dsm_count.tif",
                       folder / "dsm_sigma_relative.tif"};
  COLLINEA_TRY(const DsmSummary surface,
               build_dsm({.points = points_of(cloud), .gsd_m = gsd_m, .position_sigmas = by_orientation}, files,
                         folder / "scratch", {.cell_m = map.cell_m}, run));
  map.width = surface.grid.width;
  map.height = surface.grid.height;
  map.measured_cells = surface.measured_cells;
  map.interpolated_cells = surface.interpolated_cells;
  map.mean_sigma_m = surface.mean_sigma_m;
  map.mean_sigma_relative_m = surface.mean_sigma_relative_m;
  COLLINEA_TRY(write_hillshade(files.height, folder / "dsm_hillshade.tif", run));
  COLLINEA_TRY(const HeightField heights, open_height_field(files.height, files.sigma));
  const auto pixels = [&](ImageId image, int shrink) { return read_colour(block.images.at(image).file, shrink); };
  COLLINEA_TRY(const OrthoSummary ortho, make_orthophoto(block, nullptr, heights, {}, pixels, gsd_m,
                                                         OrthoFiles{folder / "ortho.tif", folder / "ortho_source.tif"},
                                                         {.cell_m = map.cell_m}, run));
  map.painted_cells = ortho.painted_cells;
  std::error_code ignored;
  fs::remove_all(folder / "scratch", ignored);
  return std::optional(map);
}

}  // namespace collinea
