// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "collinea/base/hash.h"
#include "collinea/base/units.h"
#include "collinea/epipolar/guide.h"
#include "collinea/match/descriptors.h"
#include "collinea/match/partners.h"
#include "collinea/match/retrieval.h"
#include "collinea/steps/internal/image_cache.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

constexpr std::size_t kCachedImages = 200;    // about 1.3 MB each
constexpr std::size_t kCachedClosure = 1000;  // keypoints alone: about 0.2 MB each
constexpr std::size_t kBatch = 32;            // pairs written at once: what a kill can cost
constexpr std::size_t kBatchPerThread = 8;    // the last of a batch are waited for
constexpr std::size_t kClosureBatch = 256;
constexpr std::size_t kClosureMatches = 200;
constexpr int kJoiningRounds = 3;

constexpr std::size_t kLeastScouts = 1000;  // features from which a guide is sought; fewer are soon matched as they are

using Ids = ImageIdPair;

struct Sight {
  const Camera& camera;
  std::span<const Keypoint> keypoints;
};

struct MatchImage {
  const Camera& camera;
  const Features& features;

  [[nodiscard]] Sight sight() const { return {camera, features.keypoints}; }

  [[nodiscard]] std::span<const Descriptor> strongest(std::size_t count) const {
    return std::span(features.descriptors).first(std::min(count, features.descriptors.size()));
  }
};

ImagePair verify_images(const Sight& first, const Sight& second, std::span<const Match> putative,
                        const VerifyOptions& options, std::uint64_t seed) {
  ImagePair pair = verify(first.camera, first.keypoints, second.camera, second.keypoints, putative, options, seed);
  pair.putative = static_cast<int>(putative.size());
  return pair;
}

// The strongest features find the epipolar geometry; all are then looked for near their epipolar lines. Nothing where
// the strongest do not fix the geometry.
std::optional<ImagePair> match_guided(const MatchImage& first, const MatchImage& second, std::size_t scouts,
                                      const Settings& settings, std::uint64_t seed) {
  const ImagePair sketch = verify_images(
      first.sight(), second.sight(),
      match_descriptors(first.strongest(scouts), second.strongest(scouts), settings.match), settings.verify, seed);
  const auto near =
      guide(first.camera, first.features.keypoints, second.camera, second.features.keypoints, sketch, settings.verify);
  if (!near) return std::nullopt;
  // Near the line a rival is looked for among a hundredth of the features only, and a wrong match is not found out by
  // the geometry: it must be the more distinct.
  MatchOptions strict = settings.match;
  strict.max_ratio *= strict.max_ratio;
  const auto putative =
      match_among(first.features.descriptors, second.features.descriptors, near->begin, near->candidates, strict);
  ImagePair pair = verify_images(first.sight(), second.sight(), putative, settings.verify, seed);
  if (pair.matches.size() < sketch.matches.size()) return std::nullopt;
  return pair;
}

// With a guide, found from a quarter of the features or a half, or without.
ImagePair match_images(const MatchImage& first, const MatchImage& second, const Settings& settings,
                       std::uint64_t seed) {
  const std::size_t count = std::min(first.features.keypoints.size(), second.features.keypoints.size());
  for (const std::size_t part : {4, 2})
    if (count / part >= kLeastScouts)
      if (auto pair = match_guided(first, second, count / part, settings, seed)) return *std::move(pair);
  return verify_images(first.sight(), second.sight(),
                       match_descriptors(first.features.descriptors, second.features.descriptors, settings.match),
                       settings.verify, seed);
}

// Searches, verifies and stores pairs, and knows all that are stored.
class Matcher {
 public:
  Matcher(Project& project, const Block& setup, std::string inputs_hash)
      : project_(project),
        setup_(setup),
        inputs_hash_(std::move(inputs_hash)),
        features_([this](ImageId image) { return project_.store.read_features(image); }, kCachedImages),
        keypoints_([this](ImageId image) { return project_.store.read_keypoints(image); }, kCachedClosure) {}

  Result<> load() {
    COLLINEA_TRY(std::vector<ImagePair> stored, project_.store.read_pairs());
    for (ImagePair& pair : stored) pairs_[{pair.first, pair.second}] = std::move(pair);
    return {};
  }

  /// Searches all features of those pairs that are not stored yet, which are the part of the progress from `begin` to
  /// `end`.
  Result<> search(const std::vector<Ids>& wanted, double begin, double end) {
    searched_.insert(wanted.begin(), wanted.end());
    return each_missing(wanted, begin, end, [&](std::size_t i) { return searched_pair(wanted[i]); });
  }

  /// Verifies matches that are known already.
  Result<> verify_known(const std::vector<SharedTracks>& wanted, double begin, double end) {
    std::vector<Ids> ids;
    for (const SharedTracks& pair : wanted) ids.push_back(pair.images);
    return each_missing(ids, begin, end, [&](std::size_t i) { return verified_pair(ids[i], wanted[i].matches); });
  }

  [[nodiscard]] const std::set<Ids>& searched() const { return searched_; }
  /// The pairs searched so far that hold; until the next search.
  [[nodiscard]] std::vector<const ImagePair*> verified() const {
    std::vector<const ImagePair*> list;
    for (const Ids& ids : searched_)
      if (const ImagePair& pair = pairs_.at(ids); pair.geometry != PairGeometry::kNone) list.push_back(&pair);
    return list;
  }
  [[nodiscard]] const std::map<Ids, ImagePair>& pairs() const { return pairs_; }
  void say_kept() const { collinea::say_kept(project_.run, "match", UnitKind::kPair, kept_, listed_); }

 private:
  Result<ImagePair> searched_pair(Ids ids) {
    COLLINEA_TRY(const auto first, features_.of(ids.first));
    COLLINEA_TRY(const auto second, features_.of(ids.second));
    return with_ids(ids, match_images({setup_.camera_of(ids.first), *first}, {setup_.camera_of(ids.second), *second},
                                      project_.settings, seed_of(ids)));
  }

  Result<ImagePair> verified_pair(Ids ids, const std::vector<Match>& putative) {
    COLLINEA_TRY(const auto first, keypoints_.of(ids.first));
    COLLINEA_TRY(const auto second, keypoints_.of(ids.second));
    return with_ids(ids, verify_images({setup_.camera_of(ids.first), *first}, {setup_.camera_of(ids.second), *second},
                                       putative, project_.settings.verify, seed_of(ids)));
  }

  [[nodiscard]] std::uint64_t seed_of(Ids ids) const {
    return Hash().add(project_.run.seed).add(ids.first.value).add(ids.second.value).value();
  }

  static ImagePair with_ids(Ids ids, ImagePair pair) {
    pair.first = ids.first;
    pair.second = ids.second;
    return pair;
  }

  // Has make(i) done for every pair that is not stored, and stores what it gives.
  Result<> each_missing(const std::vector<Ids>& wanted, double begin, double end,
                        const std::function<Result<ImagePair>(std::size_t)>& make) {
    UnitList list{.stage = "match", .begin = begin, .end = end};
    for (const Ids& ids : wanted) list.units.push_back(Unit::pair(ids.first, ids.second));
    std::map<std::size_t, ImagePair> fresh;  // of a batch, by index in the list
    std::mutex mutex;
    const UnitJob job{.is_done = [&](std::size_t i) { return pairs_.contains(wanted[i]); },
                      .work = [&](std::size_t i, const Run&) -> Result<UnitWorked> {
                        COLLINEA_TRY(ImagePair pair, make(i));
                        const std::lock_guard lock(mutex);
                        fresh.emplace(i, std::move(pair));
                        return UnitWorked{};
                      },
                      .batch = std::max(kBatch, kBatchPerThread * static_cast<std::size_t>(project_.run.threads)),
                      .keep = [&] { return store(std::exchange(fresh, {})); }};
    COLLINEA_TRY(const UnitsDone done, run_units(project_.run, list, job));
    kept_ += done.count(UnitEnd::kKept);
    listed_ += list.units.size();
    return {};
  }

  Result<> store(std::map<std::size_t, ImagePair> fresh) {
    std::vector<ImagePair> pairs;
    for (auto& [i, pair] : fresh) pairs.push_back(std::move(pair));
    COLLINEA_TRY(project_.store.write_pairs(pairs, inputs_hash_));
    for (ImagePair& pair : pairs) pairs_[{pair.first, pair.second}] = std::move(pair);
    return {};
  }

  Project& project_;
  const Block& setup_;
  const std::string inputs_hash_;
  ImageCache<Features> features_;
  ImageCache<std::vector<Keypoint>> keypoints_;
  std::map<Ids, ImagePair> pairs_;
  std::set<Ids> searched_;
  std::size_t kept_ = 0, listed_ = 0;  // pairs of all lists so far
};

Result<std::vector<LookedPair>> first_look(const Project& project, const Block& setup) {
  const PairOptions& options = project.settings.pairs;
  std::vector<ImageId> images;
  for (const auto& [id, image] : setup.images) images.push_back(id);
  const auto features_of = [&](ImageId image) { return project.store.read_features(image); };
  COLLINEA_TRY(const auto glanced, glances(images, features_of, options, project.run));
  COLLINEA_TRY(const std::vector<Ids> similar, similar_pairs(glanced, options, project.run));
  return look(glanced, joined(similar, candidate_pairs(setup, options)), project.run);
}

// Round after round depends on what the earlier ones found, and on nothing else: a run broken off comes to the same.
Result<> search_best_partners(const Project& project, const Block& setup, Matcher& matcher) {
  const PairOptions& options = project.settings.pairs;
  COLLINEA_TRY(const std::vector<LookedPair> looked, first_look(project, setup));
  COLLINEA_TRY(matcher.search(sure_pairs(looked, options), 0.05, 0.45));
  const auto lacking = lacking_pairs(looked, matcher.searched(), merge_tracks(matcher.verified()), options);
  COLLINEA_TRY(matcher.search(lacking, 0.45, 0.8));
  for (int round = 0; round < kJoiningRounds; ++round) {
    std::vector<Ids> verified;
    for (const ImagePair* pair : matcher.verified()) verified.emplace_back(pair->first, pair->second);
    const auto joining = joining_pairs(looked, matcher.searched(), verified, options);
    if (joining.empty()) break;
    const auto part = [](int rounds) { return 0.8 + 0.1 * rounds / kJoiningRounds; };
    COLLINEA_TRY(matcher.search(joining, part(round), part(round + 1)));
  }
  return {};
}

// Evenly chosen: so many fix the geometry of a pair, and the tracks hold all of them anyway.
void thin_out(std::vector<Match>& matches) {
  if (matches.size() <= kClosureMatches) return;
  for (std::size_t i = 0; i < kClosureMatches; ++i) matches[i] = matches[i * matches.size() / kClosureMatches];
  matches.resize(kClosureMatches);
}

// Neighbours of neighbours: what they have in common is known without a search.
Result<> close_over_tracks(const Project& project, Matcher& matcher) {
  const std::vector<Track> tracks = merge_tracks(matcher.verified());
  const TrackIndex index(tracks);
  const auto min_matches = static_cast<std::size_t>(project.settings.verify.min_inliers);
  std::vector<SharedTracks> wanted;
  double part_before = 0.9;
  const std::vector<ImageId> images = index.images();
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (SharedTracks& pair : index.shared_with_later(images[i], min_matches))
      if (!matcher.searched().contains(pair.images)) {
        thin_out(pair.matches);
        wanted.push_back(std::move(pair));
      }
    if (wanted.size() < kClosureBatch && i + 1 < images.size()) continue;
    const double part = 0.9 + 0.1 * double(i + 1) / double(images.size());
    COLLINEA_TRY(matcher.verify_known(wanted, part_before, part));
    part_before = part;
    wanted.clear();
  }
  return {};
}

// The block without the images that have no features: an image that could not be read has no part in any pair.
Result<Block> readable_part(const ProjectStore& store) {
  COLLINEA_TRY(Block setup, store.read_setup());
  COLLINEA_TRY(const auto detected, store.features_done());
  std::erase_if(setup.images, [&](const auto& image) { return !detected.contains(image.first); });
  return setup;
}

MatchRecord record_of(const Matcher& matcher) {
  MatchRecord record{.pairs = matcher.pairs().size(), .pairs_searched = matcher.searched().size()};
  for (const auto& [ids, pair] : matcher.pairs()) {
    record.pairs_by_geometry.add(pair.geometry);
    record.matches += pair.matches.size();
  }
  return record;
}

}  // namespace

Result<StepOutput> match_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block setup, readable_part(project.store));
  COLLINEA_TRY(project.store.erase_pairs_except(inputs_hash));
  Matcher matcher(project, setup, inputs_hash);
  COLLINEA_TRY(matcher.load());
  const PairOptions& options = project.settings.pairs;
  const bool all = all_pairs_wanted(setup, options);
  auto done = all ? matcher.search(all_pairs(setup), 0, 1) : search_best_partners(project, setup, matcher);
  if (done && !all && options.closure) done = close_over_tracks(project, matcher);
  if (!done) return tl::unexpected(done.error());
  matcher.say_kept();
  return StepOutput{inputs_hash, record_of(matcher)};
}

}  // namespace collinea
