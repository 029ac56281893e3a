// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/mirrored.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "collinea/orient/internal/resection.h"
#include "collinea/quality/mark_check.h"

namespace collinea {
namespace {

constexpr double kLoosePart = 0.1;  // of the image's width: a lens may be known badly beforehand
constexpr int kLeastMarks = 4;
constexpr double kTimesBetter = 3, kNoWorse = 0.8;  // ratio of residuals, as given to otherwise
constexpr double kLeast_px = 0.3;                   // residuals below do not count as smaller
constexpr double kMisfit_px = 3;                    // and below nothing is wrong
constexpr double kMostImages = 0.8;                 // that stand beneath their points, or above

constexpr MarkSystem kTried[] = {MarkSystem::kRowsUp, MarkSystem::kExchanged, MarkSystem::kCentre,
                                 MarkSystem::kCentreRowsUp};

struct MarkedImage {
  const Camera* camera = nullptr;
  std::vector<Eigen::Vector2d> given;
  std::vector<Eigen::Vector3d> positions;
};

std::vector<MarkedImage> images_with_control(const Block& block) {
  std::map<ImageId, MarkedImage> images;
  for (const ControlObservation& seen : block.control_observations) {
    const ControlPoint& control = block.control.at(seen.point);
    if (control.role != ControlRole::kControl || !control.sigma_m.allFinite()) continue;
    MarkedImage& image = images[seen.image];
    image.camera = &block.camera_of(seen.image);
    image.given.push_back(seen.pixel);
    image.positions.push_back(control.position_in_world);
  }
  std::vector<MarkedImage> enough;
  for (auto& [id, image] : images)
    if (image.given.size() >= kLeastMarks) enough.push_back(std::move(image));
  return enough;
}

// How the images fit control under one system.
struct Fit {
  int resected = 0, beneath = 0, above = 0;  // images; beneath and above all of their points
  std::vector<double> rms_px;                // infinite of those that are not resected
  double total_px = 0;

  [[nodiscard]] bool mostly(int count) const { return count >= kMostImages * double(rms_px.size()); }
};

void add_image(const MarkedImage& image, MarkSystem system, std::uint64_t seed, Fit& fit) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector2d& given : image.given) pixels.push_back(pixel_of({system, 1}, *image.camera, given));
  const ResectOptions options{.max_error_px = kLoosePart * std::max(image.camera->width_px, image.camera->height_px),
                              .min_inliers = kLeastMarks,
                              .min_inlier_ratio = 1};
  const auto found = resect(*image.camera, pixels, image.positions, options, seed);
  fit.rms_px.push_back(found ? found->rms_px : options.max_error_px);
  if (!found) return;
  ++fit.resected;
  const auto [low, high] = std::ranges::minmax(image.positions, {}, [](const auto& p) { return p.z(); });
  const double z = centre_of(found->cam_from_world).z();
  fit.beneath += z < low.z();
  fit.above += z > high.z();
}

Fit fit_of(const std::vector<MarkedImage>& images, MarkSystem system, std::uint64_t seed) {
  Fit fit;
  for (const MarkedImage& image : images) add_image(image, system, seed, fit);
  double squared = 0;
  for (const double rms : fit.rms_px) squared += rms * rms / double(fit.rms_px.size());
  fit.total_px = std::sqrt(squared);
  return fit;
}

std::vector<Finding> by_resection(const Block& block, std::uint64_t seed) {
  const std::vector<MarkedImage> images = images_with_control(block);
  if (images.empty()) return {};
  const Fit as_given = fit_of(images, MarkSystem::kAsGiven, seed);
  const bool is_beneath = as_given.mostly(as_given.beneath), misses = as_given.total_px > kMisfit_px;
  if (!is_beneath && !misses) return {};
  std::optional<Finding> best;
  double best_px = 0;
  for (const MarkSystem system : kTried) {
    const Fit fit = fit_of(images, system, seed);
    const double ratio = as_given.total_px / std::max(fit.total_px, kLeast_px);
    const bool fits_better = misses && ratio > kTimesBetter;
    const bool stands_better =
        is_beneath && fit.mostly(fit.above) && fit.total_px < std::max(as_given.total_px / kNoWorse, kMisfit_px);
    if ((!fits_better && !stands_better) || (best && best_px <= fit.total_px)) continue;
    int count = 0;
    for (std::size_t i = 0; i < images.size(); ++i) count += fit.rms_px[i] < as_given.rms_px[i];
    best_px = fit.total_px;
    best = finding_of(FindingCode::kMarksMirrored, {},
                      {{FigureName::kCount, double(count)},
                       {FigureName::kOf, double(images.size())},
                       {FigureName::kOffsetPx, fit.total_px},
                       {FigureName::kRatio, ratio}},
                      {RemedyCode::kCorrectMarks}, std::string(word_of(system)));
    if (!fits_better) best->severity = Severity::kWeak;
  }
  return best ? std::vector{*best} : std::vector<Finding>{};
}

// Tie points beside control: what their rays say of them does not depend on what is known of them.
std::vector<Finding> by_rays(const Block& block) {
  Block probe = block;
  probe.points.clear();
  probe.observations.clear();
  std::uint32_t next = 0;
  for (const auto& [id, point] : block.control) next = std::max(next, id.value + 1);
  for (const Observation& seen : block.observations)
    probe.control_observations.push_back(
        {ControlId{next + seen.point.value}, seen.image, seen.pixel, seen.sigma_px, seen.shape});
  std::vector<Finding> findings = check_marks(probe).findings;
  std::erase_if(findings, [](const Finding& one) { return one.code == FindingCode::kMarksCorrected; });
  return findings;
}

}  // namespace

std::vector<Finding> mirrored_measurements(const Block& block, std::uint64_t seed) {
  if (count_oriented(block) >= 2)
    if (std::vector<Finding> found = by_rays(block); !found.empty()) return found;
  return by_resection(block, seed);
}

}  // namespace collinea
