// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/base/parallel.h"
#include "collinea/base/shared_budget.h"
#include "collinea/base/units.h"
#include "collinea/edit/read_work.h"
#include "collinea/import/reason.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

// What images that are looked at side by side may take together; a larger one is looked at alone.
std::size_t most_bytes() { return std::max<std::size_t>(1'000'000'000, usable_memory() / 16); }

struct Detected {
  std::string hash;  ///< of the image and the options; empty: it could not be read
  std::size_t features = 0;
};

using Images = std::vector<std::pair<ImageId, const Image*>>;

// The fingerprint of an image with its masks and the options.
Result<std::string> made_from(const Project& project, const Image& image, const MaskRings* masks) {
  return hash_of_file(project.image_file(image)).map([&](std::uint64_t file_hash) {
    Hash hash;
    hash.add(COLLINEA_VERSION).add(options_text(project.settings, "detect")).add(file_hash);
    if (masks) hash.add(masks->text());
    return hash.hex();
  });
}

// Images are numbered in the order of their names: an image that was added or taken away changes the numbers of
// others, and their features must follow them. Returns the fingerprints of the images.
Result<std::vector<Result<std::string>>> hand_on(Project& project, const Images& images, const ImageMasks& masks) {
  COLLINEA_TRY(const auto done, project.store.features_done());
  std::vector<Result<std::string>> wanted(images.size());
  parallel_for(project.run, images.size(),
               [&](std::size_t i) { wanted[i] = made_from(project, *images[i].second, masks.of(images[i].first)); });
  if (project.run.stopped()) return fail(Errc::kCancelled, "stopped");
  std::map<std::string, ImageId> owner;
  for (const auto& [id, hash] : done) owner.emplace(hash, id);
  std::map<ImageId, ImageId> new_from_old;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const ImageId id = images[i].first;
    if (!wanted[i] || (done.contains(id) && done.at(id) == *wanted[i])) continue;
    if (const auto found = owner.find(*wanted[i]); found != owner.end()) new_from_old.emplace(found->second, id);
  }
  COLLINEA_TRY(project.store.renumber_features(new_from_old));
  return wanted;
}

// Features that are stored already: those of the image as it is, by the options as they are.
bool is_kept(const Project& project, ImageId id, const Result<std::string>& wanted,
             const std::map<ImageId, std::string>& done, Detected& detected) {
  const auto before = done.find(id);
  if (!wanted || before == done.end() || before->second != *wanted) return false;
  const auto count = project.store.count_features(id);
  if (!count) return false;
  detected = {*wanted, *count};
  return true;
}

void leave_out(const MaskRings& masks, Features& features) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    if (masks.hides({double(keypoint.x), double(keypoint.y)})) continue;
    features.keypoints[kept] = keypoint;
    features.descriptors[kept++] = features.descriptors[i];
  }
  features.keypoints.resize(kept);
  features.descriptors.resize(kept);
}

// An image that cannot be read is skipped, and features that an earlier file of its name had are erased.
Result<UnitWorked> detect_one(Project& project, ImageId id, const Image& image, const MaskRings* masks,
                              const Result<std::string>& wanted, bool has_features, Detected& detected) {
  const auto path = project.image_file(image);
  const auto skip = [&](Error error) -> Result<UnitWorked> {
    error.message = reason_without_name(error.message, path);
    if (has_features) COLLINEA_TRY(project.store.erase_features(id));
    return UnitWorked{std::move(error)};
  };
  if (!wanted) return skip(wanted.error());
  const auto raster = read_grey(path);
  if (!raster) return skip(raster.error());
  Features features = detect_features(*raster, project.settings.detect);
  if (masks) leave_out(*masks, features);
  detected = {*wanted, features.keypoints.size()};
  COLLINEA_TRY(project.store.write_features(id, features, detected.hash));
  return UnitWorked{};
}

Result<StepOutput> output_of(const Project& project, const Images& images, const UnitsDone& units,
                             const std::vector<Detected>& detected) {
  Hash output;
  DetectRecord record;
  for (const Detected& one : detected) {
    output.add(one.hash);
    record.features += one.features;
    record.images += !one.hash.empty();
  }
  for (const auto& [i, error] : units.skipped_because) {
    record.skipped.push_back(finding_of(FindingCode::kImageUnreadable, {images[i].first}, {}, {}, error.message));
    project.run.say(fmt::format("skipped {}: {}", images[i].second->file, error.message));
  }
  if (record.images < 2) return fail(Errc::kBadInput, "fewer than two photographs could be read");
  return StepOutput{output.hex(), record};
}

}  // namespace

Result<StepOutput> detect_step(Project& project, const std::string&) {
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  COLLINEA_TRY(const ImageMasks masks, read_masks(project));
  Images images;
  for (const auto& [id, image] : setup.images) images.emplace_back(id, &image);
  COLLINEA_TRY(auto done, project.store.features_done());
  const bool anew = done.empty();  // then each image is read only when its turn has come
  std::vector<Result<std::string>> wanted;
  if (!anew) {
    COLLINEA_TRY(wanted, hand_on(project, images, masks));
    COLLINEA_TRY(done, project.store.features_done());
  }

  UnitList list{.stage = "detect"};
  for (const auto& [id, image] : images) list.units.push_back(Unit::of(UnitKind::kImage, id));
  std::vector<Detected> detected(images.size());
  SharedBudget memory(most_bytes());
  const UnitJob job{
      .is_done =
          [&](std::size_t i) { return !anew && is_kept(project, images[i].first, wanted[i], done, detected[i]); },
      .work =
          [&](std::size_t i, const Run&) {
            const auto& [id, image] = images[i];
            const Camera& camera = setup.cameras.at(image->camera);
            const auto part = memory.take(bytes_to_detect(camera.width_px, camera.height_px, project.settings.detect));
            const MaskRings* hidden = masks.of(id);
            return detect_one(project, id, *image, hidden, anew ? made_from(project, *image, hidden) : wanted[i],
                              done.contains(id), detected[i]);
          }};
  COLLINEA_TRY(const UnitsDone units, run_units(project.run, list, job));
  say_kept(project.run, list, units);
  return output_of(project, images, units, detected);
}

}  // namespace collinea
