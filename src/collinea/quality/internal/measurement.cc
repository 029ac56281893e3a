// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/measurement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/gnss_vector.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class T>
void erase_at(std::vector<T>& all, std::span<const MeasurementIndex> rejected) {
  std::vector<bool> goes(all.size());
  for (const MeasurementIndex& one : rejected) goes[one.source] = true;
  std::size_t to = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!goes[i]) all[to++] = all[i];
  all.resize(to);
}

std::optional<Eigen::Vector3d> position_of(ControlId id, const Adjusted& adjusted) {
  for (const ControlDifference& one : adjusted.control)
    if (one.point == id) return one.position_in_world;
  return std::nullopt;
}

std::optional<Eigen::Vector3d> misclosure_in_image(const Block& block, ImageId image, const Eigen::Vector2d& pixel,
                                                   const Eigen::Vector3d& point_in_world) {
  const auto expected = project(block.camera_of(image), pose_of(block, image) * point_in_world);
  if (!expected) return std::nullopt;
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();
  difference.head<2>() = pixel - *expected;
  return difference;
}

// What a source of observations answers unless it answers itself.
struct AnySource {
  static std::set<ControlId> control_points(const Measurement&, const Block&) { return {}; }
  static std::optional<double> sigma_of_correlated(const Measurement&, const GivenMeasurement&, int, double,
                                                   const Measurements&, const Adjusted&) {
    return std::nullopt;
  }
};

struct TieImagePoint : AnySource {
  static Measurement named(MeasurementIndex index, const Block& block) {
    const Observation& seen = block.observations[index.source];
    return {.group = index.group, .image = seen.image, .point = seen.point};
  }
  static GivenMeasurement given(MeasurementIndex index, const Measurements& all) {
    return all.block.observations[index.source];
  }
  static void reject(Measurements& all, std::span<const MeasurementIndex> rejected) {
    erase_at(all.block.observations, rejected);
  }
  static void restore(Measurements& all, const Measurement&, const GivenMeasurement& given) {
    const Observation& ray = std::get<Observation>(given);
    auto& observations = all.block.observations;
    observations.insert(std::upper_bound(observations.begin(), observations.end(), ray,
                                         [](const Observation& a, const Observation& b) {
                                           return std::pair(a.point, a.image) < std::pair(b.point, b.image);
                                         }),
                        ray);
  }
  static std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement& given,
                                                   const Measurements& left, const Adjusted&) {
    return misclosure_in_image(left.block, measurement.image, std::get<Observation>(given).pixel,
                               left.block.points.at(measurement.point).position_in_world);
  }
};

struct ControlImagePoint : AnySource {
  static Measurement named(MeasurementIndex index, const Block& block) {
    const ControlObservation& seen = block.control_observations[index.source];
    return {.group = index.group, .image = seen.image, .control = seen.point};
  }
  static GivenMeasurement given(MeasurementIndex index, const Measurements& all) {
    return all.block.control_observations[index.source];
  }
  static void reject(Measurements& all, std::span<const MeasurementIndex> rejected) {
    erase_at(all.block.control_observations, rejected);
  }
  static void restore(Measurements& all, const Measurement&, const GivenMeasurement& given) {
    all.block.control_observations.push_back(std::get<ControlObservation>(given));
  }
  static std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement& given,
                                                   const Measurements& left, const Adjusted& adjusted) {
    const auto position = position_of(measurement.control, adjusted);
    if (!position) return std::nullopt;
    return misclosure_in_image(left.block, measurement.image, std::get<ControlObservation>(given).pixel, *position);
  }
};

// Three coordinates with a sigma each: Source::sigmas() says where. An infinite one is not given.
template <class Source>
struct Coordinates : AnySource {
  static GivenMeasurement given(MeasurementIndex index, const Measurements& all) {
    return Source::sigmas(all, Source::named(index, all.block));
  }
  static void reject(Measurements& all, std::span<const MeasurementIndex> rejected) {
    for (const MeasurementIndex& one : rejected)
      axes_of(one.group, Source::sigmas(all, Source::named(one, all.block))).setConstant(kInfinity);
  }
  static void restore(Measurements& all, const Measurement& measurement, const GivenMeasurement& given) {
    axes_of(measurement.group, Source::sigmas(all, measurement)) =
        axes_of(measurement.group, std::get<Eigen::Vector3d>(given));
  }
};

struct ControlCoordinates : Coordinates<ControlCoordinates> {
  static Measurement named(MeasurementIndex index, const Block&) {
    return {.group = index.group, .control = ControlId{index.source}};
  }
  static auto& sigmas(auto& all, const Measurement& measurement) {
    return all.block.control.at(measurement.control).sigma_m;
  }
  static std::set<ControlId> control_points(const Measurement& measurement, const Block&) {
    return {measurement.control};
  }
  static std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement&,
                                                   const Measurements& left, const Adjusted& adjusted) {
    const auto position = position_of(measurement.control, adjusted);
    if (!position) return std::nullopt;
    return left.block.control.at(measurement.control).position_in_world - *position;
  }
  static std::optional<double> sigma_of_correlated(const Measurement& measurement, const GivenMeasurement& given,
                                                   int axis, double sigma0, const Measurements& left,
                                                   const Adjusted& adjusted) {
    if (left.block.control.at(measurement.control).correlation.isZero(0)) return std::nullopt;
    for (const ControlDifference& now : adjusted.control)
      if (now.point == measurement.control && now.covariance_m2)
        return std::hypot(std::get<Eigen::Vector3d>(given)[axis], sigma0 * std::sqrt((*now.covariance_m2)(axis, axis)));
    return std::nullopt;
  }
};

struct Position : Coordinates<Position> {
  static Measurement named(MeasurementIndex index, const Block&) {
    return {.group = index.group, .image = ImageId{index.source}};
  }
  static auto& sigmas(auto& all, const Measurement& measurement) {
    return all.block.images.at(measurement.image).position->sigma_m;
  }
  static std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement&,
                                                   const Measurements& left, const Adjusted&) {
    if (!left.scope.lever_arms.empty() || !left.scope.position_tracks.empty()) return std::nullopt;
    return left.block.images.at(measurement.image).position->position_in_world -
           centre_of(pose_of(left.block, measurement.image));
  }
};

struct AttitudeOfImage : Coordinates<AttitudeOfImage> {
  static Measurement named(MeasurementIndex index, const Block&) {
    return {.group = index.group, .image = ImageId{index.source}};
  }
  static auto& sigmas(auto& all, const Measurement& measurement) {
    return all.scope.attitudes.at(measurement.image).sigma_rad;
  }
  static std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement&,
                                                   const Measurements&, const Adjusted& adjusted) {
    for (const AttitudeDifference& one : adjusted.attitudes)
      if (one.image == measurement.image) return -one.difference_rad;
    return std::nullopt;
  }
};

struct GeodeticMeasurement : AnySource {
  static Measurement named(MeasurementIndex index, const Block&) {
    return {.group = index.group, .geodetic = index.source};
  }
  static std::set<ControlId> control_points(const Measurement& measurement, const Block& block) {
    const GeodeticObservation& measured = block.geodetic[measurement.geodetic];
    return {measured.from, measured.to};
  }
  static GivenMeasurement given(MeasurementIndex, const Measurements&) { return {}; }
  static void reject(Measurements& all, std::span<const MeasurementIndex> rejected) {
    for (const MeasurementIndex& one : rejected) set_role(all.block, one.source, ControlRole::kCheck);
  }
  // The parts of a vector are one measurement.
  static void set_role(Block& block, std::uint32_t observation, ControlRole role) {
    for (const std::uint32_t part : with_their_vectors(block, observation)) block.geodetic[part].role = role;
  }
  static void restore(Measurements& all, const Measurement& measurement, const GivenMeasurement&) {
    set_role(all.block, measurement.geodetic, ControlRole::kControl);
  }
  static std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement&,
                                                   const Measurements&, const Adjusted& adjusted) {
    for (const GeodeticDifference& one : adjusted.geodetic)
      if (one.observation == measurement.geodetic) return Eigen::Vector3d(-one.difference, 0, 0);
    return std::nullopt;
  }
};

// Calls visit.operator()<Source>() with the source of a group. A new source is a struct above and a line here.
template <class Visit>
decltype(auto) visit_source(ObservationSource source, Visit&& visit) {
  switch (source) {
    case ObservationSource::kTieImagePoint:
      return visit.template operator()<TieImagePoint>();
    case ObservationSource::kControlImagePoint:
      return visit.template operator()<ControlImagePoint>();
    case ObservationSource::kControlCoordinates:
      return visit.template operator()<ControlCoordinates>();
    case ObservationSource::kPosition:
      return visit.template operator()<Position>();
    case ObservationSource::kGeodetic:
      return visit.template operator()<GeodeticMeasurement>();
    case ObservationSource::kAttitude:
      return visit.template operator()<AttitudeOfImage>();
  }
  bug("an observation without a source");
}

template <class Visit>
decltype(auto) visit_group(ObservationGroup group, Visit&& visit) {
  return visit_source(traits_of(group).source, std::forward<Visit>(visit));
}

}  // namespace

Measurement measurement_at(MeasurementIndex index, const Block& block) {
  return visit_group(index.group, [&]<class Source>() { return Source::named(index, block); });
}

std::set<ControlId> control_points_of(const Measurement& measurement, const Block& block) {
  return visit_group(measurement.group, [&]<class Source>() { return Source::control_points(measurement, block); });
}

GivenMeasurement given_at(MeasurementIndex index, const Measurements& all) {
  return visit_group(index.group, [&]<class Source>() -> GivenMeasurement { return Source::given(index, all); });
}

Measurements without(Measurements all, std::span<const MeasurementIndex> rejected) {
  std::map<ObservationSource, std::vector<MeasurementIndex>> by_source;
  for (const MeasurementIndex& one : rejected) by_source[traits_of(one.group).source].push_back(one);
  for (const auto& [source, its] : by_source) visit_source(source, [&]<class Source>() { Source::reject(all, its); });
  return all;
}

Measurements with(Measurements all, const Measurement& measurement, const GivenMeasurement& given) {
  visit_group(measurement.group, [&]<class Source>() { Source::restore(all, measurement, given); });
  return all;
}

std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement& given,
                                          const Measurements& left, const Adjusted& adjusted) {
  return visit_group(measurement.group,
                     [&]<class Source>() { return Source::misclosure(measurement, given, left, adjusted); });
}

std::optional<double> sigma_of_correlated(const Measurement& measurement, const GivenMeasurement& given, int axis,
                                          double sigma0, const Measurements& left, const Adjusted& adjusted) {
  return visit_group(measurement.group, [&]<class Source>() {
    return Source::sigma_of_correlated(measurement, given, axis, sigma0, left, adjusted);
  });
}

}  // namespace collinea
