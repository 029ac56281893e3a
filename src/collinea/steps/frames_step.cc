// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/edit/read_work.h"
#include "collinea/io/number_rows.h"
#include "collinea/io/text.h"
#include "collinea/math/median.h"
#include "collinea/project/product_frame.h"
#include "collinea/project/seamlines_file.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/block_cache.h"
#include "collinea/raster/hillshade.h"
#include "collinea/raster/image_file.h"
#include "collinea/report/elevation.h"
#include "collinea/steps/internal/frame_list.h"
#include "collinea/steps/internal/product_records.h"
#include "collinea/steps/left_points.h"
#include "collinea/steps/step.h"
#include "collinea/surface/object_frames.h"
#include "collinea/surface/surface_contours.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// Some of the points of the cloud, in the world.
struct Sample {
  std::vector<Vector3d> points;
  std::vector<double> sigmas_m;
};

// Which points are taken depends on where they lie alone, and they come in the order of their positions: the form of
// the cloud's file, which sorts them, does not matter.
Result<Sample> sample_of(const Project& project, const LocalFrame* frame) {
  constexpr double kMost = 400'000;
  COLLINEA_TRY(LeftPoints cloud, LeftPoints::open(project));
  const double part = std::min(1.0, kMost / double(std::max<std::uint64_t>(1, cloud.points_in_file())));
  const auto highest = std::uint64_t(part * double(std::numeric_limits<std::uint32_t>::max()));
  std::vector<std::pair<std::array<double, 3>, float>> taken;
  for (;;) {
    COLLINEA_TRY(const std::vector<CloudPoint> piece, cloud.next());
    if (piece.empty()) break;
    if (project.run.stopped()) return fail(Errc::kCancelled, "stopped");
    for (const CloudPoint& point : piece) {
      const Vector3d& p = point.position;
      if ((Hash().add(p.x()).add(p.y()).add(p.z()).value() >> 32) <= highest)
        taken.push_back({{p.x(), p.y(), p.z()}, point.sigma_m});
    }
  }
  std::ranges::sort(taken);
  Sample sample;
  for (const auto& [position, sigma_m] : taken) {
    sample.points.emplace_back(position[0], position[1], position[2]);
    sample.sigmas_m.push_back(double(sigma_m));
  }
  if (frame) frame->local_from_map(sample.points);
  return sample;
}

bool wants_planes(const FramesOptions& options, const Block& block) {
  const auto word = options.frames.word();
  if (!word) return true;
  return *word == FrameChoice::kPlanes || (*word == FrameChoice::kAuto && !looks_down(block));
}

// Planes of a file: three positions or more of each, on the map.
Result<std::vector<ObjectFrame>> frames_of_file(const fs::path& path, const Block& block, const LocalFrame* frame,
                                                double tolerance_m, const Vector3d& up) {
  COLLINEA_TRY(const std::string text, read_file(path));
  COLLINEA_TRY(const auto rows, parse_number_rows(text, true, 3, 3).map_error([&](Error e) {
    return std::move(e).within(path.string()).about("frames"_option);
  }));
  std::vector<std::pair<std::string, std::vector<Vector3d>>> planes;
  for (const NumberRow& row : rows) {
    auto at = std::ranges::find(planes, row.name, [](const auto& plane) { return plane.first; });
    if (at == planes.end()) at = planes.insert(at, {row.name, {}});
    const Vector3d on_map(row.numbers[0], row.numbers[1], row.numbers[2]);
    at->second.push_back(frame ? frame->local_from_map(on_map) : on_map);
  }
  std::vector<ObjectFrame> frames;
  for (const auto& [name, points] : planes) {
    const std::string which = path.string() + ": plane " + name + ": ";
    if (!is_frame_name(name))
      return fail(Errc::kBadInput, which + "a name is of letters, digits, - and _", {"frames"_option});
    const auto fit = fit_plane(points);
    if (!fit) return fail(Errc::kBadInput, which + "it needs three points that are not on a line", {"frames"_option});
    ObjectFrame one = frame_of_plane(block, points, fit->middle, fit->normal, up);
    if (one.images.empty())
      return fail(Errc::kBadInput, which + "no two images see it from the front", {"frames"_option});
    one.name = name;
    one.area_m2 = one.extent_m.prod();
    one.depth_m = default_depth_m(one, tolerance_m);
    frames.push_back(std::move(one));
  }
  return frames;
}

// The same, upright as the walls among them stand.
Result<std::vector<ObjectFrame>> frames_of_file(const fs::path& path, const Block& block, const LocalFrame* frame,
                                                double tolerance_m) {
  return frames_of_file(path, block, frame, tolerance_m, up_in_world(block))
      .and_then([&](const std::vector<ObjectFrame>& frames) {
        return frames_of_file(path, block, frame, tolerance_m, up_by_walls(block, frames));
      });
}

Result<std::vector<ObjectFrame>> frames_of(const Project& project, const Block& block, const LocalFrame* frame) {
  const FramesOptions& options = project.settings.frames;
  COLLINEA_TRY(const Sample sample, sample_of(project, frame));
  const double tolerance_m = options.tolerance_m.value_or(frame_tolerance_m(sample.points, sample.sigmas_m));
  std::vector<ObjectFrame> frames;
  if (const fs::path* file = options.frames.get<fs::path>()) {
    COLLINEA_TRY(frames, frames_of_file(*file, block, frame, tolerance_m));
  } else {
    COLLINEA_TRY(frames, find_object_frames(block, sample.points, {.tolerance_m = tolerance_m}, project.run));
  }
  if (options.depth_m)
    for (ObjectFrame& one : frames) one.depth_m = *options.depth_m;
  return frames;
}

// The size of a pixel on a plane: the median of the images that see it.
double pixel_on(const Block& block, const ObjectFrame& frame) {
  std::vector<double> sizes;
  for (const ImageId image : frame.images) {
    const double distance = frame.plane.in_plane(centre_of(pose_of(block, image))).z();
    sizes.push_back(distance / pixels_per_unit(block.camera_of(image), {0, 0}));
  }
  return median(sizes);
}

// What images and cameras make of distances from a plane: at the tie points that lie on it, or where none was kept
// there at the nearest ones before and behind it.
std::vector<PositionSigma> sigmas_along_normal(const AdjustmentRecord& adjusted, const ObjectFrame& frame) {
  constexpr std::size_t kNearest = 8;
  const Vector3d normal = frame.plane.world_from_plane.col(2);
  std::vector<PositionSigma> on_it;
  std::vector<std::pair<double, PositionSigma>> others;
  for (const PositionPrecision& at : adjusted.position_precision) {
    const Vector3d in_frame = frame.plane.in_plane(at.position_in_world);
    const PositionSigma sigma{in_frame.x(), in_frame.y(), at.sigma_m(normal, adjusted.sigma_scale())};
    if (frame.holds(in_frame))
      on_it.push_back(sigma);
    else
      others.emplace_back((in_frame - Vector3d(frame.extent_m.x() / 2, frame.extent_m.y() / 2, 0)).norm(), sigma);
  }
  if (!on_it.empty()) return on_it;
  std::ranges::sort(others, {}, [](const auto& one) { return one.first; });
  for (std::size_t i = 0; i < std::min(kNearest, others.size()); ++i) on_it.push_back(others[i].second);
  return on_it;
}

PointSource points_of(LeftPoints& cloud, const LocalFrame* map, const ObjectFrame& frame) {
  return [&cloud, map, &frame](std::vector<SurfacePoint>& batch) -> Result<> {
    batch.clear();
    std::vector<Vector3d> positions;
    while (batch.empty()) {
      COLLINEA_TRY(const std::vector<CloudPoint> points, cloud.next());
      if (points.empty()) break;
      positions.clear();
      for (const CloudPoint& point : points) positions.push_back(point.position);
      if (map) map->local_from_map(positions);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vector3d in_frame = frame.plane.in_plane(positions[i]);
        if (frame.holds(in_frame)) batch.push_back({in_frame, points[i].sigma_m, points[i].images});
      }
    }
    return {};
  };
}

// The frame as it lies on the map, or in the world where there is none.
FrameRecord location_of(const ObjectFrame& frame, const LocalFrame* map) {
  const Vector3d& origin = frame.plane.origin_in_world;
  const Eigen::Matrix3d axes =
      map ? Eigen::Matrix3d(map_from_local_rotation(*map, origin).toRotationMatrix() * frame.plane.world_from_plane)
          : frame.plane.world_from_plane;
  return {.name = frame.name,
          .origin = map ? map->map_from_local(origin) : origin,
          .right = axes.col(0),
          .up = axes.col(1),
          .normal = axes.col(2),
          .width_m = frame.extent_m.x(),
          .height_m = frame.extent_m.y(),
          .depth_m = frame.depth_m,
          .area_m2 = frame.area_m2,
          .rms_m = frame.rms_m,
          .points = frame.points,
          .images = frame.images};
}

class FrameProducts {
 public:
  static Result<FrameProducts> of(const Project& project, const Block& block) {
    COLLINEA_TRY(const ProductFrame product_frame, product_frame_of(project, block));
    COLLINEA_TRY(const auto adjusted, project.store.read_outcome<AdjustmentRecord>());
    COLLINEA_TRY(const ImageMasks masks, read_masks(project));
    return FrameProducts(project, block, product_frame, adjusted, masks);
  }
  [[nodiscard]] const LocalFrame* map() const { return product_frame_.frame_or_null(); }
  [[nodiscard]] bool is_metric() const { return product_frame_.metric; }

  Result<FrameRecord> make(const ObjectFrame& frame, const Run& run) const {
    FrameRecord record = location_of(frame, map());
    const fs::path folder = frames_folder(project_.folder) / frame.name;
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
    const double pixel_m = pixel_on(block_, frame);
    COLLINEA_TRY(record.surface, make_surface(frame, folder, pixel_m, run));
    give_back_freed_memory();
    COLLINEA_TRY(record.ortho, make_ortho(frame, folder, pixel_m, run));
    give_back_freed_memory();
    COLLINEA_TRY(const DrawnContours contours,
                 draw_surface_contours(folder / "dsm.tif", record.surface.mean_sigma_relative_m,
                                       folder / "contours.gpkg", folder / "contours.dxf", run));
    record.contour_m = contours.interval_m;
    record.contours = contours.lines;
    COLLINEA_TRY(record.scale, write_elevation(record, folder / "ortho.tif", title_of(project_), product_frame_.metric,
                                               project_.settings.frames.scale, folder / "elevation.pdf"));
    return record;
  }

 private:
  FrameProducts(const Project& project, const Block& block, ProductFrame product_frame, AdjustmentRecord adjusted,
                ImageMasks masks)
      : project_(project),
        block_(block),
        product_frame_(std::move(product_frame)),
        adjusted_(std::move(adjusted)),
        masks_(std::move(masks)) {}

  Result<SurfaceRecord> make_surface(const ObjectFrame& frame, const fs::path& folder, double pixel_m,
                                     const Run& run) const {
    COLLINEA_TRY(LeftPoints cloud, LeftPoints::open(project_));
    const BlockCacheLimit cache(kCacheOfPieces);
    const DsmFiles files{folder / "dsm.tif", folder / "dsm_sigma.tif", folder / "dsm_state.tif",
                         folder / "dsm_count.tif", folder / "dsm_sigma_relative.tif"};
    const SurfaceCloud on_frame{.points = points_of(cloud, map(), frame),
                                .gsd_m = pixel_m * product_frame_.matched_pixel_m / product_frame_.pixel_m,
                                .position_sigmas = sigmas_along_normal(adjusted_, frame),
                                .wkt = frame_wkt(frame, product_frame_.metric)};
    const DsmOptions options{.cell_m = project_.settings.frames.cell_m};
    COLLINEA_TRY(const DsmSummary summary, build_dsm(on_frame, files, project_.folder / "scratch", options, run));
    COLLINEA_TRY(write_hillshade(files.height, folder / "dsm_hillshade.tif", run));
    return surface_record(summary);
  }

  Result<OrthoRecord> make_ortho(const ObjectFrame& frame, const fs::path& folder, double pixel_m,
                                 const Run& run) const {
    COLLINEA_TRY(const HeightField surface, open_height_field(folder / "dsm.tif", folder / "dsm_sigma.tif"));
    const Block in_frame = block_in_frame(block_, frame);
    SeamGuides guides;
    guides.masks = &masks_;
    OrthoOptions options = project_.settings.ortho;
    options.cell_m = project_.settings.frames.cell_m;
    options.seamlines.reset();  // of the map
    COLLINEA_TRY(const OrthoSummary summary,
                 make_orthophoto(
                     in_frame, nullptr, surface, guides,
                     [&](ImageId image, int shrink) {
                       return read_colour(project_.image_file(block_.images.at(image)), shrink);
                     },
                     pixel_m, OrthoFiles{folder / "ortho.tif", folder / "ortho_source.tif"}, options, run));
    COLLINEA_TRY(
        write_seamlines(folder / "seamlines.gpkg", summary.seamlines, in_frame, summary.sources, summary.grid.wkt));
    return ortho_record(summary);
  }

  const Project& project_;
  const Block& block_;
  ProductFrame product_frame_;
  AdjustmentRecord adjusted_;
  ImageMasks masks_;
};

}  // namespace

Result<StepOutput> frames_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  FramesRecord record{.looked_for = wants_planes(project.settings.frames, block)};
  if (!record.looked_for) {
    COLLINEA_TRY(remove_frames(project.folder));
    return StepOutput{inputs_hash, record};
  }
  COLLINEA_TRY(const FrameProducts products, FrameProducts::of(project, block));
  COLLINEA_TRY(const std::vector<ObjectFrame> frames, frames_of(project, block, products.map()));
  COLLINEA_TRY(remove_frames(project.folder));  // of another search
  record.metric = products.is_metric();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    project.run.say(fmt::format("frames: {} of {}: {}, {:.1f} x {:.1f} {}, {} images", i + 1, frames.size(),
                                frames[i].name, frames[i].extent_m.x(), frames[i].extent_m.y(),
                                record.metric ? "m" : "units", frames[i].images.size()));
    auto made = products.make(frames[i], project.run);
    if (!made && made.error().code == Errc::kIllPosed) {
      project.run.say("note: " + frames[i].name + " is left out: " + made.error().message);
      continue;
    }
    if (!made) return tl::unexpected(std::move(made).error());
    record.frames.push_back(*std::move(made));
  }
  COLLINEA_TRY(write_frame_list(project.folder, record));
  return StepOutput{inputs_hash, record};
}

}  // namespace collinea
