// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collinea/adjust/calibration.h"
#include "collinea/adjust/place_precision.h"
#include "collinea/adjust/reliability.h"
#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/block/instruments.h"
#include "collinea/math/robust.h"

namespace collinea {

namespace bundle {
class KeptFactor;
}

/// How observations are tested for gross errors, and control by cross-validation.
struct TestOptions {
  double false_alarm = 0.001;
  double power = 0.8;
  bool sigma0_known = false;
  int folds = 5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = TestOptions;
    visit(Field{"false_alarm", &O::false_alarm, "1", "probability that the test of a good observation says blunder",
                1e-12, 0.5});
    visit(Field{"power", &O::power, "1", "probability with which a minimal detectable blunder is found", 0.5, 0.999});
    visit(Field{"sigma0_known", &O::sigma0_known, "",
                "the given sigmas are true: test by Baarda's w; otherwise by Pope's tau"});
    visit(Field{"folds", &O::folds, "1",
                "parts of the control, each left out together and predicted by the others; fewer where a part would "
                "have one point",
                2, 100});
  }
};

/// How a bundle adjustment is done. Observations are whitened by their sigmas; all costs are sums of squares in sigmas.
struct AdjustOptions {
  Calibration calibration = Calibration::kFocalRadial;
  Loss::Kind loss = Loss::kHuber;
  double loss_scale_sigmas = 2;
  Loss::Kind position_loss = Loss::kHuber;
  double position_loss_scale_sigmas = 3;
  int max_iterations = 50;
  double first_damping = 1e-4;
  double relative_cost_change = 1e-7;
  double parameter_change = 1e-9;
  double step_sigmas = 0.05;
  bool covariances = false;
  bool point_covariances = false;
  bool reliability = false;
  TestOptions tests;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = AdjustOptions;
    visit(Field{"calibration", &O::calibration, "", "free camera parameters"});
    visit(Field{"loss", &O::loss, "", "robust loss of tie point observations"});
    visit(
        Field{"loss_scale_sigmas", &O::loss_scale_sigmas, "sigma", "residual from which the loss sets in", 0.01, 1e6});
    visit(Field{"position_loss", &O::position_loss, "", "robust loss of GNSS positions"});
    visit(Field{"position_loss_scale_sigmas", &O::position_loss_scale_sigmas, "sigma",
                "distance from which the loss of positions sets in", 0.01, 1e6});
    visit(Field{"max_iterations", &O::max_iterations, "1", "upper bound of linearisations", 1, 10000});
    visit(Field{"first_damping", &O::first_damping, "1",
                "damping of the first step, over each diagonal element of the normal equations; less where the start "
                "is good",
                1e-12, 1});
    visit(Field{"relative_cost_change", &O::relative_cost_change, "1",
                "stop when a step lowers the cost by a smaller part than this", 0, 1});
    visit(Field{"parameter_change", &O::parameter_change, "1",
                "stop when no image turns by more [rad] nor moves by more of the block's size", 0, 1});
    visit(Field{"step_sigmas", &O::step_sigmas, "sigma",
                "stop when a step of images and cameras is shorter than this many of their standard deviations", 0, 1});
    visit(Field{"covariances", &O::covariances, "", "compute covariances of poses and cameras"});
    visit(Field{"point_covariances", &O::point_covariances, "", "compute covariances of points too"});
    visit(
        Field{"reliability", &O::reliability, "", "test every observation for a blunder, and say what would be found"});
    visit(Part{&O::tests});
  }
};

/// Where up is in the frame of a camera: by the attitude it wrote down, or by how pictures are held.
struct GivenVertical {
  Eigen::Vector3d up_in_cam;  ///< unit vector
  double sigma_rad = 0;
};

/// How each of Camera::params takes part. 0: held; a standard deviation: observed with it; infinite: free.
using CameraSigmas = std::array<double, Camera::kAllParams>;

/// Those that AdjustOptions::calibration stands for, where `first` is the camera before any adjustment: the weak
/// observations told at adjust().
[[nodiscard]] CameraSigmas calibration_sigmas(Calibration calibration, const Camera& first);

/// What takes part and what is held. As it stands: everything moves, everything known is used, and positions are those
/// of projection centres.
struct AdjustScope : Instruments {
  /// Nothing: every oriented image moves. Otherwise only these move; other images that see the same points take part,
  /// held where they are (local adjustment).
  std::optional<std::set<ImageId>> free_images;
  std::set<ImageId> fixed_images;    ///< held even if free otherwise
  std::set<CameraId> fixed_cameras;  ///< not calibrated
  std::set<PointId> fixed_points;    ///< held
  /// The cameras as they were before any adjustment: the values of the weak observations below. A camera that is not
  /// named counts as it stands in the block.
  std::map<CameraId, Camera> first_cameras;
  std::map<CameraId, CameraSigmas> camera_sigmas;  ///< of cameras that are not calibrated as the options say
  /// Cameras of kBrownOfMeasured whose measurements are compared after correction, where their sigmas then hold, as
  /// PhotoModeler and DBAT do. Residuals are then those, too. Else they are compared where they were measured.
  std::set<CameraId> corrected_cameras;
  std::map<ImageId, GivenVertical> verticals;  ///< observations of the attitudes of images
  bool use_positions = true;                   ///< Image::position
  bool use_control = true;                     ///< ControlRole::kControl; when false they are treated as check points
  bool use_ground = true;                      ///< Block::ground; not in a local adjustment
};

/// Unknowns beside those of images, cameras and points.
enum class UnknownKind : std::uint8_t {
  kOrientation,  ///< azimuth of zero of a horizontal circle [rad]
  kLeverArm,     ///< of a camera, along its axes [m]
  kShift,        ///< of the positions of a track [m]
  kDrift,        ///< the same in a unit of its time [m]
  kBoresight,    ///< of a camera, a rotation vector about its axes: cam_from_world = turn * given [rad]
  kTimeOffset,   ///< of the positions of a camera after the exposures [s]
  kHeight,       ///< that points have in common: theirs above the world's origin [m]
  kPlane,        ///< against where it began: along its normal [m], two tilts [1]
  kLine,         ///< against where it began: sideways [m], [1] along it, upwards [m], [1]
};

/// Those of a shape that points are known to lie on.
[[nodiscard]] constexpr bool is_of_shape(UnknownKind kind) { return kind >= UnknownKind::kHeight; }

/// One of them, as estimated.
struct EstimatedUnknown {
  UnknownKind kind{};
  std::uint32_t owner = 0;  ///< number of the set-up, the shape or the track, or of a CameraId
  int axis = 0;
  double value = 0;
  double sigma = std::numeric_limits<double>::quiet_NaN();  ///< by the given sigmas; with covariances
};

/// "the orientation of set-up 3", "the height of the antenna".
[[nodiscard]] std::string name_of_extra(const Block& block, UnknownKind kind, std::uint32_t owner, int axis);

/// A measurement on the ground after the adjustment.
struct GroundDifference {
  std::uint32_t observation = 0;  ///< place in Block::ground
  bool used = false;              ///< it took part; false: only compared
  double adjusted = 0;            ///< [m] or [rad]
  double difference = 0;          ///< adjusted minus given
  /// With covariances: of `adjusted`, by the given sigmas, and what `difference` is expected to be. NaN: not known.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  double difference_sigma = std::numeric_limits<double>::quiet_NaN();
};

/// The position of an image against what its receiver said.
struct PositionDifference {
  ImageId image;
  Eigen::Vector3d difference_m;  ///< adjusted minus given; NaN on axes that were not given
  double weight = 1;             ///< by the robust loss; below 1: partly disbelieved
};

/// The attitude of an image against what was given.
struct AttitudeDifference {
  ImageId image;
  Eigen::Vector3d difference_rad;  ///< adjusted minus given, less the boresight: a turn about x, y, z of the world
};

/// A control or check point after the adjustment.
struct ControlDifference {
  ControlId point;
  bool used = false;  ///< it took part; false: check point, intersected from the images that took part or were held
  int rays = 0;       ///< such images it was measured in
  std::optional<Eigen::Vector3d> position_in_world;  ///< nothing when the rays do not intersect
  Eigen::Vector3d difference_m = Eigen::Vector3d::Constant(
      std::numeric_limits<double>::quiet_NaN());  ///< estimated minus given, in the world frame; NaN: not surveyed
  /// With covariances: of position_in_world [m^2], by the given sigmas (of a check point without its survey) ...
  std::optional<Eigen::Matrix3d> covariance_m2;
  /// ... and what difference_m is expected to be, by the block's covariance times sigma0^2 and the survey as given.
  /// NaN: not known.
  Eigen::Vector3d difference_sigma_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using MatrixPd = Eigen::MatrixXd;  ///< of as many of Camera::params as the camera's last one needs

/// Something that the observations determine badly or not at all, in words.
struct Weakness {
  /// no_datum, datum_defect, weak_turn, weak_scale, focal_and_height, camera_and_pose, parameter_not_determined,
  /// scale_drifts, loose_images, no_base, images_left_out, ground_left_out, weak_images
  std::string code;
  std::string what, cure;
  double size = 0;  ///< motions, parameters or images; of a weak motion its standard deviation, of a mixture its
                    ///< correlation
};

/// How well images, cameras and what stands in the border can be told apart.
struct Conditioning {
  /// The largest variance that any combination of them has, over what it would be if everything else (points too) were
  /// known: 1 / the least eigenvalue of the reduced normal equations with each unknown in units of its own weight. Of
  /// sixteen digits its logarithm is lost. 0: not known.
  double inflation = 0;
  std::string mostly;  ///< what that combination consists of, in words
};

/// How a parameter of a camera goes with one of the six of an image: with what differs least from it in its effect.
struct CameraPoseCorrelation {
  CameraId camera;
  int param = 0;    ///< Camera::Param
  int of_pose = 0;  ///< 0 to 2: turns about x, y and z of the world; 3 to 5: the projection centre along them
  ImageId image;    ///< of the camera's images the one with the largest
  double correlation = 0;
};

/// The outcome of a bundle adjustment. Residuals are observed minus computed.
struct Adjusted {
  std::map<ImageId, Rigid3> cam_from_world;                 ///< of the images that moved
  std::map<CameraId, Camera> cameras;                       ///< that were calibrated
  std::vector<std::pair<PointId, Eigen::Vector3d>> points;  ///< that moved, ascending [m]

  std::vector<std::uint32_t>
      observations;  ///< of tie points that took part: their places in Block::observations, ascending
  std::vector<Eigen::Vector2d> residuals_px;  ///< one for each of them; NaN when the point is not seen by the image
  std::vector<PositionDifference> positions;
  std::vector<ControlDifference> control;             ///< every control and check point with a ray, and those that
                                                      ///< measurements on the ground alone determine, ascending
  std::vector<Eigen::Vector2d> control_residuals_px;  ///< in the order of Block::control_observations; NaN when unknown
  std::vector<GroundDifference> ground;               ///< those whose two points take part, ascending
  std::vector<EstimatedUnknown> extras;               ///< unknowns beside images, cameras and points
  std::vector<AttitudeDifference> attitudes;          ///< ascending
  /// With covariances: pairs of unknowns that hardly differ in what they do (correlation beyond 0.99), and what helps.
  std::vector<std::string> inseparable;
  std::vector<ImageId> images_left_out;  ///< free, but with too few observations to be determined; not moved

  double sigma0 = 0;                              ///< a posteriori, of unit weight: 1 when the given sigmas are true,
                                                  ///< whatever the loss
  long redundancy = 0;                            ///< observations (priors too) minus unknowns plus rank defect
  long observation_count = 0, unknown_count = 0;  ///< coordinates (of rays that see their point); single unknowns
  int rank_defect = 0;  ///< of the datum: 7 for a free block, 0 when positions, control or held images fix it
  std::string datum;    ///< what fixes place, attitude and scale, in words
  int iterations = 0;
  double initial_cost = 0, final_cost = 0;  ///< sum of squared whitened residuals after the loss
  bool converged = false;
  double last_step_sigmas = 0;  ///< length of the last step of images and cameras, in their standard deviations

  /// Covariances of the robust estimate by the given sigmas (times sigma0^2 when those are only known up to scale);
  /// empty when not asked for or when something is not determined (`undetermined` then says what).
  std::map<ImageId, Matrix6d>
      pose_covariance;  ///< [rotation (rad, in world), centre (m, in world)]: true rotation = rotation * rotation_by(e)
  std::map<CameraId, MatrixPd> camera_covariance;  ///< of Camera::params, zero for those held
  std::vector<Eigen::Matrix3d> point_covariance;   ///< [m^2], parallel to points
  std::vector<PlacePrecision> places;  ///< at up to 2000 of the tie points with three rays or more, evenly taken
  /// With covariances, where the datum is complete: six of each free parameter of each camera.
  std::vector<CameraPoseCorrelation> camera_pose_correlations;
  std::string undetermined;
  Conditioning conditioning;               ///< with covariances
  std::vector<Weakness> weaknesses;        ///< with covariances; none: everything is well determined
  std::optional<Reliability> reliability;  ///< when asked for and everything is determined
};

/// Least-squares bundle adjustment (Brown 1958; Triggs et al. 2000): Levenberg-Marquardt on images, cameras and points
/// at once, points eliminated (Schur complement), robust losses by reweighting.
///
/// Observations: tie points; control points (their image measurements, never robust, and their coordinates by sigma_m,
/// infinite = not given); measurements on the ground between control points, and planes, lines and heights that these
/// are known to lie on (Block::ground, never robust; check points
/// among them take part with their image measurements, not with their coordinates); GNSS positions, of an antenna
/// with a lever arm, a shift, a drift and a time offset if the scope says so; scope.attitudes with a boresight;
/// scope.verticals; and weak ones for the parameters of calibration so that weak geometry does not run away: f by
/// Camera::sigma_f_px (0: f is held), principal point 3 % of the width, k1 0.2, k2 0.5, k3 0.5, p1 and p2 0.01, b1 and
/// b2 0.5 % of f, all around scope.first_cameras. Cameras with calibrate = false are held. scope.camera_sigmas takes
/// the place of all that for the cameras it names.
///
/// A control point with the sigmas 0 is held where it is given. Where only some axes have the sigma 0, these get a
/// thousandth of what one measured pixel is on the ground at the point.
///
/// Datum: a part of the block whose place, attitude or scale nothing fixes keeps them: every step is orthogonal to the
/// motions that no observation sees (inner constraints over up to eight images spread over the part). Residuals do not
/// depend on that choice. Covariances of poses and points refer to the datum of all tie points of the part (inner
/// constraints over them: the least trace there is).
///
/// Points with fewer than two rays (one for held points and for control known on three axes) and images with fewer than
/// three measured points take no part, nor do measurements on the ground to such points; but points that these
/// measurements determine need no rays (a total station that no image shows). Errors: kBadInput (options,
/// sigmas not positive, coordinates with finite sigmas that are no numbers), kIllPosed (nothing to adjust, or more
/// unknowns than observations), kUnsupported (more than 10,000 unknowns of cameras and of points that are joined by
/// measurements), kCancelled.
[[nodiscard]] Result<Adjusted> adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                      const Run& run);

/// adjust() for a large block that is adjusted again and again: keeps the factor of the normal equations, by which the
/// next steps of the same images are solved with less work. The answers are the same within the accuracy of the
/// options, and depend on what was adjusted before in no other way.
class Adjuster {
 public:
  Adjuster();
  ~Adjuster();
  Adjuster(const Adjuster& other);  ///< a copy begins without a factor
  Adjuster& operator=(const Adjuster& other);
  Adjuster(Adjuster&&) noexcept;
  Adjuster& operator=(Adjuster&&) noexcept;

  [[nodiscard]] Result<Adjusted> adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                        const Run& run);

 private:
  std::unique_ptr<bundle::KeptFactor> kept_;
};

/// What the square roots of covariances are multiplied by to be standard deviations: sigma0, or 1 where that says
/// nothing: without redundancy, and where observations agree to rounding, as those of a planned block do.
[[nodiscard]] inline double sigma_scale(const Adjusted& adjusted) {
  return adjusted.redundancy > 0 && adjusted.sigma0 > 1e-9 ? adjusted.sigma0 : 1;
}

/// Writes poses, cameras and points of the adjustment into the block.
void apply(const Adjusted& adjusted, Block& block);

}  // namespace collinea
