// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <bit>
#include <numbers>

#include "collinea/base/hash.h"
#include "collinea/base/units.h"
#include "collinea/report/finding_words.h"
#include "collinea/steps/internal/edited_record.h"
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

// The ideal images of scans of film, FOLDER/film/NAME.jpg: what all further steps work on.
Result<> write_film(const Project& project, const Imported& imported) {
  const ImportedFilm& film = *imported.film;
  UnitList list{.stage = "film"};
  for (const auto& [id, scan] : film.scans) list.units.push_back(Unit::of(UnitKind::kImage, id));
  const auto work = [&](std::size_t i, const Run& run) -> Result<UnitWorked> {
    const Image& image = imported.block.images.at(list.units[i].image());
    const std::filesystem::path out = project.image_file(image);
    std::error_code error;
    std::filesystem::create_directories(out.parent_path(), error);
    if (error) return fail(Errc::kNotFound, out.parent_path().string() + ": cannot be made: " + error.message());
    COLLINEA_TRY(write_ideal_image(std::filesystem::path(project.settings.photos) / image.file,
                                   film.scans.at(list.units[i].image()).scan_from_film(), film.ideal, out, run));
    return UnitWorked{};
  };
  COLLINEA_TRY(run_units(project.run, list, {.work = work}));
  return {};
}

std::vector<FilmScanRecord> film_records(const Imported& imported) {
  std::vector<FilmScanRecord> records;
  for (const auto& [id, scan] : imported.film->scans) {
    FilmScanRecord record{.image = imported.block.images.at(id).file,
                          .model = std::string(word_of(scan.scan_from_film().model)),
                          .marks = scan.marks,
                          .misread = scan.misread(),
                          .rms_um = 1e3 * scan.rms_mm(),
                          .pixel_um = 1e3 * scan.pixel_mm(),
                          .rotation_deg = scan.scan_from_film().parameters[2] * 180 / std::numbers::pi};
    if (scan.deformation) {
      record.difference_ppm = scan.deformation->difference_ppm.value;
      record.shear_ppm = scan.deformation->shear_ppm.value;
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace

Result<StepOutput> import_step(Project& project, const std::string&) {
  COLLINEA_TRY(const Imported imported, import_images(project.settings.photos, project.settings.import, project.run));
  Journal journal(project.folder);
  COLLINEA_TRY(const std::vector<UnfitEdit> unfit, write_setup_with_edits(project.store, imported.block, journal));

  ImportRecord record = record_of(imported.block);
  if (imported.film) {
    COLLINEA_TRY(write_film(project, imported));
    record.film = film_records(imported);
  }
  record.findings = imported.findings;
  if (journal.number() > 0) {
    COLLINEA_TRY(record, with_edits(std::move(record), project.store, unfit));
  }
  record.skipped = imported.skipped;
  for (const Finding& one : imported.skipped)
    project.run.say(
        fmt::format("skipped {}: {}", words_of(one.subjects[0], imported.block), reason_of(one, imported.block)));
  COLLINEA_TRY(const Block setup, project.store.read_setup_for_names());
  for (const Finding& finding : record.findings)
    project.run.say("note: " + sentence_of(finding, setup, project.run.spelling));
  return StepOutput{hash_of_images(imported), record};
}

}  // namespace collinea
