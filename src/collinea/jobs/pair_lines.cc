// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/pair_lines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/jobs/internal/drawing.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/jobs/internal/prepared_pair.h"
#include "collinea/raster/image_file.h"
#include "collinea/vector/dxf.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

constexpr int kRim_px = 5;  // an edge point so near to where an image has nothing is of its rim
constexpr MarkColour kUnmatched{150, 150, 150};
constexpr std::array<MarkColour, 8> kColours = {{{255, 60, 60},
                                                 {60, 200, 60},
                                                 {80, 120, 255},
                                                 {255, 190, 0},
                                                 {230, 80, 230},
                                                 {0, 210, 210},
                                                 {255, 130, 40},
                                                 {160, 220, 60}}};

// Straight edges of one image, and the points that they are made of.
struct SideLines {
  EdgeMap map;
  std::vector<FoundLine> found;  // parallel to `lines`; numbers of map.points
  std::vector<MatchableLine> lines;
  std::vector<EdgeArc> arcs;  // where curves are asked for
};

bool is_at_rim(const GreyImage& image, const Vector2d& at) {
  const int x = int(std::floor(at.x())), y = int(std::floor(at.y()));
  for (int v = -kRim_px; v <= kRim_px; ++v)
    for (int u = -kRim_px; u <= kRim_px; ++u)
      if (x + u >= 0 && y + v >= 0 && x + u < image.width && y + v < image.height && image.at(x + u, y + v) == 0)
        return true;
  return false;
}

SideLines lines_in(const GreyImage& image, const PairLinesOptions& o) {
  SideLines side;
  const FloatImage grey = as_float(image);
  side.map = detect_edges(grey, o.edges);
  if (o.curves)
    side.arcs = edge_arcs(side.map, grey, o.matching.least_row_angle_deg, o.least_points,
                          [&](const Vector2d& at) { return is_at_rim(image, at); });
  std::erase_if(side.map.points, [&](const EdgePoint& point) { return is_at_rim(image, point.at); });
  side.map.chains.clear();  // they count the points as they were
  const EdgePoints edges = edge_points_of(side.map);
  const HoughOptions hough{.least_points = o.least_points, .most = o.most, .tolerance_px = o.tolerance_px};
  for (FoundLine& found : line_segments(edges, hough_lines(edges, hough), o.gap_px, o.least_points)) {
    const auto greys = side_greys(grey, found.line);
    if (!greys) continue;
    side.lines.push_back({found.line, *greys});
    side.found.push_back(std::move(found));
  }
  return side;
}

ImageLine in_space(const EdgeLine& line, const Camera& camera, const Rigid3& cam_from_world) {
  return image_line(cam_from_world, camera.focal_px(), {camera.params[Camera::kCx], camera.params[Camera::kCy]},
                    {line.theta_rad, line.r_px, line.covariance, (line.from + line.to) / 2});
}

std::optional<MatchedSpaceLine> space_line(const PairLine& line, const EpipolarPair& pair) {
  const Rigid3 right_from_world = Rigid3{Eigen::Quaterniond::Identity(), {-pair.base_m, 0, 0}} * pair.left_from_world;
  const std::array lines = {in_space(line.left, pair.left, pair.left_from_world),
                            in_space(*line.right, pair.right, right_from_world)};
  const auto met = intersect_lines(lines);
  if (!met) return std::nullopt;
  const auto along = [&](double row) {
    const Vector2d pixel(crossing(line.left, row)->column, row);
    return met->nearest_to(pair.left_from_world, normalized(pair.left, pixel));
  };
  const LineCandidate& match = *line.decision.match;
  return MatchedSpaceLine{*met, along(match.first_row), along(match.last_row)};
}

std::vector<PairLine> pair_lines(const SideLines& left, const SideLines& right, const PreparedPair& ready,
                                 std::vector<LineDecision> decisions) {
  std::vector<PairLine> out;
  for (std::size_t i = 0; i < left.lines.size(); ++i) {
    PairLine line{.left = left.lines[i].line, .decision = std::move(decisions[i])};
    if (const auto& match = line.decision.match) {
      line.right = right.lines[match->right].line;
      std::vector<EdgePoint> points;
      for (const std::size_t k : left.found[i].points) points.push_back(left.map.points[k]);
      line.points = edge_point_matches(*match, points, *line.right);
      if (ready.cameras) line.space = space_line(line, *ready.cameras);
    }
    out.push_back(std::move(line));
  }
  return out;
}

PairCurves pair_curves(const SideLines& left, const SideLines& right, const DisparityRange& range,
                       const LineMatchOptions& options) {
  const ArcMatches found = match_arcs(left.arcs, right.arcs, range.low, range.high, options);
  PairCurves out{left.arcs.size(), right.arcs.size(), found.undecided, {}};
  for (const ArcMatch& match : found.matches)
    out.curves.push_back({match, arc_point_matches(match, left.arcs[match.left], right.arcs[match.right])});
  return out;
}

ColourImage drawn_over(const GreyImage& grey) {
  ColourImage out(grey.width, grey.height, 3);
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x)
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = std::uint8_t(grey.at(x, y) / 2);
  return out;
}

void draw_thick(ColourImage& image, const EdgeLine& line, const MarkColour& colour) {
  for (const double off : {-0.5, 0.5})
    draw_line(image, line.from + off * line.normal(), line.to + off * line.normal(), colour);
}

Result<> write_images(const fs::path& folder, const PreparedPair& ready, const SideLines& right,
                      const std::vector<PairLine>& lines) {
  ColourImage left_image = drawn_over(ready.left), right_image = drawn_over(ready.right);
  for (const MatchableLine& line : right.lines) draw_line(right_image, line.line.from, line.line.to, kUnmatched);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].right) {
      draw_thick(left_image, lines[i].left, kColours[i % kColours.size()]);
      draw_thick(right_image, *lines[i].right, kColours[i % kColours.size()]);
    } else {
      draw_line(left_image, lines[i].left.from, lines[i].left.to, kUnmatched);
    }
  }
  COLLINEA_TRY(write_png(folder / "left.png", left_image));
  return write_png(folder / "right.png", right_image);
}

Result<> write_vectors(const fs::path& folder, const std::vector<PairLine>& lines) {
  VectorLayer layer{.name = "lines", .kind = VectorKind::kLine, .fields = {{"line", VectorType::kInteger}}};
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (const auto& space = lines[i].space)
      layer.rows.push_back({{space->line.at(space->from_m), space->line.at(space->to_m)}, {std::int64_t(i + 1)}});
  COLLINEA_TRY(write_geopackage(folder / "lines.gpkg", {layer}, ""));
  return write_dxf(folder / "lines.dxf", {layer});
}

}  // namespace

Result<LinesReport> lines_of_pair(const std::string& left, const std::string& right, const fs::path& folder,
                                  const StereoPairOptions& pair, const PairLinesOptions& options, const Run& run) {
  COLLINEA_TRY(validate(pair));
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(const PreparedPair ready, prepared_pair(left, right, pair, run));
  COLLINEA_TRY(const DisparityRange range, range_for(ready, pair));
  std::array<SideLines, 2> sides;
  parallel_for(run, 2, [&](std::size_t i) { sides[i] = lines_in(i == 0 ? ready.left : ready.right, options); });
  if (run.stopped()) return fail(Errc::kCancelled, "matching lines was stopped");
  for (std::size_t i = 0; i < 2; ++i)
    if (sides[i].lines.empty() && sides[i].arcs.empty())
      return fail(Errc::kIllPosed, (i == 0 ? left : right) + " has no straight edges", {"least_points"_option});
  LinesReport report{.left = left, .right = right, .low_px = range.low, .high_px = range.high, .frame = ready.frame};
  report.right_lines = sides[1].lines.size();
  report.lines = pair_lines(sides[0], sides[1], ready,
                            match_lines(sides[0].lines, sides[1].lines, range.low, range.high, options.matching));
  if (options.curves) report.curves = pair_curves(sides[0], sides[1], range, options.matching);
  COLLINEA_TRY(make_out_folder(folder));
  std::error_code error;
  for (const char* name : {"lines.gpkg", "lines.dxf", "curve_points.txt"})
    fs::remove(folder / name, error);  // of an earlier run
  if (ready.cameras) {
    const EpipolarPair& known = *ready.cameras;
    report.cameras = {known.left, known.right, known.left_from_world, known.base_m, 0};
    COLLINEA_TRY(write_vectors(folder, report.lines));
  }
  COLLINEA_TRY(write_images(folder, ready, sides[1], report.lines));
  COLLINEA_TRY(write_file(folder / "lines.txt", text_of(lines_table(report))));
  COLLINEA_TRY(write_file(folder / "edge_points.txt", text_of(edge_points_table(report))));
  if (report.curves) COLLINEA_TRY(write_file(folder / "curve_points.txt", text_of(curve_points_table(report))));
  return report;
}

}  // namespace collinea
