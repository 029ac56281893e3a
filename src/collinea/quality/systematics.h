// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/base/words.h"
#include "collinea/block/block.h"
#include "collinea/block/instrument_options.h"
#include "collinea/camera/additional.h"

namespace collinea {

/// Errors that many observations have in common. Each is a hypothesis: a few parameters that the adjustment does not
/// have.
enum class SystematicKind : std::uint8_t {
  kTimeOffset,     ///< positions were taken later than the images of a camera [s]
  kLeverArm,       ///< antenna from the projection centre of a camera: right, down, forward [m]
  kShift,          ///< of all positions, or of those of a strip [m]
  kDrift,          ///< of positions from the first to the last image of the flight or of a strip [m]
  kBoresight,      ///< rotation between the attitudes that are given and a camera, about its axes [rad]
  kVerticalDatum,  ///< heights of positions count from elsewhere than those of control [m]
  kAssignment,     ///< positions belong to the next (the value is near 1) or previous (near -1) image of the flight [1]
  kBowl,        ///< heights of the block against given ones, over the squared distance from its middle: at its rim [m]
  kAffinity,    ///< b1, b2 of a camera: scale of its columns and shear [px]
  kAdditional,  ///< a set of additional parameters of a camera [px]
  kRollingShutter,  ///< rows of a camera are read one after another while it flies: readout time of an image [s]
  kRefraction,      ///< share of the bend of rays in a standard atmosphere that the measurements still have [1]
};
inline constexpr Word<SystematicKind> kSystematicKindWords[] = {{SystematicKind::kTimeOffset, "time_offset"},
                                                                {SystematicKind::kLeverArm, "lever_arm"},
                                                                {SystematicKind::kShift, "shift"},
                                                                {SystematicKind::kDrift, "drift"},
                                                                {SystematicKind::kBoresight, "boresight"},
                                                                {SystematicKind::kVerticalDatum, "vertical_datum"},
                                                                {SystematicKind::kAssignment, "assignment"},
                                                                {SystematicKind::kBowl, "bowl"},
                                                                {SystematicKind::kAffinity, "affinity"},
                                                                {SystematicKind::kAdditional, "additional"},
                                                                {SystematicKind::kRollingShutter, "rolling_shutter"},
                                                                {SystematicKind::kRefraction, "refraction"}};
[[nodiscard]] constexpr std::span<const Word<SystematicKind>> words(SystematicKind) { return kSystematicKindWords; }

/// What becomes of systematic errors that are found.
enum class Systematics : std::uint8_t { kAuto, kName, kNone };
inline constexpr Word<Systematics> kSystematicsWords[] = {
    {Systematics::kAuto, "auto", "name them, and estimate those of instruments"},
    {Systematics::kName, "name"},
    {Systematics::kNone, "none", "do not look for them"}};
[[nodiscard]] constexpr std::span<const Word<Systematics>> words(Systematics) { return kSystematicsWords; }

/// What is looked for, and what is known of the flight.
struct SystematicOptions {
  bool test = false;
  double level = 0.001;       ///< chance that any hypothesis is called significant in a block without systematic errors
  bool sigma0_known = false;  ///< the sigmas of image points are true; otherwise sigma0 multiplies them
  std::vector<std::map<ImageId, double>> strips;  ///< in the order flown, each image with its time; see flight_strips()
  std::map<ImageId, Eigen::Vector3d> velocity_m_s;  ///< of the antenna through the world; see flight_velocities()
  bool refraction_corrected = false;                ///< measurements are free of refraction (adjust/refraction.h)
};

/// The outcome for one hypothesis.
struct SystematicTest {
  SystematicKind kind{};
  std::optional<CameraId> camera;                   ///< whose it is; nothing: of all
  std::optional<int> strip;                         ///< number in SystematicOptions::strips; nothing: the whole flight
  AdditionalSet additional = AdditionalSet::kNone;  ///< of kAdditional
  std::vector<double> values;                       ///< estimates, as if this were the only systematic error
  std::vector<double> sigmas;                       ///< their standard deviations; infinite for what is not determined
  std::string_view unit;                            ///< of both
  double statistic = 0;                             ///< chi-squared if there is no such error
  int degrees = 0;                                  ///< its degrees of freedom: parameters that are determined
  double p_value = 1;                               ///< chance of a statistic as large by accident
  double p_corrected = 1;                           ///< the same, for the number of hypotheses (Holm 1979)
  double largest_effect = 0;                        ///< on what is observed; of a deformation of images: on residuals,
                                                    ///< when all unknowns have followed
  std::string_view effect_unit;     ///< "m" at positions and control, "px" in images, "rad" of attitudes
  double ground_change_m = 0;       ///< by how much the points would move, at most, if it were estimated
  double ground_change_sigmas = 0;  ///< the same in standard deviations of the position of that point
  bool determined = false;          ///< all parameters are
  /// The largest of a parameter with all unknowns of the adjustment and the other parameters; see kInseparable.
  double multiple_correlation = 1;
  bool significant = false;  ///< p_corrected is below the level
  /// Test with the strongest evidence that leaves nothing significant of this one: this is probably its shadow. Nothing
  /// when it stands for itself.
  std::optional<std::size_t> explained_by;
  std::vector<std::size_t> indistinguishable;  ///< tests that explain the same on this block, ascending; without itself
};

/// How large p_value may be at most for an error to be taken up without being asked for.
inline constexpr double kTakenUpBelow = 1e-6;

/// Limit of a (multiple) correlation beyond which the value of a parameter says nothing by itself: its standard
/// deviation is then seven times what it would be alone.
inline constexpr double kInseparable = 0.99;

/// The options with the most significant error of an instrument among the tests also estimated: a time offset, a lever
/// arm or a shift that is determined, below kTakenUpBelow and not explained by another test; of those that cannot be
/// told from it that with the fewest parameters. One at a time, since the next adjustment judges the others anew: call
/// until nothing changes. `current` where there is none.
[[nodiscard]] InstrumentOptions taken_up(const std::vector<SystematicTest>& tests, const InstrumentOptions& current);

/// The most significant deformation of the images of one of these cameras, an affinity or additional parameters, that
/// is beyond doubt (as above) and moves a point by a standard deviation or more; of those that cannot be told from it
/// that with the fewest parameters. Each parameter has to be separable (kInseparable) from all else: what a camera
/// shares with the shape of the block would bend it by all that no model has. Its number among the tests; nothing where
/// there is none.
[[nodiscard]] std::optional<std::size_t> deformation_taken_up(const std::vector<SystematicTest>& tests,
                                                              const std::set<CameraId>& cameras);

/// Whether a test is of a stronger error than another one: what stands for itself comes before what is explained.
[[nodiscard]] bool is_stronger(const SystematicTest& a, const SystematicTest& b);

}  // namespace collinea
