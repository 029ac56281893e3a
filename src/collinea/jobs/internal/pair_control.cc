// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_control.h"

#include <fmt/format.h>

#include <cmath>

#include "collinea/epipolar/intersect.h"
#include "collinea/jobs/internal/ground_table.h"

namespace collinea {
namespace {

constexpr double kUsualSigma_m = 0.02;  // of the ground, where the table states none

AbsoluteControl on_ground_of(const GroundTablePoint& point) {
  AbsoluteControl made;
  made.has_plan = point.has_plan();
  made.has_height = point.has_height();
  for (int k = 0; k < 3; ++k) {
    const bool is_known = std::isfinite(point.position[k]);
    made.in_ground[k] = is_known ? point.position[k] : 0;
    made.ground_covariance(k, k) = is_known ? point.sigma[k] * point.sigma[k] : 0;
  }
  return made;
}

}  // namespace

Result<PairControl> read_pair_control(const std::filesystem::path& file, const PairFiles& pair, int shrink,
                                      double sigma_px) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const GroundTable ground, read_ground_table(file, kUsualSigma_m, false));
  PairControl control{.file = file, .names = {}, .pixels = {}, .sigma_px = sigma_px / shrink, .points = {}};
  for (const GroundTablePoint& point : ground.points) {
    control.names.push_back(point.name);
    control.points.push_back(on_ground_of(point));
  }
  std::array<std::vector<double>, 4> pixels;
  const char* const columns[] = {"x_left", "y_left", "x_right", "y_right"};
  for (std::size_t i = 0; i < 4; ++i) {
    COLLINEA_TRY(pixels[i], ground.table.numbers(columns[i], "px").map_error(within));
  }
  for (std::size_t i = 0; i < ground.points.size(); ++i) {
    std::array<Eigen::Vector2d, 2> seen = {Eigen::Vector2d(pixels[0][i], pixels[1][i]), {pixels[2][i], pixels[3][i]}};
    if (pair.film) {
      const auto left = pair.film->in_left(seen[0]), right = pair.film->in_right(seen[1]);
      if (!left || !right)
        return fail(Errc::kBadInput, fmt::format("{}: point {} lies beyond the film", file.string(), control.names[i]));
      seen = {*left, *right};
    }
    control.pixels.push_back({seen[0] / shrink, seen[1] / shrink});
  }
  return control;
}

std::vector<Eigen::Vector2d> PairControl::left_px() const {
  std::vector<Eigen::Vector2d> out;
  for (const auto& seen : pixels) out.push_back(seen[0]);
  return out;
}

Result<AbsoluteOrientation> oriented_absolutely(const PairControl& control, const ModelOfPair& model,
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
