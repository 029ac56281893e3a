// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_findings.h"

#include <algorithm>
#include <cmath>

#include "collinea/epipolar/intersect_rays.h"
#include "collinea/epipolar/pair_shape.h"
#include "collinea/jobs/internal/orientation_findings.h"
#include "collinea/math/median.h"
#include "collinea/report/fit_findings.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using C = FindingCode;
using F = FigureName;

constexpr int kSamples = 48;             // of the left image, along each side
constexpr double kFewPoints = 12;        // two at each of the six positions of von Gruber: they check each other
constexpr double kNccSigma_px = 0.2;     // of a correlation (docs/theory/area-matching.md)
constexpr double kLsmSigma_px = 0.1;     // of least squares matching, with what its windows do not show
constexpr double kFarBeyond = 3;         // times that: not by chance, and not by poor texture alone
constexpr double kMostlyMeasured = 0.5;  // of the cells of a surface model

std::vector<Vector2d> left_of(std::span<const MatchedPoint> points) {
  std::vector<Vector2d> out;
  for (const MatchedPoint& point : points) out.push_back(point.left_px);
  return out;
}

void add_points(const PairOrientation& last, const std::optional<PairOverlap>& overlap,
                std::span<const MatchedPoint> points, std::vector<Finding>& findings) {
  const auto used = static_cast<double>(last.orientation.used);
  if (used < kFewPoints)
    findings.push_back(finding_of(C::kPairFewPoints, {}, {{F::kCount, used}, {F::kLimit, kFewPoints}},
                                  {RemedyCode::kSpreadPairPoints}));
  if (overlap)
    if (const auto [empty, zones] = overlap->zones_without(left_of(points)); empty > 0)
      findings.push_back(finding_of(C::kPairZonesEmpty, {}, {{F::kCount, double(empty)}, {F::kOf, double(zones)}},
                                    {RemedyCode::kSpreadPairPoints}));
  const double usual = last.by == "lsm" ? kLsmSigma_px : kNccSigma_px;
  if (last.orientation.redundancy >= 1 && last.sigma0_px > kFarBeyond * usual)
    findings.push_back(finding_of(C::kPairParallax, {}, {{F::kOffsetPx, last.sigma0_px}, {F::kSigmaPx, usual}},
                                  {RemedyCode::kCalibrateCamera}));
}

void add_geometry(const ModelOfPair& model, std::vector<Finding>& findings) {
  const auto shape =
      pair_shape(model.orientation.second_from_first,
                 normalised(model.points, model.left_camera, model.right_camera, 1), model.orientation.normal);
  if (!shape) return;
  for (const PairWeakness weakness : shape->weaknesses) {
    if (weakness == PairWeakness::kNearPlane) continue;  // points off the plane tell both orientations apart
    findings.push_back(finding_of(C::kPairGeometry, {}, {{F::kRatio, shape->inflation}}, {RemedyCode::kLeaveSurface},
                                  std::string(word_of(weakness))));
  }
}

void add_choice(const ModelOfPair& model, std::vector<Finding>& findings) {
  std::vector<PairPoint> used;
  const auto points = normalised(model.points, model.left_camera, model.right_camera, 1);
  add_choice_findings(model.orientation, relative_solutions(model.orientation.second_from_first, points), findings);
}

// The base over the distance of the points along the view.
std::optional<double> base_ratio(const PairReport& report, std::optional<double> depth_in_bases) {
  if (!depth_in_bases || !(*depth_in_bases > 0)) return std::nullopt;
  return std::abs(base_in_first(report.orientations.back().orientation.second_from_first).head<2>().norm()) /
         *depth_in_bases;
}

// Median distance along the view of the left camera, in bases.
std::optional<double> median_depth(const ModelOfPair& model) {
  std::vector<double> depths;
  for (const MatchedPoint& point : model.points)
    if (const auto met = intersect_midpoint(Rigid3{}, model.orientation.second_from_first,
                                            normalized(model.left_camera, point.left_px),
                                            normalized(model.right_camera, point.right_px)))
      depths.push_back(met->z());
  if (depths.empty()) return std::nullopt;
  return median(depths);
}

void add_control(const PairReport& report, const std::optional<PairOverlap>& overlap,
                 std::span<const Vector2d> control_px, std::vector<Finding>& findings) {
  if (!report.absolute || report.is_given) return;
  if (overlap)
    if (const auto [empty, quarters] = overlap->quarters_without(control_px); empty > 0)
      findings.push_back(finding_of(C::kPairControlApart, {}, {{F::kCount, double(empty)}, {F::kOf, double(quarters)}},
                                    {RemedyCode::kGiveControlInCorners}));
  const AbsoluteOrientation& absolute = *report.absolute;
  std::vector<ControlTest> tests;
  for (std::size_t i = 0; i < absolute.residuals.size(); ++i)
    tests.push_back({report.control_names[i], absolute.residuals[i].misfit, absolute.residuals[i].w});
  add_fit_findings({absolute.sigma0, absolute.redundancy, true}, tests, findings);
}

void add_surface(const PairReport& report, std::vector<Finding>& findings) {
  if (const auto dropped = std::ranges::count(report.levels, true, &LevelCount::is_dropped); dropped > 0)
    findings.push_back(finding_of(C::kPairLevelsDropped, {},
                                  {{F::kCount, double(dropped)},
                                   {F::kOf, double(report.levels.size())},
                                   {F::kLimit, double(report.levels.back().least)}},
                                  {"last_threshold"_option}));
  if (!report.map) return;
  const double cells = double(report.map->width) * report.map->height;
  if (const double share = double(report.map->measured_cells) / std::max(cells, 1.0); share < kMostlyMeasured)
    findings.push_back(
        finding_of(C::kPairCellsMeasured, {}, {{F::kShare, share}}, {"surface"_option, "cell_m"_option}));
}

}  // namespace

std::optional<PairOverlap> PairOverlap::of(const ModelOfPair& model) {
  const auto depth = median_depth(model);
  if (!depth || !(*depth > 0)) return std::nullopt;
  PairOverlap overlap;
  const Vector2d size(model.left_camera.width_px, model.left_camera.height_px);
  overlap.step_ = size / kSamples;
  overlap.least_ = size;
  for (int row = 0; row < kSamples; ++row)
    for (int column = 0; column < kSamples; ++column) {
      const Vector2d at = overlap.step_.cwiseProduct(Vector2d(column + 0.5, row + 0.5));
      const auto there = project(model.right_camera, model.orientation.second_from_first *
                                                         (*depth * normalized(model.left_camera, at).homogeneous()));
      if (!there || !inside(model.right_camera, *there)) continue;
      overlap.inside_.push_back(at);
      overlap.least_ = overlap.least_.cwiseMin(at - overlap.step_ / 2);
      overlap.most_ = overlap.most_.cwiseMax(at + overlap.step_ / 2);
    }
  if (overlap.inside_.empty()) return std::nullopt;
  const Eigen::Vector3d base = base_in_first(model.orientation.second_from_first);
  overlap.base_along_rows_ = std::abs(base.x()) >= std::abs(base.y());
  return overlap;
}

PairOverlap::Empty PairOverlap::without(std::span<const Vector2d> left_px, int columns, int rows) const {
  const Vector2d part = (most_ - least_).cwiseQuotient(Vector2d(columns, rows));
  const auto index_of = [&](const Vector2d& at) -> std::size_t {
    const Vector2d cell = (at - least_).cwiseQuotient(part);
    return static_cast<std::size_t>(std::clamp(int(cell.y()), 0, rows - 1) * columns +
                                    std::clamp(int(cell.x()), 0, columns - 1));
  };
  std::vector<int> points(static_cast<std::size_t>(columns * rows), 0), samples = points;
  for (const Vector2d& at : left_px)
    if ((at - least_).minCoeff() >= 0 && (most_ - at).minCoeff() >= 0) ++points[index_of(at)];
  for (const Vector2d& at : inside_) ++samples[index_of(at)];
  const double whole = part.x() * part.y() / (step_.x() * step_.y());
  Empty out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (samples[i] < 0.5 * whole) continue;
    ++out.parts;
    out.empty += points[i] == 0;
  }
  return out;
}

PairOverlap::Empty PairOverlap::zones_without(std::span<const Vector2d> left_px) const {
  return base_along_rows_ ? without(left_px, 2, 3) : without(left_px, 3, 2);
}

PairOverlap::Empty PairOverlap::quarters_without(std::span<const Vector2d> left_px) const {
  return without(left_px, 2, 2);
}

std::vector<Finding> pair_findings(const ModelOfPair& model, const PairReport& report,
                                   std::span<const Vector2d> control_px, std::optional<double> wanted_sigma_z_m) {
  const PairOrientation& last = report.orientations.back();
  const auto overlap = PairOverlap::of(model);
  std::vector<Finding> findings;
  add_points(last, overlap, model.points, findings);
  if (!report.is_given) {  // what is given is not determined by the points
    add_geometry(model, findings);
    add_choice(model, findings);
  }
  if (wanted_sigma_z_m && report.is_metric() && report.median_sigma_z_m() > *wanted_sigma_z_m)
    if (const auto ratio = base_ratio(report, median_depth(model)))
      findings.push_back(
          finding_of(C::kPairBase, {},
                     {{F::kRatio, *ratio}, {F::kSigma, report.median_sigma_z_m()}, {F::kWanted, *wanted_sigma_z_m}},
                     {RemedyCode::kLengthenBase}));
  add_control(report, overlap, control_px, findings);
  add_surface(report, findings);
  return findings;
}

}  // namespace collinea
