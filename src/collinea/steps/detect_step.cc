// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <atomic>

#include "collinea/base/hash.h"
#include "collinea/base/parallel.h"
#include "collinea/import/reason.h"
#include "collinea/raster/photo.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

struct Outcome {
  std::string hash;    ///< of the picture and the options; empty: could not be read
  std::string reason;  ///< why not
  std::size_t features = 0;
  Result<> stored;
};

using Images = std::vector<std::pair<ImageId, const Image*>>;

// The fingerprint of a picture and the options.
Result<std::string> made_from(const Project& project, const Image& image) {
  return hash_of_file(project.photo(image)).map([&](std::uint64_t file_hash) {
    return Hash().add(COLLINEA_VERSION).add(options_text(project.settings, "detect")).add(file_hash).hex();
  });
}

// Images are numbered in the order of their names: a photograph that was added or taken away changes the numbers of
// others, and their features must follow them. Returns the fingerprints of the images.
Result<std::vector<Result<std::string>>> hand_on(Project& project, const Images& images) {
  COLLINEA_TRY(const auto done, project.store.features_done());
  std::vector<Result<std::string>> wanted(images.size());
  parallel_for(project.run, images.size(), [&](std::size_t i) { wanted[i] = made_from(project, *images[i].second); });
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

Outcome detect_one(Project& project, ImageId id, const Image& image, const Result<std::string>& wanted,
                   const std::map<ImageId, std::string>& done) {
  Outcome outcome;
  const auto path = project.photo(image);
  const auto before = done.find(id);
  const auto leave_out = [&](const Error& error) {
    Outcome out{.reason = reason_without_name(error.message, path)};
    if (before != done.end()) out.stored = project.store.erase_features(id);
    return out;
  };
  if (!wanted) return leave_out(wanted.error());
  outcome.hash = *wanted;
  if (before != done.end() && before->second == outcome.hash) {
    if (const auto count = project.store.count_features(id)) {
      outcome.features = *count;
      return outcome;
    }
  }
  const auto picture = read_grey(path);
  if (!picture) return leave_out(picture.error());
  const Features features = detect_sift(*picture, project.settings.detect);
  outcome.features = features.keypoints.size();
  outcome.stored = project.store.write_features(id, features, outcome.hash);
  return outcome;
}

}  // namespace

Result<StepOutput> detect_step(Project& project, const std::string&) {
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  Images images;
  for (const auto& [id, image] : setup.images) images.emplace_back(id, &image);
  COLLINEA_TRY(auto done, project.store.features_done());
  const bool anew = done.empty();  // then each picture is read only when its turn has come
  std::vector<Result<std::string>> wanted;
  if (!anew) {
    COLLINEA_TRY(wanted, hand_on(project, images));
    COLLINEA_TRY(done, project.store.features_done());
  }

  std::vector<Outcome> outcomes(images.size());
  std::atomic<std::size_t> finished = 0;
  std::atomic<bool> hopeless = false;  // a full disk, say: what remains to be done would be lost too
  parallel_for(project.run, images.size(), [&](std::size_t i) {
    if (hopeless) return;
    const auto& [id, image] = images[i];
    outcomes[i] = detect_one(project, id, *image, anew ? made_from(project, *image) : wanted[i], done);
    if (!outcomes[i].stored) hopeless = true;
    project.run.report("detect", double(++finished) / double(images.size()));
  });
  if (project.run.stopped()) return fail(Errc::kCancelled, "stopped; the same command goes on from here");

  Hash output;
  DetectRecord record;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Outcome& outcome = outcomes[i];
    if (!outcome.stored) return tl::unexpected(outcome.stored.error());
    output.add(outcome.hash);
    record.features += outcome.features;
    record.images += !outcome.hash.empty();
    if (!outcome.reason.empty()) {
      record.skipped.push_back(finding_of(FindingCode::kImageUnreadable, {images[i].first}, {}, {}, outcome.reason));
      project.run.say(fmt::format("skipped {}: {}", images[i].second->file, outcome.reason));
    }
  }
  if (record.images < 2) return fail(Errc::kBadInput, "fewer than two photographs could be read");
  return StepOutput{output.hex(), record};
}

}  // namespace collinea
