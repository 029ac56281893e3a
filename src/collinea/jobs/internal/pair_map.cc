// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "collinea/cloud/ply_reader.h"
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

Result<PointSource> points_of(const MappedCloud& cloud) {
  COLLINEA_TRY(PlyReader opened, PlyReader::open(cloud.file));
  const auto reader = std::make_shared<PlyReader>(std::move(opened));
  return PointSource([reader, at = std::uint64_t{0}, sigmas = cloud.matching_sigmas,
                      map_from_file = cloud.map_from_file](std::vector<SurfacePoint>& batch) mutable -> Result<> {
    batch.clear();
    COLLINEA_TRY(const std::vector<CloudPoint> points, reader->read(kBatch));
    if (points.empty()) return {};  // the end
    std::vector<float> of_matching(points.size());
    COLLINEA_TRY(const std::string bytes, sigmas->read(at, points.size() * sizeof(float)));
    std::memcpy(of_matching.data(), bytes.data(), bytes.size());
    at += bytes.size();
    for (std::size_t i = 0; i < points.size(); ++i)
      batch.push_back({map_from_file * points[i].position, of_matching[i], points[i].images});
    return {};
  });
}

// A folder that is gone in the end, with all that is in it.
struct Scratch {
  fs::path path;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

}  // namespace

Result<std::optional<PairMap>> map_pair(const MappedPair& pair, const MappedCloud& cloud, std::optional<double> cell_m,
                                        const fs::path& folder, const Run& run) {
  const Block block = block_of(pair);
  if (cloud.points < 4 || !looks_down(block)) return std::optional<PairMap>();
  const double distance = cloud.distance_m, gsd_m = cloud.pixel_m;
  if (cell_m && *cell_m < kLeastPart * distance)
    return fail(Errc::kBadInput,
                fmt::format("cells of {:.3g} m would hardly hold a point: points of the surface are {:.3g} m apart",
                            *cell_m, distance),
                {"cell_m"_option});
  PairMap map;
  map.cell_m = cell_m.value_or(tidy_cell_m(std::max(gsd_m, distance)));
  const DsmFiles files{folder / "dsm.tif", folder / "dsm_sigma.tif", folder / "dsm_state.tif", folder / "dsm_count.tif",
                       folder / "dsm_sigma_relative.tif"};
  const Scratch scratch{folder / "scratch"};
  COLLINEA_TRY(PointSource points, points_of(cloud));
  COLLINEA_TRY(const DsmSummary surface,
               build_dsm({.points = std::move(points), .gsd_m = gsd_m, .position_sigmas = cloud.by_orientation}, files,
                         scratch.path, {.cell_m = map.cell_m}, run));
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
  return std::optional(map);
}

}  // namespace collinea
