// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

struct pj_ctx;
struct PJconsts;

namespace collinea {

/// Owners of PROJ's two kinds of objects.
struct ProjContextDeleter {
  void operator()(pj_ctx* context) const;
};
struct ProjDeleter {
  void operator()(PJconsts* object) const;
};
using ProjContext = std::unique_ptr<pj_ctx, ProjContextDeleter>;
using ProjObject = std::unique_ptr<PJconsts, ProjDeleter>;

/// Before the file of a geoid grid in the name of a CRS.
inline constexpr std::string_view kGeoidMark = "+geoid:";

/// A context that neither prints nor goes to the network.
[[nodiscard]] ProjContext quiet_proj_context();

/// A CRS of maps: projected (or compound: projected + height), metres, axes east and north.
struct MapCrs {
  ProjObject object;
  std::string name;
  bool has_height = false;  ///< compound or three-dimensional: heights are transformed too
  std::string geoid;        ///< file of the grid its heights count by; empty: none was given
};

/// WKT2:2019 in one line.
[[nodiscard]] std::string wkt2_of(pj_ctx* context, const PJconsts* crs);
/// Both as one CRS; nothing when they are not what they should be.
[[nodiscard]] ProjObject compound_crs(pj_ctx* context, const PJconsts* horizontal, const std::string& vertical_name,
                                      const std::string& vertical_wkt);

/// Errors: unknown, not projected, not in metres, axes that do not point east and north.
[[nodiscard]] Result<MapCrs> read_map_crs(pj_ctx* context, const std::string& crs);

/// Map coordinates <-> geographic WGS84 by one fixed coordinate operation of PROJ: the best for the position it was
/// made for, so that a block never straddles two operations. PROJ objects serve one thread; this lends each call its
/// own copy. Coordinates outside the operation's domain become infinite.
class MapProjection {
 public:
  /// The operation for the neighbourhood of a position; without a position: for the whole CRS.
  static Result<std::shared_ptr<MapProjection>> create(const std::string& crs, const Eigen::Vector2d* near_lat_lon_deg);

  /// In place: (easting, northing, height) m <-> (latitude deg, longitude deg, ellipsoidal height m).
  void geographic_from_map(std::span<Eigen::Vector3d> points);
  void map_from_geographic(std::span<Eigen::Vector3d> points);

  std::string wkt1, wkt2, name;
  std::string operation;     ///< PROJ's name of the operation
  double accuracy_m = 0;     ///< what PROJ's database claims; negative: unknown
  std::string missing_grid;  ///< a grid that would allow a better operation; empty: none

 private:
  struct Worker {
    ProjContext context;  // must outlive the operation: declared first
    ProjObject operation;
  };
  Worker borrow();
  void give_back(Worker worker);
  void transform(std::span<Eigen::Vector3d> points, bool forward);

  bool has_height_ = false;
  Worker master_;
  std::vector<Worker> idle_;
  std::mutex mutex_;
};

}  // namespace collinea
