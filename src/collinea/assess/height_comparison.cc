// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/height_comparison.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "collinea/assess/internal/levelled.h"
#include "collinea/assess/internal/surface_sampler.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr std::size_t kMostPoints = 60'000;  // of which a co-registration is made
constexpr std::size_t kFewest = 30;
constexpr int kMostIterations = 40;
constexpr int kIterationsToChoose = 12;    // afterwards the limit of what is left out stays
constexpr int kFullSteps = 20;             // afterwards they become shorter, down to a half
constexpr double kSettled_cells = 1e-3;    // a step that moves points by less ends it,
constexpr double kSettled_sigmas2 = 1e-2;  // or one that is as small beside the standard deviations
constexpr double kFartherThan = 3;         // robust standard deviations: left out
constexpr double kSteepest = 1;        // rise per run; steeper is a wall between two cells, whose slope says nothing
constexpr double kVaguest_cells = 10;  // standard deviation of a shift in plan
constexpr int kReferenceTile = 256;    // cells
constexpr double kDegree = std::numbers::pi / 180;

// Every so manieth point of a reference, at most kMostPoints.
Result<std::vector<Eigen::Vector3d>> some_points(const ReferencePoints& reference) {
  std::vector<Eigen::Vector3d> kept;
  std::size_t stride = 1, count = 0;
  for (bool first = true;; first = false) {
    COLLINEA_TRY(const std::vector<Eigen::Vector3d> batch, reference(first));
    if (batch.empty()) return kept;
    for (const Eigen::Vector3d& point : batch) {
      if (count++ % stride != 0) continue;
      kept.push_back(point);
      if (kept.size() < kMostPoints) continue;
      for (std::size_t i = 0; 2 * i < kept.size(); ++i) kept[i] = kept[2 * i];
      kept.resize((kept.size() + 1) / 2);
      stride *= 2;
    }
  }
}

Eigen::Vector3d moved(const SurfaceShift& shift, const Eigen::Vector3d& point) {
  const Eigen::Vector3d arm = point - shift.middle;
  return shift.middle + shift.values.head<3>() +
         (1 + shift.values[6]) * (rotation_by(shift.values.segment<3>(3)) * arm);
}

// A difference at a point and how it changes with the unknowns.
struct Difference {
  double value_m = 0;
  Vector7 by_unknowns = Vector7::Zero();
};

Result<std::vector<Difference>> differences(SurfaceSampler& surface, const std::vector<Eigen::Vector3d>& points,
                                            const SurfaceShift& shift) {
  std::vector<Difference> found;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d there = moved(shift, point);
    COLLINEA_TRY(const SurfaceAt at, surface.at(there.head<2>()));
    if (std::isnan(at.height_m) || at.slope.norm() > kSteepest) continue;
    const Eigen::Vector3d slope(at.slope.x(), at.slope.y(), -1), arm = there - shift.middle;
    Difference difference{at.height_m - there.z(), {}};
    difference.by_unknowns << slope, arm.cross(slope), slope.dot(arm);
    found.push_back(difference);
  }
  return found;
}

double median_of(const std::vector<Difference>& differences) {
  std::vector<double> values;
  for (const Difference& each : differences) values.push_back(each.value_m);
  return median(values);
}

// The distance from their median beyond which differences are left out.
double farthest(const std::vector<Difference>& differences, double middle_m) {
  std::vector<double> values;
  for (const Difference& each : differences) values.push_back(std::abs(each.value_m - middle_m));
  return std::max(kFartherThan * 1.4826 * median(values), 1e-12);
}

struct Normals {
  Matrix7 matrix = Matrix7::Zero();
  Vector7 right = Vector7::Zero();
  double sum_squares = 0;
  std::size_t used = 0;
};

Normals normals_of(const std::vector<Difference>& differences, double middle_m, double farthest_m) {
  Normals normals;
  for (const Difference& each : differences) {
    if (std::abs(each.value_m - middle_m) > farthest_m) continue;
    normals.matrix += each.by_unknowns * each.by_unknowns.transpose();
    normals.right -= each.by_unknowns * each.value_m;
    normals.sum_squares += each.value_m * each.value_m;
    ++normals.used;
  }
  return normals;
}

// The step of the first `unknowns` and their cofactors; nothing when they are not determined.
std::optional<std::pair<Vector7, Matrix7>> solved(const Normals& normals, int unknowns) {
  // Unknowns in units in which each is known equally well by itself.
  const Eigen::VectorXd diagonal = normals.matrix.diagonal().head(unknowns);
  if (!(diagonal.minCoeff() > 0)) return std::nullopt;
  const Eigen::VectorXd unit = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled =
      unit.asDiagonal() * normals.matrix.topLeftCorner(unknowns, unknowns) * unit.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> factors(scaled);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 1e-10)) return std::nullopt;
  std::pair<Vector7, Matrix7> answer{Vector7::Zero(), Matrix7::Zero()};
  answer.first.head(unknowns) = unit.asDiagonal() * factors.solve(unit.asDiagonal() * normals.right.head(unknowns));
  answer.second.topLeftCorner(unknowns, unknowns) =
      unit.asDiagonal() * factors.solve(Eigen::MatrixXd::Identity(unknowns, unknowns)) * unit.asDiagonal();
  return answer;
}

// How far a step moves points at the distance `arm_m` from the middle.
double motion_of(const Vector7& step, double arm_m) {
  return step.head<3>().norm() + arm_m * (step.segment<3>(3).norm() + std::abs(step[6]));
}

auto too_level() {
  return fail(Errc::kIllPosed, "the surface is too level to find its shift in plan: compare without co-registration");
}

std::size_t slope_class(const Eigen::Vector2d& slope) {
  const double slope_deg = std::atan(slope.norm()) / kDegree;
  return std::size_t(std::count_if(kSlopeLimits_deg.begin(), kSlopeLimits_deg.end(),
                                   [&](double limit_deg) { return slope_deg >= limit_deg; }));
}

// Sorts differences into the classes of a comparison.
class Comparer {
 public:
  Comparer(HeightComparison& comparison, const ComparisonOptions& options)
      : comparison_(comparison), options_(options) {}

  Result<> add(const Eigen::Vector3d& reference, const SurfaceAt& at) {
    if (std::isnan(at.height_m)) {
      ++comparison_.without_height;
      return {};
    }
    const double difference_m = at.height_m - reference.z();
    comparison_.all.add(difference_m, comparison_.tolerance_m);
    comparison_.by_slope[slope_class(at.slope)].add(difference_m, comparison_.tolerance_m);
    if (options_.class_at) {
      COLLINEA_TRY(const int number, options_.class_at(reference.head<2>()));
      classes_[number].add(difference_m, comparison_.tolerance_m);
    }
    if (at.sigma_m > 0) {
      const double ratio = difference_m / at.sigma_m;
      sum_squares_ += ratio * ratio;
      within_ += std::abs(ratio) < kBoundSigmas;
      ++ratios_;
    }
    return {};
  }

  void finish() {
    comparison_.by_class.assign(std::make_move_iterator(classes_.begin()), std::make_move_iterator(classes_.end()));
    if (ratios_ == 0) return;
    comparison_.variance_ratio = sum_squares_ / double(ratios_);
    comparison_.within_bounds = double(within_) / double(ratios_);
  }

 private:
  HeightComparison& comparison_;
  const ComparisonOptions& options_;
  std::map<int, DifferenceStatistics> classes_;
  double sum_squares_ = 0;
  std::size_t ratios_ = 0, within_ = 0;
};

auto nothing_in_common() {
  return fail(Errc::kBadInput, "surface and reference have no place in common: are both in the same CRS?");
}

}  // namespace

ReferencePoints points_of_grid(const HeightField& reference) {
  auto next = std::make_shared<std::pair<int, int>>(0, 0);  // column and row of the next tile
  return [&reference, next](bool from_start) -> Result<std::vector<Eigen::Vector3d>> {
    if (from_start) *next = {0, 0};
    const MapGrid& grid = reference.grid;
    std::vector<Eigen::Vector3d> points;
    while (points.empty() && next->second < grid.height) {
      const auto [column, row] = *next;
      const int width = std::min(kReferenceTile, grid.width - column),
                height = std::min(kReferenceTile, grid.height - row);
      COLLINEA_TRY(const FloatImage heights, reference.read(column, row, width, height));
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          if (const float z = heights.at(x, y); !std::isnan(z))
            points.emplace_back(grid.east_of(column + x + 0.5), grid.north_of(row + y + 0.5), double(z));
      *next = column + width < grid.width ? std::pair(column + width, row) : std::pair(0, row + height);
    }
    return points;
  };
}

Result<SurfaceShift> coregister(const HeightField& surface, const ReferencePoints& reference, Coregistration kind) {
  SurfaceShift shift{.unknowns = kind == Coregistration::kNone ? 0 : kind == Coregistration::kShift ? 3 : 7};
  if (shift.unknowns == 0) return shift;
  COLLINEA_TRY(const std::vector<Eigen::Vector3d> points, some_points(reference));
  if (points.empty()) return nothing_in_common();
  for (const Eigen::Vector3d& point : points) shift.middle += point / double(points.size());
  double arm_m = 0;
  for (const Eigen::Vector3d& point : points) arm_m = std::max(arm_m, (point - shift.middle).norm());
  SurfaceSampler sampler(surface);
  double farthest_m = 0, middle_m = 0;
  for (; shift.iterations < kMostIterations; ++shift.iterations) {
    COLLINEA_TRY(const std::vector<Difference> found, differences(sampler, points, shift));
    if (found.size() < kFewest)
      return fail(Errc::kIllPosed,
                  fmt::format("{} points of the reference lie on the surface; a co-registration needs {}", found.size(),
                              kFewest));
    if (shift.iterations < kIterationsToChoose) {
      middle_m = shift.iterations == 0 ? median_of(found) : 0;
      farthest_m = farthest(found, middle_m);
    }
    const Normals normals = normals_of(found, middle_m, farthest_m);
    if (normals.used < kFewest) return too_level();
    const auto step = solved(normals, shift.unknowns);
    if (!step) return too_level();
    // Shorter at last: points at the limit of what is left out go in and out, to and fro.
    const double share = shift.iterations < kFullSteps ? 1 : double(kFullSteps) / (shift.iterations + 1);
    const Vector7 moved_by = share * step->first;
    shift.values += moved_by;
    shift.used = normals.used;
    shift.left_out = found.size() - normals.used;
    const double variance = std::max(normals.sum_squares - step->first.dot(normals.right), 0.0) /
                            double(normals.used - std::size_t(shift.unknowns));
    shift.sigma0_m = std::sqrt(variance);
    shift.covariance = variance * step->second;
    const double step_sigmas2 = moved_by.dot(normals.matrix * moved_by) / std::max(variance, 1e-300);
    if (motion_of(moved_by, arm_m) >= kSettled_cells * surface.grid.cell_m && step_sigmas2 >= kSettled_sigmas2)
      continue;
    if (shift.covariance.diagonal().head<2>().maxCoeff() > std::pow(kVaguest_cells * surface.grid.cell_m, 2))
      return too_level();
    return shift;
  }
  return fail(Errc::kNotConverged,
              "surface and reference could not be brought together: they are too far apart, or too "
              "unlike; compare without co-registration");
}

Result<HeightComparison> compare_heights(
    const HeightField& surface, const ReferencePoints& reference, const SurfaceShift& shift,
    const ComparisonOptions& options, const Run& run,
    const std::function<void(const Eigen::Vector3d& on_map, double difference_m)>& take) {
  HeightComparison comparison{.tolerance_m = options.tolerance_m};
  SurfaceSampler sampler(surface);
  if (options.tolerance_m == 0) {
    COLLINEA_TRY(const std::vector<Eigen::Vector3d> points, some_points(reference));
    COLLINEA_TRY(const std::vector<Difference> found, differences(sampler, points, shift));
    if (found.empty()) return nothing_in_common();
    comparison.tolerance_m = farthest(found, median_of(found)) / kFartherThan;
    comparison.tolerance_from_data = true;
  }
  Comparer comparer(comparison, options);
  for (bool first = true;; first = false) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    COLLINEA_TRY(const std::vector<Eigen::Vector3d> batch, reference(first));
    if (batch.empty()) break;
    for (const Eigen::Vector3d& point : batch) {
      const Eigen::Vector3d there = moved(shift, point);
      COLLINEA_TRY(const SurfaceAt at, sampler.at(there.head<2>()));
      COLLINEA_TRY(comparer.add(there, at));
      if (take && !std::isnan(at.height_m)) take({there.x(), there.y(), at.height_m}, at.height_m - there.z());
    }
  }
  if (comparison.all.count() == 0) return nothing_in_common();
  comparer.finish();
  return comparison;
}

}  // namespace collinea
