// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/project_store.h"

#include <unistd.h>

#include <algorithm>
#include <array>

#include "collinea/base/file.h"
#include "collinea/base/packed.h"
#include "collinea/store/internal/edit_tables.h"
#include "collinea/store/internal/project_store_state.h"

namespace collinea {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr std::int64_t kApplication = 0x434f4c4e;  // "COLN" in the file's header
constexpr std::int64_t kSchema = 2;

// Numbers that must come back bit by bit are packed in blobs: SQLite turns NaN into NULL and drops the sign of zero.
constexpr const char* kTables = R"sql(
CREATE TABLE georeference (id INTEGER PRIMARY KEY CHECK (id = 0), crs TEXT, origin BLOB);
CREATE TABLE cameras (id INTEGER PRIMARY KEY, name TEXT, width_px INTEGER, height_px INTEGER, model TEXT,
                      additional TEXT, parameters TEXT, source TEXT, calibrate INTEGER, sigma_f_px BLOB);
CREATE TABLE adjusted_cameras (id INTEGER PRIMARY KEY, name TEXT, width_px INTEGER, height_px INTEGER, model TEXT,
                               additional TEXT, parameters TEXT, source TEXT, calibrate INTEGER, sigma_f_px BLOB);
CREATE TABLE images (id INTEGER PRIMARY KEY, file TEXT, camera INTEGER, taken TEXT, orientation INTEGER,
                     position BLOB, attitude BLOB);
CREATE TABLE control (id INTEGER PRIMARY KEY, name TEXT, role TEXT, numbers BLOB);
CREATE TABLE control_observations (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE oriented (id INTEGER PRIMARY KEY CHECK (id = 0));
CREATE TABLE poses (image INTEGER PRIMARY KEY, cam_from_world BLOB);
CREATE TABLE points (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE observations (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE used_control_observations (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE features (image INTEGER PRIMARY KEY, inputs_hash TEXT, keypoints BLOB, descriptors BLOB);
CREATE TABLE pairs (first INTEGER, second INTEGER, inputs_hash TEXT, geometry TEXT, putative INTEGER, numbers BLOB,
                    matches BLOB, PRIMARY KEY (first, second));
)sql";

// Tables that came later: projects from before do without until they are written to. Their steps count as not done:
// what was recorded of them was text that nothing reads any more.
constexpr const char* kLaterTables = R"sql(
CREATE TABLE IF NOT EXISTS ground (id INTEGER PRIMARY KEY, name TEXT, numbers BLOB);
CREATE TABLE IF NOT EXISTS step_records (sequence INTEGER PRIMARY KEY AUTOINCREMENT, step TEXT UNIQUE,
                                         inputs_hash TEXT, output_hash TEXT, seconds REAL, cpu_seconds REAL,
                                         peak_memory_bytes REAL, record BLOB);
CREATE TABLE IF NOT EXISTS found_cameras (id INTEGER PRIMARY KEY, name TEXT, width_px INTEGER, height_px INTEGER,
                                          model TEXT, additional TEXT, parameters TEXT, source TEXT, calibrate INTEGER,
                                          sigma_f_px BLOB);
CREATE TABLE IF NOT EXISTS found_poses (image INTEGER PRIMARY KEY, cam_from_world BLOB);
CREATE TABLE IF NOT EXISTS found_points (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE IF NOT EXISTS found_observations (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE IF NOT EXISTS found_control_observations (chunk INTEGER PRIMARY KEY, data BLOB);
CREATE TABLE IF NOT EXISTS pose_covariances (id INTEGER PRIMARY KEY, size INTEGER, data BLOB);
CREATE TABLE IF NOT EXISTS camera_covariances (id INTEGER PRIMARY KEY, size INTEGER, data BLOB);
CREATE TABLE IF NOT EXISTS point_covariances (chunk INTEGER PRIMARY KEY, data BLOB);
DROP TABLE IF EXISTS steps;
)sql";

constexpr std::array<std::string_view, 4> kGeometryWords = {"none", "general", "planar", "rotation"};

Result<> make_tables(Database& database) {
  COLLINEA_TRY(auto transaction, sqlite::Transaction::begin(database));
  COLLINEA_TRY(const auto tables, database.integer("SELECT count(*) FROM sqlite_master"));
  if (tables > 0) return {};  // another program was faster
  const std::string marks = "PRAGMA application_id = " + std::to_string(kApplication) +
                            "; PRAGMA user_version = " + std::to_string(kSchema) + ";";
  COLLINEA_TRY(database.execute(kTables + marks));
  return transaction.commit();
}

Result<> check_tables(Database& database) {
  COLLINEA_TRY(const auto application, database.integer("PRAGMA application_id"));
  COLLINEA_TRY(const auto version, database.integer("PRAGMA user_version"));
  if (application != kApplication) return fail(Errc::kBadFormat, "not a collinea database");
  if (version > kSchema)
    return fail(Errc::kUnsupported, "made by a newer collinea: use that, or another project folder");
  if (version < kSchema) return fail(Errc::kUnsupported, "made by an older collinea: use another project folder");
  return {};
}

// A lock for writing is asked for only where something is missing.
Result<> add_later_tables(Database& database) {
  COLLINEA_TRY(const auto there,
               database.integer("SELECT count(*) FROM sqlite_master WHERE name IN ('ground', 'step_records', "
                                "'point_covariances', 'edits')"));
  return there == 4 ? Result<>{} : database.execute(std::string(kLaterTables) + kEditTables);
}

Result<> prepare(Database& database) {
  COLLINEA_TRY(database.execute("PRAGMA page_size = 16384"));
  COLLINEA_TRY(const auto tables, database.integer("SELECT count(*) FROM sqlite_master"));
  const char* mode = "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;";
  if (tables > 0) {  // a stranger's file must not even be switched to WAL
    COLLINEA_TRY(check_tables(database));
    COLLINEA_TRY(database.execute(mode));
    return add_later_tables(database);
  }
  COLLINEA_TRY(database.execute(mode));
  COLLINEA_TRY(make_tables(database));
  COLLINEA_TRY(check_tables(database));
  return add_later_tables(database);
}

std::string packed(const std::vector<Keypoint>& keypoints) {
  Packer packer;
  packer.reserve(keypoints.size() * 20);
  for (const Keypoint& k : keypoints)
    for (const float value : {k.x, k.y, k.scale_px, k.angle_rad, k.strength}) packer.put(value);
  return packer.bytes();
}

Result<std::vector<Keypoint>> unpacked_keypoints(std::string_view blob) {
  if (blob.size() % 20 != 0) return damaged("keypoints of an image");
  std::vector<Keypoint> keypoints(blob.size() / 20);
  Unpacker unpacker(blob);
  for (Keypoint& k : keypoints)
    for (float* value : {&k.x, &k.y, &k.scale_px, &k.angle_rad, &k.strength}) unpacker.get(*value);
  return keypoints;
}

std::string packed(const Rigid3& motion) {
  Packer packer;
  const auto& q = motion.rotation;
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) packer.put(value);
  for (int i = 0; i < 3; ++i) packer.put(motion.translation[i]);
  return packer.bytes();
}

std::string packed(const std::vector<Match>& matches) {
  Packer packer;
  packer.reserve(matches.size() * 8);
  for (const auto& [first, second] : matches) {
    packer.put(first);
    packer.put(second);
  }
  return packer.bytes();
}

Result<> write_pair(Statement& insert, const ImagePair& pair, const std::string& inputs_hash) {
  Packer numbers;
  numbers.put_bytes(packed(pair.second_from_first));
  numbers.put(pair.median_parallax_rad);
  const std::string matches = packed(pair.matches);
  insert.bind(pair.first.value).bind(pair.second.value).bind_text(inputs_hash);
  insert.bind_text(kGeometryWords[std::size_t(pair.geometry)]).bind(pair.putative);
  return insert.bind_blob(numbers.bytes()).bind_blob(matches).run();
}

Result<ImagePair> pair_of_row(const Statement& row) {
  ImagePair pair;
  pair.first = {std::uint32_t(row.integer(0))};
  pair.second = {std::uint32_t(row.integer(1))};
  const std::string word = row.text(2);
  const auto known = std::find(kGeometryWords.begin(), kGeometryWords.end(), word);
  if (known == kGeometryWords.end()) return damaged("geometry of an image pair");
  pair.geometry = PairGeometry(known - kGeometryWords.begin());
  pair.putative = int(row.integer(3));
  Unpacker numbers(row.blob(4));
  auto& q = pair.second_from_first.rotation;
  for (double* value : {&q.w(), &q.x(), &q.y(), &q.z()}) numbers.get(*value);
  for (int i = 0; i < 3; ++i) numbers.get(pair.second_from_first.translation[i]);
  numbers.get(pair.median_parallax_rad);
  const std::string_view blob = row.blob(5);
  if (!numbers.done() || blob.size() % 8 != 0) return damaged("an image pair");
  pair.matches.resize(blob.size() / 8);
  Unpacker matches(blob);
  for (auto& [first, second] : pair.matches) {
    matches.get(first);
    matches.get(second);
  }
  return pair;
}

constexpr const char* kStepColumns =
    "SELECT step, inputs_hash, output_hash, seconds, cpu_seconds, peak_memory_bytes, record FROM step_records ";

Result<StepRecord> step_of_row(const Statement& row) {
  COLLINEA_TRY(StepOutcome outcome, unpacked_outcome(row.text(0), row.blob(6)));
  return StepRecord{row.text(1), row.text(2), row.real(3), row.real(4), row.real(5), std::move(outcome)};
}

// False in a project that nobody has written to since its steps were recorded in another way.
Result<bool> has_step_records(Database& db) {
  return db.integer("SELECT count(*) FROM sqlite_master WHERE name = 'step_records'").map([](auto count) {
    return count > 0;
  });
}

}  // namespace

ProjectStore::ProjectStore() : state_(std::make_unique<ProjectStoreState>()) {}
ProjectStore::ProjectStore(ProjectStore&&) noexcept = default;
ProjectStore& ProjectStore::operator=(ProjectStore&&) noexcept = default;
ProjectStore::~ProjectStore() = default;

Result<ProjectStore> ProjectStore::open(const std::filesystem::path& project, std::chrono::milliseconds patience) {
  std::error_code error;
  std::filesystem::create_directories(project, error);
  if (error || !std::filesystem::is_directory(project))
    return fail(Errc::kBadInput, project.string() + ": the project folder cannot be made: " + error.message());
  ProjectStore store;
  store.state_->folder = project;
  const std::filesystem::path file = project / "block.db";
  const auto with_name = [&](Error e) { return std::move(e).within(file.string()); };
  COLLINEA_TRY(store.state_->database, Database::open(file, patience).map_error(with_name));
  COLLINEA_TRY([[maybe_unused]] const auto ready,
               prepare(store.state_->database).map([] { return true; }).map_error(with_name));
  return store;
}

Result<ProjectStore> ProjectStore::open_to_read(const std::filesystem::path& project) {
  const std::filesystem::path file = project / "block.db";
  if (!is_there(file)) return fail(Errc::kNotFound, project.string() + " is not a project: no block.db in it");
  const bool writable = ::access(project.c_str(), W_OK) == 0 && ::access(file.c_str(), W_OK) == 0;
  return writable ? open(project) : open_read_only(project);
}

Result<ProjectStore> ProjectStore::open_read_only(const std::filesystem::path& project) {
  ProjectStore store;
  store.state_->folder = project;
  const std::filesystem::path file = project / "block.db";
  const auto with_name = [&](Error e) { return std::move(e).within(file.string()); };
  COLLINEA_TRY(store.state_->database, Database::open_read_only(file).map_error(with_name));
  COLLINEA_TRY([[maybe_unused]] const auto ready,
               check_tables(store.state_->database).map([] { return true; }).map_error(with_name));
  return store;
}

const std::filesystem::path& ProjectStore::folder() const { return state_->folder; }

Result<> ProjectStore::write_features(ImageId image, const Features& features, const std::string& inputs_hash) {
  COLLINEA_CHECK(features.keypoints.size() == features.descriptors.size());
  static_assert(sizeof(Descriptor) == 128);
  const std::string keypoints = packed(features.keypoints);
  const std::string_view descriptors(reinterpret_cast<const char*>(features.descriptors.data()),
                                     features.descriptors.size() * sizeof(Descriptor));
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto insert, db.prepare("INSERT OR REPLACE INTO features VALUES (?, ?, ?, ?)"));
    return insert.bind(image.value).bind_text(inputs_hash).bind_blob(keypoints).bind_blob(descriptors).run();
  });
}

Result<Features> ProjectStore::read_features(ImageId image) const {
  return state_->read([&](Database& db) -> Result<Features> {
    COLLINEA_TRY(auto select, db.prepare("SELECT keypoints, descriptors FROM features WHERE image = ?"));
    COLLINEA_TRY(const bool found, select.bind(image.value).next());
    if (!found) return fail(Errc::kNotFound, "no features of image " + std::to_string(image.value));
    Features features;
    COLLINEA_TRY(features.keypoints, unpacked_keypoints(select.blob(0)));
    const std::string_view descriptors = select.blob(1);
    if (descriptors.size() != features.keypoints.size() * sizeof(Descriptor)) return damaged("descriptors of an image");
    features.descriptors.resize(features.keypoints.size());
    if (!descriptors.empty()) std::memcpy(features.descriptors.data(), descriptors.data(), descriptors.size());
    return features;
  });
}

Result<std::vector<Keypoint>> ProjectStore::read_keypoints(ImageId image) const {
  return state_->read([&](Database& db) -> Result<std::vector<Keypoint>> {
    COLLINEA_TRY(auto select, db.prepare("SELECT keypoints FROM features WHERE image = ?"));
    COLLINEA_TRY(const bool found, select.bind(image.value).next());
    if (!found) return fail(Errc::kNotFound, "no features of image " + std::to_string(image.value));
    return unpacked_keypoints(select.blob(0));
  });
}

Result<std::map<ImageId, std::string>> ProjectStore::features_done() const {
  return state_->read([](Database& db) -> Result<std::map<ImageId, std::string>> {
    std::map<ImageId, std::string> done;
    COLLINEA_TRY(auto select, db.prepare("SELECT image, inputs_hash FROM features ORDER BY image"));
    while (true) {
      COLLINEA_TRY(const bool row, select.next());
      if (!row) return done;
      done.emplace_hint(done.end(), ImageId{std::uint32_t(select.integer(0))}, select.text(1));
    }
  });
}

Result<> ProjectStore::erase_features(ImageId image) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto erase, db.prepare("DELETE FROM features WHERE image = ?"));
    return erase.bind(image.value).run();
  });
}

Result<std::size_t> ProjectStore::count_features(ImageId image) const {
  return state_->read([&](Database& db) -> Result<std::size_t> {
    COLLINEA_TRY(auto select, db.prepare("SELECT length(keypoints) FROM features WHERE image = ?"));
    COLLINEA_TRY(const bool found, select.bind(image.value).next());
    if (!found) return fail(Errc::kNotFound, "no features of image " + std::to_string(image.value));
    if (select.integer(0) % 20 != 0) return damaged("keypoints of an image");
    return std::size_t(select.integer(0)) / 20;
  });
}

Result<> ProjectStore::renumber_features(const std::map<ImageId, ImageId>& new_from_old) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto set_aside, db.prepare("UPDATE features SET image = ? WHERE image = ?"));
    COLLINEA_TRY(auto erase, db.prepare("DELETE FROM features WHERE image = ?"));
    // Negative numbers on the way: the new one of one image may be the old one of another.
    const auto aside = [](ImageId id) { return -1 - std::int64_t{id.value}; };
    for (const auto& [from, to] : new_from_old) COLLINEA_TRY(set_aside.bind(aside(to)).bind(from.value).run());
    for (const auto& [from, to] : new_from_old) {
      COLLINEA_TRY(erase.bind(to.value).run());
      COLLINEA_TRY(set_aside.bind(to.value).bind(aside(to)).run());
    }
    return {};
  });
}

Result<> ProjectStore::write_pairs(const std::vector<ImagePair>& pairs, const std::string& inputs_hash) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto insert, db.prepare("INSERT OR REPLACE INTO pairs VALUES (?, ?, ?, ?, ?, ?, ?)"));
    for (const ImagePair& pair : pairs) COLLINEA_TRY(write_pair(insert, pair, inputs_hash));
    return {};
  });
}

Result<std::vector<ImagePair>> ProjectStore::read_pairs() const {
  return state_->read([](Database& db) -> Result<std::vector<ImagePair>> {
    std::vector<ImagePair> pairs;
    COLLINEA_TRY(auto select, db.prepare("SELECT first, second, geometry, putative, numbers, matches FROM pairs "
                                         "ORDER BY first, second"));
    while (true) {
      COLLINEA_TRY(const bool row, select.next());
      if (!row) return pairs;
      COLLINEA_TRY(ImagePair pair, pair_of_row(select));
      pairs.push_back(std::move(pair));
    }
  });
}

Result<std::vector<std::pair<ImageId, ImageId>>> ProjectStore::pairs_done(const std::string& inputs_hash) const {
  return state_->read([&](Database& db) -> Result<std::vector<std::pair<ImageId, ImageId>>> {
    std::vector<std::pair<ImageId, ImageId>> done;
    COLLINEA_TRY(auto select,
                 db.prepare("SELECT first, second FROM pairs WHERE inputs_hash = ? ORDER BY first, second"));
    select.bind_text(inputs_hash);
    while (true) {
      COLLINEA_TRY(const bool row, select.next());
      if (!row) return done;
      done.emplace_back(ImageId{std::uint32_t(select.integer(0))}, ImageId{std::uint32_t(select.integer(1))});
    }
  });
}

Result<> ProjectStore::erase_pairs_except(const std::string& inputs_hash) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto erase, db.prepare("DELETE FROM pairs WHERE inputs_hash <> ?"));
    return erase.bind_text(inputs_hash).run();
  });
}

Result<> ProjectStore::write_step(const StepRecord& step) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto insert,
                 db.prepare("INSERT OR REPLACE INTO step_records (step, inputs_hash, output_hash, seconds, "
                            "cpu_seconds, peak_memory_bytes, record) VALUES (?, ?, ?, ?, ?, ?, ?)"));
    const std::string name = step.name(), record = packed(step.outcome);
    insert.bind_text(name).bind_text(step.inputs_hash).bind_text(step.output_hash);
    insert.bind(step.seconds).bind(step.cpu_seconds).bind(step.peak_memory_bytes);
    return insert.bind_blob(record).run();
  });
}

Result<> ProjectStore::write_outcome(const StepOutcome& outcome) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto update, db.prepare("UPDATE step_records SET record = ? WHERE step = ?"));
    const std::string name(step_of(outcome)), record = packed(outcome);
    return update.bind_blob(record).bind_text(name).run();
  });
}

Result<> ProjectStore::erase_step(const std::string& name) {
  return state_->write([&](Database& db) -> Result<> {
    COLLINEA_TRY(auto erase, db.prepare("DELETE FROM step_records WHERE step = ?"));
    return erase.bind_text(name).run();
  });
}

Result<std::optional<StepRecord>> ProjectStore::read_step(const std::string& name) const {
  return state_->read([&](Database& db) -> Result<std::optional<StepRecord>> {
    COLLINEA_TRY(const bool there, has_step_records(db));
    if (!there) return std::nullopt;
    COLLINEA_TRY(auto select, db.prepare(kStepColumns + std::string("WHERE step = ?")));
    COLLINEA_TRY(const bool found, select.bind_text(name).next());
    if (!found) return std::nullopt;
    return step_of_row(select);
  });
}

Result<std::vector<StepRecord>> ProjectStore::read_steps() const {
  return state_->read([](Database& db) -> Result<std::vector<StepRecord>> {
    std::vector<StepRecord> steps;
    COLLINEA_TRY(const bool there, has_step_records(db));
    if (!there) return steps;
    COLLINEA_TRY(auto select, db.prepare(kStepColumns + std::string("ORDER BY sequence")));
    while (true) {
      COLLINEA_TRY(const bool row, select.next());
      if (!row) return steps;
      COLLINEA_TRY(StepRecord step, step_of_row(select));
      steps.push_back(std::move(step));
    }
  });
}

}  // namespace collinea
