// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/camera/camera.h"
#include "collinea/camera/film_transformation.h"

namespace collinea {

/// What a fiducial mark looks like.
enum class MarkKind { kCross, kDot, kRing, kCorner, kNotch };
inline constexpr Word<MarkKind> kMarkKindWords[] = {
    {MarkKind::kCross, "cross", "two lines that cross in the mark"},
    {MarkKind::kDot, "dot", "a disc about the mark"},
    {MarkKind::kRing, "ring", "a circle about the mark"},
    {MarkKind::kCorner, "corner", "two lines from the mark, to the inside of the photograph"},
    {MarkKind::kNotch, "notch", "a wedge in the frame whose tip is the mark"}};
[[nodiscard]] constexpr std::span<const Word<MarkKind>> words(MarkKind) { return kMarkKindWords; }

/// A fiducial mark of a calibration, in image coordinates of the film: x right, y up.
struct CalibratedMark {
  std::string name;
  Eigen::Vector2d film_mm = Eigen::Vector2d::Zero();
  double sigma_mm = 0;  ///< of each coordinate
  std::optional<MarkKind> kind = {};
  MarkCoordinates coordinates = MarkCoordinates::kBoth;  ///< the other is about where the mark is, to find it
};

/// The calibration of a film camera. Image coordinates count from the point that the marks count from, mostly the
/// intersection of the lines between opposite ones.
struct FilmCalibration {
  std::string camera;                ///< type and number: for people
  double principal_distance_mm = 0;  ///< calibrated
  /// The principal point of autocollimation (PPA), foot of the perpendicular from the projection centre, and that of
  /// symmetry (PPS), from which the distortion counts.
  Eigen::Vector2d principal_point_mm = Eigen::Vector2d::Zero(), symmetry_point_mm = Eigen::Vector2d::Zero();
  /// The correction of the lens, added to measured coordinates x, y [mm] that count from the PPS, r^2 = x^2 + y^2:
  ///     x (k0 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 x^2) + 2 p2 x y, and so on for y
  /// It is minus the distortion.
  std::array<double, 4> radial{};
  std::array<double, 2> decentring{};
  double radial_rms_mm = 0;  ///< by which a radial table differs from the polynomial above
  std::vector<CalibratedMark> marks;
  Eigen::Vector2d size_mm = {230, 230};  ///< of the film, to find marks in scans
  /// The part of the film that shows nothing but the scene, about the origin; nothing: what the marks leave of it,
  /// film_image_size().
  std::optional<Eigen::Vector2d> image_size_mm = {};
  double mark_size_mm = 1, line_mm = 0.1;
};

/// Width and height [mm] of the largest rectangle about the origin that no mark reaches into: of the stated one,
/// else of the film without its outer 2 %.
[[nodiscard]] Eigen::Vector2d film_image_size(const FilmCalibration& calibration);

/// The inverse of corrected_mm(), by fixed point, to 1e-9 mm of lenses that distort by less than a tenth.
[[nodiscard]] Eigen::Vector2d distorted_mm(const FilmCalibration& calibration, const Eigen::Vector2d& corrected_mm);

/// Image coordinates without the distortion of the lens, from the principal point: -c times the camera coordinates over
/// their z in the form of the books.
[[nodiscard]] Eigen::Vector2d corrected_mm(const FilmCalibration& calibration, const Eigen::Vector2d& film_mm);

/// The polynomial k0 .. k3 (as many as there are radii) that fits distances Dr [mm] at radii [mm] by least squares:
/// Dr = k0 r + k1 r^3 + k2 r^5 + k3 r^7. Nothing without radii, of negative ones or of twice the same where that leaves
/// too few.
[[nodiscard]] std::optional<std::array<double, 4>> fit_radial(std::span<const double> radii_mm,
                                                              std::span<const double> distances_mm);

/// The camera whose pixels are mm of the film, y down: project() and normalized() of (x, -y). Its lens is
/// BrownOfMeasured, whose one centre is the PPA; the distance of the PPS from it changes the correction by less than
/// that distance times the slope of the distortion (10 um: some nm).
[[nodiscard]] Camera film_camera(const FilmCalibration& calibration);

/// The camera whose pixels are those of a scan.
struct ScanCamera {
  Camera camera;
  double rotation_rad = 0;  ///< point_in_scan_camera = Rz(rotation) point_in_film_camera: part of kappa
};
/// The same image coordinates as by way of the film: affinity and shear of the film become those of the camera. Nothing
/// for a projective transformation and a mirrored scan, which no camera has: these are to be resampled.
[[nodiscard]] std::optional<ScanCamera> scan_camera(const FilmCalibration& calibration,
                                                    const FilmTransformation& scan_from_film);

}  // namespace collinea
