// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/base/units.h"
#include "collinea/geodesy/heights.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/import/internal/import_control.h"
#include "collinea/import/internal/import_film.h"
#include "collinea/import/internal/import_positions.h"
#include "collinea/import/reason.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kAssumedFocal = 1.2;       // times the longer side: a plain wide-angle lens
constexpr double kAssumedFocalSigma = 0.3;  // relative
constexpr double kFullFrameDiagonal_mm = 43.2666;
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

// The distortion that follows fx, fy, cx, cy.
std::vector<int> given_distortion(CameraModel model) {
  std::vector<int> distortion;
  for (const int param : params_of(model))
    if (Camera::kParamUnits[std::size_t(param)] == "1") distortion.push_back(param);
  return distortion;
}

Result<std::vector<double>> numbers_in(const std::string& text, CameraModel model) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next < end && *next != ','))
      return fail(Errc::kBadInput, "\"" + text + "\" is no camera: expected numbers separated by commas",
                  {"camera_params"_option});
    numbers.push_back(value);
    at = next + (next < end ? 1 : 0);
  }
  if (const std::size_t most = 4 + given_distortion(model).size(); numbers.size() < 4 || numbers.size() > most)
    return fail(Errc::kBadInput,
                fmt::format("\"{}\" is no camera: expected fx,fy,cx,cy and up to {} distortion values", text,
                            most == 9 ? "five" : "four"),
                {"camera_params"_option});
  if (!std::all_of(numbers.begin(), numbers.end(), [](double value) { return std::isfinite(value); }))
    return fail(Errc::kBadInput, "\"" + text + "\" is no camera: every value must be a finite number",
                {"camera_params"_option});
  if (!(numbers[0] > 0 && numbers[1] > 0))
    return fail(Errc::kBadInput, "\"" + text + "\" is no camera: fx and fy must be positive", {"camera_params"_option});
  return numbers;
}

// One camera fits images of one size: focal length and principal point are in its pixels.
Result<> check_given_camera(const std::vector<double>& v, const Block& block) {
  const Image* first = nullptr;
  for (const auto& [id, image] : block.images) {
    const Camera& camera = block.camera_of(id);
    if (!first) {
      first = &image;
      if (!inside(camera, {v[2], v[3]}))
        return fail(Errc::kBadInput,
                    fmt::format("the principal point {}, {} of the given camera lies outside the images ({} x {} px)",
                                v[2], v[3], camera.width_px, camera.height_px),
                    {"camera_params"_option});
    }
    const Camera& of_first = block.cameras.at(first->camera);
    if (camera.width_px != of_first.width_px || camera.height_px != of_first.height_px)
      return fail(Errc::kBadInput,
                  fmt::format("one camera is given, but the images differ in size: {} has {} x {} px, "
                              "{} has {} x {} px; keep those of one size in a folder of their own",
                              first->file, of_first.width_px, of_first.height_px, image.file, camera.width_px,
                              camera.height_px),
                  {"camera_params"_option});
  }
  return {};
}

Camera given_camera(CameraModel model, const std::vector<double>& v, int width_px, int height_px) {
  Camera camera = ideal_camera(v[1], width_px, height_px);
  camera.model = model;
  camera.params[Camera::kB1] = v[0] - v[1];
  camera.params[Camera::kCx] = v[2];
  camera.params[Camera::kCy] = v[3];
  const std::vector<int> distortion = given_distortion(model);
  for (std::size_t i = 4; i < v.size(); ++i) camera.params[std::size_t(distortion[i - 4])] = v[i];
  camera.prior.calibrate = false;
  camera.prior.source = Provenance::kGiven;
  return camera;
}

// The shortest focal length that can be true, and the one assumed where none is stated [times the longer side]. A
// fisheye is taken for one that fills the image with 180 degrees from corner to corner; one that sees 220 degrees
// along the shorter of 16:9 sides has an eighth of the longer side.
struct UsualFocal {
  double shortest, assumed;
};

double focal_per_diagonal(const CameraModel& fisheye) {
  return std::visit(
      []<class Model>(const Model&) {
        if constexpr (Model::kIsFisheye) return Model::kFocalPerDiagonal;
        return std::nan("");
      },
      fisheye);
}

UsualFocal usual_focal(CameraModel model, double diagonal_px, double longer_px) {
  if (!is_fisheye(model)) return {0.2, kAssumedFocal};
  const double per_diagonal = focal_per_diagonal(model);
  return {0.12, per_diagonal * diagonal_px / longer_px};
}

Camera camera_from_header(const ImageHeader& header, CameraModel model) {
  const double diagonal_px = std::hypot(header.width_px, header.height_px);
  double focal_px = 0, relative_sigma = kExifFocalSigma;
  Provenance source = Provenance::kUnknown;
  if (header.focal_mm && header.pixel_pitch_mm && *header.focal_mm > 0) {
    focal_px = *header.focal_mm / *header.pixel_pitch_mm;
    source = Provenance::kExifPixelPitch;
  }
  // An image resampled after it was taken keeps its old pixel pitch: then the two sources disagree and the equivalent
  // wins.
  if (header.focal_35mm_mm && *header.focal_35mm_mm > 0) {
    const double equivalent_px = *header.focal_35mm_mm * diagonal_px / kFullFrameDiagonal_mm;
    if (focal_px == 0 || std::abs(focal_px / equivalent_px - 1) > 0.15) {
      focal_px = equivalent_px;
      source = Provenance::kExif35mm;
    }
  }
  const double longer_px = std::max(header.width_px, header.height_px);
  const UsualFocal usual = usual_focal(model, diagonal_px, longer_px);
  if (!(focal_px > usual.shortest * longer_px && focal_px < 50 * longer_px)) {
    focal_px = usual.assumed * longer_px;
    relative_sigma = kAssumedFocalSigma;
    source = Provenance::kAssumed;
  }
  Camera camera = ideal_camera(focal_px, header.width_px, header.height_px);
  camera.model = model;
  camera.prior.sigma_f_px = relative_sigma * focal_px;
  camera.prior.source = source;
  return camera;
}

bool states_focal(const ImageHeader& header) {
  return (header.focal_mm && header.pixel_pitch_mm) || header.focal_35mm_mm;
}

std::string small(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// Many makers begin the name of the model with their own: "Canon", "Canon EOS 5D"; "NIKON CORPORATION", "NIKON D80".
bool names_maker(const std::string& model, const std::string& maker) {
  const std::string first = small(maker.substr(0, maker.find(' '))), start = small(model);
  return !first.empty() && start.starts_with(first) && (start.size() == first.size() || start[first.size()] == ' ');
}

std::string camera_name(const ImageHeader& header) {
  std::string name = names_maker(header.model, header.maker) ? "" : header.maker;
  if (!header.model.empty()) name += (name.empty() ? "" : " ") + header.model;
  if (name.empty()) name = "unknown camera";
  if (header.focal_mm) name += fmt::format(" {:.3g} mm", *header.focal_mm);
  if (!header.serial.empty()) name += " #" + header.serial;
  return name;
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

// The middle of the block: where the world frame gets its origin, rounded so that it reads well.
Eigen::Vector3d middle_of(const Block& block) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0, heights = 0;
  double first_longitude_deg = 0;
  for (const auto& [id, image] : block.images)
    if (const auto& position = image.position) {
      if (count++ == 0) first_longitude_deg = position->longitude_deg;
      // From the first one the short way round: the date line may run through the block.
      const double from_first_deg = std::remainder(position->longitude_deg - first_longitude_deg, 360);
      sum.head<2>() += Eigen::Vector2d(position->latitude_deg, from_first_deg);
      if (!std::isfinite(position->sigma_m.z())) continue;
      sum.z() += position->height_m;
      ++heights;
    }
  return {sum.x() / std::max(1, count), std::remainder(first_longitude_deg + sum.y() / std::max(1, count), 360),
          sum.z() / std::max(1, heights)};
}

// Where the map's heights are stated beside its CRS, and those of control beside both.
struct Systems {
  std::string map, control;
};

Result<Systems> systems_of(const ImportOptions& options, const std::string& map, const std::string& control) {
  Systems systems{map, control};
  if (options.heights) {
    COLLINEA_TRY(systems.map, with_heights(map, *options.heights).map_error([](Error error) {
      return std::move(error).about("heights"_option);
    }));
  }
  if (options.control_heights) {
    COLLINEA_TRY(systems.control,
                 with_heights(control.empty() ? map : control, *options.control_heights).map_error([](Error error) {
                   return std::move(error).about("control_heights"_option);
                 }));
  } else if (options.heights && !control.empty()) {
    COLLINEA_TRY(const bool is_stated, states_heights(control));
    if (!is_stated) {
      COLLINEA_TRY(systems.control, with_heights(control, *options.heights));
    }
  }
  return systems;
}

bool has_positions(const Block& block) {
  return std::any_of(block.images.begin(), block.images.end(),
                     [](const auto& entry) { return entry.second.position.has_value(); });
}

// How high what the images count their heights from lies over the ellipsoid, for all of the block. Not for
// positions of a file, which says itself what its heights are.
Result<> raise_positions(Imported& imported, const std::set<ImageId>& of_file, const ImportOptions& options) {
  if (options.gps_heights.word() == HeightSurface::kEllipsoid || !has_positions(imported.block)) return {};
  const Eigen::Vector3d middle = middle_of(imported.block);
  const auto framed = [](Error error) { return std::move(error).about("gps_heights"_option); };
  COLLINEA_TRY(const std::string crs,
               with_heights(utm_crs(middle.x(), middle.y()), options.gps_heights).map_error(framed));
  COLLINEA_TRY(const LocalFrame frame, LocalFrame::create(crs, middle.x(), middle.y(), 0).map_error(framed));
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (auto& [id, image] : imported.block.images) {
    if (!image.position || of_file.contains(id)) continue;
    const double raised_m = -frame
                                 .map_from_local(frame.local_from_geographic(
                                     {image.position->latitude_deg, image.position->longitude_deg, 0}))
                                 .z();
    if (!std::isfinite(raised_m))
      return fail(Errc::kBadInput,
                  "the geoid grid of the heights in the photographs does not reach the position of " + image.file,
                  {"gps_heights"_option});
    image.position->height_m += raised_m;
    least = std::min(least, raised_m);
    most = std::max(most, raised_m);
  }
  if (least > most) return {};
  const std::string heights = frame.crs_name().substr(frame.crs_name().find(" + ") + 3);
  imported.findings.push_back(finding_of(FindingCode::kHeightsCountFrom, {Subject::crs(heights)},
                                         {{FigureName::kLowest, least}, {FigureName::kHighest, most}}));
  return {};
}

Result<> location_on_earth(Imported& imported, const ImportOptions& options, ControlFile control) {
  Block& block = imported.block;
  const bool has_gps = has_positions(block);
  std::string crs = options.crs.value_or(control.crs);
  if (options.crs)
    if (const auto known = check_crs(crs); !known)
      return tl::unexpected(Error(known.error()).within("CRS \"" + crs + "\"").about("crs"_option));
  Eigen::Vector3d origin = middle_of(block);
  if (has_gps && crs.empty()) crs = utm_crs(origin.x(), origin.y());
  if (!has_gps) {
    if (!is_surveyed(control)) return add_control(imported, control, nullptr);
    if (crs.empty())
      return fail(Errc::kBadInput, "the control file names no CRS and the photographs have no GPS: give one, EPSG:code",
                  {"crs"_option});
  }
  COLLINEA_TRY(const Systems systems, systems_of(options, crs, control.crs));
  crs = systems.map;
  control.crs = systems.control;
  if (!has_gps) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const ControlFilePoint& point : control.points)
      middle += point.position_in_map / double(control.points.size());
    COLLINEA_TRY(origin, geographic_from_map(control.crs.empty() ? crs : control.crs, middle));
  }
  origin = {std::round(origin.x() * 1e5) / 1e5, std::round(origin.y() * 1e5) / 1e5, std::round(origin.z())};
  COLLINEA_TRY(const LocalFrame frame,
               LocalFrame::create(crs, origin.x(), origin.y(), origin.z()).map_error([&](Error error) {
                 Error framed = std::move(error).within("CRS \"" + crs + "\"");
                 return options.crs ? std::move(framed).about("crs"_option) : framed;
               }));
  block.georeference = Georeference{crs, origin.x(), origin.y(), origin.z()};
  for (auto& [id, image] : block.images)
    if (auto& prior = image.position)
      prior->position_in_world =
          frame.local_from_geographic({prior->latitude_deg, prior->longitude_deg, prior->height_m});
  return add_control(imported, control, &frame);
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
    COLLINEA_TRY(camera_params, numbers_in(*options.camera_params, model));
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
  name_unseen_control(imported);
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
