// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace collinea {

/// Which way the polynomial of the distortion goes.
enum class CameraModel : std::uint8_t {
  kBrown,            ///< from where the point would be seen to where it is seen
  kBrownOfMeasured,  ///< from where it is seen to where it would be: corrections of measured coordinates
};
inline constexpr std::array<std::string_view, 2> kCameraModelNames = {"brown", "brown_of_measured"};

/// The interior orientation of a camera with one lens and one focus setting: central projection with the distortion of
/// Brown (1971) and the affinity and shear of the sensor. The polynomial D of the distortion is, with
/// r2 = x^2 + y^2,
///     radial = k1 r2 + k2 r2^2 + k3 r2^3
///     D(x, y) = (x + x radial + p1 (r2 + 2 x^2) + 2 p2 x y,
///                y + y radial + p2 (r2 + 2 y^2) + 2 p1 x y)
/// The measured coordinates (xd, yd) of a point X, Y, Z of the camera frame follow from
///     kBrown:            (xd, yd) = D(X/Z, Y/Z)
///     kBrownOfMeasured:  D(xd, yd) = (X/Z, Y/Z)
/// and the pixel from them:
///     column = cx + f xd + b1 xd + b2 yd,   row = cy + f yd
/// Pixel convention: the centre of the upper-left pixel is (0.5, 0.5). Camera frame: x right, y down, z forward.
struct Camera {
  enum Param : int { kF, kCx, kCy, kK1, kK2, kK3, kP1, kP2, kB1, kB2, kParams };
  static constexpr std::array<std::string_view, kParams> kParamNames = {"f",  "cx", "cy", "k1", "k2",
                                                                        "k3", "p1", "p2", "b1", "b2"};
  static constexpr std::array<std::string_view, kParams> kParamUnits = {"px", "px", "px", "1",  "1",
                                                                        "1",  "1",  "1",  "px", "px"};

  std::array<double, kParams> params{};
  CameraModel model = CameraModel::kBrown;
  int width_px = 0;
  int height_px = 0;
  std::string name;       ///< maker, model, serial: for people
  double sigma_f_px = 0;  ///< of the focal length before adjustment; 0 = held fixed
  bool calibrate = true;  ///< false: all parameters are given and held fixed
  std::string source;     ///< where the first focal length came from: "EXIF 35 mm equivalent", "assumed", "given", ...

  [[nodiscard]] double focal_px() const { return params[kF]; }
};

/// A camera without distortion whose principal point is the middle of the image.
[[nodiscard]] Camera ideal_camera(double focal_px, int width_px, int height_px);

/// Where a point of the camera frame is seen [px]; nothing when it lies behind the camera or so far outside the field
/// of view that the distortion polynomial folds back (its radial derivative is no longer positive). Where the
/// polynomial is one of measured coordinates it is inverted by Newton iteration, to rounding.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam);

using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix2P = Eigen::Matrix<double, 2, Camera::kParams>;

/// The same, with the derivatives of the pixel by the point and by the camera's parameters.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam,
                                                     Matrix23* by_point, Matrix2P* by_params);

/// The undistorted image coordinates (X/Z, Y/Z) of a pixel: the inverse of project. For kBrown by Newton iteration, to
/// 1e-10 and better inside the image for lenses whose distortion does not fold back; outside that domain the nearest
/// the iteration comes. For kBrownOfMeasured the polynomial itself.
[[nodiscard]] Eigen::Vector2d normalized(const Camera& camera, const Eigen::Vector2d& pixel);

/// The unit direction of a pixel in the camera frame.
[[nodiscard]] Eigen::Vector3d ray_in_cam(const Camera& camera, const Eigen::Vector2d& pixel);

/// True when the pixel lies on the picture: [0, width] x [0, height].
[[nodiscard]] inline bool inside(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width_px && pixel.y() <= camera.height_px;
}

}  // namespace collinea
