// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <nlohmann/json.hpp>
#include <set>

#include "collinea/base/hash.h"
#include "collinea/base/parallel.h"
#include "collinea/epipolar/guide.h"
#include "collinea/match/guided.h"
#include "collinea/pipeline/feature_cache.h"
#include "collinea/pipeline/json_text.h"
#include "collinea/pipeline/step.h"

namespace collinea {
namespace {

constexpr std::size_t kCachedImages = 200;  // about 1.3 MB each
constexpr std::size_t kBatch = 32;          // pairs written at once: what a kill can cost

constexpr std::size_t kLeastScouts = 1000;  // features from which a guide is sought; fewer are soon matched as they are

using Ids = ImageIdPair;

struct Picture {
  const Camera& camera;
  const Features& features;

  [[nodiscard]] std::span<const Descriptor> strongest(std::size_t count) const {
    return std::span(features.descriptors).first(std::min(count, features.descriptors.size()));
  }
};

ImagePair verified(const Picture& first, const Picture& second, std::span<const Match> putative,
                   const VerifyOptions& options, std::uint64_t seed) {
  ImagePair pair =
      verify(first.camera, first.features.keypoints, second.camera, second.features.keypoints, putative, options, seed);
  pair.putative = static_cast<int>(putative.size());
  return pair;
}

// The strongest features find the epipolar geometry; all are then looked for near their epipolar lines. Nothing where
// the strongest do not fix the geometry.
std::optional<ImagePair> match_guided(const Picture& first, const Picture& second, std::size_t scouts,
                                      const Settings& settings, std::uint64_t seed) {
  const ImagePair sketch =
      verified(first, second, match_descriptors(first.strongest(scouts), second.strongest(scouts), settings.match),
               settings.verify, seed);
  const auto near =
      guide(first.camera, first.features.keypoints, second.camera, second.features.keypoints, sketch, settings.verify);
  if (!near) return std::nullopt;
  // Near the line a rival is looked for among a hundredth of the features only, and a wrong match is not found out by
  // the geometry: it must be the more distinct.
  MatchOptions strict = settings.match;
  strict.max_ratio *= strict.max_ratio;
  const auto putative =
      match_among(first.features.descriptors, second.features.descriptors, near->begin, near->candidates, strict);
  ImagePair pair = verified(first, second, putative, settings.verify, seed);
  if (pair.matches.size() < sketch.matches.size()) return std::nullopt;
  return pair;
}

// With a guide, found from a quarter of the features or a half, or without.
ImagePair match_pictures(const Picture& first, const Picture& second, const Settings& settings, std::uint64_t seed) {
  const std::size_t count = std::min(first.features.keypoints.size(), second.features.keypoints.size());
  for (const std::size_t part : {4, 2})
    if (count / part >= kLeastScouts)
      if (auto pair = match_guided(first, second, count / part, settings, seed)) return *std::move(pair);
  return verified(first, second,
                  match_descriptors(first.features.descriptors, second.features.descriptors, settings.match),
                  settings.verify, seed);
}

Result<ImagePair> match_pair(const Project& project, const Block& setup, FeatureCache& cache, Ids ids) {
  COLLINEA_TRY(const auto first_features, cache.of(ids.first));
  COLLINEA_TRY(const auto second_features, cache.of(ids.second));
  const Picture first{setup.camera_of(ids.first), *first_features},
      second{setup.camera_of(ids.second), *second_features};
  const std::uint64_t seed = Hash().add(project.run.seed).add(ids.first.value).add(ids.second.value).value();
  ImagePair pair = match_pictures(first, second, project.settings, seed);
  pair.first = ids.first;
  pair.second = ids.second;
  return pair;
}

Result<> match_batch(Project& project, const Block& setup, FeatureCache& cache, std::span<const Ids> batch,
                     const std::string& inputs_hash) {
  std::vector<Result<ImagePair>> matched(batch.size(), fail(Errc::kCancelled, "stopped"));
  parallel_for(project.run, batch.size(),
               [&](std::size_t i) { matched[i] = match_pair(project, setup, cache, batch[i]); });
  std::vector<ImagePair> pairs;
  for (auto& pair : matched) {
    if (!pair) return tl::unexpected(pair.error());
    pairs.push_back(std::move(*pair));
  }
  return project.store.write_pairs(pairs, inputs_hash);
}

// By position and order; where these say nothing, by a look at the largest features.
Result<std::vector<Ids>> chosen_pairs(const Project& project, const Block& setup) {
  const std::vector<Ids> pairs = select_pairs(setup, project.settings.pairs);
  const std::vector<ImageId> wanted = images_to_preselect(setup, project.settings.pairs);
  if (wanted.empty()) return pairs;
  std::vector<ImageId> all;
  for (const auto& [id, image] : setup.images) all.push_back(id);
  const auto features_of = [&](ImageId image) { return project.store.read_features(image); };
  COLLINEA_TRY(const auto alike, preselect_pairs(wanted, all, features_of, project.settings.preselect, project.run));
  return joined(pairs, alike);
}

// The block without the images that have no features: a picture that could not be read has no part in any pair.
Result<Block> readable_part(const ProjectStore& store) {
  COLLINEA_TRY(Block setup, store.read_setup());
  COLLINEA_TRY(const auto detected, store.features_done());
  std::erase_if(setup.images, [&](const auto& image) { return !detected.contains(image.first); });
  return setup;
}

std::string word(PairGeometry geometry) {
  constexpr std::array<const char*, 4> kWords = {"unrelated", "general", "planar", "rotation"};
  return kWords[static_cast<std::size_t>(geometry)];
}

}  // namespace

Result<StepOutput> match_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block setup, readable_part(project.store));
  if (auto erased = project.store.erase_pairs_except(inputs_hash); !erased) return tl::unexpected(erased.error());
  FeatureCache cache(project.store, kCachedImages);
  COLLINEA_TRY(const std::vector<Ids> wanted, chosen_pairs(project, setup));
  COLLINEA_TRY(const auto done_list, project.store.pairs_done(inputs_hash));
  const std::set<Ids> done(done_list.begin(), done_list.end());
  std::vector<Ids> left;
  std::copy_if(wanted.begin(), wanted.end(), std::back_inserter(left),
               [&](const Ids& ids) { return !done.contains(ids); });

  for (std::size_t start = 0; start < left.size(); start += kBatch) {
    const std::span batch(left.data() + start, std::min(kBatch, left.size() - start));
    if (auto matched = match_batch(project, setup, cache, batch, inputs_hash); !matched)
      return tl::unexpected(matched.error());
    project.run.report("match", double(done.size() + start + batch.size()) / double(wanted.size()));
  }

  COLLINEA_TRY(const std::vector<ImagePair> pairs, project.store.read_pairs());
  std::map<std::string, int> by_geometry;
  std::size_t matches = 0;
  for (const ImagePair& pair : pairs) {
    ++by_geometry[word(pair.geometry)];
    matches += pair.matches.size();
  }
  const nlohmann::json report = {{"pairs", pairs.size()}, {"matches", matches}, {"pairs_by_geometry", by_geometry}};
  const auto verified = pairs.size() - static_cast<std::size_t>(by_geometry["unrelated"]);
  return StepOutput{inputs_hash, json_text(report),
                    fmt::format("{} of {} pairs verified, {} matches", verified, pairs.size(), matches)};
}

}  // namespace collinea
