// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/tie_residuals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/report/internal/cells.h"

namespace collinea {
namespace {

using Key = std::pair<PointId, ImageId>;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kPiece = std::size_t{1} << 20;  // bytes
const Eigen::Vector2d kUnknown = Eigen::Vector2d::Constant(kNaN);

Key key_of(const Observation& seen) { return {seen.point, seen.image}; }

struct TieRow {
  Eigen::Vector2d residual_px = kUnknown, redundancy = kUnknown, w = kUnknown;
  double limit = kNaN, weight = 0;
  TieState state = TieState::kNoPart;
};

/// Rows in the order of the measurements, one after the other.
class TieRows {
 public:
  explicit TieRows(const AdjustmentReport& report) : report_(report), adjusted_(report.adjusted) {
    if (report.snooped)
      for (const Rejected& rejected : report.snooped->rejected)
        if (rejected.group == ObservationGroup::kTieImages) snooped_.insert({rejected.point, rejected.image});
    std::uint32_t before = PointId::kNone;
    for (const std::uint32_t source : adjusted_.observations) {
      const PointId point = report.block.observations[source].point;
      if (point.value != before) rays_.emplace_back(point, 0);
      ++rays_.back().second;
      before = point.value;
    }
  }

  /// Of measurement i, which has to follow the one asked for before.
  TieRow next(std::size_t i) {
    const Observation& seen = report_.measured_ties[i];
    const auto& left = report_.block.observations;
    while (at_ < adjusted_.observations.size() && key_of(left[adjusted_.observations[at_]]) < key_of(seen)) ++at_;
    const bool is_used =
        at_ < adjusted_.observations.size() && key_of(left[adjusted_.observations[at_]]) == key_of(seen);
    if (!is_used) return without(i, seen);
    const std::size_t k = at_++;
    return used(k, left[adjusted_.observations[k]]);
  }

 private:
  TieRow used(std::size_t k, const Observation& seen) {
    TieRow row{.residual_px = adjusted_.residuals_px[k], .state = TieState::kUsed};
    if (!row.residual_px.allFinite()) {
      row.state = TieState::kNotSeen;
      return row;
    }
    row.weight = adjusted_.tie_loss.weight((row.residual_px / seen.sigma_px).squaredNorm()) /
                 std::max(adjusted_.tie_loss.information, 1e-300);
    if (!adjusted_.reliability || k >= adjusted_.reliability->tie_redundancy.size()) return row;
    const Reliability& tests = *adjusted_.reliability;
    row.redundancy = tests.tie_redundancy[k];
    for (int axis = 0; axis < 2; ++axis)
      row.w[axis] = tie_test(adjusted_, tests, row.residual_px, seen.sigma_px, axis, row.redundancy[axis]).w;
    row.limit = limit_of(seen.point);
    if ((row.w.array().abs() > row.limit).any()) row.state = TieState::kSuspected;
    return row;
  }

  double limit_of(PointId point) {
    while (point_ < rays_.size() && rays_[point_].first < point) ++point_;
    const Reliability& tests = *adjusted_.reliability;
    const auto its_class = tests.tie_errors.class_of(rays_[point_].second);
    return its_class ? tests.tie_limits[*its_class] : tests.limit;
  }

  TieRow without(std::size_t i, const Observation& seen) const {
    TieRow row;
    const auto is_among = [&](const std::vector<std::uint32_t>& indices) {
      return std::binary_search(indices.begin(), indices.end(), static_cast<std::uint32_t>(i));
    };
    if (report_.mismatches && is_among(report_.mismatches->wrong))
      row.state = TieState::kMismatch;
    else if (report_.mismatches && is_among(report_.mismatches->with_them))
      row.state = TieState::kWithMismatch;
    else if (snooped_.contains(key_of(seen)))
      row.state = TieState::kGrossError;
    const auto point = report_.block.points.find(seen.point);
    const auto pose = find_pose(report_.block, seen.image);
    if (point == report_.block.points.end() || !pose) return row;
    if (const auto pixel = project(report_.block.camera_of(seen.image), *pose * point->second.position_in_world))
      row.residual_px = seen.pixel - *pixel;
    return row;
  }

  const AdjustmentReport& report_;
  const Examined& adjusted_;
  std::set<Key> snooped_;
  std::vector<std::pair<PointId, int>> rays_;  // that take part, of each point, ascending
  std::size_t at_ = 0, point_ = 0;
};

void append(std::string& text, double value, int digits) {
  text += ',';
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(text), "{:.{}g}", value, digits);
}

}  // namespace

Result<> write_tie_residuals(const AdjustmentReport& report, const std::filesystem::path& file) {
  COLLINEA_TRY(OutputFile out, OutputFile::create(file));
  std::string text =
      "image,point,column_px,row_px,sigma_px,residual_column_px,residual_row_px,redundancy_column,redundancy_row,"
      "w_column,w_row,limit,weight,state\n";
  std::map<ImageId, std::string> names;
  for (const auto& [id, image] : report.block.images) names[id] = in_quotes(image.file);
  TieRows rows(report);
  for (std::size_t i = 0; i < report.measured_ties.size(); ++i) {
    const Observation& seen = report.measured_ties[i];
    const TieRow row = rows.next(i);
    fmt::format_to(std::back_inserter(text), "{},{}", names[seen.image], seen.point.value);
    for (const double px : {seen.pixel.x(), seen.pixel.y()}) append(text, px, 9);
    append(text, seen.sigma_px, 6);
    for (const Eigen::Vector2d* pair : {&row.residual_px, &row.redundancy, &row.w})
      for (const double value : {pair->x(), pair->y()}) append(text, value, 6);
    append(text, row.limit, 6);
    append(text, row.weight, 6);
    fmt::format_to(std::back_inserter(text), ",{}\n", word_of(row.state));
    if (text.size() < kPiece) continue;
    out.write(text);
    text.clear();
  }
  out.write(text);
  return out.finish();
}

}  // namespace collinea
