// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/internal/map_projection.h"

#include <proj.h>

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

struct ListDeleter {
  void operator()(PJ_OBJ_LIST* list) const { proj_list_destroy(list); }
};
struct FactoryDeleter {
  void operator()(PJ_OPERATION_FACTORY_CONTEXT* factory) const { proj_operation_factory_context_destroy(factory); }
};
using ProjList = std::unique_ptr<PJ_OBJ_LIST, ListDeleter>;

// The operations from the map to WGS84, best first when every grid were there.
ProjList operations(pj_ctx* context, const PJ* map, const PJ* wgs84, const Eigen::Vector2d* near_lat_lon_deg) {
  const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT, FactoryDeleter> factory(
      proj_create_operation_factory_context(context, nullptr));
  if (!factory) return nullptr;
  proj_operation_factory_context_set_allow_ballpark_transformations(context, factory.get(), 0);
  proj_operation_factory_context_set_spatial_criterion(context, factory.get(),
                                                       PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  proj_operation_factory_context_set_grid_availability_use(context, factory.get(), PROJ_GRID_AVAILABILITY_IGNORED);
  if (near_lat_lon_deg) {
    constexpr double kMargin_deg = 0.05;
    const double latitude = (*near_lat_lon_deg)[0], longitude = (*near_lat_lon_deg)[1];
    proj_operation_factory_context_set_area_of_interest(
        context, factory.get(), std::max(-180.0, longitude - kMargin_deg), std::max(-90.0, latitude - kMargin_deg),
        std::min(180.0, longitude + kMargin_deg), std::min(90.0, latitude + kMargin_deg));
  }
  return ProjList(proj_create_operations(context, map, wgs84, factory.get()));
}

struct MissingGrid {
  std::string name, url;

  [[nodiscard]] std::string name_and_source() const { return url.empty() ? name : name + " (" + url + ")"; }
};

MissingGrid first_missing_grid(pj_ctx* context, const PJ* operation) {
  const int count = proj_coordoperation_get_grid_used_count(context, operation);
  for (int i = 0; i < count; ++i) {
    const char *name = nullptr, *url = nullptr;
    int available = 0;
    if (!proj_coordoperation_get_grid_used(context, operation, i, &name, nullptr, nullptr, &url, nullptr, nullptr,
                                           &available) ||
        available)
      continue;
    return {name ? name : "?", url ? url : ""};
  }
  return {};
}

struct Choice {
  ProjObject operation;
  MissingGrid missing_grid;  // the first one that stood in the way; rather one that can be had
};

Choice best_available(pj_ctx* context, PJ_OBJ_LIST* list) {
  Choice choice;
  const int count = list ? proj_list_get_count(list) : 0;
  for (int i = 0; i < count && !choice.operation; ++i) {
    ProjObject candidate(proj_list_get(context, list, i));
    if (!candidate || proj_coordoperation_has_ballpark_transformation(context, candidate.get())) continue;
    if (proj_coordoperation_is_instantiable(context, candidate.get()))
      choice.operation.reset(proj_normalize_for_visualization(context, candidate.get()));
    else if (const MissingGrid missing = first_missing_grid(context, candidate.get());
             choice.missing_grid.name.empty() || (!missing.url.empty() && choice.missing_grid.url.empty()))
      choice.missing_grid = missing;
  }
  return choice;
}

std::string text(const char* words) { return words ? words : ""; }

// What is missing, and what to do about it.
tl::unexpected<Error> no_operation(pj_ctx* context, const MapCrs& map, const MissingGrid& missing) {
  if (!map.geoid.empty())
    return fail(Errc::kBadFormat, "the geoid grid " + map.geoid +
                                      " cannot be used: PROJ reads geoid heights over the ellipsoid as GTX or GeoTIFF");
  if (missing.name.empty())
    return fail(Errc::kUnsupported, "PROJ knows no transformation between " + map.name + " and WGS84");
  const std::string folder = text(proj_context_get_user_writable_directory(context, 0));
  Error error{Errc::kUnsupported,
              map.name + " needs the grid " + missing.name_and_source() + ", which is not installed for PROJ. "};
  if (missing.url.empty())
    error = std::move(error).advising("Get it from who made it and put it into " + folder);
  else
    error = std::move(error).advising("Put it into " + folder + " (projsync --file " + missing.name + " does so)");
  if (map.has_height)
    error = std::move(error)
                .advising("; or name the file of a geoid grid, or ellipsoidal, as what heights count from")
                .about("heights"_option);
  return tl::unexpected(std::move(error));
}

}  // namespace

Result<std::shared_ptr<MapProjection>> MapProjection::create(const std::string& crs,
                                                             const Eigen::Vector2d* near_lat_lon_deg) {
  auto made = std::make_shared<MapProjection>();
  made->master_.context = quiet_proj_context();
  pj_ctx* context = made->master_.context.get();
  COLLINEA_TRY(const MapCrs map, read_map_crs(context, crs));
  made->has_height_ = map.has_height;
  // Heights of a plan-only CRS are ellipsoidal heights and pass by: PROJ sees only the plan.
  const ProjObject wgs84(proj_create(context, map.has_height ? "EPSG:4979" : "EPSG:4326"));
  if (!wgs84) return fail(Errc::kNotFound, "PROJ's database does not know WGS84 (broken proj.db)");

  Choice choice = best_available(context, operations(context, map.object.get(), wgs84.get(), near_lat_lon_deg).get());
  if (!choice.operation && near_lat_lon_deg) {  // a map used outside its official area
    Choice anywhere = best_available(context, operations(context, map.object.get(), wgs84.get(), nullptr).get());
    choice.operation = std::move(anywhere.operation);
    if (choice.missing_grid.name.empty()) choice.missing_grid = anywhere.missing_grid;
  }
  if (!choice.operation) return no_operation(context, map, choice.missing_grid);
  made->accuracy_m = proj_coordoperation_get_accuracy(context, choice.operation.get());
  made->missing_grid = choice.missing_grid.name_and_source();
  made->operation = text(proj_get_name(choice.operation.get()));
  made->master_.operation = std::move(choice.operation);
  made->name = map.name;
  const char* const one_line[] = {"MULTILINE=NO", nullptr};
  made->wkt1 = text(proj_as_wkt(context, map.object.get(), PJ_WKT1_GDAL, one_line));
  made->wkt2 = wkt2_of(context, map.object.get());
  return made;
}

MapProjection::Worker MapProjection::borrow() {
  const std::lock_guard lock(mutex_);
  if (!idle_.empty()) {
    Worker worker = std::move(idle_.back());
    idle_.pop_back();
    return worker;
  }
  Worker worker{quiet_proj_context(), nullptr};
  worker.operation.reset(proj_clone(worker.context.get(), master_.operation.get()));
  COLLINEA_CHECK(worker.operation != nullptr);
  return worker;
}

void MapProjection::give_back(Worker worker) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(worker));
}

void MapProjection::transform(std::span<Eigen::Vector3d> points, bool forward) {
  if (points.empty()) return;
  Worker worker = borrow();
  double* first = points.data()->data();
  constexpr std::size_t kStride = sizeof(Eigen::Vector3d);
  const std::size_t count = points.size();
  proj_trans_generic(worker.operation.get(), forward ? PJ_FWD : PJ_INV, first, kStride, count, first + 1, kStride,
                     count, has_height_ ? first + 2 : nullptr, kStride, has_height_ ? count : 0, nullptr, 0, 0);
  proj_errno_reset(worker.operation.get());
  give_back(std::move(worker));
}

// PROJ is asked in the order (longitude, latitude).
void MapProjection::geographic_from_map(std::span<Eigen::Vector3d> points) {
  transform(points, true);
  for (Eigen::Vector3d& point : points) std::swap(point[0], point[1]);
}

void MapProjection::map_from_geographic(std::span<Eigen::Vector3d> points) {
  for (Eigen::Vector3d& point : points) std::swap(point[0], point[1]);
  transform(points, false);
}

}  // namespace collinea
