// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/simulated_project.h"

#include <fmt/format.h>

#include <map>
#include <mutex>
#include <utility>

#include "collinea/base/hash.h"
#include "collinea/base/units.h"
#include "collinea/epipolar/two_view.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/internal/import_record.h"
#include "collinea/steps/step.h"
#include "collinea/synthetic/matches.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

constexpr const char* kHash = "simulated";
constexpr std::size_t kBatch = 1024;  // pairs in work at once

// What import would know: nominal cameras, positions with the errors of a receiver, control; no poses.
Block setup_of(const Truth& truth) {
  Block setup = truth.block;
  clear_poses(setup);
  for (auto& [id, camera] : setup.cameras) {
    const Camera exact = camera;
    camera = ideal_camera(truth.nominal_focal_px, exact.width_px, exact.height_px);
    camera.model = exact.model;
    camera.prior.sigma_f_px = kExifFocalSigma * truth.nominal_focal_px;
    camera.name = exact.name;
    camera.prior.source = Provenance::kSimulated;
  }
  return setup;
}

Result<> write_features(Project& project, const SimulatedMatches& matches) {
  std::size_t features = 0;
  for (const auto& [image, keypoints] : matches.keypoints) {
    features += keypoints.size();
    if (auto done = project.store.write_features(image, {keypoints, std::vector<Descriptor>(keypoints.size())}, kHash);
        !done)
      return done;
  }
  return record_done(project, {kHash, DetectRecord{.images = matches.keypoints.size(), .features = features}});
}

// Each pair is verified with the cameras as import knows them, as the step match does.
Result<> write_pairs(Project& project, const Block& setup, SimulatedMatches& matches) {
  MatchRecord record{.pairs = matches.pairs.size()};
  UnitList list{.stage = "pairs"};
  for (const ImagePair& putative : matches.pairs) list.units.push_back(Unit::pair(putative.first, putative.second));
  std::map<std::size_t, ImagePair> fresh;  // of a batch
  std::mutex mutex;
  const auto work = [&](std::size_t i, const Run&) -> Result<UnitWorked> {
    const ImagePair& putative = matches.pairs[i];
    ImagePair pair =
        verify(setup.camera_of(putative.first), matches.keypoints.at(putative.first), setup.camera_of(putative.second),
               matches.keypoints.at(putative.second), putative.matches, project.settings.verify, project.run.seed + i);
    pair.first = putative.first;
    pair.second = putative.second;
    pair.putative = putative.putative;
    const std::lock_guard lock(mutex);
    fresh.emplace(i, std::move(pair));
    return UnitWorked{};
  };
  const auto keep = [&] {
    std::vector<ImagePair> pairs;
    for (auto& [i, pair] : std::exchange(fresh, {})) {
      record.pairs_by_geometry.add(pair.geometry);
      record.matches += pair.matches.size();
      pairs.push_back(std::move(pair));
    }
    return project.store.write_pairs(pairs, kHash);
  };
  COLLINEA_TRY(run_units(project.run, list, {.work = work, .batch = kBatch, .keep = keep}));
  project.run.say(fmt::format("{} of {} pairs verified", record.pairs_by_geometry.verified(), record.pairs));
  return record_done(project, {kHash, record});
}

}  // namespace

Result<> simulate_project(const SurveyOptions& survey, const ObservationOptions& observations,
                          const std::filesystem::path& folder, const Run& run) {
  COLLINEA_TRY(validate(observations));
  COLLINEA_TRY(const Truth truth, make_survey(survey, run));
  std::error_code error;
  std::filesystem::create_directories(folder / "images", error);
  std::filesystem::create_directories(folder / "truth", error);
  if (error) return fail(Errc::kNotFound, folder.string() + ": cannot be made: " + error.message());
  COLLINEA_TRY(write_tables(truth, folder));
  Settings settings;
  settings.photos = std::filesystem::absolute(folder / "images").string();
  COLLINEA_TRY(Project project, create_project(folder, settings, run));
  COLLINEA_TRY(project.store.erase_pairs_except(kHash));

  const Block setup = setup_of(truth);
  COLLINEA_TRY(project.store.write_setup(setup));
  COLLINEA_TRY(record_done(project, {kHash, record_of(setup)}));
  ObservationOptions seeded = observations;
  seeded.seed = truth.seed;
  COLLINEA_TRY(const Block seen, observations_only(truth, seeded, run));
  run.say(fmt::format("{} points, {:.1f} images each, {:.0f} features an image", seen.points.size(),
                      double(seen.observations.size()) / double(seen.points.size()),
                      double(seen.observations.size()) / double(seen.images.size())));
  SimulatedMatches matches = simulated_matches(seen, seeded, std::size_t(settings.verify.min_inliers), run);
  COLLINEA_TRY(write_features(project, matches));
  return write_pairs(project, setup, matches);
}

}  // namespace collinea
