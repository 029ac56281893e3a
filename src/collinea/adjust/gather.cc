// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/gather.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "collinea/adjust/gather_parts.h"
#include "collinea/adjust/internal/datum_defect.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/math/ordering.h"
#include "collinea/math/tile_kernels.h"

namespace collinea::bundle {
namespace {

constexpr int kLeastRaysOfImage = 3;
// Of the finest a pixel is on the ground: what a fixed coordinate may move beside a free one. The results then differ
// by the square of it from those of a coordinate that is really held, which a stiffer spring would spoil by rounding.
constexpr double kHeldPart = 1e-3;
constexpr int kMostCameraUnknowns = 10000;  // their normal equations are full: 0.8 GB, held twice
constexpr std::uint32_t kNobody = ~std::uint32_t{0};

// What a pixel's sigma is across the sight line at that place, the least of all lines; of no line: of no length.
double finest_on_ground_m(const std::vector<SightLine>& lines, const Eigen::Vector3d& place) {
  double finest = lines.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const SightLine& line : lines)
    finest = std::min(finest, line.sigma_px * (line.cam_from_world * place).norm() / line.camera->focal_px());
  return finest;
}

/// Gathers in four passes: images, points with their rays, what is too weak to take part, order.
class Gatherer {
 public:
  Gatherer(const Block& block, const AdjustScope& scope, const AdjustOptions& options)
      : block_(block), scope_(scope), options_(options) {}

  Result<ProblemAndStart> gather() {
    number_images();
    COLLINEA_TRY(links_, ground_taking_part(block_, scope_));
    for (const std::uint32_t link : links_) wanted_.insert({block_.ground[link].from, block_.ground[link].to});
    if (Result<> taken = take_tie_points(); !taken) return tl::unexpected(taken.error());
    if (Result<> taken = take_control(); !taken) return tl::unexpected(taken.error());
    const std::size_t measured = links_.size();
    drop_weak();
    out_.problem.geodetic_left_out = measured - links_.size();
    if (Result<> enough = check_there_is_something(); !enough) return tl::unexpected(enough.error());
    order_images();
    order_points();
    lay_out_images();
    if (Result<> laid_out = lay_out_cameras(); !laid_out) return tl::unexpected(laid_out.error());
    if (Result<> taken = take_instruments(block_, scope_, out_); !taken) return tl::unexpected(taken.error());
    lay_out_ground(block_, links_, out_);
    count();
    if (out_.problem.border > kMostCameraUnknowns)
      return fail(Errc::kUnsupported,
                  std::to_string(out_.problem.cameras.size()) + " cameras with " +
                      std::to_string(out_.problem.first_extra) + " unknowns to calibrate and " +
                      std::to_string(out_.problem.border - out_.problem.first_extra) +
                      " of points that are measured on the ground: more than " + std::to_string(kMostCameraUnknowns) +
                      " do not fit into memory. Pictures of one camera should share it; or hold the cameras, or "
                      "calibrate fewer parameters");
    return std::move(out_);
  }

 private:
  struct Candidate {
    ImageId id;
    bool free = false;
    int rays = 0;
    bool out = false;
  };
  struct CandidatePoint {
    std::uint32_t id = 0, first_ray = 0, end_ray = 0;
    int control = -1;
    bool held = false, out = false;
    bool for_ground = false;  // it takes part only because something is measured on the ground to it
    bool linked = false;      // something is
    int given = 0;            // coordinates
    int least_rays = 2;
    double position[3] = {};
  };

  void number_images() {
    const std::vector<OrientedImage> oriented = oriented_images(block_);
    if (!oriented.empty()) number_of_id_.assign(oriented.back().image.value + 1, kNobody);
    for (const auto& [id, pose] : oriented) {
      const bool free = (!scope_.free_images || scope_.free_images->contains(id)) && !scope_.fixed_images.contains(id);
      number_of_id_[id.value] = static_cast<std::uint32_t>(candidates_.size());
      candidates_.push_back({id, free});
    }
  }

  [[nodiscard]] std::uint32_t number_of(ImageId id) const {
    return id.value < number_of_id_.size() ? number_of_id_[id.value] : kNobody;
  }

  template <class Observed>
  Result<> add_ray(const Observed& observed, std::size_t source) {
    const std::uint32_t image = number_of(observed.image);
    if (image == kNobody) return {};
    if (!(observed.sigma_px > 0) || !std::isfinite(observed.sigma_px) || !observed.pixel.allFinite())
      return fail(Errc::kBadInput, "an observation in " + block_.images.at(observed.image).file +
                                       " has no finite coordinates with a positive standard deviation");
    rays_.push_back(
        {{observed.pixel.x(), observed.pixel.y()}, 1 / observed.sigma_px, image, static_cast<std::uint32_t>(source)});
    return {};
  }

  // Rays of the point from first_ray on: one for each image, none when no free image is among them (local adjustment).
  bool close_point(CandidatePoint& point) {
    const auto begin = rays_.begin() + point.first_ray;
    const auto by_image = [](const Ray& a, const Ray& b) { return a.image < b.image; };
    if (!std::is_sorted(begin, rays_.end(), by_image)) std::stable_sort(begin, rays_.end(), by_image);
    rays_.erase(std::unique(begin, rays_.end(), [](const Ray& a, const Ray& b) { return a.image == b.image; }),
                rays_.end());
    bool wanted = !scope_.free_images;
    for (auto ray = begin; ray != rays_.end() && !wanted; ++ray) wanted = candidates_[ray->image].free;
    if ((begin == rays_.end() && !point.linked) || !wanted) {
      rays_.resize(point.first_ray);
      return false;
    }
    point.end_ray = static_cast<std::uint32_t>(rays_.size());
    points_.push_back(point);
    return true;
  }

  Result<> take_tie_points() {
    const auto& observations = block_.observations;
    if (!scope_.free_images) {
      rays_.reserve(observations.size());
      points_.reserve(block_.points.size());
    }
    auto known = block_.points.begin();
    for (std::size_t i = 0, end = 0; i < observations.size(); i = end) {
      const PointId id = observations[i].point;
      bool wanted = !scope_.free_images;
      for (end = i; end < observations.size() && observations[end].point == id; ++end) {
        const std::uint32_t image = wanted ? kNobody : number_of(observations[end].image);
        wanted |= image != kNobody && candidates_[image].free;
      }
      COLLINEA_CHECK(end == observations.size() || id < observations[end].point);
      if (!wanted) continue;
      if (known != block_.points.end() && known->first < id) ++known;
      if (known == block_.points.end() || known->first != id) known = block_.points.lower_bound(id);
      if (known == block_.points.end() || known->first != id) continue;
      CandidatePoint point;
      point.id = id.value;
      point.first_ray = static_cast<std::uint32_t>(rays_.size());
      for (std::size_t k = i; k < end; ++k)
        if (Result<> added = add_ray(observations[k], k); !added) return added;
      point.held = scope_.fixed_points.contains(id);
      if (point.held) point.least_rays = 1;
      Eigen::Map<Eigen::Vector3d>(point.position) = known->second.position_in_world;
      close_point(point);
    }
    return {};
  }

  Result<> take_control() {
    if (!scope_.use_control && wanted_.empty()) return {};
    std::map<ControlId, std::vector<std::size_t>> places;
    for (std::size_t i = 0; i < block_.control_observations.size(); ++i)
      places[block_.control_observations[i].point].push_back(i);
    std::map<ControlId, std::vector<SightLine>> lines;
    std::map<ControlId, Eigen::Vector3d> starts;
    for (const auto& [id, control] : block_.control) {
      const bool is_control = scope_.use_control && control.role == ControlRole::kControl;
      if (!wanted_.contains(id) && !(is_control && places.contains(id))) continue;
      lines[id] = sight_lines(block_, id);
      if (const auto start = start_of(control, is_control, lines[id])) starts[id] = *start;
    }
    if (!links_.empty()) find_positions_by_geodetic(block_, links_, starts);
    for (const auto& [id, its_lines] : lines) {
      const auto start = starts.find(id);
      if (start == starts.end() || !start->second.allFinite()) continue;  // there is no place to begin at
      if (Result<> taken = take_control_point(id, its_lines, start->second, places[id]); !taken) return taken;
    }
    return {};
  }

  // By its images, else as surveyed.
  static std::optional<Eigen::Vector3d> start_of(const ControlPoint& control, bool is_control,
                                                 const std::vector<SightLine>& lines) {
    if (!(is_control && (control.sigma_m.array() == 0).all()))
      if (const auto met = intersect(lines)) return met->point_in_world;
    const auto given = control.sigma_m.array().isFinite();
    if (given.all() || (given.any() && !lines.empty())) return control.position_in_world;
    return std::nullopt;
  }

  Result<> take_control_point(ControlId id, const std::vector<SightLine>& lines, const Eigen::Vector3d& start,
                              const std::vector<std::size_t>& places) {
    const ControlPoint& control = block_.control.at(id);
    const bool is_control = scope_.use_control && control.role == ControlRole::kControl;
    CandidatePoint point;
    point.id = id.value;
    point.first_ray = static_cast<std::uint32_t>(rays_.size());
    point.for_ground = !is_control;
    point.linked = wanted_.contains(id);
    point.held = is_control && (control.sigma_m.array() == 0).all();
    ControlCoordinates coordinates{};
    Eigen::Vector3d sigmas_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    for (int axis = 0; axis < 3 && is_control; ++axis) {
      double sigma_m = control.sigma_m[axis];
      if (!(sigma_m >= 0))
        return fail(Errc::kBadInput, "a standard deviation of control point " + control.name + " is no number from 0");
      if (!known(control.position_in_world[axis], sigma_m))
        return fail(Errc::kBadInput, "control point " + control.name + " has no finite coordinates");
      point.given += std::isfinite(sigma_m);
      if (sigma_m == 0) sigma_m = kHeldPart * finest_on_ground_m(lines, start);
      sigmas_m[axis] = sigma_m;
      coordinates.inverse_sigma[axis] = point.held || !(sigma_m > 0) ? 0 : 1 / sigma_m;
      coordinates.given[axis] = std::isfinite(sigma_m) ? control.position_in_world[axis] : 0;
    }
    if (is_control && !point.held && !control.correlation.isZero(0))
      if (Result<> correlated = correlate(control, sigmas_m, coordinates); !correlated) return correlated;
    if (point.given == 3) point.least_rays = 1;
    for (const std::size_t place : places)
      if (Result<> added = add_ray(block_.control_observations[place], place); !added) return added;
    point.control = static_cast<int>(out_.problem.control.size());
    Eigen::Map<Eigen::Vector3d>(point.position) = start;
    if (close_point(point)) out_.problem.control.push_back(coordinates);
    return {};
  }

  static Result<> correlate(const ControlPoint& control, const Eigen::Vector3d& sigma_m,
                            ControlCoordinates& coordinates) {
    const Eigen::Vector3d exact = (control.sigma_m.array() == 0).select(0, sigma_m);
    const auto weight = survey_weight(exact, control.correlation);
    if (!weight)
      return fail(Errc::kBadInput, "the correlations of control point " + control.name +
                                       " are not those of a covariance (it has to be positive definite)");
    for (int axis = 0; axis < 3; ++axis)
      if ((*weight)(axis, axis) > 0) coordinates.inverse_sigma[axis] = std::sqrt((*weight)(axis, axis));
    coordinates.beside[0] = (*weight)(0, 1);
    coordinates.beside[1] = (*weight)(0, 2);
    coordinates.beside[2] = (*weight)(1, 2);
    return {};
  }

  // Images, coordinates and measurements on the ground together are as many as the unknowns.
  [[nodiscard]] static bool by_ground_too(const CandidatePoint& point, int rays, int on_ground) {
    return point.held || 2 * rays + point.given + on_ground >= 3;
  }

  // What is measured to a point that takes no part goes; true when something went.
  bool drop_links() {
    if (links_.empty()) return false;
    std::map<ControlId, Eigen::Vector3d> there;
    for (const CandidatePoint& point : points_)
      if (!point.out && point.control >= 0) there.emplace(ControlId{point.id}, Eigen::Vector3d(point.position));
    const std::size_t before = links_.size();
    std::erase_if(links_, [&](std::uint32_t link) {
      return !there.contains(block_.ground[link].from) || !there.contains(block_.ground[link].to);
    });
    erase_weak_shapes(
        block_, [&](ControlId id) { return there.at(id); }, links_);
    return links_.size() < before;
  }

  // Points with too few rays and images with too few points go, until all that remain have enough.
  void drop_weak() {
    for (bool changed = true; changed;) {
      changed = false;
      const std::map<ControlId, int> on_ground = ground_counts(block_, links_);
      for (Candidate& image : candidates_) image.rays = 0;
      for (CandidatePoint& point : points_) {
        if (point.out) continue;
        int rays = 0;
        for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r) rays += !candidates_[rays_[r].image].out;
        const bool seen = rays >= point.least_rays && rays > 0;
        const auto its = point.linked ? on_ground.find(ControlId{point.id}) : on_ground.end();
        const bool linked = its != on_ground.end();
        point.out = (!seen && !(linked && by_ground_too(point, rays, its->second))) || (point.for_ground && !linked);
        if (point.out) continue;
        for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r) ++candidates_[rays_[r].image].rays;
      }
      for (Candidate& image : candidates_)
        if (image.free && !image.out && image.rays < kLeastRaysOfImage) changed = image.out = true;
      changed |= drop_links();
    }
    for (Candidate& image : candidates_) {
      if (image.free && image.out) out_.problem.images_left_out.push_back(image.id);
      image.out |= image.rays == 0;
    }
  }

  [[nodiscard]] Result<> check_there_is_something() const {
    const auto takes_part = [](const auto& one) { return !one.out; };
    if (oriented_images(block_).empty())
      return fail(Errc::kIllPosed, "no image is oriented: there is nothing to adjust");
    if (std::none_of(points_.begin(), points_.end(), takes_part))
      return fail(Errc::kIllPosed,
                  "no point is measured in two images that take part: there is nothing to adjust. Measure tie "
                  "points in a second image, or control points known in plan and height");
    if (std::none_of(candidates_.begin(), candidates_.end(), [](const Candidate& c) { return c.free && !c.out; }) &&
        options_.calibration == Calibration::kNone && scope_.camera_sigmas.empty() &&
        std::all_of(points_.begin(), points_.end(), [](auto& p) { return p.held; }))
      return fail(Errc::kIllPosed, "every image, camera and point is held: there is nothing to adjust");
    return {};
  }

  [[nodiscard]] std::vector<int> order_of_free(int free, const std::vector<int>& free_number) const {
    std::vector<int> order(static_cast<std::size_t>(free));
    std::iota(order.begin(), order.end(), 0);
    if (free <= 2 * kPosesOfTile) return order;  // two tiles: nothing to gain
    const std::map<ControlId, int> linked = ground_counts(block_, links_);
    std::vector<std::uint32_t> first{0};
    std::vector<int> image_of_ray;
    for (const CandidatePoint& point : points_) {
      if (point.out || point.held || (point.control >= 0 && linked.contains(ControlId{point.id}))) continue;
      for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r)
        if (free_number[rays_[r].image] >= 0) image_of_ray.push_back(free_number[rays_[r].image]);
      first.push_back(static_cast<std::uint32_t>(image_of_ray.size()));
    }
    std::vector<Eigen::Vector3d> centres;
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      if (free_number[i] >= 0) centres.push_back(centre_of(pose_of(block_, candidates_[i].id)));
    return elimination_order(covisibility(free, first, image_of_ray), centres, kPosesOfTile);
  }

  // Free images are numbered in the order of elimination, held ones after them.
  void order_images() {
    std::vector<int> free_number(candidates_.size(), -1);
    int free = 0;
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      if (candidates_[i].free && !candidates_[i].out) free_number[i] = free++;
    const std::vector<int> order = order_of_free(free, free_number);
    new_number_.assign(candidates_.size(), kNobody);
    std::uint32_t held = static_cast<std::uint32_t>(free);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (candidates_[i].out) continue;
      new_number_[i] = free_number[i] >= 0 ? static_cast<std::uint32_t>(order[free_number[i]]) : held++;
    }
    out_.problem.poses = free;
    out_.problem.images.resize(held);
  }

  // Rays within a point: held images first. Points: by their first free image, so that neighbours are near in memory.
  void order_points() {
    Problem& problem = out_.problem;
    const auto poses = static_cast<std::uint32_t>(problem.poses);
    std::vector<std::uint32_t> key(points_.size(), kNobody), order;
    std::vector<Ray> kept;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      if (points_[p].out) continue;
      order.push_back(static_cast<std::uint32_t>(p));
      for (std::uint32_t r = points_[p].first_ray; r < points_[p].end_ray; ++r) {
        const std::uint32_t image = rays_[r].image = new_number_[rays_[r].image];
        if (image < poses) key[p] = std::min(key[p], image);
      }
    }
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return key[a] < key[b]; });
    kept.reserve(rays_.size());
    const auto rank = [&](const Ray& ray) { return ray.image < poses ? ray.image + problem.images.size() : ray.image; };
    for (const std::uint32_t p : order) {
      const CandidatePoint& point = points_[p];
      const auto begin = static_cast<std::uint32_t>(kept.size());
      for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r)
        if (rays_[r].image != kNobody) kept.push_back(rays_[r]);
      std::sort(kept.begin() + begin, kept.end(), [&](const Ray& a, const Ray& b) { return rank(a) < rank(b); });
      std::uint32_t first_free = begin;
      while (first_free < kept.size() && kept[first_free].image >= poses) ++first_free;
      problem.points.push_back({point.id, begin, first_free, point.control, point.held});
      out_.start.points.insert(out_.start.points.end(), point.position, point.position + 3);
    }
    const auto end = static_cast<std::uint32_t>(kept.size());
    problem.points.push_back({kNobody, end, end});
    problem.rays = std::move(kept);
  }

  void lay_out_images() {
    std::map<CameraId, int> camera_number;
    Problem& problem = out_.problem;
    State& start = out_.start;
    start.rotations.resize(problem.images.size());
    start.frames.resize(problem.images.size());
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (new_number_[i] == kNobody) continue;
      const ImageId id = candidates_[i].id;
      const CameraId camera = block_.images.at(id).camera;
      const auto [its, is_new] = camera_number.try_emplace(camera, static_cast<int>(problem.cameras.size()));
      if (is_new) problem.cameras.emplace_back().id = camera;
      problem.images[new_number_[i]] = {id, its->second};
      const Rigid3& pose = pose_of(block_, id);
      const Eigen::Vector3d centre = centre_of(pose);
      start.rotations[new_number_[i]] = pose.rotation.normalized();
      start.frames[new_number_[i]] = frame_of(pose.rotation.normalized(), centre.data());
    }
  }

  Result<> lay_out_cameras() {
    Problem& problem = out_.problem;
    for (ProblemCamera& unknowns : problem.cameras) {
      const Camera& camera = block_.cameras.at(unknowns.id);
      const auto first = scope_.first_cameras.find(unknowns.id);
      const Camera& given = first == scope_.first_cameras.end() ? camera : first->second;
      unknowns.border = problem.border;
      unknowns.given = given.params;
      const auto own = scope_.camera_sigmas.find(unknowns.id);
      const bool held = own == scope_.camera_sigmas.end() && !camera.prior.calibrate;
      const CameraSigmas sigmas =
          own == scope_.camera_sigmas.end() ? calibration_sigmas(options_.calibration, given) : own->second;
      for (const int param : params_of(camera)) {
        const double sigma = sigmas[static_cast<std::size_t>(param)];
        if (!(sigma >= 0))
          return fail(Errc::kBadInput, "the standard deviation of " + param_name(param) + " of camera " + camera.name +
                                           " is no number from 0");
        if (held || scope_.fixed_cameras.contains(unknowns.id) || sigma == 0) continue;
        unknowns.free.push_back(param);
        unknowns.inverse_sigma[static_cast<std::size_t>(param)] = 1 / sigma;
      }
      problem.border += static_cast<int>(unknowns.free.size());
      out_.start.cameras.push_back(camera.params);
      const bool corrected = scope_.corrected_cameras.contains(unknowns.id);
      if (corrected && kind_of(camera, true) == LensKind::kGeneral)
        return fail(Errc::kUnsupported, "camera " + camera.name +
                                            ": measurements are compared after correction with the model "
                                            "brown_of_measured alone, without additional parameters");
      out_.start.lenses.push_back(lens_of(camera, corrected));
    }
    problem.first_extra = problem.border;
    return {};
  }

  void count() {
    Problem& problem = out_.problem;
    problem.unknown_count = 6L * problem.poses + problem.border;
    for (std::size_t p = 0; p < problem.point_count(); ++p) {
      problem.unknown_count += problem.point(p).eliminated() ? 3 : 0;
      if (problem.first_control == p && problem.point(p).control < 0) ++problem.first_control;
    }
    problem.observation_count = 2 * static_cast<long>(problem.rays.size());
    for_each_kind([&]<class Kind>() {
      Kind::for_each(problem, [&](const auto& item) { problem.observation_count += Kind::count(problem, item); });
    });
  }

  const Block& block_;
  const AdjustScope& scope_;
  const AdjustOptions& options_;
  std::vector<std::uint32_t> number_of_id_, new_number_;
  std::vector<Candidate> candidates_;
  std::vector<CandidatePoint> points_;
  std::vector<Ray> rays_;
  std::vector<std::uint32_t> links_;  // places in Block::ground of what takes part
  std::set<ControlId> wanted_;        // their points
  ProblemAndStart out_;
};

}  // namespace

Result<ProblemAndStart> gather(const Block& block, const AdjustScope& scope, const AdjustOptions& options) {
  COLLINEA_TRY(ProblemAndStart gathered, Gatherer(block, scope, options).gather());
  gathered.problem.tie_loss = {options.loss, options.loss_scale_sigmas, 1};
  gathered.problem.position_loss = {options.position_loss, options.position_loss_scale_sigmas, 1};
  find_datum(gathered.problem, gathered.start);
  return gathered;
}

}  // namespace collinea::bundle
