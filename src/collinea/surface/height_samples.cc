// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/height_samples.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collinea/io/file.h"

namespace collinea {
namespace {

constexpr int kRows = 64;  // read at a time

Result<FloatImage> window(const GeoTiffReader& reader, int column, int row, int width, int height) {
  COLLINEA_TRY(FloatImage values, reader.read_float(column, row, width, height));
  if (const auto nothing = reader.nodata())
    for (float& value : values.data)
      if (value == float(*nothing)) value = std::numeric_limits<float>::quiet_NaN();
  return values;
}

Result<GeoTiffReader> opened(const std::filesystem::path& path) {
  COLLINEA_TRY(GeoTiffReader reader, GeoTiffReader::open(path));
  if (reader.channels() != 1)
    return fail(Errc::kBadInput,
                path.string() + " has " + std::to_string(reader.channels()) + " bands; a raster of heights has one");
  return reader;
}

// Corners and cells may differ by what decimal numbers in files do.
bool lie_over_each_other(const MapGrid& a, const MapGrid& b) {
  constexpr double kRounding = 1e-3;  // [cells], all over the raster
  const auto apart = [&](double x, double y) { return std::abs(x - y) / a.cell_m; };
  return a.width == b.width && a.height == b.height && apart(a.west_m, b.west_m) < kRounding &&
         apart(a.north_m, b.north_m) < kRounding && apart(a.east_of(a.width), b.east_of(b.width)) < kRounding &&
         apart(a.north_of(a.height), b.north_of(b.height)) < kRounding;
}

// Of the four cells around a place, by how much of it is nearest to each. A place on a cell's centre, but for rounding,
// does not ask its neighbours: they may have no height.
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

Result<HeightSamples> HeightSamples::open(const std::filesystem::path& height,
                                          const std::optional<std::filesystem::path>& sigma, double sigma_m) {
  COLLINEA_TRY(GeoTiffReader heights, opened(height));
  if (!sigma) return HeightSamples(std::move(heights), std::nullopt, sigma_m);
  COLLINEA_TRY(GeoTiffReader sigmas, opened(*sigma));
  if (!lie_over_each_other(heights.grid(), sigmas.grid()))
    return fail(Errc::kBadInput, sigma->string() + " does not lie over " + height.string());
  return HeightSamples(std::move(heights), std::move(sigmas), sigma_m);
}

Result<FloatImage> HeightSamples::heights(int column, int row, int width, int height) const {
  return window(height_, column, row, width, height);
}

Result<FloatImage> HeightSamples::sigmas(int column, int row, int width, int height) const {
  if (!sigma_) return FloatImage(width, height, 1, float(sigma_m_));
  return window(*sigma_, column, row, width, height);
}

Result<> HeightSamples::load(int row) {
  first_row_ = std::clamp(row - kRows / 4, 0, std::max(0, grid().height - kRows));
  const int count = std::min(kRows, grid().height - first_row_);
  COLLINEA_TRY(rows_, heights(0, first_row_, grid().width, count));
  COLLINEA_TRY(sigma_rows_, sigmas(0, first_row_, grid().width, count));
  return {};
}

Result<HeightSample> HeightSamples::at(const Eigen::Vector2d& on_map) {
  const double column = grid().column_of(on_map.x()), row = grid().row_of(on_map.y());
  if (!(column >= 0 && row >= 0 && column <= grid().width && row <= grid().height)) return HeightSample{};
  const double x = std::clamp(column - 0.5, 0.0, grid().width - 1.0),
               y = std::clamp(row - 0.5, 0.0, grid().height - 1.0);
  const int left = int(x), top = int(y);
  const int right = std::min(left + 1, grid().width - 1), bottom = std::min(top + 1, grid().height - 1);
  if (top < first_row_ || bottom >= first_row_ + rows_.height)
    if (auto loaded = load(top); !loaded) return tl::unexpected(loaded.error());
  HeightSample sample;
  sample.height_m = between(rows_, left, top - first_row_, right, bottom - first_row_, x - left, y - top);
  // Neighbours err alike: no gain from averaging them.
  sample.sigma_m = between(sigma_rows_, left, top - first_row_, right, bottom - first_row_, x - left, y - top);
  return sample;
}

std::optional<std::filesystem::path> sigmas_beside(const std::filesystem::path& height) {
  return beside(height, "_sigma");
}

std::optional<std::filesystem::path> relative_sigmas_beside(const std::filesystem::path& height) {
  return beside(height, "_sigma_relative");
}

}  // namespace collinea
