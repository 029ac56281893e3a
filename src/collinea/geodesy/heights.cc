// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/heights.h"

#include <proj.h>

#include <cmath>
#include <filesystem>

#include "collinea/geodesy/internal/map_projection.h"
#include "collinea/geodesy/local_frame.h"

namespace collinea {
namespace {

std::string text(const char* words) { return words ? words : ""; }

// A CRS in as few words as it has: "EPSG:32633".
std::string short_name(pj_ctx* context, const PJ* crs) {
  const std::string authority = text(proj_get_id_auth_name(crs, 0)), code = text(proj_get_id_code(crs, 0));
  if (!authority.empty() && !code.empty()) return authority + ":" + code;
  return wkt2_of(context, crs);
}

// The CRS of a map without the heights of a compound one.
Result<std::string> plan_of(pj_ctx* context, const std::string& crs) {
  COLLINEA_TRY(const MapCrs map, read_map_crs(context, crs));
  if (proj_get_type(map.object.get()) != PJ_TYPE_COMPOUND_CRS) return crs;
  const ProjObject plan(proj_crs_get_sub_crs(context, map.object.get(), 0));
  return short_name(context, plan.get());
}

bool names_authority(const std::string& heights) {
  const std::size_t colon = heights.find(':');
  return colon != std::string::npos && colon > 0 && heights.find_first_of("/\\. ") == std::string::npos;
}

Result<std::string> with_vertical_crs(pj_ctx* context, const std::string& plan, const std::string& heights) {
  const ProjObject vertical(proj_create(context, heights.c_str()));
  if (!vertical || proj_get_type(vertical.get()) != PJ_TYPE_VERTICAL_CRS)
    return fail(Errc::kBadInput, "\"" + heights +
                                     "\" is no vertical coordinate reference system that PROJ knows: give ellipsoidal, "
                                     "one such as EPSG:5773, or the file of a geoid grid");
  if (names_authority(plan)) return plan + "+" + heights;
  COLLINEA_TRY(const MapCrs map, read_map_crs(context, plan));
  const ProjObject compound =
      compound_crs(context, map.object.get(), text(proj_get_name(vertical.get())), wkt2_of(context, vertical.get()));
  if (!compound) return fail(Errc::kUnsupported, "\"" + plan + "\" cannot have the heights " + heights);
  return short_name(context, compound.get());
}

}  // namespace

Result<std::string> with_heights(const std::string& crs, const HeightsFrom& from) {
  const ProjContext context = quiet_proj_context();
  COLLINEA_TRY(const std::string plan, plan_of(context.get(), crs));
  if (from.word() == HeightSurface::kEllipsoid) return plan;
  const std::string& heights = from.text();
  if (names_authority(heights)) return with_vertical_crs(context.get(), plan, heights);
  std::error_code error;
  const std::filesystem::path file = std::filesystem::absolute(heights, error).lexically_normal();
  if (!std::filesystem::is_regular_file(file, error))
    return fail(Errc::kNotFound,
                "heights \"" + heights +
                    "\": no such file. Give ellipsoidal, a vertical CRS such as EPSG:5773, or the file "
                    "of a geoid grid (GTX or GeoTIFF)");
  return plan + std::string(kGeoidMark) + file.string();
}

Result<double> undulation_m(const HeightsFrom& heights, double latitude_deg, double longitude_deg) {
  if (heights.word() == HeightSurface::kEllipsoid) return 0.0;
  COLLINEA_TRY(const std::string crs, with_heights(utm_crs(latitude_deg, longitude_deg), heights));
  COLLINEA_TRY(const LocalFrame frame, LocalFrame::create(crs, latitude_deg, longitude_deg, 0));
  const double height = frame.map_from_local(Eigen::Vector3d::Zero()).z();
  if (!std::isfinite(height))
    return fail(Errc::kBadInput, "the geoid \"" + heights.text() + "\" does not reach the position");
  return -height;
}

Result<bool> states_heights(const std::string& crs) {
  const ProjContext context = quiet_proj_context();
  COLLINEA_TRY(const MapCrs map, read_map_crs(context.get(), crs));
  return map.has_height;
}

}  // namespace collinea
