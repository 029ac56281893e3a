// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include "collinea/base/words.h"
#include "collinea/camera/internal/brown.h"
#include "collinea/camera/internal/brown_of_measured.h"
#include "collinea/camera/internal/equidistant.h"
#include "collinea/camera/internal/equisolid.h"
#include "collinea/camera/internal/kannala_brandt.h"

namespace collinea {

/// How a direction becomes a position in the image: the closed list of camera models. A model has no state; its
/// parameters are in Camera::params. It is a struct with
///     kName           as files, reports and options call it
///     kHas            the parameters that it has, ascending
///     kIsFisheye      whether it shows directions far from the axis, for which X/Z, Y/Z are of no use
///     project, normalized, ray, in_plane, pixels_per_unit     see camera/central.h and camera/fisheye.h
///     operator==
/// Adding a model is its header and a line here. The laws of cameras (camera_test.cc), the adjustment, the store, the
/// adjustment file, simulation and import follow from the list; a format that can express the model names it in its
/// mapping.
using CameraModel = std::variant<Brown, BrownOfMeasured, Equidistant, Equisolid, KannalaBrandt>;

/// All models, in the order of the list.
inline constexpr auto kCameraModels = []<std::size_t... I>(std::index_sequence<I...>) {
  return std::array<CameraModel, sizeof...(I)>{CameraModel(std::in_place_index<I>)...};
}
(std::make_index_sequence<std::variant_size_v<CameraModel>>{});

[[nodiscard]] constexpr std::string_view name_of(const CameraModel& model) {
  return std::visit([](const auto& one) { return one.kName; }, model);
}
inline constexpr auto kCameraModelNames = []<std::size_t... I>(std::index_sequence<I...>) {
  return std::array<std::string_view, sizeof...(I)>{name_of(kCameraModels[I])...};
}
(std::make_index_sequence<kCameraModels.size()>{});

template <class Model>
[[nodiscard]] constexpr bool is(const CameraModel& model) {
  return std::holds_alternative<Model>(model);
}
[[nodiscard]] constexpr bool is_fisheye(const CameraModel& model) {
  return std::visit([](const auto& one) { return one.kIsFisheye; }, model);
}
inline constexpr auto kCameraModelWords = []<std::size_t... I>(std::index_sequence<I...>) {
  return std::array<Word<CameraModel>, sizeof...(I)>{
      Word<CameraModel>{kCameraModels[I], name_of(kCameraModels[I]), is_fisheye(kCameraModels[I]) ? "fisheye" : ""}...};
}
(std::make_index_sequence<kCameraModels.size()>{});
/// Words of the models in options, see base/words.h.
[[nodiscard]] constexpr std::span<const Word<CameraModel>> words(const CameraModel&) { return kCameraModelWords; }
/// The parameters of a model, ascending: CameraParameters::Param.
[[nodiscard]] constexpr std::span<const int> params_of(const CameraModel& model) {
  return std::visit([](const auto& one) { return std::span<const int>(one.kHas); }, model);
}
/// The model of that name, if there is one.
[[nodiscard]] constexpr std::optional<CameraModel> model_named(std::string_view name) {
  for (const CameraModel& model : kCameraModels)
    if (name_of(model) == name) return model;
  return std::nullopt;
}

}  // namespace collinea
