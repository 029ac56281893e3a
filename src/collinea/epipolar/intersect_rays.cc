// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/intersect_rays.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/base/result.h"

namespace collinea {
namespace {

struct Ray {
  Eigen::Vector3d centre_in_world, direction_in_world;  // unit direction
};

Ray ray(const Rigid3& cam_from_world, const Eigen::Vector2d& xy) {
  return {centre_of(cam_from_world), (cam_from_world.rotation.conjugate() * xy.homogeneous()).normalized()};
}

double angle_between_directions(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Where the rays come closest: sum of (I - d d') (X - C) = 0.
std::optional<Eigen::Vector3d> nearest_to_rays(std::span<const Ray> rays) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Ray& r : rays) {
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - r.direction_in_world * r.direction_in_world.transpose();
    a += across;
    b += across * r.centre_in_world;
  }
  const double determinant = a.determinant();
  if (!(determinant > 0)) return std::nullopt;
  const Eigen::Vector3d x = a.inverse() * b;
  if (!x.allFinite()) return std::nullopt;
  return x;
}

struct PointNormal {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double cost = 0;  // infinite when behind a camera
};

PointNormal normal_equations(std::span<const Rigid3> cams, std::span<const Eigen::Vector2d> xy,
                             const Eigen::Vector3d& x) {
  PointNormal sum;
  for (std::size_t i = 0; i < cams.size(); ++i) {
    const Eigen::Matrix3d r = cams[i].rotation.toRotationMatrix();
    const Eigen::Vector3d p = r * x + cams[i].translation;
    if (!(p.z() > 0)) {
      sum.cost = std::numeric_limits<double>::infinity();
      return sum;
    }
    const double w = 1 / p.z(), u = p.x() * w, v = p.y() * w;
    const Eigen::Vector2d e(u - xy[i].x(), v - xy[i].y());
    Eigen::Matrix<double, 2, 3> j;
    j.row(0) = (r.row(0) - u * r.row(2)) * w;
    j.row(1) = (r.row(1) - v * r.row(2)) * w;
    sum.hessian.noalias() += j.transpose() * j;
    sum.gradient.noalias() += j.transpose() * e;
    sum.cost += e.squaredNorm();
  }
  return sum;
}

// Damped Gauss-Newton; the cost is infinite behind a camera, so a start in front of all stays there.
Eigen::Vector3d refined(std::span<const Rigid3> cams, std::span<const Eigen::Vector2d> xy, Eigen::Vector3d x) {
  PointNormal normal = normal_equations(cams, xy, x);
  double damping = 1e-6;
  for (int iteration = 0; iteration < 15 && damping < 1e6; ++iteration) {
    Eigen::Matrix3d system = normal.hessian;
    system.diagonal() *= 1 + damping;
    const Eigen::Vector3d step = system.ldlt().solve(-normal.gradient);
    if (!step.allFinite()) break;
    const PointNormal next = normal_equations(cams, xy, x + step);
    const double predicted = -step.dot(normal.gradient);  // about the gain of a full step
    if (next.cost <= normal.cost) {
      x += step;
      const bool settled = predicted <= 1e-10 * normal.cost + 1e-26;
      normal = next;
      damping = std::max(1e-9, damping / 10);
      if (settled) break;
    } else {
      if (predicted <= 1e-10 * normal.cost + 1e-26) break;
      damping = std::max(1e-3, damping * 10);
    }
  }
  return x;
}

bool in_front_of_all(std::span<const Rigid3> cams, const Eigen::Vector3d& x) {
  return std::all_of(cams.begin(), cams.end(), [&](const Rigid3& cam) { return (cam * x).z() > 0; });
}

// The two rays of a proposal, spread evenly over all pairs.
struct PairOfRays {
  std::size_t first, second;
};

std::vector<PairOfRays> pairs_to_try(std::size_t rays) {
  constexpr std::size_t kMostPairs = 100;
  const std::size_t all = rays * (rays - 1) / 2, count = std::min(all, kMostPairs);
  std::vector<PairOfRays> some;
  some.reserve(count);
  // Far apart in the track first, usually the wider base: rays - step pairs are `step` apart, the first of them is the
  // pair number `begin`.
  std::size_t step = rays - 1, begin = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t number = k * all / count;
    while (number >= begin + (rays - step)) {
      begin += rays - step;
      --step;
    }
    some.push_back({number - begin, number - begin + step});
  }
  return some;
}

struct Track {
  std::span<const Rigid3> cam_from_world;
  std::span<const Eigen::Vector2d> xy;
  std::span<const double> focal_px;
  double max_error_px;

  // Sum of the squared errors, each cut off at the threshold, and who is below it.
  double cost(const Eigen::Vector3d& point, std::vector<std::uint8_t>* inlier) const {
    const double limit = max_error_px * max_error_px;
    double sum = 0;
    for (std::size_t i = 0; i < xy.size(); ++i) {
      const double error = reprojection_error_px(cam_from_world[i], xy[i], focal_px[i], point);
      const bool inside = error < max_error_px;
      sum += inside ? error * error : limit;
      if (inlier) (*inlier)[i] = inside;
    }
    return sum;
  }
};

std::optional<Eigen::Vector3d> best_proposal(const Track& track, double min_angle_rad) {
  std::optional<Eigen::Vector3d> best;
  double least = std::numeric_limits<double>::infinity();
  for (const PairOfRays& pair : pairs_to_try(track.xy.size())) {
    const auto point = intersect_midpoint(track.cam_from_world[pair.first], track.cam_from_world[pair.second],
                                            track.xy[pair.first], track.xy[pair.second], min_angle_rad);
    if (!point) continue;
    const double cost = track.cost(*point, nullptr);
    if (cost < least) {
      least = cost;
      best = point;
    }
  }
  return best;
}

struct Chosen {
  std::vector<Rigid3> cam_from_world;
  std::vector<Eigen::Vector2d> xy;
};

Chosen chosen(const Track& track, const std::vector<std::uint8_t>& inlier) {
  Chosen some;
  for (std::size_t i = 0; i < inlier.size(); ++i)
    if (inlier[i]) {
      some.cam_from_world.push_back(track.cam_from_world[i]);
      some.xy.push_back(track.xy[i]);
    }
  return some;
}

}  // namespace

std::optional<Eigen::Vector3d> intersect_rays(std::span<const Rigid3> cam_from_world,
                                           std::span<const Eigen::Vector2d> normalized_xy, double min_angle_rad) {
  COLLINEA_CHECK(cam_from_world.size() == normalized_xy.size());
  if (cam_from_world.size() < 2) return std::nullopt;
  std::vector<Ray> rays;
  rays.reserve(cam_from_world.size());
  for (std::size_t i = 0; i < cam_from_world.size(); ++i) rays.push_back(ray(cam_from_world[i], normalized_xy[i]));
  const auto start = nearest_to_rays(rays);
  if (!start || !in_front_of_all(cam_from_world, *start)) return std::nullopt;
  const Eigen::Vector3d point = refined(cam_from_world, normalized_xy, *start);
  if (!in_front_of_all(cam_from_world, point)) return std::nullopt;
  if (!(max_ray_angle_rad(cam_from_world, point) >= min_angle_rad)) return std::nullopt;
  return point;
}

std::optional<Eigen::Vector3d> intersect_midpoint(const Rigid3& first_from_world, const Rigid3& second_from_world,
                                                    const Eigen::Vector2d& first_xy, const Eigen::Vector2d& second_xy,
                                                    double min_angle_rad) {
  const Ray a = ray(first_from_world, first_xy), b = ray(second_from_world, second_xy);
  const Eigen::Vector3d normal = a.direction_in_world.cross(b.direction_in_world);
  const double squared = normal.squaredNorm();  // sine of the angle, squared
  const double sine = std::sin(std::min(min_angle_rad, 1.5));
  if (!(squared >= sine * sine) || squared == 0) return std::nullopt;
  const Eigen::Vector3d base = b.centre_in_world - a.centre_in_world;
  const double along_a = base.cross(b.direction_in_world).dot(normal) / squared;
  const double along_b = base.cross(a.direction_in_world).dot(normal) / squared;
  if (!(along_a > 0 && along_b > 0)) return std::nullopt;
  return (a.centre_in_world + along_a * a.direction_in_world + b.centre_in_world + along_b * b.direction_in_world) / 2;
}

double max_ray_angle_rad(std::span<const Rigid3> cam_from_world, const Eigen::Vector3d& point_in_world) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(cam_from_world.size());
  for (const Rigid3& cam : cam_from_world) directions.push_back((centre_of(cam) - point_in_world).normalized());
  double least_cosine = 1;
  std::size_t a = 0, b = 0;
  for (std::size_t i = 0; i < directions.size(); ++i)
    for (std::size_t j = i + 1; j < directions.size(); ++j) {
      const double cosine = directions[i].dot(directions[j]);
      if (cosine < least_cosine) {
        least_cosine = cosine;
        a = i;
        b = j;
      }
    }
  return a == b ? 0 : angle_between_directions(directions[a], directions[b]);
}

double reprojection_error_px(const Rigid3& cam_from_world, const Eigen::Vector2d& normalized_xy, double focal_px,
                             const Eigen::Vector3d& point_in_world) {
  const Eigen::Vector3d p = cam_from_world * point_in_world;
  if (!(p.z() > 0)) return std::numeric_limits<double>::infinity();
  return focal_px * (p.head<2>() / p.z() - normalized_xy).norm();
}

std::optional<RobustPoint> robust_intersect(std::span<const Rigid3> cam_from_world,
                                              std::span<const Eigen::Vector2d> normalized_xy,
                                              std::span<const double> focal_px, double max_error_px,
                                              double min_angle_rad, int min_inliers) {
  COLLINEA_CHECK(cam_from_world.size() == normalized_xy.size() && focal_px.size() == normalized_xy.size());
  if (normalized_xy.size() < 2) return std::nullopt;
  const Track track{cam_from_world, normalized_xy, focal_px, max_error_px};
  const auto proposal = best_proposal(track, min_angle_rad);
  if (!proposal) return std::nullopt;

  RobustPoint best;
  best.inlier.resize(normalized_xy.size());
  best.point_in_world = *proposal;
  double least = track.cost(*proposal, &best.inlier);
  for (int round = 0; round < 4; ++round) {
    const Chosen some = chosen(track, best.inlier);
    const auto point = intersect_rays(some.cam_from_world, some.xy, min_angle_rad);
    if (!point) break;
    std::vector<std::uint8_t> inlier(normalized_xy.size());
    const double cost = track.cost(*point, &inlier);
    if (!(cost < least)) break;
    const bool same = inlier == best.inlier;
    least = cost;
    best.point_in_world = *point;
    best.inlier = inlier;
    if (same) break;
  }

  const Chosen some = chosen(track, best.inlier);
  best.inliers = static_cast<int>(some.xy.size());
  if (best.inliers < std::max(2, min_inliers)) return std::nullopt;
  best.max_angle_rad = max_ray_angle_rad(some.cam_from_world, best.point_in_world);
  if (!(best.max_angle_rad >= min_angle_rad)) return std::nullopt;
  const double outliers = static_cast<double>(normalized_xy.size()) - best.inliers;
  best.rms_px = std::sqrt(std::max(0.0, least - outliers * max_error_px * max_error_px) / best.inliers);
  return best;
}

}  // namespace collinea
