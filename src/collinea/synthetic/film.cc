// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/film.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/base/parallel.h"
#include "collinea/geodesy/refraction.h"
#include "collinea/io/film_calibration_file.h"
#include "collinea/io/text.h"
#include "collinea/raster/image_file.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr int kScanQuality = 95;     // of JPEG
constexpr int kWindowRows = 256;     // of light in work at once
constexpr int kFiner = 3;            // positions along a side of a pixel at which the frame is drawn
constexpr int kSamples = 8;          // and marks
constexpr double kPatchSizes = 1.2;  // half of what is drawn so, in sizes of the mark: the dark ground goes on to 1.5
// Titles of the columns of the true transformations and marks.
constexpr FileText kScanColumns = "# image, column, row, rotation, scale_x, scale_y, shear\n";
constexpr FileText kDeformationColumns = "# x [mm], y [mm], displacement x [mm], displacement y [mm]\n";
constexpr int kGridSteps = 46;  // of 5 mm: a twentieth of the mean wave
constexpr FileText kFiducialColumns = "# image, mark, x, y\n";
constexpr std::uint64_t kWearStream = 7000, kGrainStream = 8000, kScratchStream = 9000;

Random stream(const Truth& truth, std::uint64_t kind, ImageId image) {
  return Random(truth.seed, (kind << 32) + image.value);
}

// The usual wide-angle aerial camera: marks in corners and sides, distortion of some um.
FilmCalibration aerial_calibration(const FilmOptions& film) {
  FilmCalibration c;
  c.camera = "Synthetic 15/23";
  c.principal_distance_mm = 153.264;
  c.principal_point_mm = {0.012, -0.008};
  c.symmetry_point_mm = c.principal_point_mm;
  c.radial = {3.0e-5, -3.3e-9, 0, 0};
  c.size_mm = {230, 230};
  c.mark_size_mm = 1.6;
  c.line_mm = 0.15;
  c.image_size_mm = Vector2d(214, 214);
  constexpr double kAt = 109.8;
  const Vector2d at[] = {{-kAt, -kAt}, {kAt, kAt}, {-kAt, kAt}, {kAt, -kAt}, {-kAt, 0}, {kAt, 0}, {0, kAt}, {0, -kAt}};
  for (std::size_t i = 0; i < std::size(at); ++i)
    c.marks.push_back(
        {.name = std::to_string(i + 1), .film_mm = at[i], .kind = i < 4 ? film.corner_mark : film.side_mark});
  return c;
}

// With pixels of that size, of the image only.
Camera image_camera(const FilmCalibration& calibration, double pixel_mm) {
  Camera camera = film_camera(calibration);
  const Vector2d size = film_image_size(calibration) / pixel_mm;
  camera.width_px = int(size.x());
  camera.height_px = int(size.y());
  camera.params[Camera::kF] /= pixel_mm;
  camera.params[Camera::kCx] = camera.params[Camera::kCx] / pixel_mm + camera.width_px / 2.0;
  camera.params[Camera::kCy] = camera.params[Camera::kCy] / pixel_mm + camera.height_px / 2.0;
  camera.prior.source = Provenance::kTrue;
  return camera;
}

void set_bends(Truth& truth, double ground_height_m) {
  for (auto& [id, image] : truth.block.images) {
    const Rigid3 pose = pose_of(truth.block, id);
    image.bend = {pose.rotation * -Eigen::Vector3d::UnitZ(),
                  refraction_rad(ground_height_m + centre_of(pose).z(), ground_height_m)};
  }
}

std::string scans_text(const FilmTruth& film) {
  std::string text = kScanColumns;
  for (const auto& [id, scan] : film.scans) {
    text += film.truth.block.images.at(id).file;
    for (const double value : scan.affine.parameters) text += ", " + exact(value);
    text += "\n";
  }
  return text;
}

std::string fiducials_text(const FilmTruth& film) {
  std::string text = kFiducialColumns;
  for (const auto& [id, scan] : film.scans)
    for (const CalibratedMark& mark : film.calibration.marks) {
      const Vector2d at = scan.pixel_of(mark.film_mm);
      text += film.truth.block.images.at(id).file + ", " + mark.name + ", " + fixed(at.x(), 4) + ", " +
              fixed(at.y(), 4) + "\n";
    }
  return text;
}

// Local deformation on a grid over the film.
std::string deformation_text(const FilmCalibration& calibration, const FilmScan& scan) {
  std::string text = kDeformationColumns;
  const Vector2d half = 0.5 * calibration.size_mm;
  for (int row = 0; row <= kGridSteps; ++row)
    for (int column = 0; column <= kGridSteps; ++column) {
      const Vector2d at = 2.0 / kGridSteps * half.cwiseProduct(Vector2d(column, row)) - half;
      const Vector2d displaced = scan.displacement_mm(at);
      text +=
          fixed(at.x(), 4) + ", " + fixed(at.y(), 4) + ", " + exact(displaced.x()) + ", " + exact(displaced.y()) + "\n";
    }
  return text;
}

// What a pixel of the frame gathers.
float framed(const FilmCalibration& calibration, const FilmRays& rays, double column, double line, std::uint32_t seed) {
  float sum = 0;
  for (int k = 0; k < kFiner * kFiner; ++k)
    sum += frame_light(
        calibration, rays.film_mm(column + (k % kFiner + 0.5) / kFiner - 0.5, line + (k / kFiner + 0.5) / kFiner - 0.5),
        seed);
  return sum / (kFiner * kFiner);
}

// A mark and its ground as pixels that gather blurred light. A blur of pixels would be a staircase, and draw lines of
// two pixels towards the middles of pixels by up to 0.06 px.
struct MarkPatch {
  int left = 0, top = 0;
  FloatImage light;

  // Takes the place of what lies in a row of the scan.
  void put(int row, std::vector<Colour>& pixels) const {
    if (row < top || row >= top + light.height) return;
    for (int x = 0; x < light.width; ++x)
      if (left + x >= 0 && left + x < int(pixels.size())) pixels[std::size_t(left + x)] = grey_light(row, x);
  }

 private:
  [[nodiscard]] Colour grey_light(int row, int x) const {
    const float value = light.at(x, row - top);
    return {value, value, value};
  }
};

// Shares of the samples about a pixel, kSamples of them a pixel, that it gathers: a box under a Gaussian.
std::vector<float> gathering_weights(double blur_px, int reach_px) {
  const int half = reach_px * kSamples + kSamples / 2;
  std::vector<float> weights;
  for (int k = -half; k < half; ++k) {
    const double at = (k + 0.5) / kSamples, width = std::sqrt(2.0) * std::max(blur_px, 1e-3);
    weights.push_back(float(0.5 * (std::erf((at + 0.5) / width) - std::erf((at - 0.5) / width)) / kSamples));
  }
  return weights;
}

// Rows of samples to rows of pixels, transposed: twice gathers both ways.
FloatImage gathered(const FloatImage& samples, const std::vector<float>& weights) {
  const int pixels = (samples.width - int(weights.size())) / kSamples + 1;
  FloatImage out(samples.height, pixels);
  for (int y = 0; y < samples.height; ++y)
    for (int x = 0; x < pixels; ++x) {
      const float* const from = samples.row(y) + x * kSamples;
      float sum = 0;
      for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * from[k];
      out.at(y, x) = sum;
    }
  return out;
}

MarkPatch mark_patch(const FilmTruth& film, const FilmScan& scan, const CalibratedMark& mark, const FilmRays& rays,
                     std::uint32_t seed) {
  const double blur = film.truth.optics.blur_px;
  const int reach = int(std::ceil(4 * blur)) + 1;
  const int half = std::max(int(kPatchSizes * film.calibration.mark_size_mm / film.pixel_mm) - reach - 1, 1);
  const Vector2d centre = scan.pixel_of(mark.film_mm);
  MarkPatch patch{int(centre.x()) - half, int(centre.y()) - half, {}};
  const int width = (2 * half + 1 + 2 * reach) * kSamples;
  FloatImage samples(width, width);
  // Samples lie sheared within their pixel, so that an edge along rows or columns meets the square of their number.
  const auto aside = [](int k) { return (k % kSamples - 0.5 * (kSamples - 1)) / kSamples; };
  for (int y = 0; y < width; ++y)
    for (int x = 0; x < width; ++x) {
      const double column = patch.left - reach + (x + 0.5 + aside(y)) / kSamples,
                   line = patch.top - reach + (y + 0.5 - aside(x)) / kSamples;
      samples.at(x, y) = frame_light(film.calibration, rays.film_mm(column, line), seed);
    }
  const std::vector<float> weights = gathering_weights(blur, reach);
  patch.light = gathered(gathered(samples, weights), weights);
  return patch;
}

// The light of a window of a scan: of the scene less what the lens loses, and of the frame where the scene is not.
void finish_light(Raster<Colour>& light, int first_row, const FilmTruth& film, ImageId image, const FilmRays& rays,
                  const Run& run) {
  const FilmCalibration& calibration = film.calibration;
  const double corner = 0.25 * calibration.size_mm.squaredNorm();
  const float gain = float(film.truth.exposure.at(image));
  parallel_for(run, std::size_t(light.height), [&](std::size_t y) {
    Colour* row = light.row(int(y));
    for (int x = 0; x < light.width; ++x) {
      const double column = x + 0.5, line = first_row + double(y) + 0.5;
      const Vector2d at = rays.film_mm(column, line);
      if (shows_scene(calibration, at)) {
        const double radius2 = (at - calibration.principal_point_mm).squaredNorm();
        row[x] = gain * float(1 - film.truth.optics.vignetting * radius2 / corner) * row[x];
        continue;
      }
      const float mean = framed(calibration, rays, column, line, image.value + 1);
      row[x] = {mean, mean, mean};
    }
  });
}

void write_grey_row(const std::vector<Colour>& light, const std::vector<float>& grain, double grain_grey,
                    std::uint8_t* out) {
  for (std::size_t x = 0; x < light.size(); ++x) {
    const float grey = tone(0.299F * light[x].r + 0.587F * light[x].g + 0.114F * light[x].b);
    // Grain is strongest in middle densities.
    const float share = grey / 255, strength = 0.3F + 1.4F * std::sqrt(std::max(0.0F, share * (1 - share)));
    out[x] = std::uint8_t(std::clamp(grey + float(grain_grey) * strength * grain[x] + 0.5F, 0.0F, 255.0F));
  }
}

}  // namespace

Result<FilmTruth> make_film_survey(const SurveyOptions& survey, const FilmOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  FilmCalibration calibration = aerial_calibration(options);
  const double pixel_mm = 1e-3 * options.scan_um;
  SurveyOptions flight = survey;
  flight.height_m = 1e-3 * options.photo_scale * calibration.principal_distance_mm;
  flight.forward_overlap = survey.forward_overlap.value_or(0.6);
  flight.side_overlap = survey.side_overlap.value_or(0.3);
  flight.cross_strips = survey.cross_strips.value_or(0);
  flight.receiver.gps = false;
  const double margin_mm = 0.5 * (calibration.size_mm - film_image_size(calibration)).maxCoeff();
  COLLINEA_TRY(Truth truth, make_survey(flight, image_camera(calibration, pixel_mm), margin_mm / pixel_mm, run));
  FilmTruth film{std::move(truth), std::move(calibration), pixel_mm, options.wear, {}};
  set_bends(film.truth, survey.site.ground_height_m);
  for (const auto& [id, image] : film.truth.block.images)
    film.scans.emplace(id, worn_scan(film.calibration, pixel_mm, options.wear, stream(film.truth, kWearStream, id)));
  return film;
}

Vector2d scan_pixel_of(const FilmTruth& film, ImageId image, const Vector2d& pixel) {
  const Camera& camera = film.truth.block.camera_of(image);
  const Eigen::Vector3d bent = film.truth.block.images.at(image).bend.bent(ray_in_cam(camera, pixel));
  const Vector2d seen = project(camera, bent).value_or(pixel) - 0.5 * Vector2d(camera.width_px, camera.height_px);
  return film.scans.at(image).pixel_of(film.pixel_mm * Vector2d(seen.x(), -seen.y()));
}

Result<GreyImage> render_scan(const FilmTruth& film, ImageId image, const Run& run) {
  const FilmScan& scan = film.scans.at(image);
  const FilmRays rays(film.calibration, scan, film_camera(film.calibration), film.truth.block.images.at(image).bend,
                      run);
  const std::vector<float> weights = gaussian_weights(film.truth.optics.blur_px);
  const int margin = int(weights.size()) / 2 + 1;
  std::vector<MarkPatch> marks(film.calibration.marks.size());
  parallel_for(run, marks.size(), [&](std::size_t i) {
    marks[i] = mark_patch(film, scan, film.calibration.marks[i], rays, image.value + 1);
  });
  GreyImage out(scan.width, scan.height);
  for (int first = 0; first < scan.height; first += kWindowRows) {
    const int last = std::min(first + kWindowRows, scan.height);
    const int top = std::max(0, first - margin), bottom = std::min(scan.height, last + margin);
    Raster<Colour> light = exposed_light(film.truth, image, rays, scan.width, {top, bottom - top}, run);
    finish_light(light, top, film, image, rays, run);
    parallel_for(run, std::size_t(last - first), [&](std::size_t i) {
      thread_local std::vector<Colour> vertical, blurred;
      thread_local std::vector<float> grain;
      const int row = first + int(i);
      blur_row(light, row - top, weights, vertical, blurred);
      for (const MarkPatch& mark : marks) mark.put(row, blurred);
      grain_of_row(film.truth.seed + kGrainStream, (std::uint64_t{image.value} + 1) * 1000000, row, scan.width, grain);
      write_grey_row(blurred, grain, grain_of_pixel(film.wear, film.pixel_mm), out.row(row));
    });
    if (run.stopped()) return fail(Errc::kCancelled, "rendering was stopped");
  }
  wear_out(out, film.wear, stream(film.truth, kScratchStream, image));
  return out;
}

Result<> simulate(const SurveyOptions& survey, const FilmOptions& options, const std::filesystem::path& folder,
                  const Run& run) {
  COLLINEA_TRY(const FilmTruth film, make_film_survey(survey, options, run));
  std::error_code error;
  std::filesystem::create_directories(folder / "images", error);
  std::filesystem::create_directories(folder / "truth/deformation", error);
  if (error) return fail(Errc::kNotFound, folder.string() + ": cannot be made: " + error.message());
  Truth measured = film.truth;
  for (ControlObservation& seen : measured.block.control_observations)
    seen.pixel = scan_pixel_of(film, seen.image, seen.pixel);
  COLLINEA_TRY(write_tables(measured, folder));
  COLLINEA_TRY(write_file(folder / "film_calibration.txt", text_of(film.calibration)));
  COLLINEA_TRY(write_file(folder / "truth/scans.csv", scans_text(film)));
  COLLINEA_TRY(write_file(folder / "truth/fiducials.csv", fiducials_text(film)));
  std::size_t done = 0;
  for (const auto& [id, scan] : film.scans) {
    COLLINEA_TRY(const GreyImage raster, render_scan(film, id, run));
    COLLINEA_TRY(write_jpeg(folder / "images" / film.truth.block.images.at(id).file, raster, kScanQuality));
    const std::filesystem::path name = std::filesystem::path(film.truth.block.images.at(id).file).stem();
    COLLINEA_TRY(
        write_file(folder / "truth/deformation" / (name.string() + ".csv"), deformation_text(film.calibration, scan)));
    run.report("scans", double(++done) / double(film.scans.size()));
  }
  return write_products(film.truth, folder / "truth", film.truth.gsd_m, run);
}

}  // namespace collinea
