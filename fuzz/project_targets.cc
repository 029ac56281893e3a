// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/seamlines_file.h"
#include "collinea/project/settings.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

// What was read can be written, and that is read as the same.
bool accepts_settings(std::string_view bytes) {
  const auto settings = read_settings(file_of(bytes, "project.json").parent_path());
  if (!settings) return false;
  COLLINEA_CHECK(write_settings(folder(), *settings));
  const auto again = read_settings(folder());
  COLLINEA_CHECK(again && again->photos == settings->photos && chosen_options(*again) == chosen_options(*settings));
  return true;
}

std::string settings_seed(const Settings& settings) {
  return write_settings(folder(), settings) ? bytes_of(folder() / "project.json") : "";
}

std::vector<std::string> settings_seeds() {
  Settings chosen;
  chosen.photos = "/flights/2024-05-17";
  chosen.seed = 7;
  chosen.orient.max_error_px = 2.5;
  return {settings_seed(chosen),
          R"({"photos": "/a", "seed": 3, "options": {"detect": {}, "orient": {"max_error_px": 2}, "ortho": {}}})"};
}

Block two_images() {
  Block block;
  block.cameras[{0}] = ideal_camera(1000, 1200, 800);
  for (std::uint32_t i = 0; i < 2; ++i) {
    block.images[{i}].file = i ? "b.jpg" : "a.jpg";
    block.images[{i}].camera = {0};
  }
  return block;
}

const std::vector<ImageId> kSources = {{0}, {1}};

bool accepts_seamlines(std::string_view bytes) {
  static const Block block = two_images();
  const auto seamlines = read_seamlines(file_of(bytes, "a.gpkg"), block, kSources, "");
  if (!seamlines) return false;
  for (const SeamPolygon& polygon : *seamlines) {
    COLLINEA_CHECK(polygon.source >= 1 && polygon.source <= kSources.size() && !polygon.rings.empty());
    for (const MapRing& ring : polygon.rings) COLLINEA_CHECK(ring.size() >= 3);
  }
  return true;
}

std::string seamlines_seed() {
  const MapRing square = {{0, 0}, {0, 10}, {10, 10}, {10, 0}}, hole = {{2, 2}, {3, 2}, {3, 3}};
  const std::filesystem::path path = folder() / "seed.gpkg";
  const bool written =
      write_seamlines(path, {{1, {square, hole}}, {2, {hole}}}, two_images(), kSources, "").has_value();
  return written ? bytes_of(path) : "";
}

}  // namespace

std::vector<Target> project_targets() {
  return {{"project_json", accepts_settings, settings_seeds()}, {"geopackage", accepts_seamlines, {seamlines_seed()}}};
}

}  // namespace collinea::fuzz
