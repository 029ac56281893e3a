// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/project_plane.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "collinea/base/file.h"
#include "collinea/io/number_rows.h"
#include "collinea/io/text.h"
#include "collinea/math/median.h"
#include "collinea/steps/cloud_pieces.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct FoundPlane {
  PlaneFit fit;
  std::vector<Vector3d> points;  // of the plane, in the world
  std::size_t of = 0;            // points looked at
};

Result<FoundPlane> plane_through(std::vector<Vector3d> points) {
  if (points.size() < 3) return fail(Errc::kIllPosed, "a plane needs three points");
  const auto fit = fit_plane(points);
  if (!fit) return fail(Errc::kIllPosed, "the points lie on a line: they give no plane");
  const std::size_t count = points.size();
  return FoundPlane{*fit, std::move(points), count};
}

Result<FoundPlane> plane_of_control(const Block& block, const std::string& asked) {
  std::vector<Vector3d> points;
  for (const std::string_view name : fields_of(asked, ',')) {
    const auto found = std::find_if(block.control.begin(), block.control.end(),
                                    [&](const auto& entry) { return entry.second.name == name; });
    if (found == block.control.end())
      return fail(Errc::kNotFound, fmt::format("the project has no control point \"{}\"", name), {"control"_option});
    if (!found->second.sigma_m.allFinite())
      return fail(Errc::kBadInput, fmt::format("control point {} was not surveyed in all three axes", name),
                  {"control"_option});
    points.push_back(found->second.position_in_world);
  }
  return plane_through(std::move(points));
}

Result<FoundPlane> plane_of_positions(const ProductFrame& product_frame, const fs::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  COLLINEA_TRY(const auto rows, parse_number_rows(text, false, 3, 3).map_error([&](Error e) {
    return std::move(e).within(path.string());
  }));
  std::vector<Vector3d> points;
  for (const NumberRow& row : rows) {
    const Vector3d on_map(row.numbers[0], row.numbers[1], row.numbers[2]);
    points.push_back(product_frame.frame ? product_frame.frame->local_from_map(on_map) : on_map);
  }
  return plane_through(std::move(points));
}

// The points of the cloud in a box of the map, every second left out whenever there are too many.
Result<std::vector<CloudPoint>> points_in(const fs::path& cloud, const Vector3d& lowest, const Vector3d& highest,
                                          const Run& run) {
  constexpr std::size_t kMost = 400'000;
  std::vector<CloudPoint> found;
  std::uint64_t inside = 0, stride = 1;
  auto read = for_each_piece(cloud, run, [&](std::vector<CloudPoint>& piece) -> Result<> {
    for (const CloudPoint& point : piece) {
      if ((point.position.array() < lowest.array()).any() || (point.position.array() > highest.array()).any()) continue;
      if (inside++ % stride == 0) found.push_back(point);
      if (found.size() <= kMost) continue;
      for (std::size_t i = 0; 2 * i < found.size(); ++i) found[i] = found[2 * i];
      found.resize((found.size() + 1) / 2);
      stride *= 2;
    }
    return {};
  });
  if (!read) return tl::unexpected(std::move(read).error());
  return found;
}

Result<FoundPlane> plane_of_region(const Project& project, const ProductFrame& product_frame, const AskedPlane& asked) {
  COLLINEA_TRY(const auto n,
               parse_numbers(*asked.region).map_error([](Error e) { return std::move(e).about("region"_option); }));
  if ((n.size() != 4 && n.size() != 6) || !(n[2] > n[0] && n[3] > n[1]) || (n.size() == 6 && !(n[5] > n[4])))
    return fail(Errc::kBadInput, "a region is west,south,east,north or west,south,east,north,lowest,highest",
                {"region"_option});
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const Vector3d lowest(n[0], n[1], n.size() == 6 ? n[4] : -kAny), highest(n[2], n[3], n.size() == 6 ? n[5] : kAny);
  if (!is_there(project.cloud()))
    return fail(Errc::kNotFound, "there is no cloud yet: collinea densify " + project.folder.string());
  COLLINEA_TRY(const auto cloud, points_in(project.cloud(), lowest, highest, project.run));
  if (cloud.size() < 100)
    return fail(Errc::kIllPosed, fmt::format("{} points of the cloud lie in the region: too few", cloud.size()));
  std::vector<Vector3d> points;
  std::vector<double> sigmas;
  for (const CloudPoint& point : cloud) {
    points.push_back(point.position);
    sigmas.push_back(double(point.sigma_m));
  }
  if (product_frame.frame) product_frame.frame->local_from_map(points);
  const double tolerance_m = asked.tolerance_m.value_or(3 * median(sigmas));
  if (!(tolerance_m > 0))
    return fail(Errc::kBadInput, "the cloud states no standard deviations: give a tolerance", {"tolerance_m"_option});
  const auto fit = find_plane(points, tolerance_m, project.run.seed);
  if (!fit)
    return fail(Errc::kIllPosed,
                fmt::format("no plane holds a tenth of the region's points within {}", metres_text(tolerance_m)));
  std::vector<Vector3d> on_it;
  for (const std::size_t i : fit->points) on_it.push_back(points[i]);
  return FoundPlane{*fit, std::move(on_it), points.size()};
}

Result<FoundPlane> plane_of(const Project& project, const Block& block, const ProductFrame& product_frame,
                            const AskedPlane& asked) {
  if (int(asked.control.has_value()) + int(asked.map_points.has_value()) + int(asked.region.has_value()) != 1)
    return fail(Errc::kBadInput, "which plane? Give control points, map points or a region, one of them",
                {"control"_option, "map_points"_option, "region"_option});
  if (asked.tolerance_m && !asked.region)
    return fail(Errc::kBadInput, "a tolerance belongs to a region", {"tolerance_m"_option});
  if (asked.control) return plane_of_control(block, *asked.control);
  if (asked.map_points) return plane_of_positions(product_frame, *asked.map_points);
  return plane_of_region(project, product_frame, asked);
}

// On which side of the plane the cameras stand that see its points: how often the points are seen from the side of the
// normal, less how often from behind.
long seen_from_front(const Block& block, const FoundPlane& found) {
  constexpr std::size_t kLookedAt = 100;
  const std::size_t step = 1 + found.points.size() / kLookedAt;
  long count = 0;
  for (const auto& [image, pose] : oriented_images(block)) {
    const long side = found.fit.normal.dot(centre_of(pose) - found.fit.middle) > 0 ? 1 : -1;
    for (std::size_t i = 0; i < found.points.size(); i += step) {
      const auto pixel = project(block.camera_of(image), pose * found.points[i]);
      if (pixel && inside(block.camera_of(image), *pixel)) count += side;
    }
  }
  return count;
}

// Without a location on Earth nothing says where up is; those who take images mostly hold the camera level.
Vector3d up_of(const Block& block) {
  if (block.georeference) return Vector3d::UnitZ();
  Vector3d up = Vector3d::Zero();
  for (const auto& [image, pose] : oriented_images(block)) up -= pose.rotation.conjugate() * Vector3d::UnitY();
  return up.norm() > 0 ? up.normalized() : Vector3d::UnitZ();
}

// Lower left and upper right corner of most of the points: one of a hundred on each side may be wrong.
std::pair<Vector2d, Vector2d> most_of(const FoundPlane& found, const FramedPlane& plane) {
  std::vector<double> x, y;
  for (const Vector3d& p : found.points) {
    const Vector3d in_plane = plane.in_plane(p);
    x.push_back(in_plane.x());
    y.push_back(in_plane.y());
  }
  std::sort(x.begin(), x.end());
  std::sort(y.begin(), y.end());
  const std::size_t off = x.size() / 100, last = x.size() - 1 - off;
  return {{x[off], y[off]}, {x[last], y[last]}};
}

}  // namespace

Result<ProjectPlane> plane_of_project(const Project& project, const Block& block, const ProductFrame& product_frame,
                                      const AskedPlane& asked) {
  COLLINEA_TRY(FoundPlane found, plane_of(project, block, product_frame, asked));
  if (seen_from_front(block, found) < 0) found.fit.normal = -found.fit.normal;
  ProjectPlane plane{framed_plane(found.fit.middle, found.fit.normal, up_of(block)),
                     found.points.size(),
                     found.of,
                     found.fit.rms_m,
                     {}};
  // Coordinates of what the points enclose are positive.
  const auto [low, high] = most_of(found, plane.frame);
  plane.frame.origin_in_world += plane.frame.world_from_plane.leftCols<2>() * low;
  plane.extent = high - low;
  return plane;
}

}  // namespace collinea
