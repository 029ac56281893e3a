// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/base/units.h"
#include "collinea/import/internal/import_camera.h"
#include "collinea/import/internal/import_control.h"
#include "collinea/import/internal/import_film.h"
#include "collinea/import/internal/import_location.h"
#include "collinea/import/internal/import_positions.h"
#include "collinea/import/reason.h"
#include "collinea/import/unseen_control.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr int kSmallest_px = 64;  // width and height of an image of use

struct ImageFile {
  std::string file;
  Result<ImageHeader> header = fail(Errc::kNotFound, "not read");
  Result<std::uint64_t> hash = fail(Errc::kNotFound, "not read");
};

// A project below the photo folder, or in it, holds rasters that are no images.
bool belongs_to_project(const fs::path& directory) {
  std::error_code ignored;
  if (fs::exists(directory / "block.db", ignored)) return true;
  const std::string name = directory.filename().string();
  return fs::exists(directory.parent_path() / "block.db", ignored) &&
         (name == "products" || name == "depth" || name == "film" || name == "report" || name == "scratch");
}

struct Listing {
  std::vector<std::string> files;           // sorted
  std::vector<Finding> unreadable_folders;  // folders that cannot be looked into
};

std::string path_below(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  const std::string below = fs::relative(path, folder, error).generic_string();
  return error ? path.generic_string() : below;
}

// Folder by folder, so that one that cannot be read neither ends the search nor is passed over in silence.
Listing files_below(const fs::path& folder) {
  Listing listing;
  std::vector<fs::path> left = {folder};
  while (!left.empty()) {
    const fs::path here = std::move(left.back());
    left.pop_back();
    std::error_code error, ignored;
    for (auto it = fs::directory_iterator(here, error); !error && it != fs::directory_iterator(); it.increment(error))
      if (it->is_directory(ignored)) {
        if (!it->is_symlink(ignored) && !belongs_to_project(it->path())) left.push_back(it->path());
      } else if (it->is_regular_file(ignored) && is_image_name(it->path())) {
        listing.files.push_back(path_below(folder, it->path()));
      }
    if (error)
      listing.unreadable_folders.push_back(finding_of(
          FindingCode::kFolderUnreadable, {Subject::file(path_below(folder, here))}, {}, {}, error.message()));
  }
  std::sort(listing.files.begin(), listing.files.end());
  return listing;
}

std::optional<PositionPrior> position_prior(const ImageHeader& header, const ImportOptions& options) {
  if (!header.latitude_deg || !header.longitude_deg) return std::nullopt;
  const double plan = options.gps_sigma_m, height = options.gps_sigma_height_m;
  PositionPrior prior{};
  prior.position_in_world.setZero();  // known once the world frame is
  prior.latitude_deg = *header.latitude_deg;
  prior.longitude_deg = *header.longitude_deg;
  prior.height_m = header.height_m.value_or(0);
  prior.height_above_start_m = header.relative_height_m;
  prior.sigma_m = {header.sigma_east_m.value_or(plan), header.sigma_north_m.value_or(plan),
                   header.height_m ? header.sigma_height_m.value_or(height) : std::numeric_limits<double>::infinity()};
  prior.sigma_m = prior.sigma_m.cwiseMax(0.005);  // no receiver is better
  return prior;
}

Result<std::vector<ImageFile>> read_headers(const fs::path& folder, const std::vector<std::string>& files,
                                            const Run& run) {
  std::vector<ImageFile> photos(files.size());
  UnitList list{.stage = "import"};
  for (std::size_t i = 0; i < files.size(); ++i) list.units.push_back(Unit::file(i));
  const auto read = [&](std::size_t i, const Run&) -> Result<UnitWorked> {
    photos[i].file = files[i];
    photos[i].header = read_image_header(folder / files[i]);
    photos[i].hash = hash_of_file(folder / files[i]);
    return UnitWorked{};
  };
  COLLINEA_TRY(run_units(run, list, {.work = read}));
  return photos;
}

// A small file may unpack to more pixels than the machine can hold: then the others are to go on without it.
std::optional<Error> beyond_memory(const ImageHeader& header) {
  constexpr double kBytesOfPixel = 12;  // of the orthophoto, measured on images of 115 megapixels
  const double pixels = double(header.width_px) * header.height_px, need = kBytesOfPixel * pixels;
  const auto have = double(usable_memory());
  if (have <= 0 || need <= have) return std::nullopt;
  return Error{
      Errc::kBadInput,
      fmt::format(
          "has {:.0f} megapixels ({} x {}): to make a map of it takes some {:.0f} GB of memory, and there are {:.0f}",
          pixels / 1e6, header.width_px, header.height_px, need / 1e9, have / 1e9)};
}

class Importer {
 public:
  Importer(const fs::path& folder, const ImportOptions& options, CameraModel model,
           std::optional<std::vector<double>> camera_params, FilmFolder* film)
      : folder_(folder), options_(options), model_(model), camera_params_(std::move(camera_params)), film_(film) {
    if (film) result.film = ImportedFilm{film->ideal, {}};
  }

  void add(const ImageFile& source) {
    if (!source.header) return skip_unreadable(source, source.header.error());
    if (!source.hash) return skip_unreadable(source, source.hash.error());
    const Subject file = Subject::file(source.file);
    if (std::min(source.header->width_px, source.header->height_px) < kSmallest_px)
      return skip(finding_of(FindingCode::kImageTooSmall, {file}, {{FigureName::kLimit, kSmallest_px}}));
    if (const auto error = beyond_memory(*source.header)) return skip_unreadable(source, *error);
    const auto [same, is_new] = file_of_hash_.emplace(*source.hash, source.file);
    if (!is_new) return skip(finding_of(FindingCode::kImageDuplicate, {file, Subject::file(same->second)}));
    ImageHeader header = *source.header;
    const ImageId id{static_cast<std::uint32_t>(result.block.images.size())};
    if (film_) {
      auto& scan = film_->scans.at(source.file);
      if (!scan)
        return skip(finding_of(FindingCode::kScanNotOriented, {file}, {}, {OptionName{"film", "import"}},
                               scan.error().message));
      result.film->scans.emplace(id, *std::move(scan));
      header = film_->header();
    }
    Image image;
    image.file = source.file;
    image.camera = film_ && film_->deformed.contains(source.file) ? camera_of_scan(source.file) : camera_of(header);
    image.taken = source.header->taken;
    image.orientation = header.orientation;
    image.position = position_prior(*source.header, options_);
    if (source.header->heading_deg && source.header->pitch_deg)
      image.attitude =
          AttitudePrior{*source.header->heading_deg, *source.header->pitch_deg, source.header->roll_deg.value_or(0)};
    result.block.images[id] = image;
    result.file_hash.push_back(Hash().add(*source.hash).hex());
  }

  Imported result;

 private:
  void skip(Finding because) { result.skipped.push_back(std::move(because)); }
  void skip_unreadable(const ImageFile& image, const Error& error) {
    skip(finding_of(FindingCode::kImageUnreadable, {Subject::file(image.file)}, {}, {},
                    reason_without_name(error.message, folder_ / image.file)));
  }

  // A scan is deformed as no other is.
  CameraId camera_of_scan(const std::string& file) {
    const CameraId id{static_cast<std::uint32_t>(result.block.cameras.size())};
    Camera& camera = result.block.cameras[id] = film_->ideal.camera;
    camera.name += ", " + file;
    camera.prior.film = film_->deformed.at(file);
    return id;
  }

  CameraId camera_of(const ImageHeader& header) {
    const Key key{header.maker,
                  header.model,
                  header.serial,
                  header.lens,
                  header.width_px,
                  header.height_px,
                  header.focal_mm.value_or(0)};
    const auto found = cameras_.find(key);
    if (found != cameras_.end()) return found->second;
    const CameraId id{static_cast<std::uint32_t>(cameras_.size())};
    cameras_[key] = id;
    if (film_) {
      result.block.cameras[id] = film_->ideal.camera;
      return id;
    }
    Camera camera = camera_params_ ? given_camera(model_, *camera_params_, header.width_px, header.height_px)
                                   : camera_from_header(header, model_);
    camera.name = camera_name(header);
    if (camera.prior.source == Provenance::kAssumed)
      result.findings.push_back(
          finding_of(states_focal(header) ? FindingCode::kFocalImpossible : FindingCode::kFocalAssumed, {id},
                     {{FigureName::kWidth, double(header.width_px)},
                      {FigureName::kHeight, double(header.height_px)},
                      {FigureName::kFocal, camera.focal_px()}}));
    result.block.cameras[id] = camera;
    return id;
  }

  using Key = std::tuple<std::string, std::string, std::string, std::string, int, int, double>;
  const fs::path& folder_;
  const ImportOptions& options_;
  CameraModel model_;
  std::optional<std::vector<double>> camera_params_;
  FilmFolder* film_;  // nullptr: the photographs are no scans
  std::map<Key, CameraId> cameras_;
  std::map<std::uint64_t, std::string> file_of_hash_;
};

// That a folder holds too few images, with what is wrong with the first of its other files.
Error too_few(const Imported& imported, const fs::path& photos) {
  Error error{Errc::kNotFound, fmt::format("{} usable photographs (JPEG, TIFF, PNG) in {}",
                                           imported.block.images.size(), photos.string())};
  if (!imported.skipped.empty()) {
    const Finding& first = imported.skipped[0];
    error = std::move(error).advising("; first skipped: " + first.subjects[0].name + ": ");
    if (first.code == FindingCode::kImageTooSmall)
      error = std::move(error).advising(fmt::format("smaller than {} x {} pixels", kSmallest_px, kSmallest_px));
    else if (first.code == FindingCode::kImageDuplicate)
      error = std::move(error).advising("the same bytes as " + first.subjects[1].name);
    else
      error = std::move(error).advising(first.detail);
  }
  return std::move(error).advising("; at least two are needed");
}

std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  std::string name;
  for (const char c : list + ",") {
    if (c != ',') {
      name += c;
    } else {
      const auto first = name.find_first_not_of(' '), last = name.find_last_not_of(' ');
      if (first != std::string::npos) names.push_back(name.substr(first, last - first + 1));
      name.clear();
    }
  }
  return names;
}

Result<ControlFile> control_of(const ImportOptions& options) {
  if (!options.control && !options.check.empty())
    return fail(Errc::kBadInput, "check points " + options.check + " are named, but there is no control file: give it",
                {"check"_option, "control"_option});
  if (!options.control) return ControlFile{};
  COLLINEA_TRY(ControlFile control, read_control(*options.control, {.sigma_plan_m = options.control_sigma_m,
                                                                    .sigma_height_m = options.control_sigma_m,
                                                                    .sigma_px = options.control_sigma_px}));
  const std::vector<std::string> checks = names_in(options.check);
  if (!checks.empty()) COLLINEA_TRY(set_check_points(control, checks));
  return control;
}

constexpr const char* kUsualControlFiles[] = {"gcp_list.txt", "gcp.txt", "gcp.csv", "gcps.csv", "control.csv"};

// A control file that lies in the folder of the images, or beside it, and was not given.
void name_control_not_given(const fs::path& photos, Imported& imported) {
  for (const fs::path& folder : {photos, photos / ".."})
    for (const char* name : kUsualControlFiles)
      if (const fs::path path = folder / name; is_there(path)) {
        const auto control = read_control(path);
        if (!control || !is_surveyed(*control)) continue;
        imported.findings.push_back(finding_of(FindingCode::kControlNotGiven,
                                               {Subject::file(path.lexically_normal().string())}, {},
                                               {OptionName{"control", "import"}}));
        return;
      }
}

}  // namespace

Result<Imported> import_images(const fs::path& photos, const ImportOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  const CameraModel model = options.camera_model;
  std::optional<std::vector<double>> camera_params;
  if (options.camera_params) {
    COLLINEA_TRY(camera_params, camera_numbers(*options.camera_params, model));
  }
  COLLINEA_TRY(const ControlFile control, control_of(options));
  std::error_code unreadable;
  if (fs::directory_iterator(photos, unreadable); unreadable)
    return fail(Errc::kNotFound, photos.string() + " cannot be read: " + unreadable.message());
  const Listing listing = files_below(photos);
  std::optional<FilmFolder> film;
  COLLINEA_TRY(check_film(options.film));
  if (!options.film.calibration && (options.film_deformation_um || options.film_correlation_mm))
    return fail(Errc::kBadInput, "only scans of film are deformed: their calibration is missing",
                {"film"_option, "film_deformation_um"_option, "film_correlation_mm"_option});
  if (options.film.calibration) {
    COLLINEA_TRY(film, film_folder(photos, listing.files, options, run));
  }
  COLLINEA_TRY(const std::vector<ImageFile> read, read_headers(photos, listing.files, run));
  Importer importer(photos, options, model, camera_params, film ? &*film : nullptr);
  for (const ImageFile& image : read) importer.add(image);
  Imported imported = std::move(importer.result);
  imported.skipped.insert(imported.skipped.end(), listing.unreadable_folders.begin(), listing.unreadable_folders.end());
  if (imported.block.images.size() < 2) return tl::unexpected(too_few(imported, photos));
  if (camera_params) COLLINEA_TRY(check_given_camera(*camera_params, imported.block));
  PositionFile positions;
  std::set<ImageId> of_file;
  if (options.positions) {
    COLLINEA_TRY(positions, read_positions(*options.positions));
    COLLINEA_TRY(of_file, add_positions(imported, positions, *options.positions, options));
  }
  COLLINEA_TRY(raise_positions(imported, of_file, options));
  COLLINEA_TRY(location_on_earth(imported, options, control));
  COLLINEA_TRY(add_map_attitudes(imported, positions));
  if (options.geodetic) COLLINEA_TRY(add_geodetic(imported, *options.geodetic));
  imported.findings = with_unseen_control(std::move(imported.findings), imported.block);
  if (imported.film) name_poor_scans(imported);
  if (!options.control) name_control_not_given(photos, imported);
  return imported;
}

std::string fingerprint_of_sources(const fs::path& photos, const ImportOptions& options) {
  Hash hash;
  const auto add_file = [&](const fs::path& path) {
    std::error_code missing;
    hash.add(path.string()).add(std::uint64_t{fs::file_size(path, missing)});
    hash.add(static_cast<std::uint64_t>(fs::last_write_time(path, missing).time_since_epoch().count()));
  };
  for (const std::string& file : files_below(photos).files) add_file(photos / file);
  if (options.control) add_file(*options.control);
  if (options.geodetic) add_file(*options.geodetic);
  if (options.positions) add_file(*options.positions);
  if (options.film.calibration) add_file(*options.film.calibration);
  const std::optional<HeightsFrom> gps_heights = options.gps_heights;
  for (const auto* heights : {&options.heights, &options.control_heights, &gps_heights})
    if (std::error_code none; *heights && fs::is_regular_file((*heights)->text(), none))  // a geoid grid
      add_file((*heights)->text());
  return hash.hex();
}

}  // namespace collinea
