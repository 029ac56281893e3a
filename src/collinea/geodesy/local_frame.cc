// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/local_frame.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "collinea/geodesy/internal/ellipsoid.h"
#include "collinea/geodesy/internal/map_projection.h"

namespace collinea {
namespace {

constexpr double kMostStretch = 0.05;  // of a map; national grids stay below 0.01
constexpr std::size_t kChunk = 4096;   // points transformed at a time: stays in the cache

bool on_earth(double latitude_deg, double longitude_deg, double height_m) {
  return std::abs(latitude_deg) <= 90 && std::abs(longitude_deg) <= 180 && std::abs(height_m) < 1e6;
}

// How many units of the map a metre on the ground is here, at most and at least.
std::pair<double, double> scales_of(const LocalFrame& frame) {
  constexpr double kStep_m = 10;
  const Eigen::Vector3d here = frame.map_from_local(Eigen::Vector3d::Zero().eval());
  const double east = (frame.map_from_local(Eigen::Vector3d(kStep_m, 0, 0)) - here).head<2>().norm() / kStep_m;
  const double north = (frame.map_from_local(Eigen::Vector3d(0, kStep_m, 0)) - here).head<2>().norm() / kStep_m;
  return {std::max(east, north), std::min(east, north)};
}

// Maps for the screen and of whole continents stretch lengths: surface model and orthophoto would have false sizes.
Result<> check_scale(const LocalFrame& frame, double latitude_deg, double longitude_deg) {
  const auto [most, least] = scales_of(frame);
  const bool web = frame.wkt2().find("Pseudo Mercator") != std::string::npos;
  if (!web && most < 1 + kMostStretch && least > 1 - kMostStretch) return {};
  std::array<char, 16> times{};
  std::snprintf(times.data(), times.size(), "%.3f", std::abs(most - 1) > std::abs(1 - least) ? most : least);
  return fail(Errc::kUnsupported, frame.crs_name() + " is no map to measure in: a metre on the ground is " +
                                      times.data() + " of its units here. Use a map of the area, such as " +
                                      utm_crs(latitude_deg, longitude_deg) + " (the UTM zone) or the national grid");
}

}  // namespace

struct LocalFrame::Transforms {
  std::shared_ptr<MapProjection> projection;
  std::string crs;
  Eigen::Vector3d origin_in_geocentric;
  Eigen::Matrix3d local_from_geocentric;

  Eigen::Vector3d local_from_geographic(const Eigen::Vector3d& lat_lon_height) const {
    return local_from_geocentric * (geocentric_from_geographic(lat_lon_height) - origin_in_geocentric);
  }
  Eigen::Vector3d geographic_from_local(const Eigen::Vector3d& local) const {
    return geographic_from_geocentric(local_from_geocentric.transpose() * local + origin_in_geocentric);
  }
};

Result<LocalFrame> LocalFrame::create(const std::string& crs, double origin_latitude_deg, double origin_longitude_deg,
                                      double origin_height_m) {
  if (!on_earth(origin_latitude_deg, origin_longitude_deg, origin_height_m))
    return fail(Errc::kBadInput, "the origin of the local frame is not on the Earth: latitude " +
                                     std::to_string(origin_latitude_deg) + ", longitude " +
                                     std::to_string(origin_longitude_deg) + ", height " +
                                     std::to_string(origin_height_m));
  LocalFrame frame;
  frame.transforms_ = std::make_shared<Transforms>();
  Transforms& transforms = *frame.transforms_;
  const Eigen::Vector2d near(origin_latitude_deg, origin_longitude_deg);
  COLLINEA_TRY(transforms.projection, MapProjection::create(crs, &near));
  transforms.crs = crs;
  const Eigen::Vector3d origin(origin_latitude_deg, origin_longitude_deg, origin_height_m);
  transforms.origin_in_geocentric = geocentric_from_geographic(origin);
  transforms.local_from_geocentric = enu_from_geocentric(origin_latitude_deg, origin_longitude_deg);

  if (!frame.map_from_local(Eigen::Vector3d::Zero().eval()).allFinite())
    return fail(Errc::kBadInput, "latitude " + std::to_string(origin_latitude_deg) + ", longitude " +
                                     std::to_string(origin_longitude_deg) + " cannot be mapped in " +
                                     transforms.projection->name +
                                     ": wrong CRS for this position, or a geoid grid that does not reach it?");
  if (const Result<> verdict = check_scale(frame, origin_latitude_deg, origin_longitude_deg); !verdict)
    return tl::unexpected(verdict.error());
  return frame;
}

Eigen::Vector3d LocalFrame::local_from_geographic(const Eigen::Vector3d& lat_lon_height) const {
  return transforms_->local_from_geographic(lat_lon_height);
}

Eigen::Vector3d LocalFrame::geographic_from_local(const Eigen::Vector3d& local) const {
  return transforms_->geographic_from_local(local);
}

Eigen::Vector3d LocalFrame::local_from_map(const Eigen::Vector3d& map) const {
  Eigen::Vector3d point = map;
  local_from_map(std::span(&point, 1));
  return point;
}

Eigen::Vector3d LocalFrame::map_from_local(const Eigen::Vector3d& local) const {
  Eigen::Vector3d point = local;
  map_from_local(std::span(&point, 1));
  return point;
}

void LocalFrame::local_from_map(std::span<Eigen::Vector3d> points) const {
  for (std::size_t i = 0; i < points.size(); i += kChunk) {
    const std::span<Eigen::Vector3d> chunk = points.subspan(i, std::min(kChunk, points.size() - i));
    transforms_->projection->geographic_from_map(chunk);
    for (Eigen::Vector3d& point : chunk) point = transforms_->local_from_geographic(point);
  }
}

void LocalFrame::map_from_local(std::span<Eigen::Vector3d> points) const {
  for (std::size_t i = 0; i < points.size(); i += kChunk) {
    const std::span<Eigen::Vector3d> chunk = points.subspan(i, std::min(kChunk, points.size() - i));
    for (Eigen::Vector3d& point : chunk) point = transforms_->geographic_from_local(point);
    transforms_->projection->map_from_geographic(chunk);
  }
}

const std::string& LocalFrame::crs() const { return transforms_->crs; }
std::string LocalFrame::wkt1() const { return transforms_->projection->wkt1; }
std::string LocalFrame::wkt2() const { return transforms_->projection->wkt2; }
std::string LocalFrame::crs_name() const { return transforms_->projection->name; }
std::string LocalFrame::operation() const { return transforms_->projection->operation; }
std::string LocalFrame::missing_grid() const { return transforms_->projection->missing_grid; }

std::optional<double> LocalFrame::accuracy_m() const {
  const double accuracy_m = transforms_->projection->accuracy_m;
  return accuracy_m < 0 ? std::nullopt : std::optional(accuracy_m);
}

Eigen::Quaterniond map_from_local_rotation(const LocalFrame& frame, const Eigen::Vector3d& local) {
  constexpr double kStep_m = 10;
  Eigen::Matrix3d derivative;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(axis);
    derivative.col(axis) = (frame.map_from_local(local + step) - frame.map_from_local(local - step)) / (2 * kStep_m);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(derivative, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())).normalized();
}

std::string utm_crs(double latitude_deg, double longitude_deg) {
  const double longitude = longitude_deg - 360 * std::floor((longitude_deg + 180) / 360);
  int zone = std::clamp(int(std::floor((longitude + 180) / 6)) + 1, 1, 60);
  // The two exceptions of the UTM grid: south-west Norway and Svalbard.
  if (latitude_deg >= 56 && latitude_deg < 64 && longitude >= 3 && longitude < 12) zone = 32;
  if (latitude_deg >= 72 && latitude_deg < 84 && longitude >= 0 && longitude < 42)
    zone = longitude < 9 ? 31 : longitude < 21 ? 33 : longitude < 33 ? 35 : 37;
  return "EPSG:" + std::to_string((latitude_deg < 0 ? 32700 : 32600) + zone);
}

Result<Eigen::Vector3d> geographic_from_map(const std::string& crs, const Eigen::Vector3d& map) {
  Eigen::Vector3d approximate = map, point = map;
  {
    COLLINEA_TRY(const auto anywhere, MapProjection::create(crs, nullptr));
    anywhere->geographic_from_map(std::span(&approximate, 1));
  }
  if (!approximate.head<2>().allFinite())
    return fail(Errc::kBadInput, "easting " + std::to_string(map.x()) + ", northing " + std::to_string(map.y()) +
                                     " lies outside what " + crs + " can map");
  // Now the operation that is best at this very position.
  const Eigen::Vector2d near = approximate.head<2>();
  COLLINEA_TRY(const auto projection, MapProjection::create(crs, &near));
  projection->geographic_from_map(std::span(&point, 1));
  if (!point.allFinite())
    return fail(Errc::kBadInput, "easting " + std::to_string(map.x()) + ", northing " + std::to_string(map.y()) +
                                     " lies outside what " + crs + " can map");
  return point;
}

Result<std::string> check_crs(const std::string& crs) {
  COLLINEA_TRY(const auto projection, MapProjection::create(crs, nullptr));
  return projection->name;
}

}  // namespace collinea
