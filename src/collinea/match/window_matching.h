// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

// Least squares matching of a window of one image in another (Ackermann 1984; Gruen 1985; Mussio 7.4, 7.5, A.12, A.14,
// A.15): position, map and light such that grey values differ least, with standard deviations that are those of the
// real errors. docs/theory/least-squares-matching.md.
namespace collinea {

/// How the window may lie in the other image: at position + map * (offset from the point).
enum class WindowModel { kTranslation, kLine, kScale, kSimilarity, kAffine };
inline constexpr Word<WindowModel> kWindowModelWords[] = {
    {WindowModel::kTranslation, "translation", "x, y"},
    {WindowModel::kLine, "line", "a shift along a given line, as the epipolar line"},
    {WindowModel::kScale, "scale", "x, y and a scale"},
    {WindowModel::kSimilarity, "similarity", "x, y, scale and rotation"},
    {WindowModel::kAffine, "affine", "x, y and the four elements of an affine map"}};
constexpr std::span<const Word<WindowModel>> words(WindowModel) { return kWindowModelWords; }

/// What light may differ by: grey there = gain * grey here + offset.
enum class WindowLight { kSame, kOffset, kGainOffset };
inline constexpr Word<WindowLight> kWindowLightWords[] = {
    {WindowLight::kSame, "same", "nothing"},
    {WindowLight::kOffset, "offset", "brightness"},
    {WindowLight::kGainOffset, "gain_offset", "brightness and contrast"}};
constexpr std::span<const Word<WindowLight>> words(WindowLight) { return kWindowLightWords; }

struct WindowOptions {
  WindowModel model = WindowModel::kAffine;
  WindowLight light = WindowLight::kGainOffset;
  int window_px = 21;
  bool robust = false;
  double farthest_px = 3;
  double least_correlation = 0.7;
  double largest_sigma_px = 0.25;

  friend bool operator==(const WindowOptions&, const WindowOptions&) = default;

  /// Of all but the model, which the caller asks for by a name of its own.
  template <class Visit>
  static void describe(Visit&& visit) {
    using O = WindowOptions;
    visit(Field{"light", &O::light, "", "what light may differ by between the images"});
    visit(Field{"window_px", &O::window_px, "px", "side of the window, odd", 7, 101});
    visit(Field{"robust", &O::robust, "",
                "leaves out what does not belong to the rest, as a part of the window that something hides"});
    visit(Field{"farthest_px", &O::farthest_px, "px", "so far from its start a position may move", 0, 50});
    visit(Field{"least_correlation", &O::least_correlation, "1", "of a window with what it is matched with", 0, 1});
    visit(Field{"largest_sigma_px", &O::largest_sigma_px, "px",
                "largest standard deviation of a position, in its worst direction", 0, 10});
  }
};

enum class WindowOutcome {
  kFound,
  kOutside,       ///< the window does not lie in its image, or at its start not in the other
  kNoTexture,     ///< the grey values do not determine what the model has free, or not well enough
  kLeftImage,     ///< moving, the window left the other image
  kDiverged,      ///< moved farther than allowed, or its map changed by more than a half
  kNotConverged,  ///< still moving after the last iteration
  kUnlike,        ///< correlates by less than asked for, or dark is bright
  kOccluded,      ///< robust: more than half of the window does not belong to the rest
  kNotReturned,   ///< matched back it comes to another position
  kOffLine,       ///< area matching found it too far from its epipolar line
};
inline constexpr Word<WindowOutcome> kWindowOutcomeWords[] = {
    {WindowOutcome::kFound, "found"},
    {WindowOutcome::kOutside, "outside", "the window does not lie in its image"},
    {WindowOutcome::kNoTexture, "no_texture", "the grey values do not determine what is unknown"},
    {WindowOutcome::kLeftImage, "left_image", "moving, the window left the right image"},
    {WindowOutcome::kDiverged, "diverged", "the window moved or was stretched too far"},
    {WindowOutcome::kNotConverged, "not_converged", "the window still moved after the last iteration"},
    {WindowOutcome::kUnlike, "unlike", "the windows are not alike"},
    {WindowOutcome::kOccluded, "occluded", "most of the window does not belong to the rest"},
    {WindowOutcome::kNotReturned, "not_returned", "matched back it comes to another position"},
    {WindowOutcome::kOffLine, "off_line", "area matching found it too far from its epipolar line"}};
constexpr std::span<const Word<WindowOutcome>> words(WindowOutcome) { return kWindowOutcomeWords; }

/// Where about the window lies in the other image.
struct WindowStart {
  Eigen::Vector2d position_px;
  Eigen::Matrix2d map = Eigen::Matrix2d::Identity();
  Eigen::Vector2d line{1, 0};  ///< of the model kLine: its direction, through position_px
};

using WindowParameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1>;
using WindowCovariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 8, 8>;

struct WindowMatch {
  WindowOutcome outcome = WindowOutcome::kOutside;
  // What follows holds where it is kFound.
  Eigen::Vector2d position_px{0, 0};
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  ///< of the position; of kLine of rank 1
  Eigen::Matrix2d map = Eigen::Matrix2d::Identity();
  double gain = 1, offset_grey = 0;
  WindowParameters parameters;  ///< as window_parameter_names
  WindowCovariance covariance;  ///< of them
  double noise_grey = 0;        ///< sigma 0: standard deviation of the noise of a pixel of either image
  double correlation = 0;
  double redundancy = 0;  ///< pixels used less unknowns
  double share_used = 1;  ///< of the window; less where robust matching left something out
  int iterations = 0;
};

/// Names of the parameters: of the position x, y [px] (kLine: along [px], from the start); scale (against the map of
/// the start); a, b (the map is [a -b; b a] times that of the start); xx, xy, yx, yy (the map); gain; offset [grey].
[[nodiscard]] std::vector<std::string_view> window_parameter_names(WindowModel model, WindowLight light);

/// The position in `right` of what `left` shows at left_px. Both images count with equal, white noise in their pixels,
/// whose size comes from the residuals; what interpolation makes of it is followed exactly.
/// Cost: 21 x 21 pixels, affine, gain and offset: some 50 microseconds.
[[nodiscard]] WindowMatch match_window(const GreyImage& left, const Eigen::Vector2d& left_px, const GreyImage& right,
                                       const WindowStart& start, const WindowOptions& options);

}  // namespace collinea
