// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_control.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "collinea/epipolar/intersect.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualSigma_m = 0.02;

// Columns of the table; NaN where a coordinate is not known.
struct Control {
  std::vector<std::string> names;
  std::array<std::vector<double>, 4> pixels;  // of the files: x, y left, x, y right
  std::array<std::vector<double>, 3> ground, sigmas;
};

Result<Control> read_control(const fs::path& file) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(file));
  Control control;
  COLLINEA_TRY(control.names, table.words("point").map_error(within));
  const char* const columns[] = {"x_left", "y_left", "x_right", "y_right"};
  for (std::size_t i = 0; i < 4; ++i) {
    COLLINEA_TRY(control.pixels[i], table.numbers(columns[i], "px").map_error(within));
  }
  const char* const axes[] = {"X", "Y", "Z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis = axes[i];
    COLLINEA_TRY(control.ground[i], table.numbers_or(axis, "m", std::nan("")).map_error(within));
    COLLINEA_TRY(control.sigmas[i], table.numbers_or("sigma_" + axis, "m", kUsualSigma_m).map_error(within));
  }
  return control;
}

// Where the images as they are worked on show a point.
struct InImages {
  Eigen::Vector2d left_px, right_px;
};

Result<InImages> in_images(const Control& control, std::size_t i, const PairFiles& pair, int shrink) {
  InImages at{{control.pixels[0][i], control.pixels[1][i]}, {control.pixels[2][i], control.pixels[3][i]}};
  if (pair.film) {
    const auto left = pair.film->in_left(at.left_px), right = pair.film->in_right(at.right_px);
    if (!left || !right) return fail(Errc::kBadInput, fmt::format("point {} lies beyond the film", control.names[i]));
    at = {*left, *right};
  }
  return InImages{at.left_px / shrink, at.right_px / shrink};
}

Result<AbsoluteControl> intersected(const Control& control, std::size_t i, const PairFiles& pair,
                                    const PairModel& model, double sigma_px) {
  COLLINEA_TRY(const InImages at, in_images(control, i, pair, model.shrink));
  const double sigma = sigma_px / model.shrink;
  const std::array<SightLine, 2> lines = {
      SightLine{&model.left_camera, {}, at.left_px, sigma, {}},
      SightLine{&model.right_camera, model.right_from_left(), at.right_px, sigma, {}}};
  const auto met = intersect(lines);
  if (!met)
    return fail(Errc::kIllPosed,
                fmt::format("the rays of point {} do not meet in front of the cameras", control.names[i]));
  AbsoluteControl made{.in_model = met->point_in_world, .model_covariance = met->covariance};
  made.in_ground = {control.ground[0][i], control.ground[1][i], control.ground[2][i]};
  made.has_plan = made.in_ground.head<2>().allFinite();
  made.has_height = std::isfinite(made.in_ground.z());
  for (int k = 0; k < 3; ++k) {
    made.ground_covariance(k, k) = control.sigmas[std::size_t(k)][i] * control.sigmas[std::size_t(k)][i];
    if (!std::isfinite(made.in_ground[k])) made.in_ground[k] = 0;
  }
  return made;
}

}  // namespace

Result<> orient_absolutely(const fs::path& file, const PairFiles& pair, const PairModel& model, double sigma_px,
                           PairReport& report) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(Control control, read_control(file));
  std::vector<AbsoluteControl> points(control.names.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    COLLINEA_TRY(points[i], intersected(control, i, pair, model, sigma_px).map_error(within));
  }
  report.control_names = std::move(control.names);
  COLLINEA_TRY(report.absolute, absolute_orientation(points).map_error(within));
  return {};
}

}  // namespace collinea
