// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/epipolar/p3p.h"
#include "collinea/geometry/circle_fit.h"
#include "collinea/geometry/plane.h"
#include "collinea/math/least_median.h"
#include "collinea/orient/space_resection.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostStarts = 4;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// Squared errors in units of the image; false, with not all of them, where more than `most` do not lie below a limit.
bool squared_errors(const Rigid3& pose, double focal, std::span<const Vector2d> xy, std::span<const Vector3d> points,
                    double limit, std::size_t most, std::vector<double>& out) {
  constexpr std::size_t kBlock = 64;
  const Matrix3d r = pose.rotation.toRotationMatrix();
  out.resize(xy.size());
  std::size_t above = 0;
  for (std::size_t begin = 0; begin < xy.size(); begin += kBlock) {
    for (std::size_t i = begin; i < std::min(begin + kBlock, xy.size()); ++i) {
      const Vector3d p = r * points[i] + pose.translation;
      out[i] = p.z() > 0 ? focal * focal * (p.head<2>() / p.z() - xy[i]).squaredNorm() : kNoLimit;
      above += !(out[i] < limit);
    }
    if (above > most) return false;
  }
  return true;
}

}  // namespace

std::vector<PoseStart> pose_starts(const Camera& camera, std::span<const Vector2d> pixels,
                                   std::span<const Vector3d> points_in_world, std::uint64_t seed, std::size_t most) {
  COLLINEA_CHECK(pixels.size() == points_in_world.size());
  if (pixels.size() < 3) return {};
  std::vector<Vector2d> xy;
  for (const Vector2d& pixel : pixels) xy.push_back(normalized(camera, pixel));
  const double focal = pixels_per_unit(camera, xy[0]);
  const std::size_t n = xy.size(), rank = median_rank(n, 3) - 1;
  struct Candidate {
    Rigid3 pose;
    double criterion;
  };
  // The best ones, of three points all: a pose that will not be among them is left as soon as its errors tell.
  std::vector<Candidate> best;
  std::vector<double> errors;
  for_triples(n, most, seed, [&](std::size_t i, std::size_t j, std::size_t l) {
    const std::array<std::size_t, 3> triple{i, j, l};
    std::array<Vector3d, 3> rays, points;
    for (std::size_t k = 0; k < 3; ++k) {
      rays[k] = Vector3d(xy[triple[k]].x(), xy[triple[k]].y(), 1).normalized();
      points[k] = points_in_world[triple[k]];
    }
    for (const Rigid3& pose : p3p(rays, points)) {
      const double limit = n > 4 && best.size() == kMostStarts ? best.back().criterion : kNoLimit;
      if (!squared_errors(pose, focal, xy, points_in_world, limit, n - rank - 1, errors)) continue;
      std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(rank), errors.end());
      double sum = 0;
      for (std::size_t k = 0; k <= rank; ++k) sum += errors[k];
      if (!std::isfinite(sum)) continue;
      const Candidate candidate{pose, n > 4 ? errors[rank] : sum};
      const auto is_better = [](const Candidate& a, const Candidate& b) { return a.criterion < b.criterion; };
      best.insert(n > 3 ? std::upper_bound(best.begin(), best.end(), candidate, is_better) : best.end(), candidate);
      if (n > 3 && best.size() > kMostStarts) best.pop_back();
    }
  });
  std::vector<PoseStart> starts;
  for (const Candidate& candidate : best) {
    const double scale = n > 3 ? robust_sigma(std::sqrt(candidate.criterion), n, 3, 2) : 0;
    starts.push_back({candidate.pose, scale});
  }
  return starts;
}

std::optional<DangerCylinder> danger_cylinder(std::span<const Vector3d> points_in_world,
                                              const Vector3d& centre_in_world) {
  const auto plane = fit_plane(points_in_world);
  if (!plane) return std::nullopt;
  const FramedPlane frame = framed_plane(plane->middle, plane->normal);
  std::vector<Vector2d> in_plane;
  for (const Vector3d& point : points_in_world) in_plane.push_back(frame.in_plane(point).head<2>());
  const auto circle = algebraic_circle(in_plane);
  if (!circle) return std::nullopt;
  double squares = 0;
  for (const Vector3d& point : points_in_world) {
    const Vector3d p = frame.in_plane(point);
    const double off = (p.head<2>() - circle->centre).norm() - circle->radius;
    squares += off * off + p.z() * p.z();
  }
  const Vector2d centre = frame.in_plane(centre_in_world).head<2>() - circle->centre;
  return DangerCylinder{
      circle->radius, std::sqrt(squares / double(points_in_world.size())), centre.norm() - circle->radius,
      frame.origin_in_world + frame.world_from_plane.leftCols<2>() * circle->centre, frame.world_from_plane.col(2)};
}

}  // namespace collinea
