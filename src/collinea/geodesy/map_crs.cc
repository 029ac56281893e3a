// SPDX-License-Identifier: Apache-2.0
#include <proj.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "collinea/base/file_text.h"
#include "collinea/geodesy/internal/map_projection.h"

namespace collinea {
namespace {

struct Axis {
  std::string abbreviation, direction, unit;
  double metres = 0;  // of one unit
};

std::vector<Axis> axes_of(pj_ctx* context, const PJ* crs) {
  const ProjObject system(proj_crs_get_coordinate_system(context, crs));
  std::vector<Axis> axes;
  const int count = system ? proj_cs_get_axis_count(context, system.get()) : 0;
  for (int i = 0; i < count; ++i) {
    const char *abbreviation = nullptr, *direction = nullptr, *unit = nullptr;
    Axis axis;
    if (!proj_cs_get_axis_info(context, system.get(), i, nullptr, &abbreviation, &direction, &axis.metres, &unit,
                               nullptr, nullptr))
      return {};
    axis.abbreviation = abbreviation ? abbreviation : "";
    axis.direction = direction ? direction : "";
    axis.unit = unit ? unit : "";
    axes.push_back(axis);
  }
  return axes;
}

// A bound CRS (with +towgs84 or a geoid attached) is looked at through what it binds.
ProjObject unbound(pj_ctx* context, ProjObject crs) {
  while (crs && proj_get_type(crs.get()) == PJ_TYPE_BOUND_CRS) crs.reset(proj_get_source_crs(context, crs.get()));
  return crs;
}

// In polar projections both axes point the same way (along two meridians); PROJ's order then tells which is which.
bool points_east_and_north(const std::vector<Axis>& axes) {
  const std::string &first = axes[0].direction, &second = axes[1].direction;
  if (first == "east" && second == "north") return true;
  if (first == "north" && second == "east") return true;
  return first == second && (axes[0].abbreviation == "E" || axes[0].abbreviation == "X");
}

Result<> check_axes(const std::vector<Axis>& axes, const std::string& name) {
  if (axes.size() < 2) return fail(Errc::kUnsupported, name + " has no coordinate axes");
  for (const Axis& axis : axes)
    if (!(std::abs(axis.metres - 1) < 1e-12))
      return fail(Errc::kUnsupported, name + " is in " + axis.unit + "; a CRS in metres is needed");
  if (!points_east_and_north(axes))
    return fail(Errc::kUnsupported, "the axes of " + name + " point " + axes[0].direction + " and " +
                                        axes[1].direction + "; a CRS with axes east and north is needed");
  return {};
}

Result<> check_height(pj_ctx* context, const PJ* compound, const std::string& name) {
  const ProjObject vertical = unbound(context, ProjObject(proj_crs_get_sub_crs(context, compound, 1)));
  const std::vector<Axis> axes = vertical ? axes_of(context, vertical.get()) : std::vector<Axis>{};
  if (axes.size() != 1) return fail(Errc::kUnsupported, name + " has no height axis that can be used");
  if (!(std::abs(axes[0].metres - 1) < 1e-12))
    return fail(Errc::kUnsupported, "the heights of " + name + " are in " + axes[0].unit + "; metres are needed");
  if (axes[0].direction != "up") return fail(Errc::kUnsupported, name + " counts depths, not heights");
  return {};
}

Result<ProjObject> parsed_crs(pj_ctx* context, const std::string& crs) {
  if (!proj_context_get_database_path(context))
    return fail(Errc::kNotFound, "PROJ's database proj.db was not found (package proj-data; PROJ_LIB)");
  // PROJ takes a bare "+proj=utm ..." for an operation unless told that a CRS is meant.
  const bool bare = crs.rfind("+proj=", 0) == 0 && crs.find("+type=crs") == std::string::npos;
  ProjObject object(proj_create(context, (bare ? crs + " +type=crs" : crs).c_str()));
  if (!object) return fail(Errc::kBadInput, "\"" + crs + "\" is not a coordinate reference system that PROJ knows");
  if (!proj_is_crs(object.get()))
    return fail(Errc::kBadInput, "\"" + crs + "\" is not a coordinate reference system (such as EPSG:32633)");
  return object;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

// A CRS whose heights count from a geoid that a file describes: the vertical part is bound to the ellipsoid by it.
Result<ProjObject> with_geoid(pj_ctx* context, const std::string& plan, const std::string& file) {
  COLLINEA_TRY(const ProjObject horizontal, parsed_crs(context, plan));
  const ProjObject hub(proj_create(context, "EPSG:4979"));
  const std::string name = "heights by " + std::filesystem::path(file).filename().string();
  const std::string vertical = "VERTCRS[" + quoted(name) + ",VDATUM[" + quoted(name) +
                               "],CS[vertical,1],AXIS[\"gravity-related height (H)\",up],LENGTHUNIT[\"metre\",1]]";
  constexpr FileText kByGrid =
      "],ABRIDGEDTRANSFORMATION[\"geoid heights\",METHOD[\"GravityRelatedHeight to Geographic3D\"],"
      "PARAMETERFILE[\"Geoid (height correction) model file\",";
  const std::string bound = "BOUNDCRS[SOURCECRS[" + vertical + "],TARGETCRS[" +
                            (hub ? wkt2_of(context, hub.get()) : "") + kByGrid + quoted(file) + "]]]";
  ProjObject compound = compound_crs(context, horizontal.get(), name, bound);
  if (!compound) return fail(Errc::kUnsupported, "\"" + plan + "\" cannot have heights by a geoid grid");
  return compound;
}

}  // namespace

void ProjContextDeleter::operator()(pj_ctx* context) const { proj_context_destroy(context); }
void ProjDeleter::operator()(PJconsts* object) const { proj_destroy(object); }

ProjContext quiet_proj_context() {
  ProjContext context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

std::string wkt2_of(pj_ctx* context, const PJ* crs) {
  const char* const one_line[] = {"MULTILINE=NO", nullptr};
  const char* wkt = proj_as_wkt(context, crs, PJ_WKT2_2019, one_line);
  return wkt ? wkt : "";
}

ProjObject compound_crs(pj_ctx* context, const PJ* horizontal, const std::string& vertical_name,
                        const std::string& vertical_wkt) {
  const char* name = proj_get_name(horizontal);
  const std::string wkt = "COMPOUNDCRS[" + quoted(std::string(name ? name : "map") + " + " + vertical_name) + "," +
                          wkt2_of(context, horizontal) + "," + vertical_wkt + "]";
  return ProjObject(proj_create(context, wkt.c_str()));
}

Result<MapCrs> read_map_crs(pj_ctx* context, const std::string& crs) {
  MapCrs map;
  if (const std::size_t mark = crs.rfind(kGeoidMark); mark != std::string::npos) {
    map.geoid = crs.substr(mark + kGeoidMark.size());
    COLLINEA_TRY(map.object, with_geoid(context, crs.substr(0, mark), map.geoid));
  } else {
    COLLINEA_TRY(map.object, parsed_crs(context, crs));
  }
  const char* name = proj_get_name(map.object.get());
  map.name = name && std::strcmp(name, "unknown") != 0 ? name : crs;

  const ProjObject whole = unbound(context, ProjObject(proj_clone(context, map.object.get())));
  ProjObject plan(proj_clone(context, whole.get()));
  if (proj_get_type(whole.get()) == PJ_TYPE_COMPOUND_CRS) {
    map.has_height = true;
    plan = unbound(context, ProjObject(proj_crs_get_sub_crs(context, whole.get(), 0)));
  }
  const PJ_TYPE type = plan ? proj_get_type(plan.get()) : PJ_TYPE_UNKNOWN;
  if (type == PJ_TYPE_GEOGRAPHIC_2D_CRS || type == PJ_TYPE_GEOGRAPHIC_3D_CRS)
    return fail(Errc::kUnsupported,
                map.name + " is in degrees; a projected CRS in metres is needed, such as the UTM zone");
  if (type != PJ_TYPE_PROJECTED_CRS)
    return fail(Errc::kUnsupported,
                map.name + " is not a projected CRS; one in metres is needed, such as the UTM zone");

  const std::vector<Axis> axes = axes_of(context, plan.get());
  if (const Result<> verdict = check_axes(axes, map.name); !verdict) return tl::unexpected(verdict.error());
  if (map.has_height) {
    if (const Result<> verdict = check_height(context, whole.get(), map.name); !verdict)
      return tl::unexpected(verdict.error());
  }
  map.has_height = map.has_height || axes.size() == 3;
  return map;
}

}  // namespace collinea
