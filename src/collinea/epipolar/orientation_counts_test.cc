// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <optional>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// What images may be oriented by: homologous points, straight lines (no point on them is homologous) and circles
// (Mussio A.5, A.6).
enum class OrientingFeature { kPoint, kLine, kCircle };

// Coordinates that an image of one gives: 2 of a point, 2 of a line (theta, r), 5 of a circle (an ellipse).
constexpr int observed_of(OrientingFeature feature) { return feature == OrientingFeature::kCircle ? 5 : 2; }
// Parameters of one in space: 3, 4, 6 (centre, radius, direction of the axis).
constexpr int unknowns_of(OrientingFeature feature) {
  return feature == OrientingFeature::kPoint ? 3 : feature == OrientingFeature::kLine ? 4 : 6;
}

// Redundancy of the relative orientation of `images` images of known interior orientation by features that all of them
// show: observations less 6 unknowns an image and those of the features, plus the 7 of a free similarity. A count: it
// says nothing of features in critical position (parallel lines, coplanar circles). Fewer than two images or no
// feature: meaningless, nothing.
constexpr std::optional<int> orientation_redundancy(OrientingFeature feature, int images, int features) {
  if (images < 2 || features < 1) return std::nullopt;
  return images * features * observed_of(feature) - (6 * images - 7) - features * unknowns_of(feature);
}

// The fewest features that orient so many images: the redundancy is no longer negative. Nothing: no number of them
// does, as of lines in two images, whose planes of rays always meet.
constexpr std::optional<int> fewest_features(OrientingFeature feature, int images) {
  const int gain = images * observed_of(feature) - unknowns_of(feature);
  if (images < 2 || gain <= 0) return std::nullopt;
  return (6 * images - 7 + gain - 1) / gain;
}

Vector3d drawn(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

// What one image, with its rotation vector and centre, shows of one feature.
using Shown = std::function<VectorXd(const VectorXd& pose, const VectorXd& feature)>;

Matrix3d rotation_of(const VectorXd& pose) { return rotation_by(Vector3d(pose.head<3>())).toRotationMatrix(); }

// Two points of the line, four coordinates: where it meets the planes x = -3 and x = 3.
VectorXd line_shown(const VectorXd& pose, const VectorXd& line) {
  const Matrix3d r = rotation_of(pose);
  const Vector3d a = r * (Vector3d(-3, line[0], line[1]) - pose.tail<3>()),
                 b = r * (Vector3d(3, line[2], line[3]) - pose.tail<3>()), n = a.cross(b);
  return Eigen::Vector2d(std::atan2(n.y(), n.x()), -n.z() / std::hypot(n.x(), n.y()));
}

// Centre, and the axis times the radius. The image: five ratios of the conic C = H^-T diag(1, 1, -1) H^-1.
VectorXd circle_shown(const VectorXd& pose, const VectorXd& circle) {
  const Matrix3d r = rotation_of(pose);
  const double radius = circle.tail<3>().norm();
  const Vector3d axis = circle.tail<3>() / radius, u = axis.unitOrthogonal(), v = axis.cross(u);
  Matrix3d h;
  h << r * u * radius, r * v * radius, r * (circle.head<3>() - pose.tail<3>());
  const Matrix3d inverse = h.inverse();
  const Matrix3d conic = inverse.transpose() * Vector3d(1, 1, -1).asDiagonal() * inverse;
  VectorXd out(5);
  out << conic(0, 0), conic(0, 1), conic(0, 2), conic(1, 2), conic(2, 2);
  return out / conic(1, 1);
}

// Rank of the derivatives of all that the images show, by central differences; singular values below 1e-6 of the
// largest are their rounding.
int rank_of(const Shown& shown, int images, int features, int parameters) {
  Random random(3);
  VectorXd unknowns(6 * images + parameters * features);
  for (int i = 0; i < images; ++i)
    unknowns.segment<6>(6 * i) << 0.1 * drawn(random), 3.0 * i + 0.3 * random.normal(), random.normal(),
        -20 + random.normal();
  for (int i = 0; i < features; ++i) {
    auto feature = unknowns.segment(6 * images + parameters * i, parameters);
    for (auto& value : feature) value = 3 * random.normal();
    if (parameters == 6) feature.tail(3) = Vector3d(0, 0, 2) + 0.7 * drawn(random);
  }
  const auto all = [&](const VectorXd& x) {
    std::vector<double> values;
    for (int i = 0; i < images; ++i)
      for (int k = 0; k < features; ++k)
        for (const double value : shown(x.segment<6>(6 * i), x.segment(6 * images + parameters * k, parameters)))
          values.push_back(value);
    return VectorXd(Eigen::Map<VectorXd>(values.data(), Eigen::Index(values.size())));
  };
  Eigen::MatrixXd derivatives(all(unknowns).size(), unknowns.size());
  for (Eigen::Index c = 0; c < unknowns.size(); ++c) {
    VectorXd more = unknowns, less = unknowns;
    more[c] += 1e-5;
    less[c] -= 1e-5;
    derivatives.col(c) = (all(more) - all(less)) / 2e-5;
  }
  const VectorXd values = derivatives.bdcSvd().singularValues();
  return int((values.array() > 1e-6 * values[0]).count());
}

// Mussio D.8, A.5: lines need three images, and six of them in three leave a redundancy of 1. The rank is that of all
// unknowns less the seven of the frame: nothing else is undetermined.
TEST(OrientationCounts, LinesOfMussioD8) {
  EXPECT_EQ(orientation_redundancy(OrientingFeature::kLine, 3, 6), 1);
  EXPECT_EQ(fewest_features(OrientingFeature::kLine, 3), 6);
  EXPECT_EQ(fewest_features(OrientingFeature::kLine, 2), std::nullopt);
  EXPECT_EQ(rank_of(line_shown, 3, 6, 4), 3 * 6 * 2 - 1);
}

// Mussio D.8, A.6: two circles in two images leave a redundancy of 3.
TEST(OrientationCounts, CirclesOfMussioD8) {
  EXPECT_EQ(orientation_redundancy(OrientingFeature::kCircle, 2, 2), 3);
  EXPECT_EQ(fewest_features(OrientingFeature::kCircle, 2), 2);
  EXPECT_EQ(rank_of(circle_shown, 2, 2, 6), 2 * 2 * 5 - 3);
}

TEST(OrientationCounts, FivePointsOrientTwoImages) {
  EXPECT_EQ(fewest_features(OrientingFeature::kPoint, 2), 5);
  EXPECT_EQ(orientation_redundancy(OrientingFeature::kPoint, 2, 5), 0);
  EXPECT_EQ(orientation_redundancy(OrientingFeature::kPoint, 1, 5), std::nullopt);
  EXPECT_EQ(orientation_redundancy(OrientingFeature::kPoint, 2, 0), std::nullopt);
}

}  // namespace
}  // namespace collinea
