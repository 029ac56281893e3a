// SPDX-License-Identifier: Apache-2.0
#pragma once

// A rendered pair with known truth, for the tests of this module only.

#include <map>

#include "collinea/restitution/ground_match.h"
#include "collinea/synthetic/render.h"
#include "collinea/synthetic/survey.h"

namespace collinea::testing {

/// A strip of three photographs of 900 x 600 pixels over rocks, as they were truly taken.
struct StereoScene {
  Truth truth;
  std::map<ImageId, ColourImage> colours = {};
  std::map<ImageId, GreyImage> greys = {};

  [[nodiscard]] const Block& block() const { return truth.block; }
  [[nodiscard]] PhotoWindow photo() const {
    return [this](ImageId image, const PixelWindow& window) -> Result<FloatImage> {
      FloatImage out(window.width, window.height);
      for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.width; ++x)
          out.at(x, y) = float(greys.at(image).at(window.left + x, window.top + y));
      return out;
    };
  }
};

inline SurveyOptions strip_of_three() {
  SurveyOptions options;
  options.strips = 1;
  options.images_per_strip = 3;
  options.cross_strips = 0;
  options.forward_overlap = 0.6;
  options.gsd_m = 0.1;
  options.camera.width_px = 900;
  options.camera.height_px = 600;
  options.control_points = 2;
  options.check_points = 2;
  options.building_area_m2 = 0;
  options.attitude_jitter_deg = 3;
  return options;
}

inline StereoScene stereo_scene(const SurveyOptions& options, std::size_t rendered) {
  StereoScene scene{*make_survey(options)};
  const Run run;
  for (const OrientedImage& one : oriented_images(scene.truth.block)) {
    if (scene.colours.size() == rendered) break;
    const RayTable rays(scene.truth.block.camera_of(one.image), run);
    const ColourImage colour = *render(scene.truth, one.image, rays, run);
    GreyImage grey(colour.width, colour.height);
    for (std::size_t i = 0; i < grey.data.size(); ++i)
      grey.data[i] = std::uint8_t(0.299 * colour.data[3 * i] + 0.587 * colour.data[3 * i + 1] +
                                  0.114 * colour.data[3 * i + 2] + 0.5);
    scene.colours.emplace(one.image, colour);
    scene.greys.emplace(one.image, std::move(grey));
  }
  return scene;
}

}  // namespace collinea::testing
