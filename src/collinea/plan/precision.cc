// SPDX-License-Identifier: Apache-2.0
#include "collinea/plan/precision.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

void write_cells(Precision& precision) {
  for (const ControlDifference& difference : precision.adjusted.control) {
    const auto cell = precision.planned.cells.find(difference.point);
    if (cell == precision.planned.cells.end() || !difference.covariance_m2) continue;
    precision.cells.push_back(
        {cell->second, precision.planned.grid.centre(cell->second), *difference.covariance_m2, difference.rays});
  }
}

AreaSigma area_sigma(const Precision& precision) {
  AreaSigma area;
  area.cells = precision.planned.cells.size();
  area.empty = area.cells - precision.cells.size();
  Vector3d sum = Vector3d::Zero();
  for (const CellPrecision& cell : precision.cells) {
    sum += cell.covariance_m2.diagonal();
    if (cell.plan_m() > area.worst_plan_m) {
      area.worst_plan_m = cell.plan_m();
      area.worst_plan_at = cell.position;
    }
    if (cell.sigma_m().z() > area.worst_height_m) {
      area.worst_height_m = cell.sigma_m().z();
      area.worst_height_at = cell.position;
    }
  }
  area.rms_m = precision.cells.empty() ? Vector3d::Constant(std::nan(""))
                                       : Vector3d((sum / double(precision.cells.size())).cwiseSqrt());
  return area;
}

// Only of points of the area, which the products are made of.
void write_rays(Precision& precision) {
  std::map<PointId, int> rays;
  for (const Observation& seen : precision.planned.block.observations) ++rays[seen.point];
  precision.rays = {{2, 2}, {3, 3}, {4, 5}, {6, 8}, {9, 0}};
  const Examined& adjusted = precision.adjusted;
  std::vector<Vector3d> sums(precision.rays.size(), Vector3d::Zero());
  const PrecisionGrid& grid = precision.planned.grid;
  for (std::size_t i = 0; i < adjusted.point_covariance.size(); ++i) {
    const Vector2d position = adjusted.points[i].second.head<2>() + precision.planned.origin;
    if (position.x() < grid.west_m || position.y() > grid.north_m ||
        position.x() > grid.west_m + grid.width * grid.cell_m ||
        position.y() < grid.north_m - grid.height * grid.cell_m)
      continue;
    const int count = rays.at(adjusted.points[i].first);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      RaysPrecision& its = precision.rays[k];
      if (count < its.from || (its.to > 0 && count > its.to)) continue;
      ++its.points;
      sums[k] += adjusted.point_covariance[i].diagonal();
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k)
    if (precision.rays[k].points > 0)
      precision.rays[k].rms_m = (sums[k] / double(precision.rays[k].points)).cwiseSqrt();
  std::erase_if(precision.rays, [](const RaysPrecision& its) { return its.points == 0; });
}

void write_poses(Precision& precision) {
  Vector3d rotations = Vector3d::Zero(), moves = Vector3d::Zero();
  for (const auto& [id, covariance] : precision.adjusted.pose_covariance) {
    const Matrix3d rotation = pose_of(precision.planned.block, id).rotation.toRotationMatrix();
    rotations += (rotation * covariance.topLeftCorner<3, 3>() * rotation.transpose()).diagonal();
    moves += covariance.bottomRightCorner<3, 3>().diagonal();
  }
  const double count = double(precision.adjusted.pose_covariance.size());
  const double nothing = std::nan("");
  precision.rotation_rms_rad = count > 0 ? Vector3d((rotations / count).cwiseSqrt()) : Vector3d::Constant(nothing);
  precision.pose_rms_m = count > 0 ? Vector3d((moves / count).cwiseSqrt()) : Vector3d::Constant(nothing);
}

// The position known worst, then those farthest from all points there are and all chosen.
std::vector<Vector2d> candidates_to_try(const std::vector<PlannedPoint>& points, const Precision& now, int count) {
  std::vector<Vector2d> positions, known;
  for (const PlannedPoint& point : points)
    if (point.role == ControlRole::kControl) known.push_back(point.position);
  const auto room = [&](const Vector2d& position) {
    double nearest = 1e300;
    for (const Vector2d& other : known) nearest = std::min(nearest, (other - position).norm());
    return nearest;
  };
  while (int(positions.size()) < count) {
    const CellPrecision* best = nullptr;
    double most = 0;
    for (const CellPrecision& cell : now.cells) {
      const double free = room(cell.position);
      const double value = positions.empty() ? cell.covariance_m2.trace() : free;
      if (free < 2 * now.planned.grid.cell_m || value <= most) continue;
      most = value;
      best = &cell;
    }
    if (!best) break;
    positions.push_back(best->position);
    known.push_back(best->position);
  }
  return positions;
}

struct Sum {
  double squares = 0;
  long count = 0;
  double mean(double degrees) const { return count > 0 ? squares / (degrees * double(count)) : std::nan(""); }
};

template <class Matrix, class Vector>
double chi2(const Matrix& covariance, const Vector& error) {
  return error.dot(covariance.ldlt().solve(error));
}

// The free parameters of a camera against its true ones.
void compare_cameras(const Precision& predicted, const Adjusted& one, Sum& sum, int& degrees) {
  for (const auto& [id, camera] : one.cameras) {
    const MatrixPd& covariance = predicted.adjusted.camera_covariance.at(id);
    std::vector<int> free;
    for (const int k : params_of(camera))
      if (covariance(k, k) > 0) free.push_back(k);
    degrees = int(free.size());
    if (free.empty()) continue;
    Eigen::VectorXd error(degrees);
    for (int i = 0; i < degrees; ++i)
      error[i] = camera.params[std::size_t(free[std::size_t(i)])] -
                 predicted.planned.block.cameras.at(id).params[std::size_t(free[std::size_t(i)])];
    const Eigen::MatrixXd its = covariance(free, free);
    // Parameters of very unlike size: each in its own standard deviations.
    const Eigen::VectorXd scale = its.diagonal().cwiseSqrt().cwiseInverse();
    sum.squares += chi2(Eigen::MatrixXd(scale.asDiagonal() * its * scale.asDiagonal()),
                        Eigen::VectorXd(scale.cwiseProduct(error)));
    ++sum.count;
  }
}

void compare_poses(const Precision& predicted, const Adjusted& one, Sum& sum) {
  for (const auto& [id, pose] : one.cam_from_world) {
    const Rigid3& truth = pose_of(predicted.planned.block, id);
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = rotation_vector(truth.rotation.conjugate() * pose.rotation);
    error.tail<3>() = centre_of(pose) - centre_of(truth);
    sum.squares += chi2(predicted.adjusted.pose_covariance.at(id), error);
    ++sum.count;
  }
}

}  // namespace

Result<Precision> predicted(PlannedBlock planned, const Run& run) {
  Precision precision;
  COLLINEA_TRY(precision.adjusted, examine(planned.block, planned.scope, planned.options, run));
  precision.planned = std::move(planned);
  write_cells(precision);
  precision.area = area_sigma(precision);
  write_rays(precision);
  write_poses(precision);
  return precision;
}

Result<std::optional<Gain>> one_more_point(const FlightPlan& plan, const std::vector<PlannedPoint>& points,
                                           const Eigen::Vector3d& sigma_m, const MeasurementOptions& options,
                                           const Precision& now, int count, const Run& run) {
  std::optional<Gain> best;
  const std::vector<Vector2d> candidates = candidates_to_try(points, now, count);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Vector2d& position = candidates[i];
    std::vector<PlannedPoint> more = points;
    more.push_back({"one more", ControlRole::kControl, position, sigma_m});
    COLLINEA_TRY(PlannedBlock planned, planned_block(plan, more, options));
    COLLINEA_TRY(const Precision with, predicted(std::move(planned), run));
    run.report("positions of one more control point", double(i + 1) / double(candidates.size()));
    if (best && with.area.rms_m.norm() >= best->area.rms_m.norm()) continue;
    best = Gain{GainBy::kControlPoint, position, sigma_m, with.area};
  }
  return best;
}

Result<Trials> tried(const Precision& predicted, int blocks, const Run& run) {
  Trials trials;
  Sum cells, poses, cameras;
  int degrees = 1;
  Vector3d squares = Vector3d::Zero();
  std::map<std::size_t, const CellPrecision*> of_cell;
  for (const CellPrecision& cell : predicted.cells) of_cell[cell.cell] = &cell;
  for (int i = 0; i < blocks; ++i) {
    PlannedBlock noisy = with_errors(predicted.planned, run.seed + std::uint64_t(i));
    COLLINEA_TRY(const Adjusted one, adjust(noisy.block, noisy.scope, noisy.options.adjust, run));
    for (const ControlDifference& difference : one.control) {
      const auto known = noisy.cells.find(difference.point);
      if (known == noisy.cells.end() || !difference.position_in_world) continue;
      const auto cell = of_cell.find(known->second);
      if (cell == of_cell.end()) continue;
      const Vector3d error =
          *difference.position_in_world - predicted.planned.block.control.at(difference.point).position_in_world;
      squares += error.cwiseQuotient(cell->second->sigma_m()).cwiseAbs2();
      cells.squares += chi2(cell->second->covariance_m2, error);
      ++cells.count;
    }
    compare_poses(predicted, one, poses);
    compare_cameras(predicted, one, cameras, degrees);
    ++trials.blocks;
    run.report("simulated blocks", double(i + 1) / blocks);
  }
  trials.cell_ratio = (squares / double(std::max(1L, cells.count))).cwiseSqrt();
  trials.cell_chi2 = cells.mean(3);
  trials.pose_chi2 = poses.mean(6);
  trials.camera_chi2 = cameras.mean(degrees);
  trials.cells = cells.count;
  trials.poses = poses.count;
  trials.cameras = cameras.count;
  return trials;
}

}  // namespace collinea
