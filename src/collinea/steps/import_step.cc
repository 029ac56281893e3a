// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <bit>

#include "collinea/base/hash.h"
#include "collinea/report/finding_words.h"
#include "collinea/steps/internal/import_record.h"
#include "collinea/steps/step.h"

namespace collinea {

namespace {

// What detection and matching depend on: the images, their cameras and positions, but neither control nor the map.
std::string hash_of_images(const Imported& imported) {
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
  COLLINEA_TRY(const Imported imported, import_images(project.settings.photos, project.settings.import, project.run));
  COLLINEA_TRY(project.store.write_setup(imported.block));

  ImportRecord record = record_of(imported.block);
  record.findings = imported.findings;
  record.skipped = imported.skipped;
  for (const Finding& one : imported.skipped)
    project.run.say(
        fmt::format("skipped {}: {}", words_of(one.subjects[0], imported.block), reason_of(one, imported.block)));
  for (const Finding& finding : imported.findings)
    project.run.say("note: " + sentence_of(finding, imported.block, project.run.spelling));
  return StepOutput{hash_of_images(imported), record};
}

}  // namespace collinea
