// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/ideal_image.h"

#include <algorithm>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/base/parallel_in_order.h"
#include "collinea/raster/cubic_row.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/jpeg_writer.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr int kLatticePx = 32;
constexpr int kImageQuality = 98;  // of JPEG: steps of a grey value or two
constexpr int kStripRows = 128;    // resampled at a time, while others are packed

// Where the corners of the cells of a lattice over the ideal lie in the scan.
class ScanLattice {
 public:
  ScanLattice(const FilmTransformation& scan_from_film, const IdealImage& ideal, const Run& run)
      : columns_(ideal.camera.width_px / kLatticePx + 2),
        nodes_(std::size_t(columns_) * std::size_t(ideal.camera.height_px / kLatticePx + 2)) {
    parallel_for(run, nodes_.size() / std::size_t(columns_), [&](std::size_t j) {
      for (int i = 0; i < columns_; ++i)
        nodes_[j * std::size_t(columns_) + std::size_t(i)] =
            scan_from_film.pixel_of(ideal.film_of(double(kLatticePx) * Vector2d(i, double(j))));
    });
  }

  // The middles of the pixels of a row, in samples of the scan (the middle of its first pixel is 0).
  void samples(int row, std::vector<float>& x, std::vector<float>& y) const {
    const double v = (row + 0.5) / kLatticePx, b = v - int(v);
    const Vector2d* const above = nodes_.data() + std::size_t(int(v)) * std::size_t(columns_);
    const Vector2d* const below = above + columns_;
    for (std::size_t column = 0; column < x.size(); ++column) {
      const double u = (double(column) + 0.5) / kLatticePx, a = u - int(u);
      const int i = int(u);
      const Vector2d at =
          (1 - b) * ((1 - a) * above[i] + a * above[i + 1]) + b * ((1 - a) * below[i] + a * below[i + 1]);
      x[column] = float(at.x() - 0.5);
      y[column] = float(at.y() - 0.5);
    }
  }

 private:
  int columns_;
  std::vector<Vector2d> nodes_;
};

// A row of a strip of the ideal image that begins at row `first`.
void resample(const Raster<std::uint8_t>& scan, const ScanLattice& lattice, int first, int row,
              Raster<std::uint8_t>& out) {
  thread_local std::vector<float> x, y;
  x.resize(std::size_t(out.width));
  y.resize(std::size_t(out.width));
  lattice.samples(first + row, x, y);
  cubic_row(scan, x.data(), y.data(), out.width, out.row(row));
}

}  // namespace

Vector2d IdealImage::pixel_of(const Vector2d& film_mm) const {
  const Vector2d at = corrected_mm(calibration, film_mm) / pixel_mm;
  return {camera.params[Camera::kCx] + at.x(), camera.params[Camera::kCy] - at.y()};
}

Vector2d IdealImage::film_of(const Vector2d& pixel) const {
  return distorted_mm(
      calibration, pixel_mm * Vector2d(pixel.x() - camera.params[Camera::kCx], camera.params[Camera::kCy] - pixel.y()));
}

IdealImage ideal_image(const FilmCalibration& calibration, double pixel_mm) {
  const Vector2d size = film_image_size(calibration) / pixel_mm;
  IdealImage ideal{calibration, pixel_mm,
                   ideal_camera(calibration.principal_distance_mm / pixel_mm, int(size.x()), int(size.y()))};
  auto& params = ideal.camera.params;
  params[Camera::kCx] = ideal.camera.width_px / 2.0 + calibration.principal_point_mm.x() / pixel_mm;
  params[Camera::kCy] = ideal.camera.height_px / 2.0 - calibration.principal_point_mm.y() / pixel_mm;
  ideal.camera.name = calibration.camera.empty() ? "film camera" : calibration.camera;
  ideal.camera.prior.calibrate = false;
  ideal.camera.prior.source = Provenance::kGiven;
  return ideal;
}

Raster<std::uint8_t> resampled_scan(const Raster<std::uint8_t>& scan, const FilmTransformation& scan_from_film,
                                    const IdealImage& ideal, const Run& run) {
  Raster<std::uint8_t> out(ideal.camera.width_px, ideal.camera.height_px, scan.channels);
  const ScanLattice lattice(scan_from_film, ideal, run);
  parallel_for(run, std::size_t(out.height), [&](std::size_t row) { resample(scan, lattice, 0, int(row), out); });
  return out;
}

Result<> write_ideal_image(const std::filesystem::path& scan, const FilmTransformation& scan_from_film,
                           const IdealImage& ideal, const std::filesystem::path& out, const Run& run) {
  COLLINEA_TRY(const int channels, channels_of(scan));
  COLLINEA_TRY(const Raster<std::uint8_t> pixels, channels == 1 ? read_grey(scan) : read_colour(scan));
  const int width = ideal.camera.width_px, height = ideal.camera.height_px;
  COLLINEA_TRY(JpegWriter writer, JpegWriter::create(out, width, height, channels, kImageQuality));
  const ScanLattice lattice(scan_from_film, ideal, run);
  const auto strip = [&](std::size_t i) -> Result<Raster<std::uint8_t>> {
    const int first = int(i) * kStripRows;
    Raster<std::uint8_t> rows(width, std::min(kStripRows, height - first), channels);
    for (int row = 0; row < rows.height; ++row) resample(pixels, lattice, first, row, rows);
    return rows;
  };
  COLLINEA_TRY(parallel_in_order(run, std::size_t((height + kStripRows - 1) / kStripRows), strip,
                                 [&](std::size_t, const Raster<std::uint8_t>& rows) { return writer.write(rows); }));
  return writer.finish();
}

std::string ideal_image_name(const std::string& scan) {
  const std::filesystem::path path(scan);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".jpg" || extension == ".jpeg" ? scan : scan + ".jpg";
}

}  // namespace collinea
