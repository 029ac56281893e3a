// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/internal/orientation_tables.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "collinea/base/packed.h"
#include "collinea/store/internal/project_store_state.h"
#include "collinea/store/internal/record_chunks.h"
#include "collinea/store/internal/setup_tables.h"

namespace collinea {

const OrientationTables kCurrentOrientation{"adjusted_cameras", "poses", "points", "observations",
                                            "used_control_observations"};
const OrientationTables kFoundOrientation{"found_cameras", "found_poses", "found_points", "found_observations",
                                          "found_control_observations"};

namespace {

using sqlite::Database;

// How one record lies in a blob. kBytes is its exact size.
struct PointRecord {
  static constexpr std::size_t kBytes = 4 + 24 + 3;
  using Value = std::pair<PointId, TiePoint>;
  static void put_one(Packer& packer, const std::pair<const PointId, TiePoint>& point) {
    packer.put(point.first.value);
    put(packer, point.second.position_in_world);
    for (const std::uint8_t channel : point.second.colour) packer.put(channel);
  }
  static Value get_one(Unpacker& unpacker) {
    Value point;
    unpacker.get(point.first.value);
    get(unpacker, point.second.position_in_world);
    for (std::uint8_t& channel : point.second.colour) unpacker.get(channel);
    return point;
  }
};

struct ObservationRecord {
  static constexpr std::size_t kBytes = 3 * 4 + 3 * 8;
  using Value = Observation;
  static void put_one(Packer& packer, const Observation& o) {
    packer.put(o.image.value);
    packer.put(o.point.value);
    packer.put(o.feature);
    put(packer, o.pixel);
    packer.put(o.sigma_px);
  }
  static Value get_one(Unpacker& unpacker) {
    Observation o;
    unpacker.get(o.image.value);
    unpacker.get(o.point.value);
    unpacker.get(o.feature);
    get(unpacker, o.pixel);
    unpacker.get(o.sigma_px);
    return o;
  }
};

Result<> write_poses(Database& db, const std::string& table, const Block& block) {
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?)"));
  for (const auto& [image, pose] : oriented_images(block)) {
    Packer packer;
    for (const double value : {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()})
      packer.put(value);
    put(packer, pose.translation);
    if (const RayBend& bend = block.images.at(image).bend; bend.per_tangent_rad != 0) {
      put(packer, bend.down_in_cam);
      packer.put(bend.per_tangent_rad);
    }
    COLLINEA_TRY(insert.bind(image.value).bind_blob(packer.bytes()).run());
  }
  return {};
}

Result<> read_poses(Database& db, const std::string& table, Block& block) {
  COLLINEA_TRY(auto select, db.prepare("SELECT image, cam_from_world FROM " + table + " ORDER BY image"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    Unpacker unpacker(select.blob(1));
    Rigid3 pose;
    for (double* value : {&pose.rotation.w(), &pose.rotation.x(), &pose.rotation.y(), &pose.rotation.z()})
      unpacker.get(*value);
    get(unpacker, pose.translation);
    const ImageId image{std::uint32_t(select.integer(0))};
    const auto found = block.images.find(image);
    if (found == block.images.end()) return damaged("pose of an image that is not there");
    if (unpacker.left() > 0) {
      get(unpacker, found->second.bend.down_in_cam);
      unpacker.get(found->second.bend.per_tangent_rad);
    }
    if (!unpacker.done()) return damaged("pose of an image");
    set_pose(block, image, pose);
  }
}

}  // namespace

Result<> read_orientation_tables(Database& db, const OrientationTables& tables, Block& block) {
  COLLINEA_TRY(read_cameras(db, tables.cameras, block.cameras));
  COLLINEA_TRY(read_poses(db, tables.poses, block));
  return read_control_observations(db, tables.control_observations, block);
}

Result<> read_tie_tables(Database& db, const OrientationTables& tables, Block& block) {
  COLLINEA_TRY(const auto bytes, db.integer("SELECT coalesce(sum(length(data)), 0) FROM " + tables.observations));
  block.observations.reserve(std::size_t(bytes) / ObservationRecord::kBytes);  // growing would take twice as much
  auto& points = block.points;
  const auto take_point = [&](const PointRecord::Value& p) {
    points.insert_or_assign(points.end(), p.first, p.second);
  };
  COLLINEA_TRY(read_chunks<PointRecord>(db, tables.points, take_point));
  return read_chunks<ObservationRecord>(db, tables.observations,
                                        [&](const Observation& o) { block.observations.push_back(o); });
}

// Points and observations side by side, both in the order of points.
Result<> read_ties_in_order(Database& db, const Block& block, const TakeTie& take) {
  COLLINEA_TRY(auto points, ChunkReader<PointRecord>::open(db, "points"));
  COLLINEA_TRY(auto observations, ChunkReader<ObservationRecord>::open(db, "observations"));
  const auto unfit = [] { return damaged("observations of images or points that are not there"); };
  std::vector<Observation> seen;
  while (!points.at_end()) {
    const auto [id, point] = points.value();
    seen.clear();
    while (!observations.at_end() && observations.value().point == id) {
      if (!block.images.contains(observations.value().image)) return unfit();
      seen.push_back(observations.value());
      COLLINEA_TRY(observations.advance());
    }
    take(id, point, seen);
    COLLINEA_TRY(points.advance());
    if (!points.at_end() && points.value().first <= id) return unfit();
  }
  return observations.at_end() ? Result<>{} : unfit();
}

Result<> erase_orientation(Database& db) {
  std::string erase =
      "DELETE FROM oriented; DELETE FROM pose_covariances; DELETE FROM camera_covariances; "
      "DELETE FROM point_covariances;";
  for (const OrientationTables& tables : {kCurrentOrientation, kFoundOrientation})
    for (const std::string& table : tables.all()) erase += "DELETE FROM " + table + ";";
  return db.execute(erase);
}

Result<> write_orientation_tables(Database& db, const OrientationTables& tables, const Block& block) {
  COLLINEA_TRY(write_cameras(db, tables.cameras, block.cameras));
  COLLINEA_TRY(write_poses(db, tables.poses, block));
  COLLINEA_TRY(write_chunks<PointRecord>(db, tables.points, block.points));
  COLLINEA_TRY(write_chunks<ObservationRecord>(db, tables.observations, block.observations));
  return write_control_observations(db, tables.control_observations, block.control_observations);
}

Result<bool> is_adjusted(Database& db) {
  return db.integer("SELECT count(*) FROM sqlite_master WHERE name = 'found_cameras'")
      .and_then([&](auto tables) -> Result<std::int64_t> {
        return tables == 0 ? Result<std::int64_t>(0) : db.integer("SELECT count(*) FROM found_cameras");
      })
      .map([](auto cameras) { return cameras > 0; });
}

Result<> put_found_aside(Database& db) {
  COLLINEA_TRY(const bool adjusted, is_adjusted(db));
  if (adjusted) return {};
  const auto from = kCurrentOrientation.all(), to = kFoundOrientation.all();
  for (std::size_t i = 0; i < from.size(); ++i)
    COLLINEA_TRY(db.execute("INSERT INTO " + to[i] + " SELECT * FROM " + from[i]));
  return {};
}

}  // namespace collinea
