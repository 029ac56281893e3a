// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "collinea/block/survey_covariance.h"
#include "collinea/jobs/predict_marks.h"
#include "collinea/marking/predicted_marks.h"
#include "collinea/report/json_values.h"
#include "collinea/restitution/map_height.h"
#include "collinea/serve/control_json.h"
#include "collinea/serve/internal/bounded_json.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json pair(const Vector2d& v) { return {number(v.x()), number(v.y())}; }

json ellipse_json(const Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix2d> eigen(covariance);
  const Vector2d major = eigen.eigenvectors().col(1);
  double angle = 180 / std::numbers::pi * std::atan2(major.y(), major.x());
  if (angle < 0) angle += 180;
  return {{"major_px", number(std::sqrt(eigen.eigenvalues()[1]))},
          {"minor_px", number(std::sqrt(std::max(0.0, eigen.eigenvalues()[0])))},
          {"angle_deg", number(angle)}};
}

json marked_json(const ProjectView& view, const PredictedMarks& found, const ControlPoint& given) {
  if (!found.marked) return nullptr;
  const MarkedPoint& marked = *found.marked;
  const Matrix3d turn = view.map_from_world();
  const Vector3d sigma = (turn * marked.covariance * turn.transpose()).diagonal().cwiseSqrt();
  Vector3d difference = turn * (marked.position_in_world - given.position_in_world);
  Vector3d difference_sigma =
      (turn * (marked.covariance + survey_covariance(given.sigma_m, given.correlation)) * turn.transpose())
          .diagonal()
          .cwiseSqrt();
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(given.sigma_m[axis]))
      difference[axis] = difference_sigma[axis] = std::numeric_limits<double>::quiet_NaN();
  json marks = json::array();
  for (std::size_t i = 0; i < marked.tests.size(); ++i) {
    const PointMarkTest& test = marked.tests[i];
    marks.push_back({{"image", found.marked_images[i].value},
                     {"residual_px", pair(test.residual_px)},
                     {"redundancy", pair(test.redundancy)},
                     {"w", pair(test.w)},
                     {"detectable_px", pair(test.detectable_px)}});
  }
  return {{"position", vector(view.in_map(marked.position_in_world))},
          {"sigma_m", vector(sigma)},
          {"difference_m", vector(difference)},
          {"difference_sigma_m", vector(difference_sigma)},
          {"sigma0", number(marked.sigma0)},
          {"redundancy", marked.redundancy},
          {"marks", marks}};
}

// The point as the whole block with all marks has it; null where it has not.
json in_block_json(const ProjectView& view, ControlId id, const std::vector<ControlObservation>& marks) {
  const auto adjusted = view.adjusted_with_marks();
  if (!adjusted) return nullptr;
  const auto number_of_point = std::distance(view.control.begin(), view.control.find(id));
  const AdjustedMark& point = adjusted->points[std::size_t(number_of_point)];
  if (!point.position_in_world) return nullptr;
  const Matrix3d turn = view.map_from_world();
  json list = json::array();
  for (std::size_t i = 0; i < marks.size() && i < point.marks.size(); ++i) {
    const BlockMarkTest& test = point.marks[i];
    list.push_back({{"image", marks[i].image.value},
                    {"residual_px", pair(test.residual_px)},
                    {"redundancy", pair(test.redundancy)},
                    {"w", pair(test.w)},
                    {"detectable_px", pair(test.minimal_detectable_bias_px)}});
  }
  const auto differences = [&](const Vector3d& values) {
    return adjusted->placed ? vector(values) : json::array({nullptr, nullptr, nullptr});
  };
  return {{"position", vector(view.in_map(*point.position_in_world))},
          {"sigma_m", vector(Vector3d((turn * point.covariance_m2 * turn.transpose()).diagonal().cwiseSqrt()))},
          {"difference_m", differences(point.difference_m)},
          {"difference_sigma_m", differences(point.difference_sigma_m)},
          {"sigma0", number(adjusted->sigma0)},
          {"marks", list}};
}

// With the surface where there is one: what hides points is read by need.
MarkingBlock marking_with_surface(const ProjectView& view, const TiedBlock& ties) {
  MarkingBlock marking = view.marking(ties);
  marking.surface =
      surface_in_world(view.frame_or_null(), heights_by_need(view.project.folder / "products" / "dsm.tif"));
  return marking;
}

Result<ControlId> point_named(const ProjectView& view, const std::string& name) {
  for (const auto& [id, point] : view.control)
    if (point.name == name) return id;
  return fail(Errc::kNotFound, "there is no control point \"" + name + "\"");
}

struct RefineRequest {
  ImageId image;
  Vector2d pixel;
  std::optional<MarkedKind> kind;
};

Result<RefineRequest> refine_request_in(std::string_view body) {
  try {
    const json asked = bounded_json(body);
    RefineRequest request{image_in(asked.at("image")),
                          {asked.at("pixel").at(0).get<double>(), asked.at("pixel").at(1).get<double>()},
                          {}};
    if (!request.pixel.allFinite()) return fail(Errc::kBadInput, "pixel: two numbers, column and row");
    const std::string kind = asked.value("kind", "auto");
    if (kind == "auto") return request;
    request.kind = from_word<MarkedKind>(kind);
    if (!request.kind) return fail(Errc::kBadInput, "kind: it is auto, circle, cross, chequerboard or tag");
    return request;
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
}

}  // namespace

Result<std::string> predicted_marks_json(const ProjectView& view, const std::string& name) {
  COLLINEA_TRY(const ControlId id, point_named(view, name));
  if (count_oriented(view.block) == 0)
    return fail(Errc::kIllPosed, "the images are not oriented yet: bring the project to the step orient first");
  COLLINEA_TRY(const auto ties, view.ties());
  const ControlPoint& given = view.control.at(id);
  std::vector<ControlObservation> marks;
  for (const ControlObservation& mark : view.marks)
    if (mark.point == id && view.block.images.contains(mark.image)) marks.push_back(mark);
  const PredictedMarks found = predicted_marks(marking_with_surface(view, *ties), given, marks);
  json list = json::array(), contradicting = json::array();
  for (const ImageId image : found.contradicting) contradicting.push_back(image.value);
  for (const PredictedMark& one : found.predicted)
    list.push_back({{"image", one.image.value},
                    {"file", view.block.images.at(one.image).file},
                    {"pixel", pair(one.pixel)},
                    {"ellipse", ellipse_json(one.covariance)},
                    {"marked", one.marked},
                    {"hidden", one.hidden},
                    {"sigma_after_m", one.sigma_after_m ? number(*one.sigma_after_m) : json(nullptr)}});
  return text_of({{"places", list},
                  {"given_disagrees", found.given_disagrees},
                  {"contradicting", contradicting},
                  {"marked", marked_json(view, found, given)},
                  {"in_block", in_block_json(view, id, marks)}});
}

namespace {

// Of each point the best place that is not marked yet, and that nothing hides.
std::vector<PossibleMark> possible_marks(const ProjectView& view, const TiedBlock& ties) {
  constexpr double kSigmaPx = 0.5;  // of a mark by hand
  std::map<ControlId, std::vector<ControlObservation>> marks;
  for (const ControlObservation& mark : view.marks)
    if (view.block.images.contains(mark.image)) marks[mark.point].push_back(mark);
  std::vector<PossibleMark> possible;
  const MarkingBlock marking = marking_with_surface(view, ties);
  std::size_t number = 0;
  for (const auto& [id, point] : view.control) {
    const PredictedMarks found = predicted_marks(marking, point, marks[id]);
    const auto best =
        std::ranges::find_if(found.predicted, [](const PredictedMark& one) { return !one.marked && !one.hidden; });
    if (best != found.predicted.end()) possible.push_back({number, {best->image, best->pixel, kSigmaPx}});
    ++number;
  }
  return possible;
}

}  // namespace

Result<std::string> next_mark_json(const ProjectView& view) {
  if (count_oriented(view.block) == 0)
    return fail(Errc::kIllPosed, "the images are not oriented yet: bring the project to the step orient first");
  COLLINEA_TRY(const auto ties, view.ties());
  const auto possible = possible_marks(view, *ties);
  COLLINEA_TRY(const auto next, view.next_mark(possible));
  if (!next) return text_of({{"next", nullptr}});
  const BlockMark& mark = next->mark.mark;
  return text_of({{"next",
                   {{"point", std::next(view.control.begin(), std::ptrdiff_t(next->mark.point))->second.name},
                    {"image", mark.image.value},
                    {"file", view.block.images.at(mark.image).file},
                    {"pixel", pair(mark.pixel)},
                    {"placed", {next->placed_before, next->placed_after}},
                    {"rms_sigma_m", {number(next->rms_sigma_before_m), number(next->rms_sigma_after_m)}}}}});
}

Result<std::string> refined_json(const ProjectView& view, std::string_view body) {
  COLLINEA_TRY(const RefineRequest request, refine_request_in(body));
  if (!view.block.images.contains(request.image)) return fail(Errc::kNotFound, "there is no such image");
  const Camera& camera = view.block.camera_of(request.image);
  COLLINEA_TRY(const RefinedMark found, target_in_image(view.image_files.at(request.image), camera.width_px,
                                                        camera.height_px, request.pixel, request.kind));
  const Matrix2d& covariance = found.covariance;
  return text_of({{"pixel", pair(found.pixel)},
                  {"covariance_px2", {number(covariance(0, 0)), number(covariance(0, 1)), number(covariance(1, 1))}},
                  {"sigma_px", number(found.sigma_px())},
                  {"kind", word_of(found.kind)}});
}

}  // namespace collinea
