// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/marked_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "collinea/adjust/bundle.h"
#include "collinea/adjust/reduced_system.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/math/quantiles.h"
#include "collinea/quality/internal/mark_equations.h"

namespace collinea {

using bundle::BlockMotion;
using bundle::CovarianceOfImages;
using bundle::MarkGround;
using bundle::MarkLink;
using bundle::MarkPoint;
using bundle::MarkSolution;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kLeastSurveySigma_m = 1e-4;
constexpr double kNoRedundancy = 1e-9;

Vector3d sigmas_of(const SurveyedPosition& surveyed) { return surveyed.sigma_m.cwiseMax(kLeastSurveySigma_m); }

Matrix3d weight_of(const SurveyedPosition& surveyed) {
  return survey_weight(sigmas_of(surveyed), surveyed.correlation).value_or(Matrix3d::Zero());
}

Result<> check(std::span<const BlockPoint> points) {
  std::size_t marks = 0;
  for (const BlockPoint& point : points) {
    for (const BlockMark& mark : point.marks)
      if (!(mark.sigma_px > 0) || !std::isfinite(mark.sigma_px) || !mark.shape.is_valid() || !mark.pixel.allFinite())
        return fail(Errc::kBadInput, "a mark needs two coordinates and a standard deviation above 0");
    marks += point.marks.size();
    if (!point.surveyed) continue;
    const SurveyedPosition& surveyed = *point.surveyed;
    if (!(surveyed.sigma_m.minCoeff() >= 0) || !survey_weight(sigmas_of(surveyed), surveyed.correlation))
      return fail(Errc::kBadInput, "the standard deviations or correlations of a surveyed point are those of none");
    for (int axis = 0; axis < 3; ++axis)
      if (std::isfinite(surveyed.sigma_m[axis]) && !std::isfinite(surveyed.position_in_world[axis]))
        return fail(Errc::kBadInput, "a surveyed coordinate is no number");
  }
  if (marks > MarkedBlock::kMostMarks)
    return fail(Errc::kUnsupported, "more than " + std::to_string(MarkedBlock::kMostMarks) +
                                        " marks: adjust the block with those that are done");
  return {};
}

// A point that takes part.
struct Taken {
  std::size_t number = 0;  // among those that were given
  MarkPoint point;
  std::vector<std::size_t> marks;   // of each ray
  bool by_its_coordinates = false;  // its rays alone do not determine it
};

// Indices of the images that take part.
std::map<ImageId, std::uint32_t> image_numbers(const bundle::Problem& problem) {
  std::map<ImageId, std::uint32_t> out;
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    const ImageId id = problem.images[i].id;
    if (!std::ranges::count(problem.images_left_out, id)) out[id] = static_cast<std::uint32_t>(i);
  }
  return out;
}

// Nothing when neither its rays nor its coordinates say where it is.
std::optional<Taken> taken_of(const BlockPoint& given, const Block& block,
                              const std::map<ImageId, std::uint32_t>& numbers) {
  Taken taken;
  std::vector<SightLine> lines;
  for (std::size_t m = 0; m < given.marks.size(); ++m) {
    const BlockMark& mark = given.marks[m];
    const auto image = numbers.find(mark.image);
    if (image == numbers.end()) continue;
    lines.push_back({&block.camera_of(mark.image), pose_of(block, mark.image), mark.pixel, mark.sigma_px, mark.shape});
    taken.point.rays.push_back({{mark.pixel.x(), mark.pixel.y()},
                                1 / mark.sigma_px,
                                image->second,
                                static_cast<std::uint32_t>(m),
                                bundle::whitening_of(mark.shape)});
    taken.marks.push_back(m);
  }
  const bool is_control = given.surveyed && given.surveyed->role == ControlRole::kControl;
  if (is_control) {
    taken.point.given = given.surveyed->sigma_m.array().isFinite().select(given.surveyed->position_in_world, 0.0);
    taken.point.weight = weight_of(*given.surveyed);
  }
  taken.point.takes_part = is_control || !given.surveyed;
  if (const auto met = intersect(lines)) {
    taken.point.start = met->point_in_world;
    return taken;
  }
  if (lines.empty() || !is_control || !given.surveyed->sigma_m.allFinite()) return std::nullopt;
  taken.point.start = given.surveyed->position_in_world;
  taken.by_its_coordinates = true;
  return taken;
}

// Points with a measurement on the ground take part; of check points their coordinates do not.
void let_linked_take_part(std::span<const PointLink> ground, std::vector<Taken>& taken) {
  std::set<std::size_t> linked;
  for (const PointLink& link : ground)
    if (link.observation.role == ControlRole::kControl) linked.insert({link.from, link.to});
  for (Taken& one : taken) one.point.takes_part |= linked.contains(one.number);
}

/// Measurements on the ground as unknowns of their own need them: lays out orientations of set-ups and shapes.
class GroundLayout {
 public:
  GroundLayout(std::span<const Taken> taken, const Earth& earth) : earth_(earth) {
    for (const Taken& one : taken)
      if (one.point.takes_part) {
        numbers_[one.number] = starts_.size();
        starts_.push_back(one.point.start);
      }
  }

  MarkGround lay_out(std::span<const PointLink> ground, bool with_shapes) {
    MarkGround out;
    std::map<ShapeKey, std::set<std::size_t>> members;
    std::map<std::uint32_t, int> directions;  // of each set-up
    for (const PointLink& link : ground) {
      if (!takes_part(link)) continue;
      if (link.observation.is_of_shape()) members[key_of(link)].insert(numbers_.at(link.from));
      if (link.observation.kind == GeodeticKind::kDirection) ++directions[link.observation.setup];
    }
    if (with_shapes) begin_shapes(members, out);
    for (const PointLink& link : ground) {
      if (!takes_part(link)) continue;
      MarkLink made{link.observation, numbers_.at(link.from), numbers_.at(link.to)};
      if (link.observation.is_of_shape()) {
        const auto shape = shapes_.find(key_of(link));
        if (shape == shapes_.end()) continue;
        made.shape = shape->second.first;
        made.auxiliary =
            shape->second.second + (link.observation.kind == GeodeticKind::kOnLine ? 2 * link.observation.axis : 0);
      } else if (link.observation.kind == GeodeticKind::kDirection) {
        if (directions.at(link.observation.setup) < 2) continue;  // it orients the set-up, and says no more
        made.auxiliary = orientation_of(made, out);
      }
      out.links.push_back(made);
    }
    return out;
  }

 private:
  using ShapeKey = std::pair<GeodeticKind, std::uint32_t>;
  static ShapeKey key_of(const PointLink& link) { return {link.observation.kind, link.observation.setup}; }
  [[nodiscard]] bool takes_part(const PointLink& link) const {
    return link.observation.role == ControlRole::kControl && numbers_.contains(link.from) && numbers_.contains(link.to);
  }

  void begin_shapes(const std::map<ShapeKey, std::set<std::size_t>>& members, MarkGround& out) {
    for (const auto& [key, points] : members) {
      std::vector<Vector3d> positions;
      for (const std::size_t point : points) positions.push_back(starts_[point]);
      const auto shape = shape_through(key.first, positions);
      if (!shape || static_cast<int>(points.size()) <= points_of_shape(key.first)) continue;
      shapes_[key] = {static_cast<int>(out.shapes.size()), static_cast<int>(out.auxiliaries.size())};
      out.shapes.push_back(*shape);
      out.auxiliaries.resize(out.auxiliaries.size() + std::size_t(unknowns_of_shape(key.first)), 0);
      if (key.first != GeodeticKind::kAtHeight) continue;
      constexpr double kZero = 0;
      for (const Vector3d& position : positions)
        out.auxiliaries.back() += shape_model({.kind = key.first}, *shape, &kZero, position, earth_).computed /
                                  static_cast<double>(positions.size());
    }
  }

  // By its first direction; those that follow are at most a turn away, and residuals of angles know no turns.
  int orientation_of(const MarkLink& link, MarkGround& out) {
    const auto [its, is_first] =
        orientations_.try_emplace(link.observation.setup, static_cast<int>(out.auxiliaries.size()));
    if (is_first)
      out.auxiliaries.push_back(-geodetic_residual(
          link.observation, geodetic_model(link.observation, starts_[link.from], starts_[link.to], 0, earth_)));
    return its->second;
  }

  const Earth& earth_;
  std::map<std::size_t, std::size_t> numbers_;  // of points that take part, among these
  std::vector<Vector3d> starts_;
  std::map<ShapeKey, std::pair<int, int>> shapes_;  // number of the shape, and of its first unknown
  std::map<std::uint32_t, int> orientations_;       // of set-ups
};

MarkGround ground_of(std::span<const Taken> taken, std::span<const PointLink> ground, const Earth& earth,
                     bool with_shapes) {
  return GroundLayout(taken, earth).lay_out(ground, with_shapes);
}

Result<> check(std::span<const PointLink> ground, std::size_t points) {
  for (const PointLink& link : ground) {
    if (link.from >= points || link.to >= points)
      return fail(Errc::kBadInput, "a measurement on the ground is of a point that there is not");
    if (!(link.observation.sigma > 0) || !std::isfinite(link.observation.sigma) ||
        !std::isfinite(link.observation.value))
      return fail(Errc::kBadInput, "a measurement on the ground is no number with a positive standard deviation");
    if (link.observation.is_of_shape() != (link.from == link.to))
      return fail(Errc::kBadInput, "a measurement on the ground joins a point with itself, or a shape has two points");
  }
  return {};
}

BlockMarkTest test_of(const bundle::Ray& ray, const MarkSolution& solution, Index row, double sigma0, double delta0) {
  BlockMarkTest out;
  out.redundancy = solution.redundancy.segment<2>(row).cwiseMax(0).cwiseMin(1);
  const Vector2d in_sigmas = solution.residuals.segment<2>(row);
  const double sigma_px = 1 / ray.inverse_sigma;
  out.residual_px = sigma_px * in_sigmas;
  if (!ray.whitening.is_plain())
    out.residual_px.y() = (out.residual_px.y() + ray.whitening.of_column * out.residual_px.x()) / ray.whitening.of_row;
  for (int axis = 0; axis < 2; ++axis) {
    if (!(out.redundancy[axis] > kNoRedundancy)) continue;
    const double spread = sigma0 * solution.residual_sigmas[row + axis];
    const double own_px = axis == 1 ? sigma_px / double(ray.whitening.of_row) : sigma_px;
    out.w[axis] = in_sigmas[axis] / spread;
    out.minimal_detectable_bias_px[axis] = delta0 * spread * own_px / out.redundancy[axis];
  }
  return out;
}

// Differences from the survey, which of control are residuals: sigma0 multiplies what the block says, and the survey is
// as stated.
void compare(const SurveyedPosition& surveyed, const Matrix3d& cofactor, bool takes_part, double sigma0,
             AdjustedMark& out) {
  const Vector3d sigma = sigmas_of(surveyed);
  const Matrix3d by_survey = cofactor * weight_of(surveyed) * cofactor;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(sigma[axis])) continue;
    out.difference_m[axis] = (*out.position_in_world)[axis] - surveyed.position_in_world[axis];
    const double whole = cofactor(axis, axis), survey = sigma[axis] * sigma[axis];
    const double of_survey = by_survey(axis, axis);
    out.difference_sigma_m[axis] =
        takes_part ? std::sqrt(std::max(0.0, sigma0 * sigma0 * (whole - of_survey) + survey - 2 * whole + of_survey))
                   : std::sqrt(sigma0 * sigma0 * whole + survey);
  }
}

}  // namespace

struct MarkedBlock::State {
  Block block;
  std::optional<bundle::ReducedSystem> system;
  std::optional<CovarianceOfImages> covariance;
  std::map<ImageId, std::uint32_t> numbers;  // of its images in the problem
  double sigma0 = 1;
  std::optional<BlockMotion> motion;  // of a block that nothing fixes
};

MarkedBlock::MarkedBlock(std::unique_ptr<State> state) : state_(std::move(state)) {}
MarkedBlock::MarkedBlock(MarkedBlock&&) noexcept = default;
MarkedBlock& MarkedBlock::operator=(MarkedBlock&&) noexcept = default;
MarkedBlock::~MarkedBlock() = default;

const Block& MarkedBlock::block() const { return state_->block; }

Result<MarkedBlock> MarkedBlock::of(Block block, const AdjustScope& scope, const AdjustOptions& options,
                                    BlockControl control, const Run& run) {
  auto state = std::make_unique<State>();
  const AdjustScope as_given = with_first_cameras(scope, block.cameras);
  COLLINEA_TRY(const Adjusted adjusted, collinea::adjust(block, as_given, options, run));
  apply(adjusted, block);
  state->sigma0 = sigma_scale(adjusted);
  state->block = std::move(block);
  if (control == BlockControl::kLeftOut) {
    state->block.control.clear();
    state->block.control_observations.clear();
    state->block.geodetic.clear();
  }
  COLLINEA_TRY(state->system, bundle::reduced_system(state->block, as_given, options, run));
  const bundle::Problem& problem = *state->system->problem;
  if (problem.rank_defect > 0) {
    if (problem.rank_defect != 7 || !problem.moves_as_one || problem.datum.empty())
      return fail(Errc::kUnsupported, "a part of the block has no datum of its own: adjust it with its control");
    state->motion = BlockMotion{{}, problem.datum.front().centre, problem.datum.front().size};
  }
  state->covariance.emplace(6 * problem.poses + problem.global_count, std::move(state->system->factor));
  state->numbers = image_numbers(problem);
  return MarkedBlock(std::move(state));
}

namespace {

std::optional<MarkSolution> solved_marks(const bundle::ReducedSystem& system, std::span<const Taken> taken,
                                         CovarianceOfImages& covariance, const std::optional<BlockMotion>& motion,
                                         std::span<const PointLink> ground = {}) {
  std::vector<MarkPoint> points;
  for (const Taken& one : taken) points.push_back(one.point);
  const MarkGround measured = ground_of(taken, ground, system.problem->earth, !motion);
  return bundle::solve_marks(*system.problem, system.state, points, covariance, system.step, motion, measured);
}

// Of a block that is not placed: coordinates say nothing of it.
void forget_coordinates(std::vector<Taken>& taken) {
  std::erase_if(taken, [](const Taken& one) { return one.by_its_coordinates; });
  for (Taken& one : taken) one.point.weight.setZero();
}

// Rays may meet nearly nowhere: such points have no position, and keep nobody else from his. Whether any was found.
bool leave_out_undetermined(const bundle::ReducedSystem& system, CovarianceOfImages& covariance,
                            std::vector<Taken>& taken) {
  return std::erase_if(taken, [&](const Taken& one) {
           return !solved_marks(system, {&one, 1}, covariance, std::nullopt);
         }) > 0;
}

}  // namespace

Result<AdjustedMarks> MarkedBlock::adjust(std::span<const BlockPoint> points, const TestOptions& test,
                                          std::span<const PointLink> ground) {
  COLLINEA_TRY(check(points));
  COLLINEA_TRY(check(ground, points.size()));
  COLLINEA_TRY(validate(test));
  State& state = *state_;
  AdjustedMarks out;
  out.sigma0 = state.sigma0;
  std::vector<Taken> taken;
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.points.emplace_back().marks.resize(points[i].marks.size());
    auto one = taken_of(points[i], state.block, state.numbers);
    if (!one) continue;
    one->number = i;
    taken.push_back(*std::move(one));
  }
  let_linked_take_part(ground, taken);
  auto solution = solved_marks(*state.system, taken, *state.covariance, state.motion, ground);
  if (!solution && leave_out_undetermined(*state.system, *state.covariance, taken))
    solution = solved_marks(*state.system, taken, *state.covariance, state.motion, ground);
  if (!solution && state.motion) {
    out.placed = false;
    forget_coordinates(taken);
    solution = solved_marks(*state.system, taken, *state.covariance, std::nullopt);
  }
  if (!solution) return fail(Errc::kIllPosed, "the marks of a point do not determine it");
  out.converged = solution->converged;
  out.covariance_m2 = state.sigma0 * state.sigma0 * solution->cofactor;
  const double delta0 = detectable_shift(test);
  Index row = 0;
  for (std::size_t p = 0; p < taken.size(); ++p) {
    const Taken& one = taken[p];
    AdjustedMark& mark = out.points[one.number];
    mark.position_in_world = solution->positions[p];
    const Matrix3d& cofactor = solution->cofactors[p];
    mark.covariance_m2 = state.sigma0 * state.sigma0 * cofactor;
    for (std::size_t r = 0; r < one.marks.size(); ++r, row += 2)
      mark.marks[one.marks[r]] = test_of(one.point.rays[r], *solution, row, state.sigma0, delta0);
    if (const auto& surveyed = points[one.number].surveyed)
      compare(*surveyed, cofactor, !one.point.weight.isZero(0), state.sigma0, mark);
  }
  return out;
}

}  // namespace collinea
