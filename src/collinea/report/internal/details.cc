// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/details.h"

#include <cmath>

#include "collinea/report/json_values.h"
#include "collinea/report/statistics.h"
#include "collinea/report/value_words.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json optional_vector(const std::optional<Eigen::Vector3d>& value) { return value ? vector(*value) : json(nullptr); }

}  // namespace

std::map<CameraId, CameraDetail> by_camera(std::span<const ImageDetail> images, const Block& block) {
  std::map<CameraId, CameraDetail> cameras;
  for (const ImageDetail& image : images) {
    CameraDetail& its = cameras[block.images.at(image.image).camera];
    ++its.images;
    its.rays += image.rays;
    its.rms_px += double(image.rays) * image.rms_px * image.rms_px;  // a sum of squares, until below
  }
  for (auto& [id, its] : cameras) {
    its.camera = id;
    its.rms_px = its.rays > 0 ? std::sqrt(its.rms_px / double(its.rays)) : 0;
  }
  return cameras;
}

json json_of(const ImageDetail& image, const Block& block) {
  json one = {{"file", block.images.at(image.image).file},
              {"rays", image.rays},
              {"rms_px", number(image.rms_px)},
              {"centre_in_world", vector(image.centre_in_world)},
              {"centre_sigma_m", optional_vector(image.centre_sigma_m)},
              {"rotation_sigma_deg", optional_vector(image.rotation_sigma_deg)}};
  if (image.position) {
    one["position_difference_m"] = vector(image.position->difference_m);
    one["position_weight"] = number(image.position->weight);
  }
  return one;
}

json json_of(const CameraDetail& detail, const Block& block) {
  const Camera& camera = block.cameras.at(detail.camera);
  json one = {{"name", camera.name},
              {"model", name_of(camera.model)},
              {"width_px", camera.width_px},
              {"height_px", camera.height_px},
              {"source", words_of(camera.prior.source)},
              {"calibrated", camera.prior.calibrate},
              {"images", detail.images},
              {"rays", detail.rays},
              {"rms_px", number(detail.rms_px)}};
  if (camera.additional != AdditionalSet::kNone) one["additional"] = kAdditionalNames[std::size_t(camera.additional)];
  for (const int param : params_of(camera)) {
    const auto i = std::size_t(param);
    json value = {{"value", number(camera.params[i])}, {"unit", param_unit(param)}};
    if (detail.before) value["before"] = number(detail.before->params[i]);
    if (i < detail.sigma.size()) value["sigma"] = number(detail.sigma[i]);
    one["parameters"][param_name(param)] = value;
  }
  return one;
}

json json_of(const ControlDifference& control, const Block& block) {
  return {{"name", block.control.at(control.point).name},
          {"role", control.excluded ? "excluded"
                   : control.used   ? "control"
                                    : "check"},
          {"images", control.rays},
          {"difference_m", vector(control.difference_m)},
          {"sigma_m", vector(control.difference_sigma_m)},
          {"rms_px", number(control_rms_px(block, control))}};
}

}  // namespace collinea
