// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/ground_match.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/match/multi_image_matching.h"
#include "collinea/raster/cubic.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A part of an epipolar image, with the camera that sees it.
struct EpipolarWindow {
  GreyImage grey;
  Camera camera;
  int left_px = 0, top_px = 0;  // in the epipolar image
};

// The part of width x height pixels about (x, y): each of its pixels where the photograph shows it.
class PartReader {
 public:
  PartReader(const Camera& photo_camera, const Eigen::Quaterniond& epipolar_from_image, const Camera& epipolar)
      : camera_(photo_camera), image_from_epipolar_(epipolar_from_image.conjugate()), epipolar_(epipolar) {}

  [[nodiscard]] Result<EpipolarWindow> read(ImageId image, const PhotoWindow& photo, double x, double y, int width,
                                            int height) const {
    EpipolarWindow part{GreyImage(width, height), epipolar_, int(std::floor(x)) - width / 2,
                        int(std::floor(y)) - height / 2};
    part.camera.width_px = width, part.camera.height_px = height;
    part.camera.params[Camera::kCx] -= part.left_px;
    part.camera.params[Camera::kCy] -= part.top_px;
    std::vector<Vector2d> at;
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::max()), high = -low;
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i) {
        at.push_back(pixel_at(part.left_px + i + 0.5, part.top_px + j + 0.5));
        if (!at.back().allFinite() || !inside(camera_, at.back())) continue;
        low = low.cwiseMin(at.back());
        high = high.cwiseMax(at.back());
      }
    if (!(high.x() >= low.x())) return fail(Errc::kBadInput, "a photograph does not show the mark");
    const PixelWindow window = window_about(low, high);
    COLLINEA_TRY(const FloatImage grey, photo(image, window));
    GreyImage rounded(grey.width, grey.height);
    std::ranges::transform(grey.data, rounded.data.begin(),
                           [](float value) { return std::uint8_t(std::clamp(value + 0.5f, 0.0f, 255.0f)); });
    for (std::size_t i = 0; i < at.size(); ++i)
      if (at[i].allFinite())
        part.grey.data[i] = std::uint8_t(cubic_at(rounded, at[i] - Vector2d(window.left + 0.5, window.top + 0.5)));
    return part;
  }

 private:
  [[nodiscard]] Vector2d pixel_at(double x, double y) const {
    const Vector3d ray((x - epipolar_.params[Camera::kCx]) / epipolar_.focal_px(),
                       (y - epipolar_.params[Camera::kCy]) / epipolar_.focal_px(), 1);
    return project(camera_, image_from_epipolar_ * ray)
        .value_or(Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }

  [[nodiscard]] PixelWindow window_about(const Vector2d& low, const Vector2d& high) const {
    constexpr int kReach_px = 3;  // of the interpolation
    const int left = std::max(int(low.x()) - kReach_px, 0), top = std::max(int(low.y()) - kReach_px, 0);
    const int right = std::min(int(high.x()) + kReach_px + 1, camera_.width_px);
    const int bottom = std::min(int(high.y()) + kReach_px + 1, camera_.height_px);
    return {left, top, right - left, bottom - top};
  }

  static int cubic_at(const GreyImage& image, const Vector2d& sample) {
    return cubic<1>(image, float(sample.x()), float(sample.y()));
  }

  const Camera& camera_;
  Eigen::Quaterniond image_from_epipolar_;
  const Camera& epipolar_;
};

/// What the window of one epipolar image shows, found in the other.
struct Found {
  double parallax_px = 0, sigma_px = 0, correlation = 0;
};

// The right camera of the pair: as the left, moved along the base.
Rigid3 right_from_world(const EpipolarPair& pair) {
  Rigid3 pose = pair.left_from_world;
  pose.translation.x() -= pair.base_m;
  return pose;
}

Result<Found> find(const StereoGeometry& model, const std::array<EpipolarWindow, 2>& parts, std::size_t reference,
                   const StereoMark& start, int search_px, const GroundMatchOptions& options) {
  const auto position = model.position_in_world(start);
  if (!position) return fail(Errc::kBadInput, "the mark lies behind the cameras");
  const OrientedView views[] = {{&parts[0].grey, &parts[0].camera, model.pair.left_from_world},
                                {&parts[1].grey, &parts[1].camera, right_from_world(model.pair)}};
  const double x = reference == 0 ? start.x : start.x - start.parallax;
  const Vector2d pixel(x - parts[reference].left_px, start.y - parts[reference].top_px);
  const MultiImagePoint point = match_in_images(
      views, reference, pixel, *position,
      {.window_px = options.window_px, .refine_search_px = search_px, .least_correlation = options.least_correlation});
  if (point.outcome != MultiImageOutcome::kFound) {
    for (const auto& word : words(point.outcome))
      if (word.value == point.outcome)
        return fail(Errc::kNotConverged, "not set on the ground: " + std::string(word.meaning));
  }
  const auto mark = model.mark_at(point.point_in_world);
  if (!mark) return fail(Errc::kNotConverged, "not set on the ground: it lies behind the cameras");
  // By the depth: parallax = infinity + f b / z, so d parallax / d z = f b / z^2.
  const Vector3d axis = model.pair.left_from_world.rotation.conjugate() * Vector3d::UnitZ();
  const double depth = (model.pair.left_from_world * point.point_in_world).z();
  const double per_m = model.pair.left.focal_px() * model.pair.base_m / (depth * depth);
  const double variance = axis.dot(point.covariance * axis);
  return Found{mark->parallax, per_m * std::sqrt(std::max(variance, 0.0)), point.views[1 - reference].correlation};
}

// Whether both photographs show the window about a mark: at its corners.
bool is_shown(const Block& block, const StereoGeometry& model, const StereoMark& mark, int window_px) {
  const double half = window_px / 2.0;
  for (const auto& [dx, dy] : {std::pair(-half, -half), {half, -half}, {-half, half}, {half, half}})
    if (!model.pixels_of(block, {mark.x + dx, mark.y + dy, mark.parallax})) return false;
  return true;
}

}  // namespace

double GroundMatch::mark_sigma_px() const { return sigma_px / std::numbers::sqrt2; }

Result<GroundMatch> match_ground(const Block& block, const StereoGeometry& model, const StereoMark& mark,
                                 const PhotoWindow& photo, const GroundMatchOptions& options) {
  if (options.window_px % 2 == 0)
    return fail(Errc::kBadInput, "the side of the window that is matched is odd", {"window_px"_option});
  if (!is_shown(block, model, mark, options.window_px))
    return fail(Errc::kBadInput, "the mark with its window is not in both photographs");
  // The window, twice as wide where it is stretched, and the search.
  const int height = 2 * options.window_px + 9, width = height + 2 * options.search_px;
  const EpipolarPair& pair = model.pair;
  std::array<EpipolarWindow, 2> parts;
  const PartReader left(block.camera_of(model.left), pair.left_from_image, pair.left);
  const PartReader right(block.camera_of(model.right), pair.right_from_image, pair.right);
  COLLINEA_TRY(parts[0], left.read(model.left, photo, mark.x, mark.y, width, height));
  COLLINEA_TRY(parts[1], right.read(model.right, photo, mark.x - mark.parallax, mark.y, width, height));
  COLLINEA_TRY(const Found there, find(model, parts, 0, mark, options.search_px, options));
  const StereoMark set{mark.x, mark.y, there.parallax_px};
  COLLINEA_TRY(const Found back, find(model, parts, 1, set, 3, options));
  const double sigma = std::hypot(std::max(there.sigma_px, back.sigma_px), kResampling_px);
  constexpr double kSure = 3.29;  // 0.1 %, of the difference of two
  if (!(std::abs(back.parallax_px - there.parallax_px) <= kSure * std::numbers::sqrt2 * sigma))
    return fail(Errc::kNotConverged, "not set on the ground: matched back it comes to another place");
  if (!is_shown(block, model, set, options.window_px))
    return fail(Errc::kNotConverged, "not set on the ground: its window leaves a photograph there");
  const auto position = model.position_in_world(set);
  const auto pixels = model.pixels_of(block, set);
  if (!position || !pixels) return fail(Errc::kNotConverged, "not set on the ground: a photograph does not show it");
  return GroundMatch{set, sigma, there.correlation, *position, *pixels};
}

}  // namespace collinea
