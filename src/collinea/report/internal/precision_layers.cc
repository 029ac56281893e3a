// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/precision_layers.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "collinea/block/world_frame.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kIn95 = 2.447746830680816;  // sqrt(-2 ln 0.05)
constexpr int kCorners = 36;
constexpr double kPartOfBlock = 1.0 / 30;
constexpr std::size_t kMostTiePoints = 2000;

// What is drawn of a point.
struct Drawn {
  std::string what, name;
  Eigen::Vector3d position_m;
  Eigen::Matrix3d covariance_m2;
};

std::vector<Drawn> drawn_of(const AdjustmentReport& report, const AdjustmentProducts& products) {
  std::vector<Drawn> drawn;
  for (const ProductControl& one : products.control)
    if (one.position_m.allFinite())
      drawn.push_back({one.difference->used ? "control" : "check", report.block.control.at(one.difference->point).name,
                       one.position_m, one.covariance_m2});
  for (const ProductImage& one : products.images)
    drawn.push_back({"image", report.block.images.at(one.image).file, one.centre_m, one.covariance_m2});
  const std::size_t step = products.points.size() / kMostTiePoints + 1;
  for (std::size_t i = 0; i < products.points.size(); i += step)
    drawn.push_back({"tie point", std::to_string(products.points[i].point.value), products.points[i].position_m,
                     products.points[i].covariance_m2});
  std::erase_if(drawn, [](const Drawn& one) { return !one.covariance_m2.topLeftCorner<2, 2>().allFinite(); });
  return drawn;
}

double extent_m(const AdjustmentProducts& products) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
  const auto add = [&](const Eigen::Vector3d& position) {
    if (!position.allFinite()) return;
    low = low.cwiseMin(position.head<2>());
    high = high.cwiseMax(position.head<2>());
  };
  for (const ProductImage& one : products.images) add(one.centre_m);
  for (const ProductPoint& one : products.points) add(one.position_m);
  for (const ProductControl& one : products.control) add(one.position_m);
  return (high.array() < low.array()).any() ? 0 : (high - low).norm();
}

// The largest of 1, 2, 5, 10 ... that does not make the median length longer than its part of the block.
double round_factor(std::vector<double> lengths_m, double block_m) {
  std::erase_if(lengths_m, [](double length) { return !(length > 0) || !std::isfinite(length); });
  if (lengths_m.empty() || !(block_m > 0)) return 1;
  const double most = std::clamp(kPartOfBlock * block_m / median(std::move(lengths_m)), 1e-6, 1e9);
  const double power = std::pow(10, std::floor(std::log10(most)));
  return power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
}

VectorLayer ellipses(const std::vector<Drawn>& drawn, double block_m) {
  std::vector<double> lengths_m;
  for (const Drawn& one : drawn)
    lengths_m.push_back(kIn95 * error_ellipse(one.covariance_m2.topLeftCorner<2, 2>()).semi_major_m);
  const double times = round_factor(std::move(lengths_m), block_m);
  VectorLayer layer{
      "error_ellipses",
      VectorKind::kPolygon,
      {{"of", VectorType::kText},
       {"name", VectorType::kText},
       {"semi_major_m"},
       {"semi_minor_m"},
       {"azimuth_deg"},
       {"sigma_height_m"},
       {"probability"},
       {"times_enlarged"}},
      {},
      true,
      fmt::format("Error ellipses (95 %), drawn {:g} times larger; semi-axes are standard deviations", times),
      VectorStyle{{200, 40, 40}}};
  for (const Drawn& one : drawn) {
    const ErrorEllipse ellipse = error_ellipse(one.covariance_m2.topLeftCorner<2, 2>());
    layer.rows.push_back({ellipse_outline(one.position_m, ellipse, times),
                          {one.what, one.name, ellipse.semi_major_m, ellipse.semi_minor_m, ellipse.azimuth_deg,
                           std::sqrt(one.covariance_m2(2, 2)), 0.95, times}});
  }
  return layer;
}

// A difference, adjusted minus given, where the point was found.
struct Off {
  std::string of, name;
  Eigen::Vector3d position_m, difference_m;
};

std::vector<Off> differences_of(const AdjustmentReport& report, const AdjustmentProducts& products) {
  std::vector<Off> all;
  for (const ProductControl& one : products.control)
    all.push_back({one.difference->used ? "control" : "check", report.block.control.at(one.difference->point).name,
                   one.position_m, one.difference->difference_m});
  std::map<ImageId, Eigen::Vector3d> centres;
  for (const ProductImage& one : products.images) centres[one.image] = one.centre_m;
  for (const PositionDifference& one : report.adjusted.positions)
    if (const auto centre = centres.find(one.image); centre != centres.end())
      all.push_back({"position", report.block.images.at(one.image).file, centre->second, one.difference_m});
  std::erase_if(all,
                [](const Off& one) { return !one.position_m.allFinite() || !one.difference_m.head<2>().allFinite(); });
  return all;
}

// Axes of the map from those of the world, in the middle of what is drawn: they differ by the convergence of meridians.
Eigen::Matrix3d map_axes(const AdjustmentReport& report, const std::vector<Off>& all) {
  const auto frame = world_frame(report.block);
  if (!frame || !*frame || all.empty()) return Eigen::Matrix3d::Identity();
  return map_from_local_rotation(**frame, (*frame)->local_from_map(all[all.size() / 2].position_m)).toRotationMatrix();
}

VectorLayer residuals(const AdjustmentReport& report, std::vector<Off> all, double block_m) {
  const Eigen::Matrix3d axes = map_axes(report, all);
  std::vector<double> lengths_m;
  for (Off& one : all) {
    const bool has_height = std::isfinite(one.difference_m.z());
    if (!has_height) one.difference_m.z() = 0;
    one.difference_m = axes * one.difference_m;
    if (!has_height) one.difference_m.z() = std::nan("");
    lengths_m.push_back(one.difference_m.head<2>().norm());
  }
  const double times = round_factor(std::move(lengths_m), block_m);
  VectorLayer layer{"residuals",
                    VectorKind::kLine,
                    {{"of", VectorType::kText},
                     {"name", VectorType::kText},
                     {"east_m"},
                     {"north_m"},
                     {"height_m"},
                     {"times_enlarged"}},
                    {},
                    true,
                    fmt::format("Given minus adjusted coordinates in plan, drawn {:g} times larger", times),
                    VectorStyle{{30, 70, 200}, 0.5}};
  for (const Off& one : all) {
    const Eigen::Vector3d off = -one.difference_m;
    Eigen::Vector3d end = one.position_m;
    end.head<2>() += times * off.head<2>();
    layer.rows.push_back({{one.position_m, end}, {one.of, one.name, off.x(), off.y(), off.z(), times}});
  }
  return layer;
}

}  // namespace

ErrorEllipse error_ellipse(const Eigen::Matrix2d& covariance_m2) {
  if (!covariance_m2.allFinite()) return {std::nan(""), std::nan(""), std::nan("")};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance_m2);
  const Eigen::Vector2d axis = eigen.eigenvectors().col(1);
  double azimuth_deg = std::atan2(axis.x(), axis.y()) * kDegrees;
  if (azimuth_deg < 0) azimuth_deg += 180;
  if (azimuth_deg >= 180) azimuth_deg -= 180;
  const auto root = [&](int i) { return std::sqrt(std::max(0.0, eigen.eigenvalues()[i])); };
  return {root(1), root(0), azimuth_deg};
}

std::vector<Eigen::Vector3d> ellipse_outline(const Eigen::Vector3d& centre_m, const ErrorEllipse& ellipse,
                                             double times) {
  const double azimuth = ellipse.azimuth_deg / kDegrees;
  const Eigen::Vector3d major(std::sin(azimuth), std::cos(azimuth), 0), minor(std::cos(azimuth), -std::sin(azimuth), 0);
  std::vector<Eigen::Vector3d> outline;
  for (int i = 0; i < kCorners; ++i) {
    const double turn = 2 * std::numbers::pi * i / kCorners;
    outline.push_back(
        centre_m + times * kIn95 *
                       (ellipse.semi_major_m * std::cos(turn) * major + ellipse.semi_minor_m * std::sin(turn) * minor));
  }
  return outline;
}

std::vector<VectorLayer> precision_layers(const AdjustmentReport& report, const AdjustmentProducts& products) {
  const double block_m = extent_m(products);
  std::vector<VectorLayer> layers{ellipses(drawn_of(report, products), block_m),
                                  residuals(report, differences_of(report, products), block_m)};
  std::erase_if(layers, [](const VectorLayer& layer) { return layer.rows.empty(); });
  return layers;
}

}  // namespace collinea
