// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/block/features.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/orient/internal/noise.h"
#include "collinea/orient/options.h"
#include "collinea/quality/examine.h"

namespace collinea {

using KeypointSource = std::function<Result<std::vector<Keypoint>>(ImageId)>;

/// A block while it grows: poses of the images oriented so far and the state of every track, a track being a tie point
/// to be. World frame: whatever the first pair gave until the caller moves it.
class Reconstruction {
 public:
  /// One image of a track. Active: it takes part in the adjustment.
  struct Ray {
    ImageId image;
    std::uint32_t feature = 0;
    Eigen::Vector2d pixel;
    double sigma_factor = 1;   ///< of its feature's scale
    double anew_sigma_px = 0;  ///< of a ray measured anew, as its window states it; 0: where its feature is
    bool active = false;
  };
  /// A position measured anew, with the standard deviation of each coordinate.
  struct MovedRay {
    Eigen::Vector2d pixel;
    double sigma_px = 0;
  };
  struct TrackState {
    std::vector<Ray> rays;                 ///< sorted by image
    std::optional<Eigen::Vector3d> point;  ///< in world
    bool asleep = false;                   ///< not looked at: see sleep_surplus
  };
  struct RayRef {
    std::uint32_t track = 0, ray = 0;
  };

  static Result<Reconstruction> create(const Block& setup, std::span<const ImagePair> pairs,
                                       const KeypointSource& keypoints, const OrientOptions& options);

  /// What is known of the block besides its features: cameras before any adjustment, images with their positions and
  /// attitudes, control, geodetic observations. No poses, no points.
  [[nodiscard]] const Block& setup() const { return setup_; }
  /// Replaces it, from the next block() and adjustment on. Cameras and images are the same ones; cameras that images
  /// use keep the values they have.
  void set_setup(Block setup) { setup_ = std::move(setup); }

  [[nodiscard]] bool oriented(ImageId image) const { return poses_.contains(image); }
  [[nodiscard]] const std::map<ImageId, Rigid3>& poses() const { return poses_; }
  [[nodiscard]] const Camera& camera_of(ImageId image) const { return cameras_.at(setup_.images.at(image).camera); }
  [[nodiscard]] std::size_t point_count() const;
  /// Rays of oriented images in tracks that two and more of them see, and how many of these are active.
  struct RayCount {
    std::size_t all = 0, active = 0;
  };
  [[nodiscard]] RayCount ray_count() const;
  [[nodiscard]] int active_rays(ImageId image) const;
  [[nodiscard]] const std::vector<ImageId>& images_with_tracks() const { return images_; }

  /// Puts tracks to sleep that growth can do without: kept are, from the longest, those that some image still needs in
  /// its part of the image. A block grows as safely on them, in a fraction of the time; wake_all brings the others
  /// back.
  void sleep_surplus();
  void wake_all();

  /// Orients two images and intersects what they share. Returns the number of points.
  int start(ImageId first, ImageId second, const Rigid3& second_from_first);
  /// How well the points found so far cover a new image: grows with their number and spread. And their number.
  struct Coverage {
    double score = 0;
    int points = 0;
  };
  [[nodiscard]] Coverage coverage(ImageId image) const;
  /// Images that see an awake track of this one, itself among them: only their coverage changes with its points.
  [[nodiscard]] std::set<ImageId> images_around(ImageId image) const;
  /// Resection of one image on the points it shares with the block; rays that agree become active.
  bool orient_image(ImageId image, std::uint64_t seed);
  /// Gives up an image: its rays leave their points. A camera without oriented images is as it was at first.
  void drop_image(ImageId image);

  /// Intersects tracks without a point and adds rays to points, as far as they agree within the error; over the tracks
  /// of one image or all.
  int extend(ImageId image);
  int extend_all(const Run& run);
  /// Switches off rays with large residuals and points with too small an angle. Returns how many rays went.
  int filter(double max_error_px, const Run& run);

  /// Adjusts `centre` with its closest neighbours; everything else is fixed.
  Result<> adjust_around(ImageId centre, const AdjustOptions& options, const Run& run);
  Result<Adjusted> adjust_all(const AdjustOptions& options, const AdjustScope& scope, const Run& run);
  /// The same with covariances of control points.
  Result<Adjusted> examine_all(const AdjustOptions& options, const AdjustScope& scope, const Run& run);

  /// The oriented part as a block; with control observations and the setup's priors.
  [[nodiscard]] Block block() const;
  void move_world(const Similarity3& new_from_old);
  /// What the errors of tie points are taken for. At first: sigma_px of the options and Huber's loss.
  [[nodiscard]] const TieNoise& noise() const { return noise_; }
  [[nodiscard]] double sigma_px(const Ray& ray) const {
    return ray.anew_sigma_px > 0 ? noise_.anew_factor * ray.anew_sigma_px : noise_.sigma_px * ray.sigma_factor;
  }
  /// Their sigma is kept between a hundredth and ten times sigma_px.
  void set_noise(const TieNoise& noise);
  /// What the points with three rays and more show of it; nothing when there are too few.
  [[nodiscard]] std::optional<TieNoise> shown_noise() const;
  /// Rays whose error is gross for the noise leave, and the choice of rays is closed: extend adds none. The noise has
  /// no loss any more: after a robust adjustment, least squares. Answers how many left, with the rays of points that
  /// are lost with them. Nothing, and nothing is done, where the noise knows no limit.
  std::optional<int> leave_out_gross(const Run& run);
  /// Other positions in the images for the rays of a block made by block(), in the order of its observations; nothing:
  /// the ray keeps its own. Such rays have their own standard deviations, of which the noise knows the true size apart
  /// from that of features. Positions of a point are against that of its reference, which is a feature's: a ray of the
  /// same point that keeps its feature errs by both.
  void move_rays(const Block& block, std::span<const std::optional<MovedRay>> moved);
  /// Cameras that are calibrated get these parameters, zero at first.
  void set_additional(AdditionalSet set);
  /// Sets the poses of images; nothing else.
  void start_from_poses(const std::map<ImageId, Rigid3>& poses);
  /// Gives up images with fewer active rays, and those that have fewer without them.
  void drop_loose(int least_rays);
  /// How far a ray may miss its point from now on.
  void set_max_error_px(double max_error_px) { options_.max_error_px = max_error_px; }
  void take(const Adjusted& adjusted);
  void forget();  ///< back to no pose and no point

 private:
  [[nodiscard]] const std::vector<RayRef>& rays_of(ImageId image) const;
  [[nodiscard]] std::optional<double> error_px(const Ray& ray, const Eigen::Vector3d& point_in_world) const;
  [[nodiscard]] bool camera_in_use(CameraId camera) const;
  /// Largest error of a ray [px]; `share` of the squared errors of its point is left after the point was fitted.
  using Limit = std::function<double(const Ray& ray, double share)>;
  int filter(const Limit& limit_px, const Run& run);
  bool intersect(TrackState& track) const;
  bool extend_track(TrackState& track) const;
  [[nodiscard]] Block block_of(const std::vector<std::uint32_t>& numbers) const;
  [[nodiscard]] Block block_around(const std::set<ImageId>& images) const;
  [[nodiscard]] std::vector<ImageId> neighbours_of(ImageId image, std::size_t count) const;

  Block setup_;
  OrientOptions options_;
  TieNoise noise_;
  bool chosen_ = false;  ///< the rays that take part; none is added any more
  std::vector<ImageId> images_;
  std::vector<TrackState> tracks_;
  std::map<ImageId, std::vector<RayRef>> rays_of_;
  std::map<CameraId, Camera> cameras_;
  std::map<ImageId, Rigid3> poses_;
  Adjuster adjuster_;
};

}  // namespace collinea
