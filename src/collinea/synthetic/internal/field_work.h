// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/survey_parts.h"
#include "collinea/synthetic/internal/truth.h"

namespace collinea {

/// The steps that an aerial and a terrestrial survey have in common. All act on a truth whose scene and frame are set.

/// Cameras, images and poses; each image with its own exposure.
void add_images(Truth& truth, const Camera& camera, const std::vector<Rigid3>& cam_from_world, double exposure_sigma,
                double white_balance_sigma = 0);

/// What the receiver wrote down: true positions plus normal errors.
void add_positions(Truth& truth, double sigma_plan_m, double sigma_height_m);

/// What the gimbal of a drone that looks down wrote down: heading of the upper edge of the image, forward tilt, no
/// roll; errors of `sigma_deg`.
void add_attitudes(Truth& truth, double sigma_deg);

struct MarkOptions {
  int control_points = 0, check_points = 0;
  Eigen::Vector3d sigma_m;  ///< of the surveyed coordinates, east, north, height
  double measurement_sigma_px = 0.25;
  int least_images = 3;
  double margin_px = 15;
};

/// Chooses marks among the candidates, spread as far apart as they can be, paints them, surveys them and measures
/// them in the images that show them whole. Control first, then check points, each set well spread.
/// Error: too few candidates are seen in enough images.
[[nodiscard]] Result<> add_marks(Truth& truth, const std::vector<Mark>& candidates, const MarkOptions& options,
                                 const Run& run);

/// A rotation about three axes with normal angles, none beyond 2.5 sigma.
[[nodiscard]] Eigen::Quaterniond shaken(Random& random, double sigma_deg);
[[nodiscard]] double bounded_normal(Random& random);

/// The camera of either kind of survey. Without a given focal length it is `share` of the width.
/// Errors: an image wider than can be rendered.
[[nodiscard]] inline Result<Camera> true_camera(const SurveyCamera& o, double share) {
  Camera camera = ideal_camera(o.focal_px.value_or(share * o.width_px), o.width_px, o.height_px);
  camera.model = o.camera_model;
  auto& p = camera.params;
  p[Camera::kCx] += o.principal_x_px;
  p[Camera::kCy] += o.principal_y_px;
  const std::pair<std::string_view, double> distortion[] = {{"k1", o.k1}, {"k2", o.k2}, {"k3", o.k3},
                                                            {"k4", o.k4}, {"p1", o.p1}, {"p2", o.p2}};
  for (const auto& [name, value] : distortion)
    if (const auto param = param_named(camera, name)) p[std::size_t(*param)] = value;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), Eigen::Vector2d(o.width_px, 0),
                                        Eigen::Vector2d(0, o.height_px), Eigen::Vector2d(o.width_px, o.height_px)})
    if (!in_plane(camera, corner))
      return fail(Errc::kBadInput,
                  "the corners of the images see more than 80 degrees from the axis, which is not "
                  "rendered: a longer focal length is needed",
                  {"focal_px"_option});
  camera.name = "Collinea Synthetic";
  camera.prior.source = Provenance::kTrue;
  return camera;
}

[[nodiscard]] inline Optics optics_of(const SurveyLight& o) { return {o.blur_px, o.noise_grey, o.vignetting}; }

}  // namespace collinea
