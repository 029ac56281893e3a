// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/layout.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "collinea/adjust/internal/gather_geodetic.h"
#include "collinea/adjust/internal/gather_instruments.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/math/ordering.h"
#include "collinea/math/tile_kernels.h"

namespace collinea::bundle {
namespace {

constexpr std::uint32_t kNone = CandidateImages::kNone;
constexpr int kMostGlobalUnknowns = 10000;  // their normal equations are full: 0.8 GB, held twice

// The rank of each free image in the order of elimination. `free_index`: of candidates; -1: not free or no part.
std::vector<int> order_of_free(const Block& block, const Participants& participants, int free,
                               const std::vector<int>& free_index) {
  std::vector<int> order(static_cast<std::size_t>(free));
  std::iota(order.begin(), order.end(), 0);
  if (free <= 2 * kPosesOfTile) return order;  // two tiles: nothing to gain
  const std::set<ControlId> linked = points_of(block, participants.points.geodetic);
  std::vector<std::uint32_t> first{0};
  std::vector<int> image_of_ray;
  for (std::size_t p = 0; p < participants.has_point.size(); ++p) {
    const CandidatePoint& point = participants.points.points[p];
    if (!participants.has_point[p] || point.is_fixed || (point.control >= 0 && linked.contains(ControlId{point.id})))
      continue;
    for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r)
      if (const int index = free_index[participants.points.rays[r].image]; index >= 0) image_of_ray.push_back(index);
    first.push_back(static_cast<std::uint32_t>(image_of_ray.size()));
  }
  std::vector<Eigen::Vector3d> centres;
  for (std::size_t i = 0; i < free_index.size(); ++i)
    if (free_index[i] >= 0) centres.push_back(centre_of(pose_of(block, participants.images.images[i].id)));
  return elimination_order(covisibility(free, first, image_of_ray), centres, kPosesOfTile);
}

// Points that take part in the order of their first free image.
std::vector<std::uint32_t> order_points(const Participants& participants, const ImageOrder& order) {
  std::vector<std::uint32_t> key(participants.has_point.size(), kNone), points;
  for (std::size_t p = 0; p < key.size(); ++p) {
    if (!participants.has_point[p]) continue;
    points.push_back(static_cast<std::uint32_t>(p));
    const CandidatePoint& point = participants.points.points[p];
    for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r)
      if (const std::uint32_t image = order.index[participants.points.rays[r].image];
          image < static_cast<std::uint32_t>(order.free))
        key[p] = std::min(key[p], image);
  }
  std::stable_sort(points.begin(), points.end(), [&](auto a, auto b) { return key[a] < key[b]; });
  return points;
}

// Rays within a point: fixed images first.
void lay_out_points(const Participants& participants, const ImageOrder& order, ProblemAndStart& out) {
  Problem& problem = out.problem;
  const auto free = static_cast<std::uint32_t>(order.free), all = static_cast<std::uint32_t>(order.all);
  const auto rank = [&](const Ray& ray) { return ray.image < free ? ray.image + all : ray.image; };
  std::vector<Ray>& rays = problem.rays;
  rays.reserve(participants.points.rays.size());
  for (const std::uint32_t p : order_points(participants, order)) {
    const CandidatePoint& point = participants.points.points[p];
    const auto begin = static_cast<std::uint32_t>(rays.size());
    for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r) {
      Ray ray = participants.points.rays[r];
      ray.image = order.index[ray.image];
      if (ray.image != kNone) rays.push_back(ray);
    }
    std::sort(rays.begin() + begin, rays.end(), [&](const Ray& a, const Ray& b) { return rank(a) < rank(b); });
    std::uint32_t first_free = begin;
    while (first_free < rays.size() && rays[first_free].image >= free) ++first_free;
    problem.points.push_back({point.id, begin, first_free, point.control, point.is_fixed});
    out.start.points.insert(out.start.points.end(), point.position, point.position + 3);
  }
  const auto end = static_cast<std::uint32_t>(rays.size());
  problem.points.push_back({kNone, end, end});
}

// Images, and cameras in the order in which candidates have them.
void lay_out_images(const Block& block, const Participants& participants, const ImageOrder& order,
                    ProblemAndStart& out) {
  std::map<CameraId, int> index_of_camera;
  Problem& problem = out.problem;
  State& start = out.start;
  problem.poses = order.free;
  problem.images.resize(static_cast<std::size_t>(order.all));
  start.rotations.resize(problem.images.size());
  start.frames.resize(problem.images.size());
  for (std::size_t i = 0; i < order.index.size(); ++i) {
    const std::uint32_t index = order.index[i];
    if (index == kNone) continue;
    const ImageId id = participants.images.images[i].id;
    const CameraId camera = block.images.at(id).camera;
    const auto [its, is_new] = index_of_camera.try_emplace(camera, static_cast<int>(problem.cameras.size()));
    if (is_new) problem.cameras.emplace_back().id = camera;
    problem.images[index] = {id, its->second};
    const Rigid3& pose = pose_of(block, id);
    const Eigen::Vector3d centre = centre_of(pose);
    start.rotations[index] = pose.rotation.normalized();
    start.frames[index] = frame_of(pose.rotation.normalized(), centre.data());
  }
}

// The unknowns of a camera that takes part, with their priors.
Result<> lay_out_camera(const Camera& camera, const AdjustScope& scope, const AdjustOptions& options,
                        ProblemCamera& unknowns) {
  const auto first = scope.first_cameras.find(unknowns.id);
  const Camera& given = first == scope.first_cameras.end() ? camera : first->second;
  unknowns.given = given.params;
  const auto own = scope.camera_sigmas.find(unknowns.id);
  const bool is_fixed =
      (own == scope.camera_sigmas.end() && !camera.prior.calibrate) || scope.fixed_cameras.contains(unknowns.id);
  const CameraSigmas sigmas =
      own == scope.camera_sigmas.end() ? calibration_sigmas(options.calibration, given) : own->second;
  for (const int param : params_of(camera)) {
    const double sigma = sigmas[static_cast<std::size_t>(param)];
    if (!(sigma >= 0))
      return fail(Errc::kBadInput, "the standard deviation of " + param_name(param) + " of camera " + camera.name +
                                       " is no number from 0");
    if (is_fixed || sigma == 0) continue;
    unknowns.free.push_back(param);
    unknowns.inverse_sigma[static_cast<std::size_t>(param)] = 1 / sigma;
  }
  return {};
}

// The local deformation of scans, whose marks are at the same positions mostly.
class FilmLayout {
 public:
  // The unknowns of the scan whose camera it is.
  [[nodiscard]] Result<> add(const Camera& camera, ProblemCamera& unknowns) {
    const FilmPrior& prior = *camera.prior.film;
    const FilmField field = film_field(prior, shape_of(prior, camera));
    const Eigen::LLT<Eigen::MatrixXd> factor(field.covariance);
    if (factor.info() != Eigen::Success)
      return fail(Errc::kBadInput, "the deformation of film of " + camera.name + " has no covariance");
    const Eigen::Index count = field.covariance.rows();
    unknowns.film_whitening = factor.matrixL().solve(Eigen::MatrixXd::Identity(count, count));
    for (Eigen::Index k = 0; k < count; ++k)
      for (const int axis : {0, 1}) {
        const int param = Camera::kParams + 2 * static_cast<int>(k) + axis;
        unknowns.free.push_back(param);
        unknowns.given[static_cast<std::size_t>(param)] = axis == 0 ? field.column[k] : field.row[k];
        unknowns.inverse_sigma[static_cast<std::size_t>(param)] = 0;
      }
    return {};
  }

 private:
  const FilmShape& shape_of(const FilmPrior& prior, const Camera& camera) {
    std::vector<Eigen::Vector2d> marks;
    for (const FilmMarkOffset& mark : prior.marks) marks.push_back(mark.pixel);
    if (!shape_ || marks != marks_ || prior.correlation_px != correlation_px_ || prior.functions != functions_) {
      shape_ = film_shape(prior, {double(camera.width_px), double(camera.height_px)}, prior.correlation_px);
      marks_ = std::move(marks);
      correlation_px_ = prior.correlation_px;
      functions_ = prior.functions;
    }
    return *shape_;
  }

  std::optional<FilmShape> shape_;
  std::vector<Eigen::Vector2d> marks_;
  double correlation_px_ = 0;
  int functions_ = 0;
};

Result<> lay_out_cameras(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                         ProblemAndStart& out) {
  Problem& problem = out.problem;
  FilmLayout film;
  for (ProblemCamera& unknowns : problem.cameras) {
    const Camera& camera = block.cameras.at(unknowns.id);
    unknowns.first_global = problem.global_count;
    COLLINEA_TRY(lay_out_camera(camera, scope, options, unknowns));
    if (is_deformed_film(camera) && !scope.fixed_cameras.contains(unknowns.id)) {
      COLLINEA_TRY(film.add(camera, unknowns));
    }
    problem.global_count += static_cast<int>(unknowns.free.size());
    out.start.cameras.push_back(camera.params);
    const bool corrected = scope.corrected_cameras.contains(unknowns.id);
    if (corrected && kind_of(camera, true) == LensKind::kGeneral)
      return fail(Errc::kUnsupported, "camera " + camera.name +
                                          ": measurements are compared after correction with the model "
                                          "brown_of_measured alone, without additional parameters");
    out.start.lenses.push_back(lens_of(camera, corrected));
  }
  problem.first_auxiliary = problem.global_count;
  return {};
}

void count(Problem& problem) {
  problem.unknown_count = 6L * problem.poses + problem.global_count;
  for (std::size_t p = 0; p < problem.point_count(); ++p) {
    problem.unknown_count += problem.point(p).eliminated() ? 3 : 0;
    if (problem.first_control == p && problem.point(p).control < 0) ++problem.first_control;
  }
  problem.observation_count = 0;
  for_each_kind<kEvery>([&]<class Kind>() {
    Kind::for_each(problem, [&](const auto& item) { problem.observation_count += Kind::count(problem, item); });
  });
}

Result<> check_size(const Problem& problem) {
  if (problem.global_count <= kMostGlobalUnknowns) return {};
  return fail(Errc::kUnsupported,
              std::to_string(problem.cameras.size()) + " cameras with " + std::to_string(problem.first_auxiliary) +
                  " unknowns to calibrate and " + std::to_string(problem.global_count - problem.first_auxiliary) +
                  " of points that are measured on the ground: more than " + std::to_string(kMostGlobalUnknowns) +
                  " do not fit into memory. Images of one camera should share it; or hold the cameras, or "
                  "calibrate fewer parameters");
}

}  // namespace

ImageOrder order_images(const Block& block, const Participants& participants) {
  const std::size_t candidates = participants.has_image.size();
  std::vector<int> free_index(candidates, -1);
  ImageOrder result;
  for (std::size_t i = 0; i < candidates; ++i)
    if (participants.is_unknown(i)) free_index[i] = result.free++;
  const std::vector<int> order = order_of_free(block, participants, result.free, free_index);
  result.index.assign(candidates, kNone);
  result.all = result.free;
  for (std::size_t i = 0; i < candidates; ++i)
    if (participants.has_image[i])
      result.index[i] = static_cast<std::uint32_t>(free_index[i] >= 0 ? order[free_index[i]] : result.all++);
  return result;
}

Result<ProblemAndStart> lay_out(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                Participants participants, const ImageOrder& order) {
  ProblemAndStart out;
  lay_out_points(participants, order, out);
  lay_out_images(block, participants, order, out);
  out.problem.control = std::move(participants.points.control);
  out.problem.images_left_out = std::move(participants.images_left_out);
  out.problem.geodetic_left_out = participants.geodetic_left_out;
  COLLINEA_TRY(lay_out_cameras(block, scope, options, out));
  COLLINEA_TRY(lay_out_instruments(block, scope, out));
  lay_out_geodetic(block, participants.points.geodetic, out);
  count(out.problem);
  COLLINEA_TRY(check_size(out.problem));
  return out;
}

}  // namespace collinea::bundle
