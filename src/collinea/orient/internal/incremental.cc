// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/incremental.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr int kInitialPairsTried = 30;
constexpr int kMinInitialPoints = 40;
constexpr double kEnoughParallax_rad = 8 * std::numbers::pi / 180;
constexpr double kGlobalGrowth = 1.2;  // a global adjustment each time the block has grown by this factor
constexpr std::size_t kImagesToCalibrate = 3;
constexpr int kMaxFailures = 3;  // resections of one image before it is left for good

// Support counts only as far as it comes with parallax; beyond some degrees more parallax does not help.
double worth_as_start(const ImagePair& pair) {
  if (pair.geometry != PairGeometry::kGeneral && pair.geometry != PairGeometry::kPlanar) return 0;
  const double parallax = std::min(1.0, pair.median_parallax_rad / kEnoughParallax_rad);
  const double planar = pair.geometry == PairGeometry::kPlanar ? 0.3 : 1.0;  // weak relative orientation
  return planar * parallax * std::sqrt(static_cast<double>(std::min<std::size_t>(pair.matches.size(), 2000)));
}

bool is_start(const ImagePair& pair, const std::set<ImageId>& exclude) {
  return worth_as_start(pair) > 0 && !exclude.contains(pair.first) && !exclude.contains(pair.second);
}

std::vector<const ImagePair*> initial_pairs(std::span<const ImagePair> pairs, const std::set<ImageId>& exclude) {
  std::vector<const ImagePair*> sorted;
  for (const ImagePair& pair : pairs)
    if (is_start(pair, exclude)) sorted.push_back(&pair);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ImagePair* a, const ImagePair* b) { return worth_as_start(*a) > worth_as_start(*b); });
  if (sorted.size() > kInitialPairsTried) sorted.resize(kInitialPairsTried);
  return sorted;
}

// While the block grows, what is adjusted now is adjusted again: a coarse minimum is enough.
AdjustOptions growing(Calibration calibration, int max_iterations) {
  return {.calibration = calibration, .max_iterations = max_iterations, .relative_cost_change = 1e-3};
}

// What a young block is adjusted with: the fewer images, the fewer camera parameters, because bad matches are still
// among the good.
Calibration young_calibration(const OrientOptions& options, std::size_t images) {
  if (options.calibration) return *options.calibration;
  if (images < 3) return Calibration::kNone;
  if (images < 5) return Calibration::kFocal;
  if (images < 8) return Calibration::kFocalRadial;
  return Calibration::kBrown;
}

class Grower {
 public:
  Grower(Reconstruction& reconstruction, std::span<const ImagePair> pairs, const std::set<ImageId>& exclude,
         const OrientOptions& options, const Run& run)
      : block_(reconstruction), pairs_(pairs), exclude_(exclude), options_(options), run_(run) {}

  Result<> grow() {
    if (!block_.poses().empty()) {
      images_at_global_ = static_cast<double>(block_.poses().size());
      stuck_ = true;  // it was adjusted as a whole: no need to do so before an image is added
    } else if (!start()) {
      return run_.stopped() ? fail(Errc::kCancelled, "stopped") : Result<>{};
    }
    for (;;) {
      if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
      if (add_next_image()) {
        run_.report("orient", double(block_.poses().size()) / double(std::max<std::size_t>(1, total())));
        const auto due = static_cast<std::size_t>(std::max(images_at_global_ + 1.0, images_at_global_ * kGlobalGrowth));
        if (block_.poses().size() >= due) COLLINEA_TRY(global(1));
        continue;
      }
      if (block_.poses().size() == images_at_global_ && stuck_) break;  // nothing new since the last full clean-up
      stuck_ = true;
      COLLINEA_TRY(global(2));
    }
    return {};
  }

 private:
  [[nodiscard]] std::size_t total() const { return block_.images_with_tracks().size() - exclude_.size(); }

  bool start() {
    for (const ImagePair* pair : initial_pairs(pairs_, exclude_)) {
      if (run_.stopped()) break;
      block_.forget();
      if (block_.start(pair->first, pair->second, pair->second_from_first) < kMinInitialPoints) continue;
      const auto adjusted = block_.adjust_all(
          growing(Calibration::kNone, 20), {.use_positions = false, .use_control = false, .use_geodetic = false}, run_);
      if (!adjusted) continue;
      block_.filter(options_.max_error_px, run_);
      if (block_.point_count() < kMinInitialPoints) continue;
      images_at_global_ = 2;
      return true;
    }
    block_.forget();
    return false;
  }

  // The image best covered by the points there are; one that fails waits until the block has grown.
  bool add_next_image() {
    std::vector<std::pair<double, ImageId>> candidates;
    for (const ImageId image : block_.images_with_tracks()) {
      if (block_.oriented(image) || exclude_.contains(image)) continue;
      const auto failed = failures_.find(image);
      if (failed != failures_.end() &&
          (failed->second.times >= kMaxFailures || failed->second.block_size == block_.poses().size()))
        continue;
      const auto [coverage, unknown] = coverage_.try_emplace(image);
      if (unknown) coverage->second = block_.coverage(image);
      if (coverage->second.points >= options_.min_points) candidates.push_back({coverage->second.score, image});
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [score, image] : candidates) {
      if (run_.stopped()) return false;
      if (block_.orient_image(image, run_.seed)) {
        block_.extend(image);
        for (const ImageId neighbour : block_.images_around(image)) coverage_.erase(neighbour);
        if (!block_.adjust_around(image, local_options(), run_)) {
          block_.drop_image(image);
        } else {
          stuck_ = false;
          return true;
        }
      }
      auto& failure = failures_[image];
      ++failure.times;
      failure.block_size = block_.poses().size();
    }
    return false;
  }

  Result<> global(int rounds) {
    for (int round = 0; round < rounds; ++round) {
      const AdjustOptions adjust = growing(young_calibration(options_, block_.poses().size()), 20);
      if (auto adjusted =
              block_.adjust_all(adjust, {.use_positions = false, .use_control = false, .use_geodetic = false}, run_);
          !adjusted)
        return tl::unexpected(adjusted.error());
      block_.filter(options_.max_error_px, run_);
      block_.extend_all(run_);
    }
    coverage_.clear();
    images_at_global_ = static_cast<double>(block_.poses().size());
    return {};
  }

  [[nodiscard]] AdjustOptions local_options() const { return growing(Calibration::kNone, 8); }

  struct Failure {
    int times = 0;
    std::size_t block_size = 0;
  };
  Reconstruction& block_;
  std::span<const ImagePair> pairs_;
  const std::set<ImageId>& exclude_;
  const OrientOptions& options_;
  const Run& run_;
  std::map<ImageId, Failure> failures_;
  std::map<ImageId, Reconstruction::Coverage> coverage_;  ///< as far as no point of it has come or gone
  double images_at_global_ = 0;
  bool stuck_ = false;
};

}  // namespace

Result<> grow(Reconstruction& reconstruction, std::span<const ImagePair> pairs, const std::set<ImageId>& exclude,
              const OrientOptions& options, const Run& run) {
  return Grower(reconstruction, pairs, exclude, options, run).grow();
}

bool can_start(std::span<const ImagePair> pairs, const std::set<ImageId>& exclude) {
  return std::any_of(pairs.begin(), pairs.end(), [&](const ImagePair& pair) { return is_start(pair, exclude); });
}

AdjustOptions settled_options(const Reconstruction& reconstruction, const OrientOptions& options) {
  const bool calibrates = reconstruction.poses().size() >= kImagesToCalibrate;
  return {.calibration = options.calibration.value_or(calibrates ? Calibration::kBrown : Calibration::kNone),
          .loss = reconstruction.noise().loss,
          .loss_scale_sigmas = reconstruction.noise().loss_scale_sigmas,
          .position_loss_scale_sigmas = 3};  // whatever the noise of tie points is
}

Result<Adjusted> settle(Reconstruction& reconstruction, const AdjustScope& scope, const OrientOptions& options,
                        bool learn_noise, const Run& run) {
  constexpr int kRounds = 5;
  constexpr double kSettled = 1e-3;      // share of rays that came or went
  constexpr double kNoiseSettled = 0.2;  // change of their sigmas
  for (int round = 1;; ++round) {
    AdjustOptions adjust = settled_options(reconstruction, options);
    adjust.relative_cost_change = 1e-4;
    adjust.first_damping = kSettledDamping;
    COLLINEA_TRY(Adjusted adjusted, reconstruction.adjust_all(adjust, scope, run));
    const int removed = reconstruction.filter(options.max_error_px, run);
    const int added = reconstruction.extend_all(run);
    reconstruction.drop_loose(options.min_points);
    if (reconstruction.poses().size() < 2)
      return fail(Errc::kIllPosed, fmt::format("no two images keep {} tie points that fit", options.min_points));
    const auto shown = learn_noise ? reconstruction.shown_noise() : std::nullopt;
    const TieNoise& noise = reconstruction.noise();
    const double change = shown ? std::max(std::abs(shown->sigma_px / noise.sigma_px - 1),
                                           std::abs(shown->anew_factor / noise.anew_factor - 1))
                                : 0;
    const bool settled = removed + added < kSettled * static_cast<double>(adjusted.residuals_px.size());
    if ((settled && change < kNoiseSettled) || round == kRounds) return adjusted;
    if (shown) reconstruction.set_noise(*shown);
  }
}

}  // namespace collinea
