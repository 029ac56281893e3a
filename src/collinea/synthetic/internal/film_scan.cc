// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/film_scan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/parallel.h"
#include "collinea/synthetic/fiducial_look.h"
#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr int kLattice = 16;         // px
constexpr double kBed_mm = 1;        // of the scanner that shows round the film
constexpr double kFrame_mm = 3;      // dark frame of the film round the image
constexpr double kPatchSizes = 1.5;  // half the dark ground of a mark, in sizes of the mark
constexpr float kBedLight = 0.85F, kFrameLight = 0.004F, kMarkLight = 0.7F;

bool is_at_mark(const FilmCalibration& calibration, const Vector2d& film_mm) {
  const double half = kPatchSizes * calibration.mark_size_mm;
  for (const CalibratedMark& mark : calibration.marks)
    if ((film_mm - mark.film_mm).cwiseAbs().maxCoeff() < half) return true;
  return false;
}

void add_blob(GreyImage& scan, double x, double y, double sigma, double grey) {
  const int reach = int(std::ceil(3 * sigma)), left = int(x), top = int(y);
  for (int row = std::max(0, top - reach); row <= std::min(scan.height - 1, top + reach); ++row)
    for (int column = std::max(0, left - reach); column <= std::min(scan.width - 1, left + reach); ++column) {
      const double dx = column + 0.5 - x, dy = row + 0.5 - y;
      const double value = scan.at(column, row) + grey * std::exp(-0.5 * (dx * dx + dy * dy) / (sigma * sigma));
      scan.at(column, row) = std::uint8_t(std::clamp(value + 0.5, 0.0, 255.0));
    }
}

// Along the transport of the film; its width and depth change little by little.
void add_scratch(GreyImage& scan, Random& random) {
  const double turn = 0.03 * random.normal(), length = scan.height * random.uniform(0.05, 0.5);
  const double x0 = random.uniform(0, scan.width), y0 = random.uniform(0, scan.height);
  const double grey = random.uniform() < 0.7 ? random.uniform(25, 80) : -random.uniform(25, 80);
  const double sigma = random.uniform(0.5, 1.0);
  const int reach = int(std::ceil(3 * sigma));
  for (int row = std::max(0, int(y0)); row < std::min(double(scan.height), y0 + length); ++row) {
    const double x = x0 + turn * (row - y0);
    for (int column = std::max(0, int(x) - reach); column <= std::min(scan.width - 1, int(x) + reach); ++column) {
      const double d = (column + 0.5 - x) / sigma;
      const double value = scan.at(column, row) + grey * std::exp(-0.5 * d * d);
      scan.at(column, row) = std::uint8_t(std::clamp(value + 0.5, 0.0, 255.0));
    }
  }
}

}  // namespace

Vector2d FilmScan::displacement_mm(const Vector2d& film_mm) const {
  Vector2d sum = Vector2d::Zero();
  for (const Wave& wave : waves) sum += wave.amplitude_mm * std::cos(wave.per_mm.dot(film_mm) + wave.phase_rad);
  return sum;
}

Vector2d FilmScan::pixel_of(const Vector2d& film_mm) const {
  return affine.pixel_of(film_mm + displacement_mm(film_mm));
}

Vector2d FilmScan::film_of(const Vector2d& pixel) const {
  const Vector2d displaced = *affine.film_of(pixel);  // an affinity has no horizon
  Vector2d film = displaced;
  for (int i = 0; i < 4; ++i) film = displaced - displacement_mm(film);
  return film;
}

FilmScan worn_scan(const FilmCalibration& calibration, double pixel_mm, const ScanWear& wear, Random random) {
  FilmScan scan;
  scan.width = int(std::ceil((calibration.size_mm.x() + 2 * kBed_mm) / pixel_mm));
  scan.height = int(std::ceil((calibration.size_mm.y() + 2 * kBed_mm) / pixel_mm));
  const auto normal = [&] { return std::clamp(random.normal(), -2.5, 2.5); };
  scan.affine.model = FilmModel::kAffine;
  scan.affine.parameters.resize(6);
  scan.affine.covariance = Eigen::MatrixXd::Zero(6, 6);
  auto& p = scan.affine.parameters;
  p[0] = scan.width / 2.0 + 0.2 * kBed_mm / pixel_mm * normal();
  p[1] = scan.height / 2.0 + 0.2 * kBed_mm / pixel_mm * normal();
  p[2] = wear.scan_turn_deg * std::numbers::pi / 180 * normal();
  p[3] = (1 + 1e-6 * wear.film_difference_ppm * normal()) / pixel_mm;
  p[4] = (1 + 1e-6 * wear.film_difference_ppm * normal()) / pixel_mm;
  p[5] = 1e-6 * wear.film_shear_ppm * normal();
  // A wave of amplitude a has the mean square a^2 / 2 in each coordinate.
  const double amplitude = 1e-3 * wear.film_local_um * std::sqrt(2.0 / double(scan.waves.size()));
  for (FilmScan::Wave& wave : scan.waves) {
    const double direction = random.uniform(0, std::numbers::pi), length_mm = random.uniform(70, 200);
    wave.amplitude_mm = amplitude * Vector2d(random.uniform() < 0.5 ? 1 : -1, random.uniform() < 0.5 ? 1 : -1);
    wave.per_mm = 2 * std::numbers::pi / length_mm * Vector2d(std::cos(direction), std::sin(direction));
    wave.phase_rad = random.uniform(0, 2 * std::numbers::pi);
  }
  return scan;
}

bool shows_scene(const FilmCalibration& calibration, const Vector2d& film_mm) {
  const Vector2d half = 0.5 * calibration.size_mm.array() - kFrame_mm;
  return std::abs(film_mm.x()) < half.x() && std::abs(film_mm.y()) < half.y() && !is_at_mark(calibration, film_mm);
}

float frame_light(const FilmCalibration& calibration, const Vector2d& film_mm, std::uint32_t seed) {
  const Vector2d half = 0.5 * calibration.size_mm;
  if (std::abs(film_mm.x()) > half.x() || std::abs(film_mm.y()) > half.y()) return kBedLight;
  for (const CalibratedMark& mark : calibration.marks) {
    const Vector2d offset = film_mm - mark.film_mm;
    if (offset.cwiseAbs().maxCoeff() > kPatchSizes * calibration.mark_size_mm) continue;
    const double axis = mark_axis_rad(mark), c = std::cos(axis), s = std::sin(axis);
    const double x = offset.x(), y = -offset.y();  // y down, as scans have it
    return kFrameLight +
           kMarkLight * float(mark_brightness(mark.kind.value_or(MarkKind::kCross), c * x + s * y, -s * x + c * y,
                                              calibration.mark_size_mm, calibration.line_mm));
  }
  // The data strip: cells of 0.4 mm between image and left edge, bright where a number of the photograph says so.
  const bool is_strip = film_mm.x() < -half.x() + 0.8 * kFrame_mm && film_mm.x() > -half.x() + 0.2 * kFrame_mm;
  if (is_strip && std::abs(film_mm.y()) < 0.3 * half.y() &&
      lattice_uniform(floor_int(film_mm.x() / 0.4), floor_int(film_mm.y() / 0.4), seed) < 0.4F)
    return kMarkLight;
  return kFrameLight;
}

FilmRays::FilmRays(const FilmCalibration& calibration, const FilmScan& scan, const Camera& film_camera_mm,
                   const RayBend& bend, const Run& run)
    : calibration_(calibration),
      focal_px_(film_camera_mm.focal_px() * scan.affine.parameters[3]),
      columns_(scan.width / kLattice + 2) {
  const int rows = scan.height / kLattice + 2;
  lattice_.resize(std::size_t(columns_) * std::size_t(rows));
  parallel_for(run, std::size_t(rows), [&](std::size_t j) {
    for (int i = 0; i < columns_; ++i) {
      const Vector2d film = scan.film_of({double(kLattice * i), double(kLattice) * double(j)});
      const Vector3d seen = normalized(film_camera_mm, {film.x(), -film.y()}).homogeneous();
      const Vector3d straight = 2 * seen - bend.bent(seen);
      lattice_[j * std::size_t(columns_) + std::size_t(i)] << film, straight.hnormalized();
    }
  });
}

Vector4d FilmRays::between(double x, double y) const {
  const double u = x / kLattice, v = y / kLattice;
  const int i = int(u), j = int(v);
  const double a = u - i, b = v - j;
  const Vector4d* const at = lattice_.data() + std::size_t(j) * std::size_t(columns_) + std::size_t(i);
  return (1 - b) * ((1 - a) * at[0] + a * at[1]) + b * ((1 - a) * at[columns_] + a * at[columns_ + 1]);
}

Vector3d FilmRays::direction(int column, int row, double dx, double dy) const {
  const Vector4d at = between(column + 0.5 + dx, row + 0.5 + dy);
  if (!shows_scene(calibration_, at.head<2>())) return Vector3d::Zero();
  return {at[2], at[3], 1};
}

double grain_of_pixel(const ScanWear& wear, double pixel_mm) {
  constexpr double kStated_mm = 0.015;
  return wear.grain_grey * kStated_mm / pixel_mm;
}

void grain_of_row(std::uint64_t seed, std::uint64_t item, int row, int width, std::vector<float>& out) {
  // White noise under weights 1 2 1 along rows and columns; of a scan every row has the same noise for all its readers.
  constexpr float kSpread = 0.375F;  // standard deviation that the weights leave
  std::vector<float> sum(std::size_t(width) + 2, 0);
  for (int j = -1; j <= 1; ++j) {
    Random random(seed, item + std::uint64_t(row + 1 + j));
    const float weight = j == 0 ? 0.5F : 0.25F;
    for (float& value : sum) value += weight * quick_normal(random);
  }
  out.resize(std::size_t(width));
  for (std::size_t x = 0; x < out.size(); ++x)
    out[x] = (0.25F * sum[x] + 0.5F * sum[x + 1] + 0.25F * sum[x + 2]) / kSpread;
}

void wear_out(GreyImage& scan, const ScanWear& wear, Random random) {
  for (int i = 0; i < wear.scratches; ++i) add_scratch(scan, random);
  for (int i = 0; i < wear.dust; ++i) {
    const double x = random.uniform(0, scan.width), y = random.uniform(0, scan.height);
    add_blob(scan, x, y, random.uniform(0.7, 3.5), -random.uniform(30, 120));
  }
}

}  // namespace collinea
