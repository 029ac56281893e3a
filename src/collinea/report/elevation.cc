// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/elevation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/raster/geotiff.h"
#include "collinea/report/internal/counted.h"
#include "collinea/report/internal/figures.h"
#include "collinea/report/internal/pdf_page.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// Around the drawing: coordinates of the grid, the title below it.
constexpr double kLeft_mm = 22, kRight_mm = 12, kTop_mm = 12, kBottom_mm = 48;
constexpr double kText_mm = 3, kTitle_mm = 5;
constexpr double kGrid_mm = 25;        // between lines, at least
constexpr double kPixels_per_mm = 12;  // 300 to the inch

struct Paper {
  const char* name;
  double short_mm, long_mm;
};
constexpr std::array<Paper, 5> kPapers = {
    {{"A4", 210, 297}, {"A3", 297, 420}, {"A2", 420, 594}, {"A1", 594, 841}, {"A0", 841, 1189}}};

ElevationSheet sheet_at(double width_m, double height_m, double scale) {
  const double width = 1000 * width_m / scale + kLeft_mm + kRight_mm;
  const double height = 1000 * height_m / scale + kTop_mm + kBottom_mm;
  for (const Paper& paper : kPapers) {
    if (width <= paper.long_mm && height <= paper.short_mm) return {scale, paper.long_mm, paper.short_mm, paper.name};
    if (width <= paper.short_mm && height <= paper.long_mm) return {scale, paper.short_mm, paper.long_mm, paper.name};
  }
  return {scale, width, height, ""};
}

// Lines of equal coordinates, and what they are.
void draw_grid(const MapGrid& grid, const Vector2d& corner, const Vector2d& size, double mm_per_m, PdfPage& page) {
  const Vector2d low(grid.west_m, grid.north_m - grid.height * grid.cell_m);
  const double step_m = round_above(kGrid_mm / mm_per_m);
  for (int axis = 0; axis < 2; ++axis) {
    const double high = low[axis] + size[axis] / mm_per_m;
    for (const double value : multiples(step_m, low[axis], high)) {
      const double at = corner[axis] + (value - low[axis]) * mm_per_m;
      const std::string label = tick_text(value, step_m);
      if (axis == 0) {
        page.line({at, corner.y()}, {at, corner.y() + size.y()}, 0.1, 0.45);
        page.text({at, corner.y() - 1.4 * kText_mm}, kText_mm, label, TextAnchor::kMiddle);
      } else {
        page.line({corner.x(), at}, {corner.x() + size.x(), at}, 0.1, 0.45);
        page.text({corner.x() - 1.5, at - 0.35 * kText_mm}, kText_mm, label, TextAnchor::kEnd);
      }
    }
  }
}

// Four parts, black and white in turn, to the left of a position.
void draw_scale_bar(const Vector2d& end, double mm_per_m, const std::string& unit, PdfPage& page) {
  const double part_m = round_above(10 / mm_per_m), part_mm = part_m * mm_per_m;
  const Vector2d at = end - Vector2d(4 * part_mm + 6, 0);
  for (int i = 0; i < 4; ++i) {
    page.rectangle(at + Vector2d(i * part_mm, 0), {part_mm, 2}, 0.15, i % 2 == 0);
    page.text(at + Vector2d(i * part_mm, 3), kText_mm, tick_text(i * part_m, part_m), TextAnchor::kMiddle);
  }
  page.text(at + Vector2d(4 * part_mm, 3), kText_mm, tick_text(4 * part_m, part_m) + " " + unit, TextAnchor::kMiddle);
}

std::vector<std::string> lines_of(const FrameRecord& frame, const std::string& unit) {
  const auto location = [](const Eigen::Vector3d& p, int decimals) {
    return fmt::format("{:.{}f}, {:.{}f}, {:.{}f}", p.x(), decimals, p.y(), decimals, p.z(), decimals);
  };
  return {
      fmt::format("{:.2f} x {:.2f} {}, cells of {:.3g} {}, {}", frame.width_m, frame.height_m, unit, frame.ortho.cell_m,
                  unit, counted(frame.ortho.images_used, "photograph")),
      fmt::format("Distances from the plane: standard deviation {:.3g} {} in the mean, {:.3g} {} against those around",
                  frame.surface.mean_sigma_m, unit, frame.surface.mean_sigma_relative_m, unit),
      fmt::format("Origin of x and y at {} {}; x along {}; y along {}", location(frame.origin, 3), unit,
                  location(frame.right, 6), location(frame.up, 6)),
  };
}

}  // namespace

ElevationSheet elevation_sheet(double width_m, double height_m, std::optional<double> scale) {
  if (scale) return sheet_at(width_m, height_m, *scale);
  for (double power = 1; power < 1e9; power *= 10)
    for (const double times : {1.0, 2.0, 2.5, 5.0}) {
      if (times == 2.5 && power != 10) continue;  // 1:25 is in use, 1:2.5 and 1:250 hardly
      const ElevationSheet sheet = sheet_at(width_m, height_m, times * power);
      if (sheet.paper == "A4" || sheet.paper == "A3") return sheet;
    }
  return sheet_at(width_m, height_m, 1e9);
}

Result<double> write_elevation(const FrameRecord& frame, const std::filesystem::path& ortho, const std::string& project,
                               bool is_metric, std::optional<double> scale, const std::filesystem::path& pdf) {
  COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(ortho));
  const MapGrid& grid = reader.grid();
  const double width_m = grid.width * grid.cell_m, height_m = grid.height * grid.cell_m;
  const ElevationSheet sheet = elevation_sheet(width_m, height_m, scale);
  if (!sheet.fits_in_a_pdf())
    return fail(Errc::kBadInput,
                fmt::format("no sheet of {:.0f} x {:.0f} mm can be made", sheet.width_mm, sheet.height_mm),
                {"scale"_option});
  const double mm_per_m = 1000 / sheet.scale;
  const Vector2d size(width_m * mm_per_m, height_m * mm_per_m);
  const std::string unit = is_metric ? "m" : "units";
  const std::string title = project + ", " + frame.name;
  COLLINEA_TRY(PdfPage page, PdfPage::create(sheet.width_mm, sheet.height_mm, title));
  const Vector2d room(sheet.width_mm - kLeft_mm - kRight_mm, sheet.height_mm - kTop_mm - kBottom_mm);
  const Vector2d corner = Vector2d(kLeft_mm, kBottom_mm) + (room - size) / 2;
  const int longest_px = std::min(std::max(grid.width, grid.height), int(std::ceil(size.maxCoeff() * kPixels_per_mm)));
  COLLINEA_TRY(const Preview preview, preview_of_image(ortho, longest_px));
  page.image(preview.jpeg, corner, size);
  draw_grid(grid, corner, size, mm_per_m, page);
  page.rectangle(corner, size, 0.3);
  page.rectangle({5, 5}, {sheet.width_mm - 10, sheet.height_mm - 10}, 0.5);
  page.text({kLeft_mm, 27}, kTitle_mm, title);
  page.text({sheet.width_mm - kRight_mm, 27}, kTitle_mm,
            is_metric ? fmt::format("1 : {:.10g}", sheet.scale) : "not to scale: the block has none", TextAnchor::kEnd);
  double y = 20;
  for (const std::string& line : lines_of(frame, unit)) {
    page.text({kLeft_mm, y}, kText_mm, line);
    y -= 1.6 * kText_mm;
  }
  draw_scale_bar({sheet.width_mm - kRight_mm, 35}, mm_per_m, unit, page);
  COLLINEA_TRY(const std::string bytes, page.finish());
  COLLINEA_TRY(write_file(pdf, bytes));
  return sheet.scale;
}

}  // namespace collinea
