// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <nlohmann/json.hpp>
#include <set>

#include "collinea/base/hash.h"
#include "collinea/base/parallel.h"
#include "collinea/pipeline/feature_cache.h"
#include "collinea/pipeline/json_text.h"
#include "collinea/pipeline/step.h"

namespace collinea {
namespace {

constexpr std::size_t kCachedImages = 200;  // about 1.3 MB each
constexpr std::size_t kBatch = 32;          // pairs written at once: what a kill can cost

using Ids = ImageIdPair;

Result<ImagePair> match_pair(const Project& project, const Block& setup, FeatureCache& cache, Ids ids) {
  COLLINEA_TRY(const auto first, cache.of(ids.first));
  COLLINEA_TRY(const auto second, cache.of(ids.second));
  const auto putative = match_descriptors(first->descriptors, second->descriptors, project.settings.match);
  const std::uint64_t seed = Hash().add(project.run.seed).add(ids.first.value).add(ids.second.value).value();
  ImagePair pair = verify(setup.camera_of(ids.first), first->keypoints, setup.camera_of(ids.second), second->keypoints,
                          putative, project.settings.verify, seed);
  pair.first = ids.first;
  pair.second = ids.second;
  pair.putative = static_cast<int>(putative.size());
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
