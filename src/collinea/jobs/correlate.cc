// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/correlate.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/feature/interest.h"
#include "collinea/io/number_rows.h"
#include "collinea/jobs/internal/drawing.h"
#include "collinea/jobs/internal/fundamental_file.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/match/neighbour_matching.h"
#include "collinea/match/pair_points.h"
#include "collinea/match/rank_covariance.h"
#include "collinea/match/window_return.h"
#include "collinea/math/median.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

constexpr int kUsualPoints = 200;
constexpr std::size_t kNearest = 5;  // coarse matches by which a point is expected

// Left less right of the coarse matches nearest to a position: their median, so that a wrong one does no harm.
Vector2d parallax_near(const std::vector<MatchedPoint>& coarse, const Vector2d& left_px) {
  std::vector<MatchedPoint> nearest(std::min(kNearest, coarse.size()));
  std::partial_sort_copy(coarse.begin(), coarse.end(), nearest.begin(), nearest.end(),
                         [&](const MatchedPoint& a, const MatchedPoint& b) {
                           return (a.left_px - left_px).squaredNorm() < (b.left_px - left_px).squaredNorm();
                         });
  Vector2d parallax;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const MatchedPoint& point : nearest) values.push_back(point.left_px[axis] - point.right_px[axis]);
    parallax[axis] = median(values);
  }
  return parallax;
}

// Where points without an expected position are looked for: by the given parallax, or by coarse matching.
Result<> expect(CorrelateReport& report, const GreyImage& left, const GreyImage& right, const CorrelateOptions& options,
                const Run& run) {
  std::vector<MatchedPoint> coarse;
  if (options.parallax_px) {
    const auto given = parse_numbers(*options.parallax_px);
    if (!given || given->size() != 2)
      return fail(Errc::kBadInput, "the parallax is not two numbers with a comma between", {"parallax_px"_option});
    report.parallax_px = {(*given)[0], (*given)[1]};
  } else {
    COLLINEA_TRY(const PairPoints pair, find_pair_points(left, right, {}, run).map_error([](Error error) {
      return std::move(error).about("parallax_px"_option);
    }));
    coarse = pair.points;
    report.parallax_px = pair.stages.back().parallax_px;
  }
  for (CorrelatedPoint& point : report.points)
    if (!point.expected_px.allFinite())
      point.expected_px = point.left_px - (coarse.empty() ? report.parallax_px : parallax_near(coarse, point.left_px));
  return {};
}

// Points whose expected position is not stated have none that is finite.
Result<std::vector<CorrelatedPoint>> points_of_table(const fs::path& path) {
  const auto within = [&](Error error) { return std::move(error).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  COLLINEA_TRY(const auto names, table.words("point").map_error(within));
  COLLINEA_TRY(const auto x, table.numbers("x_left", "px").map_error(within));
  COLLINEA_TRY(const auto y, table.numbers("y_left", "px").map_error(within));
  COLLINEA_TRY(const auto x_right, table.numbers_or("x_right", "px", std::nan("")).map_error(within));
  COLLINEA_TRY(const auto y_right, table.numbers_or("y_right", "px", std::nan("")).map_error(within));
  std::vector<CorrelatedPoint> points;
  for (std::size_t i = 0; i < names.size(); ++i)
    points.push_back({.name = names[i], .left_px = {x[i], y[i]}, .expected_px = {x_right[i], y_right[i]}});
  return points;
}

std::vector<CorrelatedPoint> interest_points_of(const GreyImage& image, int most) {
  InterestOptions options;
  options.max_points = most;
  std::vector<CorrelatedPoint> points;
  for (const InterestPoint& point : find_interest_points(image, options).points)
    points.push_back({.name = std::to_string(points.size() + 1),
                      .left_px = point.position_px,
                      .expected_px = Vector2d::Constant(std::nan(""))});
  return points;
}

// Lines of the refinement along a line: a direction, or of each point its epipolar line.
struct Lines {
  Vector2d direction{1, 0};
  std::optional<Eigen::Matrix3d> fundamental = {};
};

// Whether options of the refinement mean anything, and the lines of refine line.
Result<Lines> lines_of(const CorrelateOptions& options) {
  if (!options.refine && (options.window != WindowOptions{} || options.refine_return_px))
    return fail(Errc::kBadInput, "options of the refinement say nothing without it", {"refine"_option});
  if (!options.line_px && !options.epipolar) return Lines{};
  if (options.refine != WindowModel::kLine)
    return fail(Errc::kBadInput, "lines are given, and the refinement is not along a line",
                {options.line_px ? "line_px"_option : "epipolar"_option, "refine"_option});
  if (options.line_px && options.epipolar)
    return fail(Errc::kBadInput, "the lines are given twice", {"line_px"_option, "epipolar"_option});
  if (options.epipolar) {
    COLLINEA_TRY(const Eigen::Matrix3d fundamental, read_fundamental(*options.epipolar).map_error([](Error error) {
      return std::move(error).about("epipolar"_option);
    }));
    return Lines{{1, 0}, fundamental};
  }
  const auto given = parse_numbers(*options.line_px);
  if (!given || given->size() != 2 || !(std::hypot((*given)[0], (*given)[1]) > 0))
    return fail(Errc::kBadInput, "the direction of the line is not two numbers with a comma between",
                {"line_px"_option});
  return Lines{{(*given)[0], (*given)[1]}};
}

// What a decision does not ask for says nothing beside it.
Result<> check_decision(const CorrelateOptions& options) {
  if (options.decision != PointDecision::kRelaxation) {
    if (options.relaxation != RelaxationOptions{})
      return fail(Errc::kBadInput, "options of the relaxation say nothing without it", {"decision"_option});
    return {};
  }
  if (options.matching.return_px != AreaOptions{}.return_px)
    return fail(Errc::kBadInput, "relaxation asks the neighbours of a point, not whether it comes back",
                {"return_px"_option, "decision"_option});
  return {};
}

Result<> check_sides(const CorrelateOptions& options) {
  for (const auto& [side_px, option] : {std::pair(options.matching.template_px, "template_px"_option),
                                        std::pair(options.matching.search_px, "search_px"_option),
                                        std::pair(options.matching.neighbourhood_px, "neighbourhood_px"_option),
                                        std::pair(options.window.window_px, "window_px"_option)})
    if (side_px % 2 == 0) return fail(Errc::kBadInput, "the side of a window is odd: it has a middle", {option});
  return {};
}

Result<> write_images(const fs::path& folder, const GreyImage& left, const GreyImage& right,
                      const CorrelateReport& report) {
  ColourImage on_left = to_draw_on(left), on_right = to_draw_on(right);
  for (const CorrelatedPoint& point : report.points) {
    draw_cross(on_left, point.left_px, 5, point.match ? kMarkRed : kMarkBlue);
    if (point.match)
      draw_cross(on_right, point.is_refined() ? point.refined->position_px : point.match->position_px, 5, kMarkRed);
  }
  COLLINEA_TRY(write_png(folder / "left.png", on_left));
  return write_png(folder / "right.png", on_right);
}

Result<> write_surface(const fs::path& folder, const GreyImage& left, const GreyImage& right,
                       const CorrelateReport& report, const std::string& name) {
  const auto found = std::find_if(report.points.begin(), report.points.end(),
                                  [&](const CorrelatedPoint& point) { return point.name == name; });
  if (found == report.points.end()) return fail(Errc::kBadInput, "there is no point " + name, {"surface_of"_option});
  const CorrelationSurface surface =
      match_area(left, found->left_px, right, found->expected_px, report.options).surface;
  if (surface.values.empty())
    return fail(Errc::kBadInput, "the window of point " + name + " does not lie in its image, or nothing is searched",
                {"surface_of"_option});
  COLLINEA_TRY(write_float_tiff(folder / "surface.tif", surface.values));
  return write_file(folder / "surface.svg", correlation_svg(surface, name));
}

// Matches every point by itself, or all of them together by what their neighbours match.
void match_points(CorrelateReport& report, const GreyImage& left, const GreyImage& right,
                  const CorrelateOptions& options, const Run& run) {
  if (report.is_relaxed) {
    std::vector<AreaPoint> points;
    for (const CorrelatedPoint& point : report.points) points.push_back({point.left_px, point.expected_px});
    const auto found = match_areas(left, right, points, options.matching, options.relaxation, run);
    for (std::size_t i = 0; i < points.size(); ++i) {
      report.points[i].outcome = found[i].outcome;
      report.points[i].match = found[i].match;
      report.points[i].candidates = found[i].candidates;
      if (found[i].candidates > 0) report.points[i].probability = found[i].probability;
    }
    return;
  }
  parallel_for(run, report.points.size(), [&](std::size_t i) {
    CorrelatedPoint& point = report.points[i];
    AreaMatching matching = match_area(left, point.left_px, right, point.expected_px, options.matching);
    add_rank_covariance(left, point.left_px, right, options.matching, matching);
    point.outcome = matching.outcome;
    point.match = matching.match;
    point.candidates = matching.candidates.size();
  });
}

// Along an epipolar line the window begins at the foot of what area matching found, and goes back along the line of
// that in the left image.
void refine_point(CorrelatedPoint& point, const GreyImage& left, const GreyImage& right, const Lines& lines,
                  const CorrelateReport& report) {
  WindowStart start{point.match->position_px, Eigen::Matrix2d::Identity(), lines.direction};
  Vector2d left_line = lines.direction;
  if (lines.fundamental) {
    const auto line = epipolar_line(*lines.fundamental, point.left_px);
    const auto back = epipolar_line(lines.fundamental->transpose(), start.position_px);
    point.refined = WindowMatch{.outcome = WindowOutcome::kOffLine};
    if (!line || !back) return;
    point.off_line_px = line->distance_px(start.position_px);
    if (std::abs(*point.off_line_px) > report.window.farthest_px) return;
    start.position_px = line->foot_px(start.position_px);
    start.line = line->direction();
    left_line = back->direction();
  }
  if (!report.refine_return_px) {
    point.refined = match_window(left, point.left_px, right, start, report.window);
    return;
  }
  const ReturnedWindow found =
      match_window_and_back(left, point.left_px, right, start, report.window, left_line, *report.refine_return_px);
  point.refined = found.match;
  point.refined_returned_px = found.returned_px;
}

}  // namespace

Result<CorrelateReport> correlate_points(const fs::path& left_file, const fs::path& right_file, const fs::path& folder,
                                         const CorrelateOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(check_sides(options));
  COLLINEA_TRY(check_decision(options));
  COLLINEA_TRY(const Lines lines, lines_of(options));
  if (options.points && options.max_points)
    return fail(Errc::kBadInput, "the points are those of the table", {"max_points"_option, "points"_option});
  COLLINEA_TRY(const GreyImage left, read_grey(left_file));
  COLLINEA_TRY(const GreyImage right, read_grey(right_file));
  CorrelateReport report{.left = left_file.filename().string(),
                         .right = right_file.filename().string(),
                         .options = options.matching,
                         .refine = options.refine,
                         .window = options.window,
                         .refine_return_px = options.refine_return_px,
                         .has_epipolar_lines = options.epipolar.has_value(),
                         .is_parallax_found = !options.parallax_px,
                         .is_relaxed = options.decision == PointDecision::kRelaxation};
  if (options.points) {
    COLLINEA_TRY(report.points, points_of_table(*options.points));
  } else {
    report.points = interest_points_of(left, options.max_points.value_or(kUsualPoints));
  }
  const bool needs_parallax = std::any_of(report.points.begin(), report.points.end(),
                                          [](const CorrelatedPoint& point) { return !point.expected_px.allFinite(); });
  if (!needs_parallax && options.parallax_px)
    return fail(Errc::kBadInput, "the table says of every point where it is expected", {"parallax_px"_option});
  if (needs_parallax) {
    COLLINEA_TRY(expect(report, left, right, options, run));
  }
  match_points(report, left, right, options, run);
  if (options.refine) {
    report.window.model = *options.refine;
    parallel_for(run, report.points.size(), [&](std::size_t i) {
      if (report.points[i].match) refine_point(report.points[i], left, right, lines, report);
    });
  }
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  COLLINEA_TRY(make_out_folder(folder));
  COLLINEA_TRY(write_file(folder / "correlated.txt", text_of(correlated_table(report))));
  if (options.refine) {
    COLLINEA_TRY(write_file(folder / "refined.txt", text_of(refined_windows_table(report))));
  }
  COLLINEA_TRY(write_images(folder, left, right, report));
  if (options.surface_of) {
    COLLINEA_TRY(write_surface(folder, left, right, report, *options.surface_of));
  }
  return report;
}

}  // namespace collinea
