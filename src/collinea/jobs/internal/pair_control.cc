// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_control.h"

#include <fmt/format.h>

#include <cmath>

#include "collinea/epipolar/intersect.h"
#include "collinea/io/text_table.h"

namespace collinea {
namespace {

constexpr double kUsualSigma_m = 0.02;  // of the ground, where the table states none

Result<> read_ground(const TextTable& table, std::vector<AbsoluteControl>& points) {
  const char* const axes[] = {"X", "Y", "Z"};
  for (int k = 0; k < 3; ++k) {
    const std::string axis = axes[k];
    COLLINEA_TRY(const std::vector<double> ground, table.numbers_or(axis, "m", std::nan("")));
    COLLINEA_TRY(const std::vector<double> sigmas, table.numbers_or("sigma_" + axis, "m", kUsualSigma_m));
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].in_ground[k] = ground[i];
      points[i].ground_covariance(k, k) = sigmas[i] * sigmas[i];
    }
  }
  for (AbsoluteControl& point : points) {
    point.has_plan = point.in_ground.head<2>().allFinite();
    point.has_height = std::isfinite(point.in_ground.z());
    for (double& value : point.in_ground)
      if (!std::isfinite(value)) value = 0;
  }
  return {};
}

}  // namespace

Result<PairControl> read_pair_control(const std::filesystem::path& file, const PairFiles& pair, int shrink,
                                      double sigma_px) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(file));
  PairControl control{.file = file, .names = {}, .pixels = {}, .sigma_px = sigma_px / shrink, .points = {}};
  COLLINEA_TRY(control.names, table.words("point").map_error(within));
  std::array<std::vector<double>, 4> pixels;
  const char* const columns[] = {"x_left", "y_left", "x_right", "y_right"};
  for (std::size_t i = 0; i < 4; ++i) {
    COLLINEA_TRY(pixels[i], table.numbers(columns[i], "px").map_error(within));
  }
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    std::array<Eigen::Vector2d, 2> seen = {Eigen::Vector2d(pixels[0][i], pixels[1][i]), {pixels[2][i], pixels[3][i]}};
    if (pair.film) {
      const auto left = pair.film->in_left(seen[0]), right = pair.film->in_right(seen[1]);
      if (!left || !right)
        return fail(Errc::kBadInput, fmt::format("{}: point {} lies beyond the film", file.string(), control.names[i]));
      seen = {*left, *right};
    }
    control.pixels.push_back({seen[0] / shrink, seen[1] / shrink});
  }
  control.points.resize(table.rows.size());
  COLLINEA_TRY(read_ground(table, control.points).map_error(within));
  return control;
}

Result<AbsoluteOrientation> oriented_absolutely(const PairControl& control, const PairModel& model,
                                                const Rigid3& right_from_left) {
  std::vector<AbsoluteControl> points = control.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::array<SightLine, 2> lines = {
        SightLine{&model.left_camera, {}, control.pixels[i][0], control.sigma_px, {}},
        SightLine{&model.right_camera, right_from_left, control.pixels[i][1], control.sigma_px, {}}};
    const auto met = intersect(lines);
    if (!met)
      return fail(Errc::kIllPosed, fmt::format("{}: the rays of point {} do not meet in front of the cameras",
                                               control.file.string(), control.names[i]));
    points[i].in_model = met->point_in_world;
    points[i].model_covariance = met->covariance;
  }
  return absolute_orientation(points).map_error(
      [&](Error error) { return std::move(error).within(control.file.string()); });
}

}  // namespace collinea
