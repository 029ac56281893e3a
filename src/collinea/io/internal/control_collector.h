// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/io/control_contents.h"

namespace collinea {

[[nodiscard]] tl::unexpected<Error> bad_control_line(int line, const std::string& what);

/// Collects rows of a control file into points and observations, whatever the format: names differ, a coordinate that
/// is missing is infinite until `finish`, a copied line counts once, and a point has one position in an image.
class ControlCollector {
 public:
  explicit ControlCollector(const ControlDefaults& defaults) : defaults_(defaults) {}

  Result<> add_point(int line, ControlFilePoint point);
  /// A row of our CSV: covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2.
  Result<> add_covariance(int line, const std::vector<std::string_view>& fields);
  /// A row of our CSV: image_covariance, id, file, xx_px2, xy_px2, yy_px2. It is of the last row of that point in that
  /// file.
  Result<> add_image_covariance(int line, const std::vector<std::string_view>& fields);
  /// A row of a point and where it is seen; the point may have been there before. x, y, z: NaN where missing. Without a
  /// name rows of one position are one point.
  Result<> add_row(int line, const Eigen::Vector3d& position, std::string_view name, ControlFileObservation seen);
  Result<> add_observation(ControlFileObservation seen);
  /// All of it, once. Points that are only marked, in two images or more, have no coordinates. Errors: no point, one
  /// that no row gives and a single image shows.
  Result<ControlFile> finish(std::string crs);

 private:
  Result<> add_new(int line, const std::array<double, 3>& key, const std::string& name);
  Result<> add_marked_points();
  void fill_missing_axes();

  ControlDefaults defaults_;
  ControlFile file_;
  std::map<std::string, std::size_t> by_name_;
  std::map<std::array<double, 3>, std::size_t> by_position_;  // infinity where missing: NaN has no order
  std::vector<std::array<double, 3>> keys_;
  std::map<std::pair<std::string, std::string>, std::size_t> known_;  // observations, by point and file
  std::set<std::string> with_covariance_;
  int unnamed_ = 0;
};

}  // namespace collinea
