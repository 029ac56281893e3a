// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "collinea/import/internal/imported.h"

namespace collinea {
namespace {

constexpr double kAssumedFocal = 1.2;       // times the longer side: a plain wide-angle lens
constexpr double kAssumedFocalSigma = 0.3;  // relative
constexpr double kFullFrameDiagonal_mm = 43.2666;

// The distortion that follows fx, fy, cx, cy.
std::vector<int> given_distortion(CameraModel model) {
  std::vector<int> distortion;
  for (const int param : params_of(model))
    if (Camera::kParamUnits[std::size_t(param)] == "1") distortion.push_back(param);
  return distortion;
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

std::string small(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// Many makers begin the name of the model with their own: "Canon", "Canon EOS 5D"; "NIKON CORPORATION", "NIKON D80".
bool names_maker(const std::string& model, const std::string& maker) {
  const std::string first = small(maker.substr(0, maker.find(' '))), start = small(model);
  return !first.empty() && start.starts_with(first) && (start.size() == first.size() || start[first.size()] == ' ');
}

}  // namespace

Result<std::vector<double>> camera_numbers(const std::string& text, CameraModel model) {
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

std::string camera_name(const ImageHeader& header) {
  std::string name = names_maker(header.model, header.maker) ? "" : header.maker;
  if (!header.model.empty()) name += (name.empty() ? "" : " ") + header.model;
  if (name.empty()) name = "unknown camera";
  if (header.focal_mm) name += fmt::format(" {:.3g} mm", *header.focal_mm);
  if (!header.serial.empty()) name += " #" + header.serial;
  return name;
}

}  // namespace collinea
