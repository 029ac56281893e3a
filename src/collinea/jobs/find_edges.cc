// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/find_edges.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/feature/texture.h"
#include "collinea/io/number_rows.h"
#include "collinea/jobs/internal/drawing.h"
#include "collinea/jobs/internal/edge_tables.h"
#include "collinea/raster/image_file.h"
#include "collinea/vector/dxf.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kEllipseVertices = 72;
constexpr MarkColour kEdgeColour{255, 200, 0}, kFoundColour{255, 0, 60};

// What was found, as a table and as curves for the image and the vectors.
struct Found {
  TextTable table;
  TextTable lines = {};  // that the corners are made of
  std::vector<Curve> curves;
  bool are_closed = false;
  std::vector<Vector2d> centres;
  std::size_t scaled = 0, not_measured = 0;
};

Curve curve_of(const Ellipse& ellipse) {
  Curve out;
  for (int k = 0; k < kEllipseVertices; ++k) out.push_back(ellipse.at(2 * std::numbers::pi * k / kEllipseVertices));
  return out;
}

Found lines_among(const EdgeMap& map, const HoughOptions& options) {
  const std::vector<FoundLine> lines = hough_lines(edge_points_of(map), options);
  Found out{.table = table_of(lines)};
  for (const FoundLine& l : lines) {
    out.curves.push_back({l.line.from, l.line.to});
    out.scaled += l.line.quality.is_scaled;
  }
  return out;
}

Found corners_among(const EdgeMap& map, const FindEdgesOptions& options) {
  const std::vector<FoundLine> lines = hough_lines(edge_points_of(map), options.hough);
  const std::vector<LineCorner> corners = line_corners(lines, map.points, options.corners);
  Found out{.table = table_of(corners), .lines = table_of(lines)};
  for (const FoundLine& l : lines) {
    out.curves.push_back({l.line.from, l.line.to});
    out.scaled += l.line.quality.is_scaled;
  }
  for (const LineCorner& c : corners) out.centres.push_back(c.at);
  return out;
}

Found circles_among(const EdgeMap& map, const HoughOptions& options) {
  const std::vector<FoundCircle> circles = hough_circles(edge_points_of(map), options);
  Found out{.table = table_of(circles), .are_closed = true};
  for (const FoundCircle& c : circles) {
    out.curves.push_back(curve_of(Ellipse{c.circle.centre, c.circle.radius_px, c.circle.radius_px, 0}));
    out.centres.push_back(c.circle.centre);
    out.scaled += c.circle.quality.is_scaled;
  }
  return out;
}

Found ellipses_among(const EdgeMap& map, const HoughOptions& options) {
  std::vector<EdgeEllipse> ellipses;
  for (const EdgeChain& chain : map.chains) {
    if (chain.count < std::size_t(options.least_points)) continue;
    const auto fit = fit_ellipse(map.points_of(chain), map.along_px);
    if (fit && fit->quality.rms_px < options.tolerance_px / 2 &&
        fit->arc_rad >= options.least_arc * 2 * std::numbers::pi)
      ellipses.push_back(*fit);
  }
  Found out{.table = table_of(ellipses), .are_closed = true};
  for (const EdgeEllipse& e : ellipses) {
    out.curves.push_back(curve_of(e.ellipse));
    out.centres.push_back(e.ellipse.centre);
    out.scaled += e.quality.is_scaled;
  }
  return out;
}

struct GivenPoints {
  std::vector<std::string> names;
  std::vector<Vector2d> at;
};

Result<GivenPoints> given_points(const fs::path& file) {
  COLLINEA_TRY(const TextTable table, read_text_table(file));
  const auto in_file = [&](Error e) { return std::move(e).within(file.string()).about("points"_option); };
  COLLINEA_TRY(const auto names, table.words("point").map_error(in_file));
  COLLINEA_TRY(const auto x, table.numbers("x", "px").map_error(in_file));
  COLLINEA_TRY(const auto y, table.numbers("y", "px").map_error(in_file));
  GivenPoints out{names, {}};
  for (std::size_t i = 0; i < x.size(); ++i) out.at.emplace_back(x[i], y[i]);
  return out;
}

Result<Found> targets_in(const FloatImage& image, const EdgeMap& map, const FindEdgesOptions& options) {
  std::vector<Target> targets;
  std::vector<std::string> names;
  Found out{.are_closed = true};
  if (options.points) {
    COLLINEA_TRY(const GivenPoints given, given_points(*options.points));
    for (std::size_t i = 0; i < given.at.size(); ++i) {
      auto target = measure_target(image, options.target, given.at[i], options.target_radius_px);
      if (!target) {
        ++out.not_measured;
        continue;
      }
      targets.push_back(std::move(*target));
      names.push_back(given.names[i]);
    }
  } else {
    targets = find_targets(image, map, options.target,
                           {.radius_px = options.target_radius_px, .most = std::size_t(options.hough.most)});
  }
  out.table = table_of(targets, names);
  for (const Target& t : targets) {
    out.centres.push_back(t.at);
    if (t.kind == TargetKind::kCircle)
      out.curves.push_back(curve_of(Ellipse{t.at, t.unknowns[7], t.unknowns[8], t.unknowns[9]}));
  }
  return out;
}

// The smallest and the largest scale of a shape that is looked for.
Result<std::pair<double, double>> scales_of(const FindEdgesOptions& options) {
  if (!options.shape_scale) return std::pair(1.0, 1.0);
  const auto given = parse_numbers(*options.shape_scale);
  if (!given || given->empty() || given->size() > 2 || !(given->front() >= 0.05) || !(given->back() <= 20) ||
      !(given->front() <= given->back()))
    return fail(Errc::kBadInput, "scales of a shape are one, or the smallest and the largest, of 0.05 to 20",
                {"shape_scale"_option});
  return std::pair(given->front(), given->back());
}

Result<Found> shapes_among(const EdgeMap& map, const FindEdgesOptions& options) {
  if (!options.shape) return fail(Errc::kBadInput, "which shape? Give an image of it", {"shape"_option});
  COLLINEA_TRY(const GreyImage image, read_grey(*options.shape));
  const EdgeMap of_shape = detect_edges(as_float(image), options.edges);
  const auto table = ShapeTable::create(of_shape.points, {image.width / 2.0, image.height / 2.0});
  if (!table)
    return fail(Errc::kBadInput, options.shape->string() + " shows no edges to be found elsewhere", {"shape"_option});
  COLLINEA_TRY(const auto scales, scales_of(options));
  ShapeSearch search =
      shape_search(*table, options.shape_rotation_deg.value_or(0) / kDegrees, scales.first, scales.second);
  search.least_share = options.hough.least_arc;
  const std::vector<FoundShape> shapes = hough_shapes(edge_points_of(map), *table, search, options.hough);
  Found out{.table = table_of(shapes, search)};
  for (const FoundShape& s : shapes) {
    out.centres.push_back(s.at);
    out.scaled += s.quality.is_scaled;
  }
  return out;
}

Found chains_of(const EdgeMap& map, const FindEdgesOptions& options) {
  Found out{.table = chain_table(map, options.polygon_px)};
  for (const EdgeChain& chain : map.chains) {
    Curve polygon = polygon_of(curve_of(map, chain), chain.is_closed, options.polygon_px);
    if (chain.is_closed) polygon.push_back(polygon.front());
    out.curves.push_back(std::move(polygon));
  }
  return out;
}

Result<Found> found_in(const FloatImage& image, const EdgeMap& map, const FindEdgesOptions& options) {
  switch (options.find) {
    case EdgeFind::kLines:
      return lines_among(map, options.hough);
    case EdgeFind::kCorners:
      return corners_among(map, options);
    case EdgeFind::kCircles:
      return circles_among(map, options.hough);
    case EdgeFind::kEllipses:
      return ellipses_among(map, options.hough);
    case EdgeFind::kTargets:
      return targets_in(image, map, options);
    case EdgeFind::kShapes:
      return shapes_among(map, options);
    case EdgeFind::kChains:
      break;
  }
  return chains_of(map, options);
}

// --- files
// ------------------------------------------------------------------------------------------------------------

Eigen::Vector3d on_drawing(const Vector2d& p) { return {p.x(), -p.y(), 0}; }

VectorRow row_of(const Curve& curve, bool is_closed, std::int64_t number) {
  VectorRow row;
  for (const Vector2d& p : curve) row.positions.push_back(on_drawing(p));
  if (is_closed && !curve.empty()) row.positions.push_back(on_drawing(curve.front()));
  row.values = {number};
  return row;
}

std::vector<VectorLayer> layers_of(const Found& found, std::string_view name) {
  std::vector<VectorLayer> layers;
  const std::vector<VectorField> fields{{"number", VectorType::kInteger}};
  if (!found.curves.empty()) {
    VectorLayer layer{.name = std::string(name),
                      .kind = found.are_closed ? VectorKind::kPolygon : VectorKind::kLine,
                      .fields = fields,
                      .flat = true};
    for (std::size_t i = 0; i < found.curves.size(); ++i)
      if (found.curves[i].size() > 1) layer.rows.push_back(row_of(found.curves[i], found.are_closed, int(i + 1)));
    layers.push_back(std::move(layer));
  }
  if (!found.centres.empty()) {
    VectorLayer layer{.name = "centres", .kind = VectorKind::kPoint, .fields = fields, .flat = true};
    for (std::size_t i = 0; i < found.centres.size(); ++i)
      layer.rows.push_back({{on_drawing(found.centres[i])}, {std::int64_t(i + 1)}});
    layers.push_back(std::move(layer));
  }
  return layers;
}

ColourImage overlay_of(const GreyImage& grey, const EdgeMap& map, const Found& found) {
  ColourImage out(grey.width, grey.height, 3);
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x)
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = std::uint8_t(96 + grey.at(x, y) * 5 / 8);
  for (const EdgePoint& p : map.points) draw_point(out, p.at, kEdgeColour);
  for (const Curve& curve : found.curves) draw_curve(out, curve, found.are_closed, kFoundColour);
  for (const Vector2d& p : found.centres) draw_cross(out, p, 5, kFoundColour);
  return out;
}

GreyImage stretched(const FloatImage& values, double white) {
  GreyImage out(values.width, values.height);
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = std::uint8_t(std::clamp(255 * double(values.data[i]) / white, 0.0, 255.0));
  return out;
}

// Writes files into one folder and remembers them.
class Outputs {
 public:
  explicit Outputs(fs::path folder) : folder_(std::move(folder)) {}

  Result<> table(const char* name, TextTable table) {
    files.push_back(folder_ / name);
    return write_file(files.back(), text_of(table));
  }
  Result<> image(const char* name, const Raster<std::uint8_t>& image) {
    files.push_back(folder_ / name);
    return write_png(files.back(), image);
  }
  Result<> vectors(const std::vector<VectorLayer>& layers) {
    if (layers.empty()) return {};
    files.push_back(folder_ / "found.gpkg");
    COLLINEA_TRY(write_geopackage(files.back(), layers, ""));
    files.push_back(folder_ / "found.dxf");
    return write_dxf(files.back(), layers);
  }
  std::vector<fs::path> files;

 private:
  fs::path folder_;
};

Result<> write_texture(Outputs& outputs, const GreyImage& image, const FindEdgesOptions& options) {
  const Texture texture = texture_of(image, options.texture_window);
  COLLINEA_TRY(outputs.image("entropy.png", stretched(texture.entropy, 8)));
  COLLINEA_TRY(outputs.image("entropy_mask.png", entropy_mask(texture.entropy, options.entropy)));
  COLLINEA_TRY(outputs.image("deviation.png", stretched(texture.deviation, 64)));
  COLLINEA_TRY(outputs.image("contrast.png", stretched(texture.contrast, 64)));
  return outputs.image("homogeneity.png", stretched(texture.homogeneity, 1));
}

Result<> write_all(Outputs& outputs, const GreyImage& image, const EdgeMap& map, const Found& found,
                   const FindEdgesOptions& options) {
  COLLINEA_TRY(outputs.table("found.txt", found.table));
  if (!found.lines.columns.empty()) COLLINEA_TRY(outputs.table("lines.txt", found.lines));
  if (options.find == EdgeFind::kChains) {
    COLLINEA_TRY(outputs.table("points.txt", edge_point_table(map, options.curvature_px)));
    COLLINEA_TRY(outputs.table("chain_codes.txt", code_table(map)));
    COLLINEA_TRY(outputs.table("fourier.txt", descriptor_table(map)));
  }
  const bool are_corners = options.find == EdgeFind::kCorners;  // drawn with their lines
  COLLINEA_TRY(outputs.vectors(layers_of(found, are_corners ? "lines" : word_of(options.find))));
  COLLINEA_TRY(outputs.image("overlay.png", overlay_of(image, map, found)));
  COLLINEA_TRY(outputs.image("amplitude.png", stretched(map.amplitude, std::max(1.0, 5 * map.high))));
  return options.texture ? write_texture(outputs, image, options) : Result<>{};
}

}  // namespace

Result<EdgesReport> find_edges(const fs::path& image, const fs::path& folder, const FindEdgesOptions& options,
                               const Run&) {
  COLLINEA_TRY(validate(options));
  if (options.texture_window % 2 == 0)
    return fail(Errc::kBadInput, "a window has a pixel in its middle: give an odd side", {"texture_window"_option});
  if (options.hough.smallest_radius_px > options.hough.largest_radius_px)
    return fail(Errc::kBadInput, "the smallest radius is larger than the largest",
                {"smallest_radius_px"_option, "largest_radius_px"_option});
  COLLINEA_TRY(const GreyImage grey, read_grey(image));
  const FloatImage values = as_float(grey);
  const EdgeMap map = detect_edges(values, options.edges);
  COLLINEA_TRY(Found found, found_in(values, map, options));
  Outputs outputs(folder);
  COLLINEA_TRY(write_all(outputs, grey, map, found, options));
  return EdgesReport{.image = image,
                     .width = grey.width,
                     .height = grey.height,
                     .edge_operator = options.edges.edge_operator,
                     .noise_grey = map.noise_grey,
                     .high = map.high,
                     .low = map.low,
                     .along_px = map.along_px,
                     .points = map.points.size(),
                     .chains = map.chains.size(),
                     .find = options.find,
                     .found = std::move(found.table),
                     .scaled = found.scaled,
                     .not_measured = found.not_measured,
                     .files = std::move(outputs.files)};
}

}  // namespace collinea
