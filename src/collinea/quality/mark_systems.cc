// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/mark_systems.h"

namespace collinea {
namespace {

Eigen::Matrix2d columns_and_rows(double xu, double xv, double yu, double yv) {
  return (Eigen::Matrix2d() << xu, xv, yu, yv).finished();
}

}  // namespace

MarkMap map_of(const MarkHypothesis& hypothesis, double width_px, double height_px) {
  const double w = width_px, h = height_px, s = hypothesis.factor;
  switch (hypothesis.system) {
    case MarkSystem::kAsGiven:
      break;
    case MarkSystem::kRowsUp:
      return {columns_and_rows(1, 0, 0, -1), {0, h}};
    case MarkSystem::kColumnsLeft:
      return {columns_and_rows(-1, 0, 0, 1), {w, 0}};
    case MarkSystem::kUpsideDown:
      return {columns_and_rows(-1, 0, 0, -1), {w, h}};
    case MarkSystem::kExchanged:
      return {columns_and_rows(0, 1, 1, 0), {0, 0}};
    case MarkSystem::kTurnedRight:
      return {columns_and_rows(0, 1, -1, 0), {0, h}};
    case MarkSystem::kTurnedLeft:
      return {columns_and_rows(0, -1, 1, 0), {w, 0}};
    case MarkSystem::kCentre:
    case MarkSystem::kScaledCentre:
      return {columns_and_rows(s, 0, 0, s), {w / 2, h / 2}};
    case MarkSystem::kCentreRowsUp:
    case MarkSystem::kScaledCentreRowsUp:
      return {columns_and_rows(s, 0, 0, -s), {w / 2, h / 2}};
    case MarkSystem::kResampled:
      return {columns_and_rows(s, 0, 0, s), {0, 0}};
    case MarkSystem::kResampledRowsUp:
      return {columns_and_rows(s, 0, 0, -s), {0, h}};
  }
  return {Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero()};
}

Eigen::Vector2d pixel_of(const MarkHypothesis& hypothesis, const Camera& camera, const Eigen::Vector2d& given) {
  const MarkMap map = map_of(hypothesis, camera.width_px, camera.height_px);
  return map.linear * given + map.origin;
}

}  // namespace collinea
