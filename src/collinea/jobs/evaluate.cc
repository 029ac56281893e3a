// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/evaluate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "collinea/base/file.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/jobs/internal/point_rows.h"
#include "collinea/raster/band_descriptions.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/surface/dsm.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBatch = 100'000;  // points of a cloud
constexpr double kMostCells = 4e6;       // of the raster of differences
constexpr float kNoDifference = -9999;
constexpr double kColourRange = 3;  // tolerances from the middle of the colours to their ends

ReferencePoints points_of_list(std::vector<Eigen::Vector3d> points) {
  auto kept = std::make_shared<std::pair<std::vector<Eigen::Vector3d>, bool>>(std::move(points), false);
  return [kept](bool from_start) -> Result<std::vector<Eigen::Vector3d>> {
    if (from_start) kept->second = false;
    if (std::exchange(kept->second, true)) return std::vector<Eigen::Vector3d>{};
    return kept->first;
  };
}

std::vector<Eigen::Vector3d> positions_of(const std::vector<CloudPoint>& points) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(points.size());
  for (const CloudPoint& point : points) positions.push_back(point.position);
  return positions;
}

Result<ReferencePoints> points_of_las(const fs::path& path) {
  COLLINEA_TRY(LasReader first, LasReader::open(path));
  auto reader = std::make_shared<LasReader>(std::move(first));
  return [reader, path](bool from_start) -> Result<std::vector<Eigen::Vector3d>> {
    if (from_start) {
      COLLINEA_TRY(*reader, LasReader::open(path));
    }
    COLLINEA_TRY(const std::vector<CloudPoint> points, reader->read(kBatch));
    return positions_of(points);
  };
}

Result<ReferencePoints> points_of_table(const fs::path& path) {
  COLLINEA_TRY(const std::vector<HeightPoint> rows, read_point_rows(path));
  std::vector<Eigen::Vector3d> points;
  for (const HeightPoint& row : rows) points.push_back(row.position);
  return points_of_list(std::move(points));
}

// A reference and what it reads.
struct Reference {
  std::shared_ptr<const HeightField> grid;  // of a grid
  ReferencePoints points;
};

Result<Reference> open_reference(const fs::path& path) {
  const std::string kind = lower(path.extension().string());
  Reference reference;
  if (kind == ".tif" || kind == ".tiff") {
    COLLINEA_TRY(HeightField field, open_height_field(path));
    reference.grid = std::make_shared<const HeightField>(std::move(field));
    reference.points = points_of_grid(*reference.grid);
  } else if (kind == ".las" || kind == ".laz") {
    COLLINEA_TRY(reference.points, points_of_las(path));
  } else if (kind == ".ply") {
    COLLINEA_TRY(const std::vector<CloudPoint> points, read_ply(path));
    reference.points = points_of_list(positions_of(points));
  } else {
    COLLINEA_TRY(reference.points, points_of_table(path));
  }
  return reference;
}

fs::path beside(const fs::path& surface, const std::string& what) {
  return surface.parent_path() / (surface.stem().string() + "_" + what + surface.extension().string());
}

// The raster of classes and what it says at positions; not asked for and not there: nothing.
Result<std::function<Result<int>(const Eigen::Vector2d&)>> classes_of(const std::optional<fs::path>& asked,
                                                                      const fs::path& surface) {
  const fs::path path = asked.value_or(beside(surface, "state"));
  if (!asked && !fs::exists(path)) return std::function<Result<int>(const Eigen::Vector2d&)>{};
  COLLINEA_TRY(GeoTiffReader opened, GeoTiffReader::open(path));
  struct Rows {
    GeoTiffReader reader;
    Raster<float> row;
    int number = -1;
  };
  auto rows = std::make_shared<Rows>(Rows{std::move(opened), {}, -1});
  return [rows](const Eigen::Vector2d& on_map) -> Result<int> {
    const MapGrid& grid = rows->reader.grid();
    const int column = int(std::floor(grid.column_of(on_map.x()))), row = int(std::floor(grid.row_of(on_map.y())));
    if (column < 0 || row < 0 || column >= grid.width || row >= grid.height) return 0;
    if (row != rows->number) {
      COLLINEA_TRY(rows->row, rows->reader.read_float(0, row, grid.width, 1));
      rows->number = row;
    }
    return int(std::lround(rows->row.at(column, 0)));
  };
}

Result<std::optional<double>> predicted_sigma_m(const EvaluateOptions& options) {
  const int given = int(options.scale_number.has_value()) + int(options.height_over_base.has_value()) +
                    int(options.sigma_image_um.has_value());
  if (given == 0 && options.sigma_reference_m > 0)
    return fail(
        Errc::kBadInput, "the sigma of the reference is part of the predicted one: give the other three, too",
        {"sigma_reference_m"_option, "scale_number"_option, "height_over_base"_option, "sigma_image_um"_option});
  if (given > 0 && options.tolerance_m)
    return fail(Errc::kBadInput, "the tolerance is given twice: as a number and by what predicts it",
                {"tolerance_m"_option, "scale_number"_option});
  if (given == 0) return std::nullopt;
  if (given < 3)
    return fail(Errc::kBadInput, "the predicted sigma needs all three of scale, height over base and image sigma",
                {"scale_number"_option, "height_over_base"_option, "sigma_image_um"_option});
  const double own_m =
      normal_case_sigma_m(*options.scale_number, *options.height_over_base, *options.sigma_image_um * 1e-6);
  return difference_sigma_m(own_m, options.sigma_reference_m);
}

// The mean difference in cells of the surface's map, few enough for memory.
class DifferenceRaster {
 public:
  explicit DifferenceRaster(const MapGrid& surface) : grid_(surface) {
    const double times = std::ceil(std::sqrt(std::max(double(surface.width) * surface.height / kMostCells, 1.0)));
    grid_.cell_m *= times;
    grid_.width = int(std::ceil(surface.width / times));
    grid_.height = int(std::ceil(surface.height / times));
    sum_ = FloatImage(grid_.width, grid_.height, 1);
    count_ = FloatImage(grid_.width, grid_.height, 1);
  }

  void add(const Eigen::Vector3d& on_map, double difference_m) {
    const int column = int(std::floor(grid_.column_of(on_map.x()))), row = int(std::floor(grid_.row_of(on_map.y())));
    if (column < 0 || row < 0 || column >= grid_.width || row >= grid_.height) return;
    sum_.at(column, row) += float(difference_m);
    count_.at(column, row) += 1;
  }

  Result<> write(const fs::path& folder, double tolerance_m) {
    ColourImage image(grid_.width, grid_.height, 3);
    for (std::size_t i = 0; i < sum_.data.size(); ++i) {
      const bool known = count_.data[i] > 0;
      sum_.data[i] = known ? sum_.data[i] / count_.data[i] : kNoDifference;
      if (known) paint(double(sum_.data[i]) / (kColourRange * tolerance_m), &image.data[3 * i]);
    }
    COLLINEA_TRY(GeoTiffWriter<float> writer, GeoTiffWriter<float>::create(folder / "differences.tif", grid_, 1,
                                                                           {.nodata = double(kNoDifference),
                                                                            .description = band::kHeightDifference}));
    COLLINEA_TRY(writer.write(0, 0, sum_));
    COLLINEA_TRY(writer.finish());
    return write_png(folder / "differences.png", image);
  }

 private:
  // Blue: too low; white; red: too high; black: nothing.
  static void paint(double part, std::uint8_t* pixel) {
    const double strength = std::clamp(std::abs(part), 0.0, 1.0);
    const auto faded = std::uint8_t(std::lround(255 * (1 - strength)));
    pixel[0] = part < 0 ? faded : 255;
    pixel[1] = faded;
    pixel[2] = part < 0 ? 255 : faded;
  }

  MapGrid grid_;
  FloatImage sum_, count_;
};

}  // namespace

Result<Evaluation> evaluate_surface(const fs::path& surface, const fs::path& reference, const EvaluateOptions& options,
                                    const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(const HeightField field, open_height_field(surface, beside(surface, "sigma")));
  COLLINEA_TRY(const Reference compared, open_reference(reference));
  Evaluation evaluation;
  COLLINEA_TRY(evaluation.predicted_sigma_m, predicted_sigma_m(options));
  ComparisonOptions comparison{.tolerance_m = options.tolerance_m.value_or(evaluation.predicted_sigma_m.value_or(0))};
  COLLINEA_TRY(comparison.class_at, classes_of(options.classes, surface));
  evaluation.classes_are_states = !options.classes;
  COLLINEA_TRY(evaluation.shift, coregister(field, compared.points, options.coregistration));
  DifferenceRaster raster(field.grid);
  COLLINEA_TRY(evaluation.comparison, compare_heights(field, compared.points, evaluation.shift, comparison, run,
                                                      [&](const Eigen::Vector3d& on_map, double difference_m) {
                                                        raster.add(on_map, difference_m);
                                                      }));
  if (options.out) {
    COLLINEA_TRY(make_out_folder(*options.out));
    COLLINEA_TRY(raster.write(*options.out, evaluation.comparison.tolerance_m));
    COLLINEA_TRY(write_file(*options.out / "evaluation.txt", evaluation_text(evaluation)));
  }
  return evaluation;
}

}  // namespace collinea
