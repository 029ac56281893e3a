// SPDX-License-Identifier: Apache-2.0
// The block of a ProjectStore: what was set up, and what the orientation made of it.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>

#include "collinea/base/hash.h"
#include "collinea/base/packed.h"
#include "collinea/store/internal/project_store_state.h"
#include "collinea/store/project_store.h"

namespace collinea {
namespace {

using sqlite::Database;
using sqlite::Statement;

void put(Packer& packer, const Eigen::Vector2d& v) {
  for (int i = 0; i < 2; ++i) packer.put(v[i]);
}
void put(Packer& packer, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) packer.put(v[i]);
}
void get(Unpacker& unpacker, Eigen::Vector2d& v) {
  for (int i = 0; i < 2; ++i) unpacker.get(v[i]);
}
void get(Unpacker& unpacker, Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) unpacker.get(v[i]);
}

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

struct ControlObservationRecord {
  static constexpr std::size_t kBytes = 2 * 4 + 3 * 8;
  using Value = ControlObservation;
  static void put_one(Packer& packer, const ControlObservation& o) {
    packer.put(o.point.value);
    packer.put(o.image.value);
    put(packer, o.pixel);
    packer.put(o.sigma_px);
  }
  static Value get_one(Unpacker& unpacker) {
    ControlObservation o;
    unpacker.get(o.point.value);
    unpacker.get(o.image.value);
    get(unpacker, o.pixel);
    unpacker.get(o.sigma_px);
    return o;
  }
};

// A symmetric matrix: its lower triangle, row by row.
template <class Matrix>
void put_symmetric(Packer& packer, const Matrix& m) {
  for (Eigen::Index row = 0; row < m.rows(); ++row)
    for (Eigen::Index column = 0; column <= row; ++column) packer.put(m(row, column));
}
template <class Matrix>
void get_symmetric(Unpacker& unpacker, Matrix& m) {
  for (Eigen::Index row = 0; row < m.rows(); ++row)
    for (Eigen::Index column = 0; column <= row; ++column) {
      unpacker.get(m(row, column));
      m(column, row) = m(row, column);
    }
}

struct PointCovarianceRecord {
  static constexpr std::size_t kBytes = 6 * 8;
  using Value = Eigen::Matrix3d;
  static void put_one(Packer& packer, const Eigen::Matrix3d& covariance) { put_symmetric(packer, covariance); }
  static Value get_one(Unpacker& unpacker) {
    Eigen::Matrix3d covariance;
    get_symmetric(unpacker, covariance);
    return covariance;
  }
};

// Many records a row: far fewer and smaller rows than one each, and no blob grows with the block.
template <class Record, class Values>
Result<> write_chunks(Database& db, const std::string& table, const Values& values) {
  constexpr std::size_t kPerChunk = 16384;
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?)"));
  Packer packer;
  packer.reserve(std::min(kPerChunk, values.size()) * Record::kBytes);
  std::int64_t chunk = 0;
  const auto flush = [&] {
    auto written = insert.bind(chunk++).bind_blob(packer.bytes()).run();
    packer.clear();
    return written;
  };
  for (const auto& value : values) {
    Record::put_one(packer, value);
    if (packer.size() == kPerChunk * Record::kBytes) COLLINEA_TRY(flush());
  }
  return packer.size() > 0 ? flush() : Result<>{};
}

// The records of a table, one after the other.
template <class Record>
class ChunkReader {
 public:
  static Result<ChunkReader> open(Database& db, const std::string& table) {
    ChunkReader reader;
    reader.table_ = table;
    COLLINEA_TRY(reader.select_, db.prepare("SELECT data FROM " + table + " ORDER BY chunk"));
    COLLINEA_TRY(reader.advance());
    return reader;
  }
  [[nodiscard]] bool at_end() const { return !value_; }
  [[nodiscard]] const typename Record::Value& value() const { return *value_; }
  Result<> advance() {
    while (chunk_.left() == 0) {
      value_.reset();
      COLLINEA_TRY(const bool row, select_.next());
      if (!row) return {};
      const std::string_view blob = select_.blob(0);
      if (blob.size() % Record::kBytes != 0) return damaged(table_);
      chunk_ = Unpacker(blob);
    }
    value_ = Record::get_one(chunk_);
    return {};
  }

 private:
  std::string table_;
  Statement select_;
  Unpacker chunk_{std::string_view()};  // of the row that the statement is at
  std::optional<typename Record::Value> value_;
};

template <class Record, class Take>
Result<> read_chunks(Database& db, const std::string& table, Take&& take) {
  COLLINEA_TRY(auto reader, ChunkReader<Record>::open(db, table));
  while (!reader.at_end()) {
    take(reader.value());
    COLLINEA_TRY(reader.advance());
  }
  return {};
}

Result<> write_georeference(Database& db, const std::optional<Georeference>& georeference) {
  COLLINEA_TRY(db.execute("DELETE FROM georeference"));
  if (!georeference) return {};
  Packer origin;
  origin.put(georeference->origin_latitude_deg);
  origin.put(georeference->origin_longitude_deg);
  origin.put(georeference->origin_height_m);
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO georeference VALUES (0, ?, ?)"));
  return insert.bind_text(georeference->crs).bind_blob(origin.bytes()).run();
}

Result<> read_georeference(Database& db, std::optional<Georeference>& georeference) {
  COLLINEA_TRY(auto select, db.prepare("SELECT crs, origin FROM georeference"));
  COLLINEA_TRY(const bool row, select.next());
  if (!row) return {};
  Georeference g{.crs = select.text(0)};
  Unpacker origin(select.blob(1));
  origin.get(g.origin_latitude_deg);
  origin.get(g.origin_longitude_deg);
  origin.get(g.origin_height_m);
  if (!origin.done()) return damaged("georeference");
  georeference = std::move(g);
  return {};
}

// The index of a name in a list of them.
std::optional<std::size_t> index_of(std::span<const std::string_view> names, std::string_view name) {
  const auto found = std::ranges::find(names, name);
  return found == names.end() ? std::nullopt : std::optional(std::size_t(found - names.begin()));
}

// "name value" of every parameter that the camera has, in shortest decimals that give the same bits back.
std::string parameters_text(const Camera& camera) {
  std::string text;
  for (const int param : params_of(camera)) {
    char value[32];
    const auto [end, error] = std::to_chars(value, value + sizeof(value), camera.params[std::size_t(param)]);
    text += (text.empty() ? "" : " ") + param_name(param) + " " + std::string(value, end);
  }
  return text;
}

bool read_parameters(const std::string& text, Camera& camera) {
  std::istringstream words(text);
  std::size_t count = 0;
  for (std::string name, value; words >> name >> value; ++count) {
    const auto param = param_named(camera, name);
    if (!param) return false;
    double& number = camera.params[std::size_t(*param)];
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc() || end != value.data() + value.size()) return false;
  }
  return count == params_of(camera).size();
}

Result<> write_cameras(Database& db, const std::string& table, const std::map<CameraId, Camera>& cameras) {
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  for (const auto& [id, camera] : cameras) {
    Packer sigma;
    sigma.put(camera.prior.sigma_f_px);
    const std::string parameters = parameters_text(camera);  // texts are bound where they lie, until the row is written
    insert.bind(id.value).bind_text(camera.name).bind(camera.width_px).bind(camera.height_px);
    insert.bind_text(name_of(camera.model)).bind_text(kAdditionalNames[std::size_t(camera.additional)]);
    insert.bind_text(parameters).bind_text(word_of(camera.prior.source));
    COLLINEA_TRY(insert.bind(int(camera.prior.calibrate)).bind_blob(sigma.bytes()).run());
  }
  return {};
}

Result<> read_cameras(Database& db, const std::string& table, std::map<CameraId, Camera>& cameras) {
  COLLINEA_TRY(auto select, db.prepare("SELECT * FROM " + table + " ORDER BY id"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    Camera camera;
    camera.name = select.text(1);
    camera.width_px = int(select.integer(2));
    camera.height_px = int(select.integer(3));
    const auto model = model_named(select.text(4));
    const auto additional = index_of(kAdditionalNames, select.text(5));
    const auto source = from_word<Provenance>(select.text(7));
    if (!model || !additional) return damaged(table);
    camera.model = *model;
    camera.additional = AdditionalSet(*additional);
    if (!read_parameters(select.text(6), camera)) return damaged(table);
    camera.prior.source = source.value_or(Provenance::kUnknown);  // other versions have other words
    camera.prior.calibrate = select.integer(8) != 0;
    Unpacker sigma(select.blob(9));
    sigma.get(camera.prior.sigma_f_px);
    if (!sigma.done()) return damaged(table);
    cameras[{std::uint32_t(select.integer(0))}] = std::move(camera);
  }
}

Result<> write_image(Statement& insert, ImageId id, const Image& image) {
  Packer position, attitude;
  insert.bind(id.value).bind_text(image.file).bind(image.camera.value).bind_text(image.taken).bind(image.orientation);
  if (const auto& p = image.position) {
    put(position, p->position_in_world);
    put(position, p->sigma_m);
    for (const double value : {p->latitude_deg, p->longitude_deg, p->height_m}) position.put(value);
    position.put(p->height_above_start_m.value_or(std::numeric_limits<double>::quiet_NaN()));
    insert.bind_blob(position.bytes());
  } else {
    insert.bind_null();
  }
  if (const auto& a = image.attitude) {
    for (const double value : {a->heading_deg, a->pitch_deg, a->roll_deg}) attitude.put(value);
    if (!a->sigma_deg.isZero(0))
      for (const double value : a->sigma_deg) attitude.put(value);
    insert.bind_blob(attitude.bytes());
  } else {
    insert.bind_null();
  }
  return insert.run();
}

Result<> write_images(Database& db, const std::map<ImageId, Image>& images) {
  COLLINEA_TRY(db.execute("DELETE FROM images"));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO images VALUES (?, ?, ?, ?, ?, ?, ?)"));
  for (const auto& [id, image] : images) COLLINEA_TRY(write_image(insert, id, image));
  return {};
}

Result<Image> image_of_row(const Statement& row) {
  Image image;
  image.file = row.text(1);
  image.camera = {std::uint32_t(row.integer(2))};
  image.taken = row.text(3);
  image.orientation = int(row.integer(4));
  if (!row.is_null(5)) {
    Unpacker unpacker(row.blob(5));
    PositionPrior& p = image.position.emplace();
    get(unpacker, p.position_in_world);
    get(unpacker, p.sigma_m);
    for (double* value : {&p.latitude_deg, &p.longitude_deg, &p.height_m}) unpacker.get(*value);
    const double height_m = unpacker.left() > 0 ? unpacker.get<double>() : std::nan("");  // older projects have none
    if (std::isfinite(height_m)) p.height_above_start_m = height_m;
    if (!unpacker.done()) return damaged("position of " + image.file);
  }
  if (!row.is_null(6)) {
    Unpacker unpacker(row.blob(6));
    AttitudePrior& a = image.attitude.emplace();
    for (double* value : {&a.heading_deg, &a.pitch_deg, &a.roll_deg}) unpacker.get(*value);
    if (unpacker.left() > 0)
      for (double& value : a.sigma_deg) unpacker.get(value);
    if (!unpacker.done()) return damaged("attitude of " + image.file);
  }
  return image;
}

Result<> read_images(Database& db, Block& block) {
  COLLINEA_TRY(auto select, db.prepare("SELECT * FROM images ORDER BY id"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    COLLINEA_TRY(Image image, image_of_row(select));
    if (!block.cameras.contains(image.camera)) return damaged("no camera of " + image.file);
    block.images[{std::uint32_t(select.integer(0))}] = std::move(image);
  }
}

Result<> write_control(Database& db, const std::map<ControlId, ControlPoint>& control) {
  COLLINEA_TRY(db.execute("DELETE FROM control"));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO control VALUES (?, ?, ?, ?)"));
  for (const auto& [id, point] : control) {
    Packer numbers;
    for (const auto& v : {point.position_in_map, point.position_in_world, point.sigma_m}) put(numbers, v);
    if (!point.correlation.isZero(0)) put(numbers, point.correlation);
    insert.bind(id.value).bind_text(point.name).bind_text(point.role == ControlRole::kControl ? "control" : "check");
    COLLINEA_TRY(insert.bind_blob(numbers.bytes()).run());
  }
  return {};
}

Result<> read_control(Database& db, std::map<ControlId, ControlPoint>& control) {
  COLLINEA_TRY(auto select, db.prepare("SELECT * FROM control ORDER BY id"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    ControlPoint point;
    point.name = select.text(1);
    const std::string role = select.text(2);
    if (role != "control" && role != "check") return damaged("role of control point " + point.name);
    point.role = role == "control" ? ControlRole::kControl : ControlRole::kCheck;
    Unpacker numbers(select.blob(3));
    for (auto* v : {&point.position_in_map, &point.position_in_world, &point.sigma_m}) get(numbers, *v);
    if (!numbers.done()) get(numbers, point.correlation);
    if (!numbers.done()) return damaged("control point " + point.name);
    control[{std::uint32_t(select.integer(0))}] = std::move(point);
  }
}

Result<> write_geodetic(Database& db, const std::vector<GeodeticObservation>& geodetic) {
  COLLINEA_TRY(db.execute("DELETE FROM ground"));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO ground VALUES (?, ?, ?)"));
  for (std::size_t i = 0; i < geodetic.size(); ++i) {
    const GeodeticObservation& one = geodetic[i];
    Packer numbers;
    for (const std::uint32_t value : {static_cast<std::uint32_t>(one.kind), one.from.value, one.to.value,
                                      static_cast<std::uint32_t>(one.role), one.setup})
      numbers.put(value);
    for (const double value : {one.value, one.sigma, one.instrument_height_m, one.target_height_m}) numbers.put(value);
    if (one.is_of_shape()) numbers.put(static_cast<std::uint32_t>(one.axis));
    insert.bind(static_cast<std::int64_t>(i)).bind_text(one.name);
    COLLINEA_TRY(insert.bind_blob(numbers.bytes()).run());
  }
  return {};
}

// Projects of older versions that cannot be written have no such table.
Result<bool> has_geodetic(Database& db) {
  return db.integer("SELECT count(*) FROM sqlite_master WHERE name = 'ground'").map([](auto count) {
    return count > 0;
  });
}

Result<> read_geodetic(Database& db, std::vector<GeodeticObservation>& geodetic) {
  COLLINEA_TRY(const bool there, has_geodetic(db));
  if (!there) return {};
  COLLINEA_TRY(auto select, db.prepare("SELECT name, numbers FROM ground ORDER BY id"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    GeodeticObservation one;
    one.name = select.text(0);
    Unpacker numbers(select.blob(1));
    std::uint32_t kind = 0, role = 0;
    for (std::uint32_t* value : {&kind, &one.from.value, &one.to.value, &role, &one.setup}) numbers.get(*value);
    for (double* value : {&one.value, &one.sigma, &one.instrument_height_m, &one.target_height_m}) numbers.get(*value);
    one.kind = static_cast<GeodeticKind>(kind);
    std::uint32_t axis = 0;
    if (one.is_of_shape()) numbers.get(axis);
    if (!numbers.done() || kind >= kGeodeticKinds || role > 1 || axis > 1)
      return damaged("a measurement on the ground");
    one.axis = static_cast<int>(axis);
    one.role = static_cast<ControlRole>(role);
    geodetic.push_back(std::move(one));
  }
}

Result<> read_control_observations(Database& db, const std::string& table, Block& block) {
  return read_chunks<ControlObservationRecord>(
      db, table, [&](const ControlObservation& o) { block.control_observations.push_back(o); });
}

Result<> read_setup_tables(Database& db, Block& block) {
  COLLINEA_TRY(read_georeference(db, block.georeference));
  COLLINEA_TRY(read_cameras(db, "cameras", block.cameras));
  COLLINEA_TRY(read_images(db, block));
  COLLINEA_TRY(read_control(db, block.control));
  return read_geodetic(db, block.geodetic);
}

// Where an orientation lies: the one that counts, and the one that was found, from which adjustment begins.
struct OrientationTables {
  std::string cameras, poses, points, observations, control_observations;
  [[nodiscard]] std::array<std::string, 5> all() const {
    return {cameras, poses, points, observations, control_observations};
  }
};
const OrientationTables kCurrent{"adjusted_cameras", "poses", "points", "observations", "used_control_observations"};
const OrientationTables kFound{"found_cameras", "found_poses", "found_points", "found_observations",
                               "found_control_observations"};

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
  for (const OrientationTables& tables : {kCurrent, kFound})
    for (const std::string& table : tables.all()) erase += "DELETE FROM " + table + ";";
  return db.execute(erase);
}

Result<> write_orientation_tables(Database& db, const OrientationTables& tables, const Block& block) {
  COLLINEA_TRY(write_cameras(db, tables.cameras, block.cameras));
  COLLINEA_TRY(write_poses(db, tables.poses, block));
  COLLINEA_TRY(write_chunks<PointRecord>(db, tables.points, block.points));
  COLLINEA_TRY(write_chunks<ObservationRecord>(db, tables.observations, block.observations));
  return write_chunks<ControlObservationRecord>(db, tables.control_observations, block.control_observations);
}

// The first adjustment puts aside what it began with.
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
  const auto from = kCurrent.all(), to = kFound.all();
  for (std::size_t i = 0; i < from.size(); ++i)
    COLLINEA_TRY(db.execute("INSERT INTO " + to[i] + " SELECT * FROM " + from[i]));
  return {};
}

// Matrices of any size, by id.
template <class Matrices>
Result<> write_covariances(Database& db, const std::string& table, const Matrices& matrices) {
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?, ?)"));
  for (const auto& [id, matrix] : matrices) {
    Packer packer;
    put_symmetric(packer, matrix);
    COLLINEA_TRY(insert.bind(id.value).bind(static_cast<std::int64_t>(matrix.rows())).bind_blob(packer.bytes()).run());
  }
  return {};
}

template <class Matrices>
Result<> read_covariances(Database& db, const std::string& table, Matrices& matrices) {
  constexpr std::int64_t kMostRows = 1000;
  using Matrix = typename Matrices::mapped_type;
  COLLINEA_TRY(auto select, db.prepare("SELECT id, size, data FROM " + table + " ORDER BY id"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    const std::int64_t size = select.integer(1);
    const bool fits = Matrix::RowsAtCompileTime == Eigen::Dynamic || size == Matrix::RowsAtCompileTime;
    if (size < 1 || size > kMostRows || !fits) return damaged("a covariance matrix");
    Matrix matrix(size, size);
    Unpacker unpacker(select.blob(2));
    get_symmetric(unpacker, matrix);
    if (!unpacker.done()) return damaged("a covariance matrix");
    matrices[{static_cast<std::uint32_t>(select.integer(0))}] = std::move(matrix);
  }
}

// Every reference from one table to another is kept.
bool fits_together(const Block& block) {
  for (const auto& [image, pose] : oriented_images(block))
    if (!block.images.contains(image)) return false;
  PointId known;  // observations of one point follow each other: look each up once
  for (const Observation& o : block.observations) {
    if (!block.images.contains(o.image)) return false;
    if (o.point != known && !block.points.contains(o.point)) return false;
    known = o.point;
  }
  for (const ControlObservation& o : block.control_observations)
    if (!block.images.contains(o.image) || !block.control.contains(o.point)) return false;
  for (const GeodeticObservation& o : block.geodetic)
    if (!block.control.contains(o.from) || !block.control.contains(o.to)) return false;
  return true;
}

enum class Wanted { kSetup, kOrientation, kAll, kFound };

Result<Block> read_tables(Database& db, Wanted wanted) {
  Block block;
  COLLINEA_TRY(read_setup_tables(db, block));
  COLLINEA_TRY(const auto oriented, db.integer("SELECT count(*) FROM oriented"));
  if (oriented == 0) wanted = Wanted::kSetup;
  const OrientationTables* tables = &kCurrent;
  if (wanted == Wanted::kFound) {
    COLLINEA_TRY(const bool adjusted, is_adjusted(db));
    if (adjusted) tables = &kFound;
  }
  const auto read = wanted == Wanted::kSetup ? read_control_observations(db, "control_observations", block)
                                             : read_orientation_tables(db, *tables, block);
  if (!read) return tl::unexpected(read.error());
  if (wanted == Wanted::kAll || wanted == Wanted::kFound) {
    COLLINEA_TRY(read_tie_tables(db, *tables, block));
  }
  if (!fits_together(block)) return damaged("observations or poses of images or points that are not there");
  return block;
}

Result<Block> read_consistently(Database& db, Wanted wanted) {
  COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
  return read_tables(db, wanted);
}

}  // namespace

Result<std::uint64_t> ProjectStore::setup_hash() const {
  return state_->read([](Database& db) -> Result<std::uint64_t> {
    Hash hash;
    std::vector<const char*> tables = {"georeference", "cameras", "images", "control", "control_observations"};
    COLLINEA_TRY(const bool may_have_geodetic, has_geodetic(db));
    if (may_have_geodetic) {
      COLLINEA_TRY(const auto measured, db.integer("SELECT count(*) FROM ground"));
      if (measured > 0) tables.push_back("ground");  // without any, the fingerprint is that of older versions
    }
    for (const char* table : tables) {
      hash.add(std::string_view(table));
      COLLINEA_TRY(auto select, db.prepare(std::string("SELECT * FROM ") + table + " ORDER BY 1"));
      while (true) {
        COLLINEA_TRY(const bool row, select.next());
        if (!row) break;
        for (int column = 0; column < select.columns(); ++column)
          hash.add(std::uint64_t{select.is_null(column)}).add(select.blob(column));
      }
    }
    return hash.value();
  });
}

Result<> ProjectStore::write_setup(const Block& block) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(write_georeference(db, block.georeference));
    COLLINEA_TRY(write_cameras(db, "cameras", block.cameras));
    COLLINEA_TRY(write_images(db, block.images));
    COLLINEA_TRY(write_control(db, block.control));
    COLLINEA_TRY(write_geodetic(db, block.geodetic));
    if (auto written = write_chunks<ControlObservationRecord>(db, "control_observations", block.control_observations);
        !written)
      return written;
    return read_tables(db, Wanted::kAll) ? Result<>{} : erase_orientation(db);  // it was of another setup
  });
}

Result<> ProjectStore::write_orientation(const Block& block) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(erase_orientation(db));
    COLLINEA_TRY(write_orientation_tables(db, kCurrent, block));
    return db.execute("INSERT INTO oriented VALUES (0)");
  });
}

Result<> ProjectStore::write_adjustment(const Block& block, const BlockCovariances& covariances) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(put_found_aside(db));
    COLLINEA_TRY(write_orientation_tables(db, kCurrent, block));
    COLLINEA_TRY(write_covariances(db, "pose_covariances", covariances.poses));
    COLLINEA_TRY(write_covariances(db, "camera_covariances", covariances.cameras));
    return write_chunks<PointCovarianceRecord>(db, "point_covariances", covariances.points);
  });
}

Result<BlockCovariances> ProjectStore::read_covariances() const {
  return state_->read([](Database& db) -> Result<BlockCovariances> {
    COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
    BlockCovariances covariances;
    COLLINEA_TRY(const bool adjusted, is_adjusted(db));
    if (!adjusted) return covariances;
    COLLINEA_TRY(collinea::read_covariances(db, "pose_covariances", covariances.poses));
    COLLINEA_TRY(collinea::read_covariances(db, "camera_covariances", covariances.cameras));
    if (Result<> read = read_chunks<PointCovarianceRecord>(
            db, "point_covariances", [&](const Eigen::Matrix3d& one) { covariances.points.push_back(one); });
        !read)
      return tl::unexpected(read.error());
    return covariances;
  });
}

Result<Block> ProjectStore::read_found() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kFound); });
}

Result<Block> ProjectStore::read_block() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kAll); });
}

Result<Block> ProjectStore::read_orientation() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kOrientation); });
}

Result<> ProjectStore::read_ties(const Block& block, const TakeTie& take) const {
  return state_->read([&](Database& db) -> Result<> {
    COLLINEA_TRY(const auto transaction, sqlite::Transaction::begin_reading(db));
    return read_ties_in_order(db, block, take);
  });
}

Result<Block> ProjectStore::read_setup() const {
  return state_->read([](Database& db) { return read_consistently(db, Wanted::kSetup); });
}

}  // namespace collinea
