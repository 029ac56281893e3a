// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <variant>

#include "collinea/base/result.h"
#include "collinea/camera/internal/fisheye_projection.h"

namespace collinea {
namespace {

CameraCore core_of(const Camera& camera) {
  return {camera.params.data(),
          camera.model,
          camera.additional,
          {static_cast<double>(camera.width_px), static_cast<double>(camera.height_px)}};
}

std::optional<Eigen::Vector2d> project_without_additional(const CameraCore& camera, const Eigen::Vector3d& point_in_cam,
                                                          Matrix23* by_point, Matrix2P* by_params) {
  return std::visit(
      [&]<class Model>(const Model&) { return Model::project(camera.params, point_in_cam, by_point, by_params); },
      camera.model);
}

const double* additional_of(const CameraCore& camera) { return camera.params + Camera::kParams; }

// The pixel before the additional shift, by Newton iteration from where it was measured: the shift is small and smooth.
Eigen::Vector2d without_additional(const CameraCore& camera, const Eigen::Vector2d& pixel) {
  Eigen::Vector2d at = pixel;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const AdditionalShift shift = additional_shift(camera.additional, additional_of(camera), camera.size, at);
    const Eigen::Matrix2d by_pixel = Eigen::Matrix2d::Identity() + shift.by_pixel;
    if (!(by_pixel.determinant() > 1e-3)) break;
    const Eigen::Vector2d step = by_pixel.inverse() * (pixel - at - shift.shift_px);
    at += step;
    if (step.norm() < 1e-12 * (1 + pixel.norm())) break;
  }
  return at;
}

// The position in the image in focal lengths from the principal point, before D is undone.
Eigen::Vector2d measured_coordinates(const Camera& camera, Eigen::Vector2d pixel) {
  if (camera.additional != AdditionalSet::kNone) [[unlikely]]
    pixel = without_additional(core_of(camera), pixel);
  const auto& p = camera.params;
  const double yd = (pixel.y() - p[Camera::kCy]) / p[Camera::kF];
  const double xd = (pixel.x() - p[Camera::kCx] - p[Camera::kB2] * yd) / (p[Camera::kF] + p[Camera::kB1]);
  return {xd, yd};
}

}  // namespace

Camera ideal_camera(double focal_px, int width_px, int height_px) {
  Camera camera;
  camera.params[Camera::kF] = focal_px;
  camera.params[Camera::kCx] = width_px / 2.0;
  camera.params[Camera::kCy] = height_px / 2.0;
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

std::vector<int> params_of(const Camera& camera) {
  const std::span<const int> of_model = params_of(camera.model);
  std::vector<int> list(of_model.begin(), of_model.end());
  for (int k = 0; k < static_cast<int>(count_of(camera.additional)); ++k) list.push_back(Camera::kParams + k);
  return list;
}

std::string param_name(int param) {
  COLLINEA_CHECK(param >= 0 && param < Camera::kAllParams);
  if (param >= Camera::kParams) return "a" + std::to_string(param - Camera::kParams + 1);
  return std::string(Camera::kParamNames[static_cast<std::size_t>(param)]);
}

std::string_view param_unit(int param) {
  return param >= Camera::kParams ? "px" : Camera::kParamUnits[static_cast<std::size_t>(param)];
}

std::optional<int> param_named(const Camera& camera, std::string_view name) {
  for (const int k : params_of(camera))
    if (param_name(k) == name) return k;
  return std::nullopt;
}

void scale_params(Camera& camera, double times) {
  for (int k = 0; k < Camera::kAllParams; ++k)
    if (param_unit(k) == "px") camera.params[static_cast<std::size_t>(k)] *= times;
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam) {
  return project(core_of(camera), point_in_cam, nullptr, nullptr);
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam, Matrix23* by_point,
                                       Matrix2P* by_params) {
  return project(core_of(camera), point_in_cam, by_point, by_params);
}

std::optional<Eigen::Vector2d> project(const CameraCore& camera, const Eigen::Vector3d& point_in_cam,
                                       Matrix23* by_point, Matrix2P* by_params) {
  if (camera.additional == AdditionalSet::kNone) [[likely]]
    return project_without_additional(camera, point_in_cam, by_point, by_params);
  const auto pixel = project_without_additional(camera, point_in_cam, by_point, by_params);
  if (!pixel) return pixel;
  const AdditionalShift shift = additional_shift(camera.additional, additional_of(camera), camera.size, *pixel);
  const Eigen::Matrix2d by_pixel = Eigen::Matrix2d::Identity() + shift.by_pixel;
  if (by_point) *by_point = by_pixel * *by_point;
  if (by_params) {
    *by_params = by_pixel * *by_params;
    AdditionalEffect effect;
    additional_effect(camera.additional, camera.size, *pixel, effect);
    for (std::size_t k = 0; k < count_of(camera.additional); ++k)
      by_params->col(Camera::kParams + static_cast<int>(k)) << effect.column[k], effect.row[k];
  }
  return *pixel + shift.shift_px;
}

Eigen::Vector2d normalized(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d measured = measured_coordinates(camera, pixel);
  return std::visit([&]<class Model>(const Model&) { return Model::normalized(camera.params.data(), measured); },
                    camera.model);
}

Eigen::Vector2d without_additional(const Camera& camera, const Eigen::Vector2d& pixel) {
  return camera.additional == AdditionalSet::kNone ? pixel : without_additional(core_of(camera), pixel);
}

bool in_plane(const Camera& camera, const Eigen::Vector2d& pixel) {
  if (!is_fisheye(camera.model)) return true;
  const Eigen::Vector2d measured = measured_coordinates(camera, pixel);
  return std::visit([&]<class Model>(const Model&) { return Model::in_plane(camera.params.data(), measured); },
                    camera.model);
}

double pixels_per_unit(const Camera& camera, const Eigen::Vector2d& normalized_xy) {
  return std::visit([&]<class Model>(const Model&) { return Model::pixels_per_unit(camera.focal_px(), normalized_xy); },
                    camera.model);
}

Eigen::Vector3d ray_in_cam(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d measured = measured_coordinates(camera, pixel);
  return std::visit([&]<class Model>(const Model&) { return Model::ray(camera.params.data(), measured); },
                    camera.model);
}

}  // namespace collinea
