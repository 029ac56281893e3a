// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "collinea/base/hash.h"
#include "collinea/project/json_text.h"
#include "collinea/steps/step.h"

namespace collinea {

namespace {

// What detection and matching depend on: the pictures, their cameras and places, but neither control nor the map.
std::string hash_of_pictures(const Imported& imported) {
  Hash hash;
  const auto add = [&](double value) { hash.add(std::bit_cast<std::uint64_t>(value)); };
  for (const std::string& file_hash : imported.file_hash) hash.add(file_hash);
  for (const auto& [id, camera] : imported.block.cameras) {
    for (std::size_t k = 0; k < Camera::kK4; ++k) add(camera.params[k]);
    add(camera.prior.sigma_f_px);
    if (!is<Brown>(camera.model)) add(double(camera.model.index())), add(camera.params[Camera::kK4]);
  }
  for (const auto& [id, image] : imported.block.images) {
    hash.add(image.file).add(image.camera.value).add(image.taken);
    if (!image.position) continue;
    add(image.position->latitude_deg);
    add(image.position->longitude_deg);
    add(image.position->height_m);
  }
  return hash.hex();
}

}  // namespace

Result<StepOutput> import_step(Project& project, const std::string&) {
  COLLINEA_TRY(const Imported imported, import_photos(project.settings.photos, project.settings.import, project.run));
  COLLINEA_TRY(project.store.write_setup(imported.block));

  nlohmann::json report = {{"findings", imported.findings}, {"skipped", nlohmann::json::array()}};
  for (const SkippedPhoto& photo : imported.skipped) {
    report["skipped"].push_back({{"file", photo.file}, {"reason", photo.reason}});
    project.run.say(fmt::format("skipped {}: {}", photo.file, photo.reason));
  }
  for (const std::string& finding : imported.findings) project.run.say("note: " + finding);

  std::size_t positions = 0;
  for (const auto& [id, image] : imported.block.images) positions += image.position.has_value();
  const Block& block = imported.block;
  return StepOutput{
      hash_of_pictures(imported), json_text(report),
      fmt::format("{} images, {} camera{}, {} positions, {} control points{}{}", block.images.size(),
                  block.cameras.size(), block.cameras.size() == 1 ? "" : "s", positions, block.control.size(),
                  block.ground.empty() ? "" : fmt::format(", {} measurements on the ground", block.ground.size()),
                  block.georeference ? ", map " + block.georeference->crs : ", no map: local gauge")};
}

}  // namespace collinea
