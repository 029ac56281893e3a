// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "collinea/geometry/polygon.h"
#include "collinea/io/control_file.h"
#include "collinea/io/geodetic_file.h"
#include "collinea/io/map_area.h"
#include "collinea/io/number_rows.h"
#include "collinea/io/position_file.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

bool accepts_control(std::string_view bytes) {
  const auto control = parse_control(bytes);
  if (!control) return false;
  for (const ControlFilePoint& point : control->points)
    COLLINEA_CHECK(point.position_in_map.allFinite() && (point.sigma_m.array() > 0).all());
  for (const ControlFileObservation& seen : control->observations)
    COLLINEA_CHECK(seen.pixel.allFinite() && seen.sigma_px > 0);
  return true;
}

bool accepts_geodetic(std::string_view bytes) {
  const auto rows = parse_geodetic(bytes);
  if (!rows) return false;
  for (const GeodeticFileRow& row : *rows) COLLINEA_CHECK(std::isfinite(row.value) && row.sigma > 0);
  return true;
}

bool accepts_positions(std::string_view bytes) {
  const auto file = parse_positions(bytes);
  if (!file) return false;
  for (const PositionFileRow& row : file->rows) {
    if (row.geographic) COLLINEA_CHECK(std::abs((*row.geographic)[0]) <= 90 && std::abs((*row.geographic)[1]) <= 360);
    if (row.in_map) COLLINEA_CHECK(row.in_map->head<2>().allFinite());
    COLLINEA_CHECK(!(row.sigma_m.array() <= 0).any());
  }
  return true;
}

}  // namespace

std::vector<Target> table_targets() {
  return {
      {"control",
       accepts_control,
       {"# collinea control, EPSG:32633\npoint, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role\n"
        "point, A, 500100.5, 5300000, 420, 0.02, 0.02, 0.03, control\npoint, B, 500200, 5300100, , inf, 0.1, , check\n"
        "image, A, a.jpg, 100.5, 200, 0.4\ncovariance, A, 1e-4, 1e-5, 0, 1e-4, 0, 4e-4\n",
        "WGS84 UTM 17N\n500100.5 4300000.5 100 10.5 20.5 a.jpg one\n500110.5 4300000.5 NaN 10.5 20.5 b.jpg two\n",
        "EPSG:4326\n15.25 48.5 100 10.5 20.5 a.jpg\n15.26 48.5 100 10.5 20.5 b.jpg\n"}},
      {"ground",
       accepts_geodetic,
       {"# scale bars\nto, from, sigma_m, distance_m, name, role\nB, A, 0.001, 12.5, bar 1,\nC, A, 0.002, 7, , check\n",
        "from,to,setup,direction_gon,sigma_direction_mgon,zenith_deg,sigma_zenith_arcsec,distance_m,sigma_m,"
        "instrument_height_m,target_height_m\nS,A,1,100,1,90,3600,20,0.002,1.5,1.2\nS,B,1,200,1,,,,,1.5,\n",
        "from,plane,sigma_plane_m,line,sigma_line_m,level,sigma_level_m\nA,wall,0.01,,,,\nB,,,edge,0.02,,\n"
        "C,,,,,lake,0.03\n"}},
      {"positions",
       accepts_positions,
       {"# collinea positions, EPSG:32633\nimage, easting_m, northing_m, height_m, sigma_plan_m, sigma_height_m, "
        "omega_deg, phi_deg, kappa_deg, sigma_attitude_deg, taken\n"
        "a.jpg, 500100.5, 5300000, 420, 0.02, 0.03, 1, -2, 90, 0.01, 2024-05-17T10:31:08.25\n"
        "b.jpg, 500110.5, 5300000, , 0.02, , , , , ,\n",
        "image,latitude_deg,longitude_deg,height_m,sigma_m,yaw_deg,pitch_deg,roll_deg\na.jpg,48.1,15.3,400,0.02,90,0,"
        "1\n",
        "image,camera_yaw_deg,camera_pitch_deg,camera_roll_deg,sigma_yaw_deg\na.jpg,12,-90,0,0.1\n"}},
      {"mrk",
       accepts_positions,
       {"1\t458325.112309\t[2080]\t   -18,N\t     4,E\t   193,V\t48.10000001,Lat\t15.30000001,Lon\t412.345,Ellh\t"
        "0.012000, 0.011000, 0.025000\t50,Q\n2\t458327.5\t[2080]\t   -18,N\t     4,E\t   193,V\t48.1001,Lat\t"
        "15.3001,Lon\t412.4,Ellh\t0.012, 0.011, 0.025\t50,Q\n"}},
      {"number_rows",
       [](std::string_view bytes) {
         const bool named = parse_number_rows(bytes, true, 2, 5).has_value();
         const bool plain = parse_number_rows(bytes, false, 2, 2).has_value();
         return parse_numbers(bytes).has_value() || plain || named;
       },
       {"id, x, y\nA, 1.5, 2\nB, -3e2, 4 # five\n", "1 2\n3 4\n", "1,2.5,-3"}},
      {"map_area",
       [](std::string_view bytes) {
         const std::string text(bytes);
         const auto area = parse_area(text);
         if (area) (void)is_inside(*area, area->front()), (void)size_m2(*area);
         return parse_map_points(text).has_value() && area;
       },
       {"easting, northing\n500000, 5300000\n500100, 5300000\n500100, 5300100\n500000, 5300000\n",
        "0 0\n10 0 x\n10 10\n# end\n"}},
  };
}

}  // namespace collinea::fuzz
