// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/internal/setup_tables.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <vector>

#include "collinea/base/packed.h"
#include "collinea/store/internal/project_store_state.h"
#include "collinea/store/internal/record_chunks.h"

namespace collinea {
namespace {

using sqlite::Database;
using sqlite::Statement;

// How one record lies in a blob. kBytes is its exact size. A record of no point says the shape of the one before it, in
// place of the pixel: almost all are round, and have none.
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

std::vector<ControlObservation> with_shapes(const std::vector<ControlObservation>& observations) {
  std::vector<ControlObservation> records;
  records.reserve(observations.size());
  for (const ControlObservation& one : observations) {
    records.push_back(one);
    if (!one.shape.is_round())
      records.push_back({ControlId{}, one.image, {one.shape.row_over_column, one.shape.correlation}});
  }
  return records;
}

// The deformation of film behind the sigma of a camera: those of other cameras end there.
void put_film(Packer& packer, const FilmPrior& film) {
  for (const double value : {film.sigma_px, film.correlation_px, film.mark_sigma_px}) packer.put(value);
  packer.put(std::uint32_t{film.sigma_is_given});
  packer.put(std::uint32_t{film.correlation_is_given});
  packer.put(static_cast<std::uint32_t>(film.functions));
  for (const FilmMarkOffset& mark : film.marks) {
    put(packer, mark.pixel);
    put(packer, mark.offset_px);
  }
}

void get_film(Unpacker& unpacker, FilmPrior& film) {
  for (double* value : {&film.sigma_px, &film.correlation_px, &film.mark_sigma_px}) unpacker.get(*value);
  std::uint32_t sigma_is_given = 0, correlation_is_given = 0, functions = 0;
  for (std::uint32_t* value : {&sigma_is_given, &correlation_is_given, &functions}) unpacker.get(*value);
  film.sigma_is_given = sigma_is_given != 0;
  film.correlation_is_given = correlation_is_given != 0;
  film.functions = static_cast<int>(std::min<std::uint32_t>(functions, kFilmFunctions));
  while (unpacker.ok() && !unpacker.done()) {
    FilmMarkOffset mark;
    get(unpacker, mark.pixel);
    get(unpacker, mark.offset_px);
    film.marks.push_back(mark);
  }
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

// Position in the map and in the world and its standard deviations; correlations where there are some.
std::string control_numbers(const ControlPoint& point) {
  Packer numbers;
  for (const auto& v : {point.position_in_map, point.position_in_world, point.sigma_m}) put(numbers, v);
  if (!point.correlation.isZero(0)) put(numbers, point.correlation);
  return numbers.bytes();
}

std::string_view role_word(ControlRole role) { return role == ControlRole::kControl ? "control" : "check"; }

Result<> write_control(Database& db, const std::map<ControlId, ControlPoint>& control) {
  COLLINEA_TRY(db.execute("DELETE FROM control"));
  return update_control(db, "control", control);
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
    const bool is_vector = one.kind == GeodeticKind::kGnssVector;
    if (one.is_of_shape() || is_vector) numbers.put(static_cast<std::uint32_t>(one.axis));
    if (is_vector) {
      put(numbers, one.along);
      numbers.put(static_cast<std::uint32_t>(one.is_local));
    }
    insert.bind(static_cast<std::int64_t>(i)).bind_text(one.name);
    COLLINEA_TRY(insert.bind_blob(numbers.bytes()).run());
  }
  return {};
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
    const bool is_vector = one.kind == GeodeticKind::kGnssVector;
    if (one.is_of_shape() || is_vector) numbers.get(axis);
    std::uint32_t is_local = 0;
    if (is_vector) {
      get(numbers, one.along);
      numbers.get(is_local);
    }
    one.is_local = is_local != 0;
    if (!numbers.done() || kind >= kGeodeticKinds || role > 1 || axis > (is_vector ? 2 : 1))
      return damaged("a measurement on the ground");
    one.axis = static_cast<int>(axis);
    one.role = static_cast<ControlRole>(role);
    geodetic.push_back(std::move(one));
  }
}

}  // namespace

Result<> write_cameras(Database& db, const std::string& table, const std::map<CameraId, Camera>& cameras) {
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  for (const auto& [id, camera] : cameras) {
    Packer sigma;
    sigma.put(camera.prior.sigma_f_px);
    if (camera.prior.film) put_film(sigma, *camera.prior.film);
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
    if (!sigma.done()) get_film(sigma, camera.prior.film.emplace());
    if (!sigma.done()) return damaged(table);
    cameras[{std::uint32_t(select.integer(0))}] = std::move(camera);
  }
}

Result<> read_control(Database& db, const std::string& table, std::map<ControlId, ControlPoint>& control) {
  COLLINEA_TRY(auto select, db.prepare("SELECT * FROM " + table + " ORDER BY id"));
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

Result<> update_control(Database& db, const std::string& table, const std::map<ControlId, ControlPoint>& control) {
  std::map<ControlId, ControlPoint> before;
  COLLINEA_TRY(read_control(db, table, before));
  COLLINEA_TRY(auto erase, db.prepare("DELETE FROM " + table + " WHERE id = ?"));
  for (const auto& [id, point] : before)
    if (!control.contains(id)) COLLINEA_TRY(erase.bind(id.value).run());
  COLLINEA_TRY(auto insert, db.prepare("INSERT OR REPLACE INTO " + table + " VALUES (?, ?, ?, ?)"));
  for (const auto& [id, point] : control) {
    const std::string numbers = control_numbers(point);
    const auto old = before.find(id);
    if (old != before.end() && old->second.name == point.name && old->second.role == point.role &&
        control_numbers(old->second) == numbers)
      continue;
    insert.bind(id.value).bind_text(point.name).bind_text(role_word(point.role)).bind_blob(numbers);
    COLLINEA_TRY(insert.run());
  }
  return {};
}

Result<bool> has_geodetic(Database& db) {
  return db.integer("SELECT count(*) FROM sqlite_master WHERE name = 'ground'").map([](auto count) {
    return count > 0;
  });
}

Result<> write_control_observations(Database& db, const std::string& table,
                                    const std::vector<ControlObservation>& observations) {
  return write_chunks<ControlObservationRecord>(db, table, with_shapes(observations));
}

Result<> update_control_observations(Database& db, const std::string& table,
                                     const std::vector<ControlObservation>& observations) {
  return update_chunks<ControlObservationRecord>(db, table, with_shapes(observations));
}

Result<> read_control_observations(Database& db, const std::string& table, Block& block) {
  bool is_sound = true;
  COLLINEA_TRY(read_chunks<ControlObservationRecord>(db, table, [&](const ControlObservation& o) {
    auto& all = block.control_observations;
    if (o.point.valid()) return all.push_back(o);
    const PixelShape shape{static_cast<float>(o.pixel.x()), static_cast<float>(o.pixel.y())};
    is_sound = is_sound && !all.empty() && shape.is_valid();
    if (!all.empty()) all.back().shape = shape;
  }));
  if (!is_sound) return damaged(table);
  return {};
}

Result<> write_setup_tables(Database& db, const Block& block) {
  COLLINEA_TRY(write_georeference(db, block.georeference));
  COLLINEA_TRY(write_cameras(db, "cameras", block.cameras));
  COLLINEA_TRY(write_images(db, block.images));
  COLLINEA_TRY(write_control(db, block.control));
  COLLINEA_TRY(write_geodetic(db, block.geodetic));
  return write_control_observations(db, "control_observations", block.control_observations);
}

Result<> read_setup_tables(Database& db, Block& block) {
  COLLINEA_TRY(read_georeference(db, block.georeference));
  COLLINEA_TRY(read_cameras(db, "cameras", block.cameras));
  COLLINEA_TRY(read_images(db, block));
  COLLINEA_TRY(read_control(db, "control", block.control));
  return read_geodetic(db, block.geodetic);
}

}  // namespace collinea
