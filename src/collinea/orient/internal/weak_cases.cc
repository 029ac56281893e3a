// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/weak_cases.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "collinea/math/median.h"
#include "collinea/orient/internal/line_motion.h"

namespace collinea {
namespace {

constexpr double kFlat = 0.02;             // relief over distance to the cameras
constexpr double kHardlyDetermined = 0.5;  // sigma of f after adjustment over before
constexpr double kAlong = 0.94;            // cosine: base within 20 degrees of the view
constexpr std::size_t kManyMatches = 30;   // of a pair whose contradiction to the block is no accident
constexpr double kFewOfThem = 0.1;
constexpr double kOnSurface = 0.005;  // distance from a quadric over the size of the block
constexpr double kMoved = 0.1;        // of the residual variance: below it the residuals lose less than a twentieth
constexpr double kBeyondSource = 3;   // standard deviations of a focal length as given
constexpr std::size_t kNamed = 3;     // images
constexpr std::size_t kMostPoints = 2000;  // looked at
constexpr std::size_t kLeastPoints = 30, kLeastImages = 3;

std::vector<Eigen::Vector3d> some_points(const Block& block) {
  std::vector<Eigen::Vector3d> points;
  const std::size_t stride = block.points.size() / kMostPoints + 1;
  std::size_t i = 0;
  for (const auto& [id, point] : block.points)
    if (i++ % stride == 0) points.push_back(point.position_in_world);
  return points;
}

std::vector<Eigen::Vector3d> centres_of(const Block& block) {
  std::vector<Eigen::Vector3d> centres;
  for (const auto& [id, pose] : oriented_images(block)) centres.push_back(centre_of(pose));
  return centres;
}

Eigen::Vector3d mean_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& point : points) mean += point / static_cast<double>(points.size());
  return mean;
}

// Root mean square distance of the points from the plane that fits them best, over their distance to the cameras.
double relief(const Block& block, const std::vector<Eigen::Vector3d>& points) {
  const Eigen::Vector3d mean = mean_of(points);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& point : points) scatter += (point - mean) * (point - mean).transpose();
  const double across = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues()[0];
  std::vector<double> distances;
  for (const auto& centre : centres_of(block)) distances.push_back((centre - mean).norm());
  return std::sqrt(std::max(0.0, across) / static_cast<double>(points.size())) / median(distances);
}

using Pair = std::pair<ImageId, ImageId>;

std::map<Pair, std::size_t> common_points(const Block& block) {
  std::map<Pair, std::size_t> common;
  const auto& seen = block.observations;  // sorted by point and image
  for (std::size_t begin = 0, end = 0; begin < seen.size(); begin = end) {
    while (end < seen.size() && seen[end].point == seen[begin].point) ++end;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = i + 1; j < end; ++j) ++common[{seen[i].image, seen[j].image}];
  }
  return common;
}

// Whether most bases between images with common points lie along the views of both.
bool moves_along_view(const Block& block, const std::map<Pair, std::size_t>& common) {
  std::vector<double> cosines;
  for (const auto& [pair, count] : common) {
    if (count < kLeastPoints) continue;
    const Rigid3 &first = pose_of(block, pair.first), &second = pose_of(block, pair.second);
    const Eigen::Vector3d base = (centre_of(second) - centre_of(first)).normalized();
    const auto along = [&](const Rigid3& pose) { return std::abs((pose.rotation * base).z()); };
    cosines.push_back(std::min(along(first), along(second)));
  }
  return cosines.size() + 1 >= kLeastImages && median(cosines) > kAlong;
}

std::vector<Finding> undetermined_focals(const std::map<CameraId, Camera>& first_cameras, const Examined& adjusted,
                                         bool flat, bool along) {
  std::vector<Finding> findings;
  for (const auto& [id, covariance] : adjusted.camera_covariance) {
    const Camera& before = first_cameras.at(id);
    const double sigma_px = std::sqrt(covariance(Camera::kF, Camera::kF));
    if (!(sigma_px > kHardlyDetermined * before.prior.sigma_f_px)) continue;
    const FindingCode code = flat    ? FindingCode::kFocalOfFlatScene
                             : along ? FindingCode::kFocalAlongView
                                     : FindingCode::kFocalOfFewImages;
    findings.push_back(
        finding_of(code, {id}, {{FigureName::kRelative, sigma_px / before.focal_px()}},
                   {RemedyCode::kCalibrateCamera, OptionName{"camera_params", "import"}, RemedyCode::kAddDistances}));
  }
  return findings;
}

std::optional<Finding> moved_while_read(const Block& block) {
  const LineMotion motion = line_motion(block);
  if (motion.explained < kMoved || motion.images.size() < kLeastImages) return std::nullopt;
  std::vector<Subject> worst;
  for (std::size_t i = 0; i < std::min(kNamed, motion.images.size()); ++i) worst.emplace_back(motion.images[i].image);
  return finding_of(FindingCode::kMovedWhileRead, worst, {{FigureName::kShare, motion.explained}},
                    {RemedyCode::kHoldStill});
}

std::optional<Finding> contradicting_pairs(const Block& block, std::span<const ImagePair> pairs,
                                           const std::map<Pair, std::size_t>& common, bool moved) {
  std::size_t count = 0;
  const ImagePair* worst = nullptr;
  for (const ImagePair& pair : pairs) {
    if (pair.matches.size() < kManyMatches || pair.geometry == PairGeometry::kRotation) continue;
    if (!is_oriented(block, pair.first) || !is_oriented(block, pair.second)) continue;
    const auto found = common.find({pair.first, pair.second});
    const double left = found == common.end() ? 0 : static_cast<double>(found->second);
    if (left >= kFewOfThem * static_cast<double>(pair.matches.size())) continue;
    ++count;
    if (!worst || pair.matches.size() > worst->matches.size()) worst = &pair;
  }
  if (!worst) return std::nullopt;
  return finding_of(moved ? FindingCode::kPairsContradictWhileRead : FindingCode::kPairsContradict,
                    {worst->first, worst->second},
                    {{FigureName::kCount, static_cast<double>(count)},
                     {FigureName::kMatches, static_cast<double>(worst->matches.size())}},
                    {RemedyCode::kRemoveRepeats});
}

using Vector10d = Eigen::Matrix<double, 10, 1>;

Vector10d monomials(const Eigen::Vector3d& p) {
  Vector10d m;
  m << p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), 2 * p.x() * p.y(), 2 * p.x() * p.z(), 2 * p.y() * p.z(), 2 * p.x(),
      2 * p.y(), 2 * p.z(), 1;
  return m;
}

Eigen::Matrix4d matrix_of(const Vector10d& q) {
  Eigen::Matrix4d m;
  m << q[0], q[3], q[4], q[6], q[3], q[1], q[5], q[7], q[4], q[5], q[2], q[8], q[6], q[7], q[8], q[9];
  return m;
}

double distance(const Eigen::Matrix4d& quadric, const Eigen::Vector3d& p) {
  const Eigen::Vector4d at = quadric * p.homogeneous();
  const double slope = 2 * at.head<3>().norm();
  return slope > 0 ? std::abs(at.dot(p.homogeneous())) / slope : 0;
}

// The quadric nearest to points and centres, in coordinates of unit size about their middle.
bool on_critical_surface(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& centres) {
  const Eigen::Vector3d middle = mean_of(points);
  std::vector<double> sizes;
  for (const auto& point : points) sizes.push_back((point - middle).norm());
  const double size = 2 * median(sizes);
  if (!(size > 0)) return false;
  Eigen::Matrix<double, 10, 10> normals = Eigen::Matrix<double, 10, 10>::Zero();
  const auto add = [&](const std::vector<Eigen::Vector3d>& some) {
    for (const auto& one : some) {
      const Vector10d m = monomials((one - middle) / size);
      normals += m * m.transpose() / static_cast<double>(some.size());
    }
  };
  add(points);
  add(centres);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 10, 10>> eigen(normals);
  const Eigen::Matrix4d quadric = matrix_of(eigen.eigenvectors().col(0));
  const auto off = [&](const std::vector<Eigen::Vector3d>& some) {
    double sum = 0;
    for (const auto& one : some) sum += std::pow(distance(quadric, (one - middle) / size), 2);
    return std::sqrt(sum / static_cast<double>(some.size()));
  };
  // Ruled: two positive and two negative eigenvalues, or a cone or cylinder. An ellipsoid has a negative determinant.
  const Eigen::Matrix4d unit = quadric / quadric.norm();
  return unit.determinant() > -1e-6 && off(points) < kOnSurface && off(centres) < kOnSurface;
}

}  // namespace

std::vector<Finding> weak_focals(const Block& oriented, const std::map<CameraId, Camera>& first_cameras,
                                 const Examined& adjusted) {
  const std::vector<Eigen::Vector3d> points = some_points(oriented);
  if (points.size() < kLeastPoints || count_oriented(oriented) < 2) return {};
  return undetermined_focals(first_cameras, adjusted, relief(oriented, points) < kFlat,
                             moves_along_view(oriented, common_points(oriented)));
}

std::vector<Finding> moved_focals(const std::map<CameraId, Camera>& first_cameras, const Adjusted& adjusted) {
  std::vector<Finding> findings;
  for (const auto& [id, camera] : adjusted.cameras) {
    const auto first = first_cameras.find(id);
    if (first == first_cameras.end()) continue;
    const CameraPrior& prior = first->second.prior;
    const bool is_from_file = prior.source == Provenance::kExifPixelPitch || prior.source == Provenance::kExif35mm ||
                              prior.source == Provenance::kGiven;
    const double start_px = first->second.focal_px(), moved_px = std::abs(camera.focal_px() - start_px);
    if (!is_from_file || !(prior.sigma_f_px > 0) || !(moved_px > kBeyondSource * prior.sigma_f_px)) continue;
    findings.push_back(finding_of(FindingCode::kFocalMoved, {id},
                                  {{FigureName::kFocal, camera.focal_px()},
                                   {FigureName::kFocalGiven, start_px},
                                   {FigureName::kRelative, camera.focal_px() / start_px - 1},
                                   {FigureName::kRatio, moved_px / prior.sigma_f_px}},
                                  {RemedyCode::kCalibrateCamera, OptionName{"camera_params", "import"}}));
  }
  return findings;
}

std::vector<Finding> weak_cases(const Block& oriented, std::span<const ImagePair> pairs) {
  const std::vector<Eigen::Vector3d> points = some_points(oriented), centres = centres_of(oriented);
  if (points.size() < kLeastPoints || centres.size() < 2) return {};
  const auto common = common_points(oriented);
  const bool flat = relief(oriented, points) < kFlat;
  std::vector<Finding> findings;
  if (moves_along_view(oriented, common))
    findings.push_back(finding_of(FindingCode::kMovedAlongView, {}, {}, {RemedyCode::kAddSideViews}));
  const auto moved = moved_while_read(oriented);
  if (moved) findings.push_back(*moved);
  if (auto pairs_against = contradicting_pairs(oriented, pairs, common, moved.has_value()))
    findings.push_back(*pairs_against);
  if (!flat && on_critical_surface(points, centres))
    findings.push_back(finding_of(FindingCode::kCriticalSurface, {}, {}, {RemedyCode::kLeaveSurface}));
  return findings;
}

Error nothing_fits(std::span<const ImagePair> pairs) {
  std::size_t rotations = 0, others = 0;
  for (const ImagePair& pair : pairs) ++(pair.geometry == PairGeometry::kRotation ? rotations : others);
  if (rotations > others)
    return Error{Errc::kIllPosed,
                 "the photographs were taken from one position (a panorama): without parallax there is no depth. Take "
                 "overlapping photographs from different positions, a tenth of the distance apart and more"};
  return Error{
      Errc::kIllPosed,
      "no two images fit together with enough parallax: are there overlapping photographs of one scene, taken from "
      "different positions?"};
}

}  // namespace collinea
