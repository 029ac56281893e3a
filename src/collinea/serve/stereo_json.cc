// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/stereo_json.h"

#include <cmath>
#include <stdexcept>

#include "collinea/raster/image_tiles.h"
#include "collinea/raster/image_window.h"
#include "collinea/report/json_values.h"
#include "collinea/restitution/ground_match.h"
#include "collinea/restitution/plotted_vertex.h"
#include "collinea/serve/internal/bounded_json.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json of_mark(const StereoMark& mark) { return {number(mark.x), number(mark.y), number(mark.parallax)}; }
json pair(const Vector2d& v) { return {number(v.x()), number(v.y())}; }

MapHeight surface_of(const ProjectView& view) { return heights_by_need(view.project.folder / "products" / "dsm.tif"); }

void add_covariance(json& out, const std::optional<Matrix3d>& covariance) {
  if (!covariance || !covariance->allFinite()) {
    out["covariance_m2"] = nullptr;
    out["sigma_m"] = nullptr;
    return;
  }
  const Matrix3d& c = *covariance;
  out["covariance_m2"] = {number(c(0, 0)), number(c(0, 1)), number(c(0, 2)),
                          number(c(1, 1)), number(c(1, 2)), number(c(2, 2))};
  out["sigma_m"] = vector(Vector3d(c.diagonal().cwiseSqrt()));
}

// Position and covariance of a mark: the vertex that is plotted by its two pixels.
void add_position(json& out, const ProjectView& view, const MarkingBlock& marking, const StereoGeometry& model,
                  const StereoMark& mark, double sigma_px) {
  const auto pixels = model.pixels_of(marking.block, mark);
  const auto position = model.position_in_world(mark);
  out["position"] = position ? vector(view.in_map(*position)) : json(nullptr);
  std::optional<Matrix3d> covariance;
  VertexPlotter plotter(marking, view.frame_or_null(), nullptr);
  if (pixels) {
    const auto vertex =
        plotter.plot(MarkedVertex{{{model.left, (*pixels)[0], sigma_px}, {model.right, (*pixels)[1], sigma_px}}});
    if (vertex) covariance = plotter.covariance_in_map(*vertex);
  }
  add_covariance(out, covariance);
}

json of_lattice(const PixelLattice& lattice) {
  json nodes = json::array();
  for (const Vector2d& node : lattice.nodes)
    for (int axis = 0; axis < 2; ++axis) nodes.push_back(number(std::round(node[axis] * 1e3) / 1e3));
  return {{"step_px", lattice.step_px},
          {"columns", lattice.columns},
          {"rows", lattice.rows},
          {"error_px", number(lattice.error_px)},
          {"nodes", nodes}};
}

json of_side(const Block& block, ImageId image, const Camera& epipolar, const PixelLattice& lattice) {
  const Camera& camera = block.camera_of(image);
  return {{"image", image.value},
          {"file", block.images.at(image).file},
          {"width", camera.width_px},
          {"height", camera.height_px},
          {"levels", tile_levels(camera.width_px, camera.height_px)},
          {"columns", epipolar.width_px},
          {"rows", epipolar.height_px},
          {"cx", number(epipolar.params[Camera::kCx])},
          {"cy", number(epipolar.params[Camera::kCy])},
          {"lattice", of_lattice(lattice)}};
}

json of_choice(const Block& block, const StereoChoice& choice) {
  return {{"images", {choice.images[0].value, choice.images[1].value}},
          {"files", {block.images.at(choice.images[0]).file, block.images.at(choice.images[1]).file}},
          {"base_to_height", number(choice.base_to_height)},
          {"convergence_rad", number(choice.convergence_rad)},
          {"gsd_m", {number(choice.gsd_m[0]), number(choice.gsd_m[1])}},
          {"sigma_height_m", choice.sigma_height_m ? number(*choice.sigma_height_m) : json(nullptr)},
          {"hidden", choice.is_hidden}};
}

json of_map(const MapPolynomial& map) {
  json coefficients = json::array();
  for (int axis = 0; axis < 3; ++axis) {
    json row = json::array();
    for (int k = 0; k < 10; ++k) row.push_back(number(map.coefficients(axis, k)));
    coefficients.push_back(row);
  }
  return {{"origin", vector(map.origin)}, {"scale_m", number(map.scale_m)}, {"coefficients", coefficients}};
}

json of_pose(const Rigid3& pose) {
  const Matrix3d r = pose.rotation.toRotationMatrix();
  json rotation = json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rotation.push_back(number(r(row, column)));
  return {{"rotation", rotation}, {"translation", vector(pose.translation)}};
}

struct AskedGround {
  ImageId left, right;
  StereoMark mark;
  GroundMatchOptions options;
};

Result<AskedGround> asked_ground(std::string_view body) {
  try {
    const json asked = bounded_json(body);
    const json& mark = asked.at("mark");
    AskedGround ground{image_in(asked.at("images").at(0)),
                       image_in(asked.at("images").at(1)),
                       {mark.at(0).get<double>(), mark.at(1).get<double>(), mark.at(2).get<double>()},
                       {}};
    ground.options.search_px = asked.value("search_px", ground.options.search_px);
    ground.options.window_px = asked.value("window_px", ground.options.window_px);
    for (const double value : {ground.mark.x, ground.mark.y, ground.mark.parallax})
      if (!(std::abs(value) < 1e6)) return fail(Errc::kBadInput, "mark: three numbers, x, y and parallax");
    COLLINEA_TRY(validate(ground.options));
    return ground;
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
}

}  // namespace

Result<std::string> stereo_json(const ProjectView& view, const AskedStereo& asked) {
  COLLINEA_TRY(const auto ties, view.ties());
  const MarkingBlock marking = view.plotting(*ties);
  COLLINEA_TRY(const StereoView scene, stereo_view(marking, view.frame_or_null(), surface_of(view), asked));
  const Block& block = ties->block;
  const EpipolarPair& geometry = scene.model.pair;
  json out = of_choice(block, scene.shown);
  out["focal_px"] = number(geometry.left.focal_px());
  out["base_m"] = number(geometry.base_m);
  out["left_from_world"] = of_pose(geometry.left_from_world);
  out["left"] = of_side(block, scene.model.left, geometry.left, scene.left);
  out["right"] = of_side(block, scene.model.right, geometry.right, scene.right);
  out["map"] = of_map(scene.map);
  out["mark"] = of_mark(scene.mark);
  add_position(out, view, marking, scene.model, scene.mark, kPointing_px);
  out["pairs"] = json::array();
  for (const StereoChoice& choice : scene.choices) out["pairs"].push_back(of_choice(block, choice));
  return text_of(out);
}

Result<std::string> ground_json(const ProjectView& view, std::string_view body) {
  COLLINEA_TRY(const AskedGround asked, asked_ground(body));
  COLLINEA_TRY(const auto ties, view.ties());
  const MarkingBlock marking = view.plotting(*ties);
  COLLINEA_TRY(const StereoGeometry model, StereoGeometry::of(ties->block, asked.left, asked.right));
  if (model.left != asked.left) return fail(Errc::kBadInput, "images: the left one comes first, as in stereo");
  const PhotoWindow photo = [&](ImageId image, const PixelWindow& window) {
    const Camera& camera = ties->block.camera_of(image);
    return read_grey_window(view.image_files.at(image), camera.width_px, camera.height_px, window);
  };
  COLLINEA_TRY(const GroundMatch found, match_ground(ties->block, model, asked.mark, photo, asked.options));
  json out{{"mark", of_mark(found.mark)},
           {"sigma_px", number(found.sigma_px)},
           {"mark_sigma_px", number(found.mark_sigma_px())},
           {"correlation", number(found.correlation)},
           {"pixels", {pair(found.pixels[0]), pair(found.pixels[1])}}};
  add_position(out, view, marking, model, found.mark, found.mark_sigma_px());
  return text_of(out);
}

}  // namespace collinea
