// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/height_samples.h"

#include <algorithm>
#include <utility>

#include "collinea/base/file.h"

namespace collinea {
namespace {

constexpr int kRows = 64;  // read at a time

Result<GeoTiffReader> opened(const std::filesystem::path& path) {
  COLLINEA_TRY(GeoTiffReader reader, GeoTiffReader::open(path));
  if (reader.channels() != 1)
    return fail(Errc::kBadInput,
                path.string() + " has " + std::to_string(reader.channels()) + " bands; a raster of heights has one");
  return reader;
}

// Mean of the four cells around a position, by how much of it is nearest to each. A position on a cell's centre, but
// for rounding, does not ask its neighbours: they may have no height.
double between(const FloatImage& rows, int x, int y, int next_x, int next_y, double u, double v) {
  constexpr double kRounding = 1e-6;
  const auto mixed = [](double a, double b, double share) {
    if (share < kRounding) return a;
    return share > 1 - kRounding ? b : a + share * (b - a);
  };
  const auto along = [&](int row) { return mixed(double(rows.at(x, row)), double(rows.at(next_x, row)), u); };
  return mixed(along(y), along(next_y), v);
}

std::optional<std::filesystem::path> beside(const std::filesystem::path& height, const char* ending) {
  const std::filesystem::path file =
      height.parent_path() / (height.stem().string() + ending + height.extension().string());
  return is_there(file) ? std::optional(file) : std::nullopt;
}

}  // namespace

SurfaceFiles with_sigmas_beside(const std::filesystem::path& height) {
  SurfaceFiles files{height, beside(height, "_sigma")};
  if (files.sigma) files.sigma_relative = beside(height, "_sigma_relative");
  return files;
}

Result<HeightSamples> HeightSamples::open(const SurfaceFiles& files, double sigma_m) {
  if (files.sigma_relative && !files.sigma)
    return fail(Errc::kBadInput, files.sigma_relative->string() + " says nothing without the whole sigmas");
  COLLINEA_TRY(GeoTiffReader heights, opened(files.height));
  HeightSamples samples(std::move(heights), sigma_m);
  for (const auto& [path, reader] :
       {std::pair(&files.sigma, &samples.sigma_), std::pair(&files.sigma_relative, &samples.sigma_relative_)}) {
    if (!*path) continue;
    COLLINEA_TRY(GeoTiffReader sigmas, opened(**path));
    if (!same_cells(samples.grid(), sigmas.grid()))
      return fail(Errc::kBadInput, (*path)->string() + " does not lie over " + files.height.string());
    *reader = std::move(sigmas);
  }
  return samples;
}

Result<FloatImage> HeightSamples::heights(int column, int row, int width, int height) const {
  return height_.read_known(column, row, width, height);
}

Result<FloatImage> HeightSamples::sigmas(int column, int row, int width, int height) const {
  if (!sigma_) return FloatImage(width, height, 1, float(sigma_m_));
  return sigma_->read_known(column, row, width, height);
}

Result<FloatImage> HeightSamples::relative_sigmas(int column, int row, int width, int height) const {
  if (!sigma_relative_) return sigmas(column, row, width, height);
  return sigma_relative_->read_known(column, row, width, height);
}

Result<> HeightSamples::load(int row) {
  first_row_ = std::clamp(row - kRows / 4, 0, std::max(0, grid().height - kRows));
  const int count = std::min(kRows, grid().height - first_row_);
  COLLINEA_TRY(rows_, heights(0, first_row_, grid().width, count));
  COLLINEA_TRY(sigma_rows_, sigmas(0, first_row_, grid().width, count));
  COLLINEA_TRY(relative_rows_, relative_sigmas(0, first_row_, grid().width, count));
  return {};
}

Result<HeightSample> HeightSamples::at(const Eigen::Vector2d& on_map) {
  const double column = grid().column_of(on_map.x()), row = grid().row_of(on_map.y());
  if (!(column >= 0 && row >= 0 && column <= grid().width && row <= grid().height)) return HeightSample{};
  const double x = std::clamp(column - 0.5, 0.0, grid().width - 1.0),
               y = std::clamp(row - 0.5, 0.0, grid().height - 1.0);
  const int left = int(x), top = int(y);
  const int right = std::min(left + 1, grid().width - 1), bottom = std::min(top + 1, grid().height - 1);
  if (top < first_row_ || bottom >= first_row_ + rows_.height) COLLINEA_TRY(load(top));
  const auto here = [&](const FloatImage& rows) {
    return between(rows, left, top - first_row_, right, bottom - first_row_, x - left, y - top);
  };
  // Neighbours err alike: sigmas gain nothing from averaging.
  return HeightSample{here(rows_), here(sigma_rows_), here(relative_rows_)};
}

}  // namespace collinea
