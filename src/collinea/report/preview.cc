// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/raster/geotiff.h"
#include "collinea/raster/hillshade.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/pyramid.h"
#include "collinea/report/internal/figures.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

constexpr int kJpegQuality = 85;
constexpr int kPreviewSide_px = 900;

using Colour = std::array<double, 3>;

// Dark blue to light yellow, evenly brighter: reads in grey print as well.
Colour ramp(double t) {
  constexpr std::array<Colour, 6> kColours = {
      {{38, 44, 96}, {34, 94, 128}, {46, 138, 128}, {112, 176, 102}, {196, 206, 102}, {250, 240, 178}}};
  const double at = std::clamp(t, 0.0, 1.0) * (kColours.size() - 1);
  const auto i = std::min(std::size_t(at), kColours.size() - 2);
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = kColours[i][c] + (at - double(i)) * (kColours[i + 1][c] - kColours[i][c]);
  return colour;
}

struct Size {
  int width, height;
};

Size reduced(const MapGrid& grid, int longest_side_px) {
  const double factor = std::min(1.0, double(longest_side_px) / std::max({1, grid.width, grid.height}));
  return {std::max(1, int(std::lround(grid.width * factor))), std::max(1, int(std::lround(grid.height * factor)))};
}

std::pair<double, double> percentiles(const FloatImage& heights, double low, double high) {
  std::vector<float> values;
  for (const float v : heights.data)
    if (std::isfinite(v)) values.push_back(v);
  if (values.empty()) return {0, 0};
  const auto at = [&](double share) {
    const auto quantile = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), quantile, values.end());
    return double(*quantile);
  };
  return {at(low), at(high)};
}

// Without the size of a cell: without light.
Raster<std::uint8_t> shaded(const FloatImage& heights, std::optional<double> cell_m, double low, double high) {
  Raster<std::uint8_t> image(heights.width, heights.height, 3, 255);
  for (int y = 0; y < heights.height; ++y)
    for (int x = 0; x < heights.width; ++x) {
      const float value = heights.at(x, y);
      if (!std::isfinite(value)) continue;
      const Colour colour = ramp((value - low) / std::max(1e-9, high - low));
      const double facing = cell_m ? hillshade_at(heights, x, y, *cell_m) * std::numbers::sqrt2 : 1;  // 1 on a plane
      const double light = 0.35 + 0.65 * std::min(facing, 1.35);
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = std::uint8_t(std::clamp(colour[std::size_t(c)] * light, 0.0, 255.0));
    }
  return image;
}

Result<Preview> encoded(const Raster<std::uint8_t>& image, double low, double high) {
  COLLINEA_TRY(std::string jpeg, encode_jpeg(image, kJpegQuality));
  return Preview{std::move(jpeg), image.width, image.height, low, high};
}

Result<Preview> in_colours(const std::filesystem::path& geotiff, int longest_side_px, bool has_light) {
  COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(geotiff));
  const MapGrid& grid = reader.grid();
  const Size size = reduced(grid, longest_side_px);
  COLLINEA_TRY(const FloatImage values, reader.read_known(0, 0, grid.width, grid.height, size.width, size.height));
  const auto [low, high] = percentiles(values, 0.01, 0.99);
  const double cell_m = grid.cell_m * grid.width / size.width;
  return encoded(shaded(values, has_light ? std::optional(cell_m) : std::nullopt, low, high), low, high);
}

}  // namespace

Result<Preview> preview_of_values(const std::filesystem::path& geotiff, int longest_side_px) {
  return in_colours(geotiff, longest_side_px, false);
}

Result<Preview> preview_of_file(const std::filesystem::path& file, int longest_side_px) {
  COLLINEA_TRY(const ImageHeader header, read_image_header(file));
  const int longest = std::max(header.width_px, header.height_px);
  int shrink = 1;
  while (shrink < 8 && longest / (2 * shrink) >= longest_side_px) shrink *= 2;
  COLLINEA_TRY(const ColourImage image, read_colour(file, shrink));
  const int rest = (std::max(image.width, image.height) + longest_side_px - 1) / longest_side_px;
  return encoded(rest > 1 ? shrunk(image, rest) : image, 0, 0);
}

std::optional<Preview> preview_or_finding(MakePreview make, const std::filesystem::path& file,
                                          std::vector<Finding>& findings) {
  if (file.empty()) return std::nullopt;
  Result<Preview> made = make(file, kPreviewSide_px);
  if (made) return *std::move(made);
  findings.push_back(
      finding_of(FindingCode::kNoPreview, {Subject::file(file.filename().string())}, {}, {}, made.error().message));
  return std::nullopt;
}

Result<Preview> preview_of_heights(const std::filesystem::path& geotiff, int longest_side_px) {
  return in_colours(geotiff, longest_side_px, true);
}

Result<Preview> preview_of_image(const std::filesystem::path& geotiff, int longest_side_px) {
  COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(geotiff));
  const MapGrid& grid = reader.grid();
  const Size size = reduced(grid, longest_side_px);
  COLLINEA_TRY(const auto pixels, reader.read_byte(0, 0, grid.width, grid.height, size.width, size.height));
  Raster<std::uint8_t> image(size.width, size.height, 3, 255);
  const bool grey = pixels.channels < 3, alpha = pixels.channels == 2 || pixels.channels == 4;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const int opacity = alpha ? pixels.at(x, y, pixels.channels - 1) : 255;
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = std::uint8_t((pixels.at(x, y, grey ? 0 : c) * opacity + 255 * (255 - opacity)) / 255);
    }
  return encoded(image, 0, 0);
}

std::string height_scale(const Preview& preview, const std::string& unit, int decimals) {
  constexpr int kSteps = 60;
  Svg svg(460, 40, "Heights");
  for (int i = 0; i < kSteps; ++i) {
    const Colour c = ramp((i + 0.5) / kSteps);
    svg.rectangle(60 + 340.0 * i / kSteps, 4, 340.0 / kSteps + 0.5, 14, "swatch",
                  fmt::format("#{:02x}{:02x}{:02x}", int(c[0]), int(c[1]), int(c[2])));
  }
  svg.text({54, 16}, number_text(preview.low_m, decimals) + " " + unit, "end");
  svg.text({406, 16}, number_text(preview.high_m, decimals) + " " + unit, "start");
  return svg.finish();
}

}  // namespace collinea
