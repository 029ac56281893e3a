// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/control_collector.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/block/survey_covariance.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

tl::unexpected<Error> bad_control_line(int line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": " + what);
}

Result<> ControlCollector::add_point(int line, ControlFilePoint point) {
  if (!by_name_.emplace(point.name, file_.points.size()).second)
    return bad_control_line(line, "point " + point.name + " is given twice");
  file_.points.push_back(std::move(point));
  return {};
}

Result<> ControlCollector::add_covariance(int line, const std::vector<std::string_view>& f) {
  if (f.size() != 8)
    return bad_control_line(line, "a covariance row needs: covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2");
  const auto known = by_name_.find(std::string(f[1]));
  if (known == by_name_.end())
    return bad_control_line(line, "there is no point " + std::string(f[1]) + " above this line");
  if (!with_covariance_.insert(known->first).second)
    return bad_control_line(line, "the covariance of " + known->first + " is given twice");
  ControlFilePoint& point = file_.points[known->second];
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::size_t next = 2;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column, ++next) {
      if (f[next].empty()) continue;
      const auto value = finite_number(f[next]);
      if (!value) return bad_control_line(line, "\"" + std::string(f[next]) + "\" is not a covariance");
      covariance(row, column) = covariance(column, row) = *value;
    }
  for (int axis = 0; axis < 3; ++axis) {
    const bool surveyed = std::isfinite(point.position_in_map[axis]) && covariance(axis, axis) > 0;
    if (!surveyed && !covariance.row(axis).isZero(0))
      return bad_control_line(line, "covariances of an axis that has no coordinate, or no variance above 0");
    point.sigma_m[axis] = surveyed ? std::sqrt(covariance(axis, axis)) : kInfinity;
  }
  point.correlation = correlation_of(covariance);
  if (!survey_weight(point.sigma_m, point.correlation))
    return bad_control_line(line, "this is no covariance of " + point.name + ": it has to be positive definite");
  return {};
}

Result<> ControlCollector::add_image_covariance(int line, const std::vector<std::string_view>& f) {
  if (f.size() != 6)
    return bad_control_line(line,
                            "a row of an image's covariance needs: image_covariance, id, file, xx_px2, xy_px2, yy_px2");
  const auto seen = std::find_if(file_.observations.rbegin(), file_.observations.rend(),
                                 [&](const auto& one) { return one.point == f[1] && one.file == f[2]; });
  if (seen == file_.observations.rend())
    return bad_control_line(
        line, "there is no image row of " + std::string(f[1]) + " in " + std::string(f[2]) + " above this line");
  const auto xx = finite_number(f[3]), xy = finite_number(f[4]), yy = finite_number(f[5]);
  if (!xx || !xy || !yy || !(*xx > 0) || !(*yy > 0) || !(*xy * *xy < *xx * *yy))
    return bad_control_line(line,
                            "this is no covariance: xx_px2 and yy_px2 are above 0, and xy_px2 is smaller than the "
                            "root of their product");
  seen->sigma_px = std::sqrt(*xx);
  seen->shape = {.row_over_column = static_cast<float>(std::sqrt(*yy / *xx)),
                 .correlation = static_cast<float>(*xy / std::sqrt(*xx * *yy))};
  if (!seen->shape.is_valid())
    return bad_control_line(line, "column and row are as good as one: this is no covariance");
  return {};
}

Result<> ControlCollector::add_row(int line, const Eigen::Vector3d& position, std::string_view name,
                                   ControlFileObservation seen) {
  std::array<double, 3> key;
  for (int i = 0; i < 3; ++i) key[std::size_t(i)] = std::isnan(position[i]) ? kInfinity : position[i];
  if (name.empty()) {
    auto known = by_position_.find(key);
    if (known == by_position_.end()) {
      std::string made;
      do made = "gcp" + std::to_string(++unnamed_);
      while (by_name_.contains(made));
      COLLINEA_TRY(add_new(line, key, made));
      known = by_position_.find(key);
    }
    seen.point = file_.points[known->second].name;
  } else {
    seen.point = std::string(name);
    const auto known = by_name_.find(seen.point);
    if (known == by_name_.end()) {
      COLLINEA_TRY(add_new(line, key, seen.point));
    } else if (keys_[known->second] != key) {
      return bad_control_line(line, "point " + seen.point + " had other coordinates before");
    }
  }
  return add_observation(std::move(seen));
}

Result<> ControlCollector::add_observation(ControlFileObservation seen) {
  const auto [known, is_new] = known_.emplace(std::pair{seen.point, seen.file}, file_.observations.size());
  if (is_new) {
    file_.observations.push_back(std::move(seen));
    return {};
  }
  const ControlFileObservation& first = file_.observations[known->second];
  if (first.pixel == seen.pixel) return {};  // a copied line
  return bad_control_line(seen.line, "point " + seen.point + " is measured twice in " + seen.file +
                                         ", elsewhere in line " + std::to_string(first.line));
}

Result<ControlFile> ControlCollector::finish(std::string crs) {
  COLLINEA_TRY(add_marked_points());
  if (file_.points.empty()) return fail(Errc::kBadFormat, "no control point found");
  fill_missing_axes();
  file_.crs = std::move(crs);
  return std::move(file_);
}

Result<> ControlCollector::add_marked_points() {
  std::map<std::string, std::set<std::string>> images;
  for (const ControlFileObservation& seen : file_.observations)
    if (!by_name_.contains(seen.point)) images[seen.point].insert(seen.file);
  for (const ControlFileObservation& seen : file_.observations) {
    const auto its = images.find(seen.point);
    if (its == images.end() || by_name_.contains(seen.point)) continue;
    if (its->second.size() < 2)
      return bad_control_line(seen.line, "image row of a point " + seen.point +
                                             " that no point row gives, and no other image: without coordinates a "
                                             "point is marked in two images at least");
    ControlFilePoint point{seen.point, Eigen::Vector3d::Constant(kInfinity), Eigen::Vector3d::Constant(kInfinity),
                           ControlRole::kControl};
    COLLINEA_TRY(add_point(seen.line, std::move(point)));
  }
  return {};
}

Result<> ControlCollector::add_new(int line, const std::array<double, 3>& key, const std::string& name) {
  ControlFilePoint point{name, {key[0], key[1], key[2]}, {}, ControlRole::kControl};
  point.sigma_m = {defaults_.sigma_plan_m, defaults_.sigma_plan_m, defaults_.sigma_height_m};
  for (int i = 0; i < 3; ++i)
    if (key[std::size_t(i)] == kInfinity) point.sigma_m[i] = kInfinity;
  by_position_.emplace(key, file_.points.size());
  keys_.push_back(key);
  return add_point(line, std::move(point));
}

void ControlCollector::fill_missing_axes() {
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0;
    int known = 0;
    for (const auto& point : file_.points)
      if (std::isfinite(point.position_in_map[axis])) {
        sum += point.position_in_map[axis];
        ++known;
      }
    for (auto& point : file_.points)
      if (!std::isfinite(point.position_in_map[axis])) {
        point.position_in_map[axis] = known ? sum / known : 0;
        point.sigma_m[axis] = kInfinity;
      }
  }
}

}  // namespace collinea
