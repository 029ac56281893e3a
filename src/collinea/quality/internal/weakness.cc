// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/weakness.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>

#include "collinea/adjust/block_motion.h"
#include "collinea/base/parallel.h"
#include "collinea/math/median.h"
#include "collinea/math/random.h"
#include "collinea/quality/internal/ground_motion.h"
#include "collinea/quality/internal/point_cofactor.h"
#include "collinea/quality/mismatches.h"

namespace collinea::bundle {
namespace {

// Motions of the images of a camera that its parameters can stand for.
constexpr std::array kImitatingMotions = {Aspect::kDistance, Aspect::kTiltX, Aspect::kTiltY, Aspect::kPositionX,
                                          Aspect::kPositionY};
constexpr double kDegrees = 180 / std::numbers::pi;
// A motion of the whole block that moves its edge by so many standard deviations of what fixes the block.
constexpr double kWeakMotion = 5;
// A parameter that owes half of its information, and more, to its pseudo-observation.
constexpr double kShareOfPrior = 0.5;
// A motion whose standard deviation the camera's parameters enlarge so many times: a correlation of 0.995 with them.
// (Principal point and tilt have 0.97 in any block whose images look down.)
constexpr double kInflation = 10;
constexpr double kWeakImage = 5;  // times the median standard deviation
// Standard deviation of the distance to a point over the distance. A parallax that is not ten times its own standard
// deviation may be the errors of the measurements alone, to which the positions in the images were fitted.
constexpr double kDepthUnknown = 0.1;
constexpr std::size_t kMostCameras = 3, kSampledPoints = 300;

// Azimuth of an axis, either way along it, and how steep it is.
std::vector<Figure> figures_of_axis(const Eigen::Vector3d& axis) {
  double azimuth_deg = std::fmod(std::atan2(axis.x(), axis.y()) * kDegrees + 360, 180);
  if (azimuth_deg > 179.5) azimuth_deg = 0;
  return {{FigureName::kAzimuth, azimuth_deg}, {FigureName::kSteepness, std::abs(axis.z())}};
}

std::vector<Subject> subjects_of(const std::vector<ImageId>& images) { return {images.begin(), images.end()}; }

// Standard deviations of a point by its rays alone, images being exact; nothing where they do not fix it.
std::optional<Eigen::Vector3d> sigmas_by_rays(const Problem& problem, const State& state, std::size_t p) {
  PointSystem system(problem);
  for (std::uint32_t r = problem.point(p).first_ray; r < problem.end_ray(p); ++r) {
    LinearRay linear;
    linearise(problem, state, problem.rays[r], &state.points[3 * p], problem.loss_of(problem.point(p)), &linear);
    system.add(linear, static_cast<int>(problem.rays[r].image), state);
  }
  system.close(false, nullptr, &state.points[3 * p]);
  if (problem.point(p).first_ray == problem.end_ray(p) || !system.determined()) return {};
  Eigen::Vector3d sigmas;
  for (int axis = 0; axis < 3; ++axis) sigmas[axis] = std::sqrt(system.solve_own(Eigen::Vector3d::Unit(axis))[axis]);
  return sigmas;
}

Figure count_of(std::size_t count) { return {FigureName::kCount, static_cast<double>(count)}; }

}  // namespace

void WeaknessFinder::add(Finding finding) { weaknesses_.push_back(std::move(finding)); }

bool WeaknessFinder::has(std::initializer_list<FindingCode> codes) const {
  return std::any_of(weaknesses_.begin(), weaknesses_.end(), [&](const Finding& weak) {
    return std::find(codes.begin(), codes.end(), weak.code) != codes.end();
  });
}

std::vector<Subject> WeaknessFinder::subjects(const std::vector<int>& images) const {
  std::vector<Subject> all;
  for (const int image : images) all.emplace_back(problem_.images[image].id);
  return all;
}

void WeaknessFinder::look_at_observations() {
  std::map<int, std::vector<const DatumConstraint*>> of_part;
  for (const DatumConstraint& unseen : problem_.datum) of_part[unseen.part].push_back(&unseen);
  for (const auto& [part, unseen] : of_part) name_unseen(unseen, of_part.size() == 1);
  if (!adjusted_.images_left_out.empty()) {
    add(finding_of(FindingCode::kImagesLeftOut, subjects_of(adjusted_.images_left_out),
                   {count_of(adjusted_.images_left_out.size())}, {RemedyCode::kMeasureTiePoints}));
  }
  if (const std::size_t count = problem_.geodetic_left_out; count > 0)
    add(finding_of(FindingCode::kGeodeticLeftOut, {},
                   {count_of(count), {FigureName::kOf, static_cast<double>(block_.geodetic.size())}},
                   {RemedyCode::kMeasureGroundPoints}));
  if (auto left = mismatches_left(block_, adjusted_)) add(*std::move(left));
}

// The variance of the logarithm of a point's distance from the first of its images; infinite where nothing tells it.
double WeaknessFinder::variance_of_distance(std::size_t p, TileCholesky* inverse) const {
  const auto image = problem_.rays[problem_.point(p).first_free].image;
  const Eigen::Vector3d from = Eigen::Map<const Eigen::Vector3d>(&state_.points[3 * p]) - centre_in(state_, image);
  const double distance = from.norm();
  const PointSystem system(problem_, state_, p);
  if (!system.determined() || !(distance > 0)) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d direction = from / (distance * distance);
  if (!inverse) return direction.dot(system.solve_own(direction));
  // That of all distances together, the scale of the block, is another matter.
  const PointSystem::Relative relative =
      system.relative_to(static_cast<int>(image), direction, *inverse, with_scale_.data());
  return relative.variance - (scale_variance_ > 0 ? relative.product * relative.product / scale_variance_ : 0);
}

// The mean logarithm of the distances of some points stands for the scale.
void WeaknessFinder::look_at_scale(const TileCholesky& factor) {
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(6 * problem_.poses + problem_.global_count);
  std::size_t sampled = 0;
  const std::size_t step = std::max<std::size_t>(1, problem_.point_count() / kSampledPoints);
  for (std::size_t p = 0; p < problem_.point_count(); p += step) {
    const std::uint32_t ray = problem_.point(p).first_free;
    if (!problem_.point(p).eliminated() || ray >= problem_.end_ray(p)) continue;
    const PointSystem system(problem_, state_, p);
    const auto image = problem_.rays[ray].image;
    const Eigen::Vector3d from = Eigen::Map<const Eigen::Vector3d>(&state_.points[3 * p]) - centre_in(state_, image);
    if (!system.determined() || !(from.norm() > 0)) continue;
    system.add_following(from / from.squaredNorm(), scale);
    scale.segment<3>(6 * static_cast<Eigen::Index>(image) + 3) -= from / from.squaredNorm();
    ++sampled;
  }
  if (sampled > 0) scale /= static_cast<double>(sampled);
  with_scale_ = solved(factor, std::vector<double>(scale.data(), scale.data() + scale.size()));
  scale_variance_ = scale.dot(Eigen::Map<const Eigen::VectorXd>(with_scale_.data(), scale.size()));
}

void WeaknessFinder::look_at_bases(TileCholesky* inverse, const Run& run) {
  const double limit = std::pow(kDepthUnknown / std::max(sigma_scale(adjusted_), 1e-300), 2);
  std::vector<char> unknown(problem_.point_count(), 0), asked = unknown;
  parallel_for(run, problem_.point_count(), [&](std::size_t p) {
    const ProblemPoint& point = problem_.point(p);
    if (point.is_fixed || point.control >= 0 || point.first_free == problem_.end_ray(p)) return;
    asked[p] = 1;
    unknown[p] = !(variance_of_distance(p, inverse) < limit);
  });
  std::vector<int> points(problem_.images.size(), 0), deep(problem_.images.size(), 0);
  for (std::size_t p = 0; p < problem_.point_count(); ++p)
    for (std::uint32_t r = problem_.point(p).first_ray; asked[p] && r < problem_.end_ray(p); ++r) {
      ++points[problem_.rays[r].image];
      deep[problem_.rays[r].image] += unknown[p];
    }
  std::vector<int> rotated;
  for (int i = 0; i < problem_.poses; ++i)
    if (points[i] > 0 && 2 * deep[i] > points[i]) rotated.push_back(i);
  if (!rotated.empty())
    add(finding_of(FindingCode::kNoBase, subjects(rotated), {count_of(rotated.size())},
                   {RemedyCode::kAddImagesFromElsewhere}));
}

// The control of a part whose coordinates take part.
WeaknessFinder::KnownInPart WeaknessFinder::known_in(int part) const {
  KnownInPart known;
  const auto is_in = [&](std::uint32_t image) {
    return static_cast<int>(image) < problem_.poses && problem_.part_of_pose[image] == part;
  };
  for (std::size_t p = problem_.first_control; p < problem_.point_count(); ++p) {
    const ProblemPoint& point = problem_.point(p);
    if (point.control < 0 || problem_.part_of_point[p] != part) continue;
    const Eigen::Map<const Eigen::Array3d> inverse_sigma(problem_.control[point.control].inverse_sigma);
    if (!point.is_fixed && !(inverse_sigma > 0).any()) continue;
    known.whole = known.whole && (point.is_fixed || (inverse_sigma > 0).all());
    known.control.push_back(ControlId{point.id});
  }
  std::sort(known.control.begin(), known.control.end(),
            [&](ControlId a, ControlId b) { return block_.control.at(a).name < block_.control.at(b).name; });
  known.control_alone = std::none_of(problem_.positions.begin(), problem_.positions.end(), [&](const auto& position) {
    return is_in(position.image) && position.axes() > 0;
  });
  return known;
}

namespace {

// What of a block's position, attitude and scale nothing fixes, and for each what would.
struct Unfixed {
  std::vector<Subject> what;
  std::vector<Remedy> remedies;
  std::vector<Figure> figures;  // of an axis

  void add(Aspect aspect, RemedyCode remedy) {
    what.emplace_back(aspect);
    remedies.emplace_back(remedy);
  }
};

// Names the motions that scale and rotate: log scale in the last row of `space`, rotations in the three before.
void name_rotations(const Eigen::MatrixXd& space, Unfixed& unfixed) {
  if (space.row(3).norm() > 0.3) unfixed.add(Aspect::kScale, RemedyCode::kGiveScale);
  const Eigen::JacobiSVD<Eigen::MatrixXd> axes(space.topRows(3), Eigen::ComputeFullU);
  int rotations = 0;
  while (rotations < std::min<int>(3, static_cast<int>(axes.singularValues().size())) &&
         axes.singularValues()[rotations] > 0.3)
    ++rotations;
  const bool upright = rotations == 2 && std::abs(axes.matrixU()(2, 2)) > 0.9;
  if (rotations == 3) {
    unfixed.add(Aspect::kAttitude, RemedyCode::kGiveControlForAttitude);
  } else if (upright) {
    unfixed.add(Aspect::kTilt, RemedyCode::kGiveHeightsForTilt);
  } else if (rotations == 2) {
    unfixed.add(Aspect::kTwoRotations, RemedyCode::kGiveControlOffLine);
  } else if (rotations == 1) {
    unfixed.add(Aspect::kRotation, RemedyCode::kGiveControlOffThatLine);
    unfixed.figures = figures_of_axis(axes.matrixU().col(0));
  }
}

void name_shifts(const Eigen::MatrixXd& shifts, Unfixed& unfixed) {
  if (shifts.cols() == 3)
    unfixed.add(Aspect::kPosition, RemedyCode::kGivePosition);
  else if (shifts.cols() == 1 && std::abs(shifts(2, 0)) > 0.9 * shifts.norm())
    unfixed.add(Aspect::kHeight, RemedyCode::kGiveHeight);
  else if (shifts.row(2).norm() < 0.1 * shifts.norm())
    unfixed.add(Aspect::kPlan, RemedyCode::kGivePlan);
  else
    unfixed.add(Aspect::kSomeShift, RemedyCode::kGiveMoreCoordinates);
}

}  // namespace

// The motions that nothing observes: first what turns and scales, then what is only shifted. Subjects are these, then
// the control points that alone are known, then an image of the part when there are others.
void WeaknessFinder::name_unseen(const std::vector<const DatumConstraint*>& unseen, bool whole) {
  const auto count = static_cast<int>(unseen.size());
  const std::vector<Subject> which = whole ? std::vector<Subject>() : subjects({unseen.front()->poses.front()});
  const Figure defect{FigureName::kDefect, static_cast<double>(count)};
  if (count == 7) {
    add(finding_of(FindingCode::kNoDatum, which, {defect}, {RemedyCode::kFixDatum}));
    return;
  }
  const KnownInPart known = known_in(unseen.front()->part);
  Eigen::MatrixXd motions(7, count);
  for (int k = 0; k < count; ++k) motions.col(k) = unseen[static_cast<std::size_t>(k)]->motion;
  const Eigen::JacobiSVD<Eigen::MatrixXd> turning(motions.bottomRows(4), Eigen::ComputeFullU | Eigen::ComputeFullV);
  int rank = 0;
  while (rank < std::min(4, count) && turning.singularValues()[rank] > 1e-4) ++rank;
  Unfixed unfixed;
  if (rank > 0) name_rotations(turning.matrixU().leftCols(rank), unfixed);
  if (count > rank) name_shifts((motions * turning.matrixV().rightCols(count - rank)).topRows(3), unfixed);
  Finding finding = finding_of(FindingCode::kDatumDefect, unfixed.what, {defect}, unfixed.remedies);
  finding.figures.insert(finding.figures.end(), unfixed.figures.begin(), unfixed.figures.end());
  if (known.control_alone && (known.control.size() == 1 || (known.control.size() == 2 && known.whole)))
    finding.subjects.insert(finding.subjects.end(), known.control.begin(), known.control.end());
  finding.subjects.insert(finding.subjects.end(), which.begin(), which.end());
  add(std::move(finding));
}

// Images through which alone two parts hang together: each part has its own scale.
void WeaknessFinder::name_articulation_images() {
  constexpr int kMostImages = 3000;  // each is tried: the square of their number
  if (problem_.poses > kMostImages) return;
  std::vector<std::set<int>> neighbours(static_cast<std::size_t>(problem_.poses));
  for (std::size_t p = 0; p < problem_.point_count(); ++p)
    for (std::uint32_t a = problem_.point(p).first_free; a < problem_.end_ray(p); ++a)
      for (std::uint32_t b = problem_.point(p).first_free; b < a; ++b) {
        const int i = static_cast<int>(problem_.rays[a].image), k = static_cast<int>(problem_.rays[b].image);
        neighbours[i].insert(k);
        neighbours[k].insert(i);
      }
  std::vector<int> articulation_images;
  for (int articulation_image = 0; articulation_image < problem_.poses; ++articulation_image) {
    if (neighbours[articulation_image].size() < 2) continue;
    std::vector<bool> reached(neighbours.size(), false);
    std::vector<int> open{*neighbours[articulation_image].begin()};
    reached[articulation_image] = reached[open.front()] = true;
    while (!open.empty()) {
      const int at = open.back();
      open.pop_back();
      for (const int next : neighbours[at])
        if (!reached[next]) {
          reached[next] = true;
          open.push_back(next);
        }
    }
    if (std::any_of(neighbours[articulation_image].begin(), neighbours[articulation_image].end(),
                    [&](int k) { return !reached[k]; }))
      articulation_images.push_back(articulation_image);
  }
  if (articulation_images.empty()) return;
  std::sort(articulation_images.begin(), articulation_images.end(),
            [&](int a, int b) { return problem_.images[a].id < problem_.images[b].id; });
  add(finding_of(FindingCode::kScaleDrifts, subjects(articulation_images), {count_of(articulation_images.size())},
                 {RemedyCode::kAddTripleOverlap}));
}

void WeaknessFinder::look_at_loose_images(Solved& solved, const Run& run) {
  name_articulation_images();
  constexpr double kStiffer = 1e-10;  // of each diagonal element: what is determined resists a thousand times as much
  constexpr int kVectors = 4, kRounds = 6;
  const auto factor = solved.factor_stiffened(kStiffer, run).factor;
  if (!factor || run.stopped()) return;
  // In units of the stiffening, D: (N + e D)^-1 D again and again.
  const std::vector<double> stiffening = solved.diagonal();
  const std::size_t size = stiffening.size();
  Eigen::MatrixXd vectors(static_cast<Eigen::Index>(size), kVectors);
  Random random(1);
  for (Eigen::Index i = 0; i < vectors.rows(); ++i)
    for (int k = 0; k < kVectors; ++k)
      vectors(i, k) = stiffening[static_cast<std::size_t>(i)] > 0
                          ? random.normal() / std::sqrt(stiffening[static_cast<std::size_t>(i)])
                          : 0;
  const Eigen::Map<const Eigen::VectorXd> weights(stiffening.data(), static_cast<Eigen::Index>(size));
  Eigen::Matrix<double, kVectors, 1> grown;
  for (int round = 0; round < kRounds; ++round)
    for (int k = 0; k < kVectors; ++k) {
      std::vector<double> x(size, 0.0);
      for (std::size_t i = 0; i < size; ++i)
        x[i] = weights[static_cast<Eigen::Index>(i)] * vectors(static_cast<Eigen::Index>(i), k);
      factor->solve(x.data());
      vectors.col(k) = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(size));
      for (int other = 0; other < k; ++other)
        vectors.col(k) -= vectors.col(other) * vectors.col(other).dot(weights.cwiseProduct(vectors.col(k)));
      grown[k] = std::sqrt(vectors.col(k).dot(weights.cwiseProduct(vectors.col(k))));
      if (grown[k] > 0) vectors.col(k) /= grown[k];
    }
  std::vector<std::pair<double, int>> by_image;
  for (int i = 0; i < problem_.poses; ++i) {
    double moved = 0;
    for (int k = 0; k < kVectors; ++k)
      if (grown[k] * kStiffer > 1e-3)  // what nothing but the stiffening holds grows by 1 / e
        moved += vectors.col(k).segment<6>(6 * i).cwiseAbs2().dot(weights.segment<6>(6 * i));
    by_image.emplace_back(moved, i);
  }
  std::sort(by_image.begin(), by_image.end(), [](auto a, auto b) { return a.first > b.first; });
  std::vector<int> loose;
  for (const auto& [moved, image] : by_image)
    if (moved > 0.1 * by_image.front().first && moved > 0) loose.push_back(image);
  if (loose.empty() || has({FindingCode::kScaleDrifts, FindingCode::kNoBase})) return;
  add(finding_of(FindingCode::kLooseImages, subjects(loose), {count_of(loose.size())},
                 {RemedyCode::kMeasureTiePointsBetween}));
}

std::vector<double> WeaknessFinder::solved(const TileCholesky& factor, std::vector<double> right) const {
  right.resize(static_cast<std::size_t>(factor.tile_rows()) * kTile, 0.0);
  factor.solve(right.data());
  return right;
}

void WeaknessFinder::look_at_correlations(const TileCholesky& factor) {
  std::vector<std::size_t> images(problem_.cameras.size(), 0), order(problem_.cameras.size());
  for (int i = 0; i < problem_.poses; ++i) ++images[problem_.images[i].camera];
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return images[a] > images[b]; });
  for (std::size_t k = 0; k < std::min(kMostCameras, order.size()); ++k)
    if (const ProblemCamera& camera = problem_.cameras[order[k]];
        !camera.free.empty() && !camera.is_of_film() && images[order[k]] > 0)
      look_at_camera(factor, order[k]);
  // What a camera leaves open moves the block too: that is named already.
  const bool by_camera =
      has({FindingCode::kFocalAndHeight, FindingCode::kCameraAndPose, FindingCode::kParameterNotDetermined});
  if (problem_.poses > 1 && !by_camera) look_at_motions(factor);
  look_at_scale(factor);
}

// The median standard deviation of what fixes plan or height: control, where there are three and more, else positions.
// Control is known as it is given and as the images measure it; what they do not measure fixes nothing of them.
double WeaknessFinder::reference_sigma(bool height) const {
  std::vector<double> control, positions;
  const auto sigma_of = [&](const auto& inverse_sigma) {
    const double w = height ? inverse_sigma[2] : std::min(inverse_sigma[0], inverse_sigma[1]);
    return w > 0 ? 1 / w : 0;
  };
  for (std::size_t p = problem_.first_control; p < problem_.point_count(); ++p) {
    if (problem_.point(p).control < 0) continue;
    const double given = sigma_of(problem_.control[problem_.point(p).control].inverse_sigma);
    const std::optional<Eigen::Vector3d> measured = sigmas_by_rays(problem_, state_, p);
    if (!(given > 0) || !measured) continue;
    control.push_back(
        std::hypot(given, sigma_scale(adjusted_) * (height ? measured->z() : measured->head<2>().maxCoeff())));
  }
  for (const GivenPosition& one : problem_.positions)
    if (const double given = sigma_of(one.inverse_sigma); given > 0) positions.push_back(given);
  if (control.size() < 3) control.insert(control.end(), positions.begin(), positions.end());
  return control.empty() ? 0 : median(control);
}

// The motion of the whole, as that of its ground. Scale and turns each by themselves: where plan hangs on one spot,
// scale and azimuth are equally weak, and no mixture of both is any better a name.
void WeaknessFinder::look_at_motions(const TileCholesky& factor) {
  if (!problem_.moves_as_one) return;
  const std::optional<GroundMotion> ground = ground_motion(problem_, state_, factor);
  if (!ground) return;
  name_weak_motion({}, ground->covariance(6, 6), ground->size);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turns(ground->covariance.block<3, 3>(3, 3));
  for (int k = 2; k >= 0; --k) name_weak_motion(turns.eigenvectors().col(k), turns.eigenvalues()[k], ground->size);
}

// Of the turn about an axis, or (none) of the scale. `variance`: by the given sigmas.
void WeaknessFinder::name_weak_motion(const std::optional<Eigen::Vector3d>& axis, double variance, double size) {
  const double sigma = std::sqrt(std::max(variance, 0.0)) * sigma_scale(adjusted_);
  // A turn about a level axis shows in height, one about the plumb line in plan.
  const double upright = axis ? std::abs(axis->z()) : 1, level = std::sqrt(std::max(0.0, 1 - upright * upright));
  const double reference = std::hypot(upright * reference_sigma(false), level * reference_sigma(true));
  if (!(reference > 0) || !(sigma * size > kWeakMotion * reference)) return;
  Finding weak =
      axis ? finding_of(FindingCode::kWeakRotation, {}, figures_of_axis(*axis),
                        {upright > 0.9 ? RemedyCode::kWidenControlInPlan : RemedyCode::kAddCrossStrip})
           : finding_of(FindingCode::kWeakScale, {}, {{FigureName::kSigmaScale, sigma}}, {RemedyCode::kWidenControl});
  if (axis) weak.figures.push_back({FigureName::kSigmaAngle, sigma * kDegrees});
  const std::array known = {Figure{FigureName::kExtent, size}, Figure{FigureName::kMotion, sigma * size},
                            Figure{FigureName::kReference, reference}};
  weak.figures.insert(weak.figures.end(), known.begin(), known.end());
  add(std::move(weak));
}

void WeaknessFinder::look_at_camera(const TileCholesky& factor, std::size_t number) {
  const ProblemCamera& camera = problem_.cameras[number];
  FreeCamera free{camera, 6 * problem_.poses + camera.first_global, {}};
  const int count = free.count(), unknowns = 6 * problem_.poses + problem_.global_count;
  free.cofactor.resize(count, count);
  for (int k = 0; k < count; ++k) {
    std::vector<double> right(static_cast<std::size_t>(unknowns), 0.0);
    right[static_cast<std::size_t>(free.first + k)] = 1;
    const std::vector<double> column = solved(factor, std::move(right));
    for (int i = 0; i < count; ++i) free.cofactor(i, k) = column[static_cast<std::size_t>(free.first + i)];
  }
  const std::vector<Eigen::VectorXd> motions = motions_like_a_camera(number);
  bool imitated = false;
  for (std::size_t m = 0; m < motions.size(); ++m) imitated |= name_imitation(factor, free, m, motions[m]);
  name_what_is_owed(free, imitated);
}

// Motions of the images that imitate their camera, as what they make of the reduced unknowns; none when no point of
// them can be asked.
std::vector<Eigen::VectorXd> WeaknessFinder::motions_like_a_camera(std::size_t number) const {
  const int unknowns = 6 * problem_.poses + problem_.global_count;
  std::vector<Eigen::VectorXd> motions(kImitatingMotions.size(), Eigen::VectorXd::Zero(unknowns));
  double images = 0, sampled = 0;
  for (int i = 0; i < problem_.poses; ++i) {
    if (problem_.images[i].camera != static_cast<int>(number)) continue;
    motions[1][6 * i] += 1;
    motions[2][6 * i + 1] += 1;
    ++images;
  }
  const std::size_t step = std::max<std::size_t>(1, problem_.point_count() / kSampledPoints);
  for (std::size_t p = 0; p < problem_.point_count(); p += step) {
    if (!problem_.point(p).eliminated()) continue;
    const std::uint32_t ray = problem_.point(p).first_free;
    if (ray >= problem_.end_ray(p)) continue;
    const int image = static_cast<int>(problem_.rays[ray].image);
    if (problem_.images[image].camera != static_cast<int>(number)) continue;
    const PointSystem system(problem_, state_, p);
    if (!system.determined()) continue;
    for (int across = 0; across < 3; ++across) {  // along the optical axis, to the right, down
      const Frame& frame = state_.frames[static_cast<std::size_t>(image)];
      const double* row = frame.data() + (across == 0 ? 6 : 3 * (across - 1));
      Eigen::VectorXd& motion = motions[across == 0 ? 0 : static_cast<std::size_t>(across) + 2];
      system.add_following(Eigen::Vector3d(row), motion);
      for (int c = 0; c < 3; ++c) motion[6 * image + 3 + c] -= row[c];
    }
    ++sampled;
  }
  if (sampled == 0) return {};
  for (const std::size_t m : {1, 2}) motions[m] /= images;
  for (const std::size_t m : {0, 3, 4}) motions[m] /= sampled;
  return motions;
}

// Whether the camera makes a motion much less certain than it would be without; then it is named.
bool WeaknessFinder::name_imitation(const TileCholesky& factor, const FreeCamera& free, std::size_t which,
                                    const Eigen::VectorXd& motion) {
  const std::vector<double> x = solved(factor, std::vector<double>(motion.data(), motion.data() + motion.size()));
  const double variance = motion.dot(Eigen::Map<const Eigen::VectorXd>(x.data(), motion.size()));
  const Eigen::VectorXd with_camera = Eigen::Map<const Eigen::VectorXd>(x.data() + free.first, free.count());
  const double left = variance - with_camera.dot(free.cofactor.inverse() * with_camera);
  if (!(variance > kInflation * kInflation * std::max(left, 0.0))) return false;
  Finding mixed = finding_of(which == 0 ? FindingCode::kFocalAndHeight : FindingCode::kCameraAndPose,
                             {{free.camera.id, kImitatingMotions[which]}},
                             {{FigureName::kRatio, std::sqrt(variance / std::max(left, 1e-12 * variance))}});
  double strongest = 0;
  for (int k = 0; k < free.count(); ++k) {
    const double correlation = with_camera[k] / std::sqrt(variance * free.cofactor(k, k));
    if (std::abs(correlation) > std::abs(strongest)) strongest = correlation;
    if (!(std::abs(correlation) > 0.8)) continue;
    mixed.subjects.push_back(free.parameter(k));
    mixed.figures.push_back({FigureName::kCorrelation, correlation});
  }
  if (mixed.subjects.size() == 1)
    mixed.figures.push_back({FigureName::kCorrelation, strongest});  // all of them together
  if (which == 0)
    mixed.remedies = {RemedyCode::kVaryHeights, RemedyCode::kCalibrateCamera,
                      OptionName{"calibration", "orient", "none"}};
  else
    mixed.remedies = {RemedyCode::kRotateImages, RemedyCode::kFewerParameters};
  add(std::move(mixed));
  return true;
}

// Parameters that owe their values to the pseudo-observations.
void WeaknessFinder::name_what_is_owed(const FreeCamera& free, bool imitated) {
  std::vector<Subject> owed;
  bool focal = false, decentred = false;
  for (int k = 0; k < free.count(); ++k) {
    const int param = free.camera.free[static_cast<std::size_t>(k)];
    const double prior = free.camera.inverse_sigma[param];
    if (!(prior * prior * free.cofactor(k, k) > kShareOfPrior)) continue;
    owed.push_back(free.parameter(k));
    focal |= param == Camera::kF;
    decentred |= param == Camera::kCx || param == Camera::kCy || param == Camera::kP1 || param == Camera::kP2;
  }
  if (owed.empty()) return;
  Finding finding = finding_of(FindingCode::kParameterNotDetermined, owed, {count_of(owed.size())});
  if (focal)
    finding.remedies = {RemedyCode::kVaryHeights, RemedyCode::kCalibrateCamera};
  else if (decentred)
    finding.remedies = {RemedyCode::kRotateImages, OptionName{"calibration", "orient", "focal_radial"}};
  else
    finding.remedies = {RemedyCode::kReachCorners, OptionName{"calibration", "orient", "focal"}};
  if (focal && imitated) finding.subjects.push_back({free.camera.id, Aspect::kDistance});
  add(std::move(finding));
}

void WeaknessFinder::look_at_images(const std::map<ImageId, Eigen::Matrix<double, 6, 6>>& pose_covariance) {
  std::vector<double> all;
  std::vector<std::pair<double, int>> sigmas;
  for (int i = 0; i < problem_.poses; ++i) {
    const auto its = pose_covariance.find(problem_.images[i].id);
    if (its == pose_covariance.end()) return;
    const double sigma = std::sqrt(its->second.bottomRightCorner<3, 3>().trace());
    sigmas.emplace_back(sigma, i);
    all.push_back(sigma);
  }
  if (all.size() < 3) return;
  const double typical = median(all);
  std::sort(sigmas.begin(), sigmas.end(), [](auto a, auto b) { return a.first > b.first; });
  std::vector<int> weak;
  for (const auto& [sigma, image] : sigmas)
    if (sigma > kWeakImage * typical) weak.push_back(image);
  if (weak.empty()) return;
  add(finding_of(FindingCode::kWeakImages, subjects(weak),
                 {count_of(weak.size()),
                  {FigureName::kRatio, sigmas.front().first / typical},
                  {FigureName::kSigma, sigmas.front().first * sigma_scale(adjusted_)},
                  {FigureName::kTypicalSigma, typical * sigma_scale(adjusted_)}},
                 {RemedyCode::kSpreadTiePoints}));
}

}  // namespace collinea::bundle
