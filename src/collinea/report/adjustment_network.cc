// SPDX-License-Identifier: Apache-2.0
// The network of observations as textbooks count it: how much there is of what, and where it checks itself.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/map_view.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using json = nlohmann::ordered_json;

constexpr int kMostRays = 10;  // the last row of tie points: in so many images or more

// Points of one kind, with the observations of them that took part. Local redundancy is the sum of their redundancy
// numbers: of images and cameras these observations determine the rest.
struct PointCounts {
  std::size_t points = 0, rays = 0;
  long observations = 0;  // coordinates, in images and on the ground
  long unknowns = 0;
  long tested = 0;        // observations whose redundancy number is known
  double redundancy = 0;  // its sum over them
  [[nodiscard]] double mean() const { return tested > 0 ? redundancy / double(tested) : std::nan(""); }
};

struct NetworkCounts {
  long images = 0, image_unknowns = 0, camera_unknowns = 0, tie_unknowns = 0, other_unknowns = 0;
  std::map<int, PointCounts> tie;  // by rays, the last with all beyond
  PointCounts control, check;
};

// Rays of each tie point: its observations that took part.
std::map<PointId, int> rays_of(const AdjustmentReport& report) {
  std::map<PointId, int> rays;
  for (const std::uint32_t index : report.adjusted.observations) ++rays[report.block.observations[index].point];
  return rays;
}

void add_number(double redundancy, PointCounts& counts) {
  if (!std::isfinite(redundancy)) return;
  ++counts.tested;
  counts.redundancy += redundancy;
}

void count_tie_points(const AdjustmentReport& report, NetworkCounts& counts) {
  const auto rays = rays_of(report);
  for (const auto& [point, n] : rays) {
    PointCounts& its = counts.tie[std::min(n, kMostRays)];
    ++its.points;
    its.rays += std::size_t(n);
    its.observations += 2L * n;
    its.unknowns += 3;
  }
  if (!report.adjusted.reliability) return;
  const auto& numbers = report.adjusted.reliability->tie_redundancy;
  for (std::size_t i = 0; i < std::min(numbers.size(), report.adjusted.observations.size()); ++i) {
    const Observation& seen = report.block.observations[report.adjusted.observations[i]];
    for (const double one : {numbers[i].x(), numbers[i].y()})
      add_number(one, counts.tie[std::min(rays.at(seen.point), kMostRays)]);
  }
}

void count_control(const AdjustmentReport& report, NetworkCounts& counts) {
  std::set<ControlId> used;
  for (const ControlDifference& one : report.adjusted.control) {
    PointCounts& its = one.used ? counts.control : counts.check;
    if (one.used) used.insert(one.point);
    ++its.points;
    its.rays += std::size_t(one.rays);
    if (one.used) its.unknowns += 3;
  }
  if (!report.adjusted.reliability) return;
  for (const TestedObservation& one : report.adjusted.reliability->others) {
    const ObservationSource source = traits_of(one.group).source;
    const bool in_image = source == ObservationSource::kControlImagePoint;
    if (!in_image && source != ObservationSource::kControlCoordinates) continue;
    const ControlId point = in_image ? report.block.control_observations[one.source].point : ControlId{one.source};
    PointCounts& its = used.contains(point) ? counts.control : counts.check;
    ++its.observations;
    add_number(one.redundancy, its);
  }
}

NetworkCounts counts_of(const AdjustmentReport& report) {
  const Examined& adjusted = report.adjusted;
  NetworkCounts counts;
  count_tie_points(report, counts);
  count_control(report, counts);
  counts.images = long(adjusted.cam_from_world.size());
  counts.image_unknowns = 6 * counts.images;
  counts.tie_unknowns = 3L * long(adjusted.points.size());
  for (const auto& [id, covariance] : adjusted.camera_covariance)
    counts.camera_unknowns += (covariance.diagonal().array() > 0).count();
  counts.other_unknowns = adjusted.unknown_count - counts.image_unknowns - counts.tie_unknowns - counts.camera_unknowns;
  return counts;
}

// Mean redundancy numbers of the rays of tie points over a grid.
struct RedundancyGrid {
  Vector2d low{0, 0};
  double cell_m = 0;
  int columns = 0, rows = 0;
  std::vector<double> sum;
  std::vector<long> count;

  [[nodiscard]] double mean(std::size_t i) const { return count[i] > 0 ? sum[i] / double(count[i]) : std::nan(""); }
};

// Where the points are, without the few that lie far off and would make the others small.
std::pair<Vector2d, Vector2d> bounds_of_most(const std::map<PointId, Vector2d>& position) {
  constexpr double kFew = 0.01, kMargin = 0.25;
  Vector2d low, high;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const auto& [id, at] : position) values.push_back(at[axis]);
    std::sort(values.begin(), values.end());
    const auto few = std::size_t(kFew * double(values.size()));
    const double first = values[few], last = values[values.size() - 1 - few], margin = kMargin * (last - first);
    low[axis] = std::max(values.front(), first - margin);
    high[axis] = std::min(values.back(), last + margin);
  }
  return {low, high};
}

RedundancyGrid grid_of(const AdjustmentReport& report) {
  constexpr int kAcross = 40;
  RedundancyGrid grid;
  if (!report.adjusted.reliability) return grid;
  std::map<PointId, Vector2d> position;
  for (const auto& [id, point] : report.adjusted.points)
    if (point.allFinite()) position[id] = point.head<2>();
  if (position.empty()) return grid;
  const auto [low, high] = bounds_of_most(position);
  grid.low = low;
  grid.cell_m = std::max((high - low).maxCoeff(), 1e-9) / kAcross;
  grid.columns = int((high - low).x() / grid.cell_m) + 1;
  grid.rows = int((high - low).y() / grid.cell_m) + 1;
  grid.sum.resize(std::size_t(grid.columns * grid.rows));
  grid.count.resize(grid.sum.size());
  const auto& numbers = report.adjusted.reliability->tie_redundancy;
  for (std::size_t i = 0; i < std::min(numbers.size(), report.adjusted.observations.size()); ++i) {
    const auto at = position.find(report.block.observations[report.adjusted.observations[i]].point);
    if (at == position.end() || !numbers[i].allFinite()) continue;
    if ((at->second.array() < low.array()).any() || (at->second.array() > high.array()).any()) continue;
    const Vector2d cell = (at->second - low) / grid.cell_m;
    const auto index = std::size_t(int(cell.y()) * grid.columns + int(cell.x()));
    grid.sum[index] += numbers[i].mean();
    ++grid.count[index];
  }
  return grid;
}

// Two rays leave one of four observations over, three rays three of six, ten rays 17 of 20.
constexpr std::array<double, 6> kFrom = {0, 0.3, 0.5, 0.6, 0.7, 0.8};
constexpr std::array<const char*, 6> kColours = {"#d7301f", "#fdcc8a", "#d9f0d3", "#7fcdbb", "#41a6c4", "#225ea8"};

std::string redundancy_map(const RedundancyGrid& grid, const std::string& unit) {
  constexpr double kLegend = 46, kMostHeight = 520;
  MapBounds bounds;
  bounds.add(grid.low);
  bounds.add(grid.low + grid.cell_m * Vector2d(grid.columns, grid.rows));
  const MapView view = bounds.view(kMapWidth, kMostHeight);
  Svg svg(view.width, view.height + kLegend, "Local redundancy");
  const double side = grid.cell_m * view.pixels_per_unit;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const double mean = grid.mean(std::size_t(row * grid.columns + column));
      if (!std::isfinite(mean)) continue;
      const auto above = std::upper_bound(kFrom.begin() + 1, kFrom.end(), mean);
      const Vector2d at = view(Vector2d(grid.low + grid.cell_m * Vector2d(column, row + 1)));
      svg.rectangle(at.x(), at.y(), side, side, "redundancy", kColours[std::size_t(above - kFrom.begin()) - 1]);
    }
  draw_scale_and_north(svg, view, unit);
  for (std::size_t i = 0; i < kFrom.size(); ++i) {
    const double x = 20 + 100.0 * double(i), y = view.height + 16;
    svg.rectangle(x, y, 16, 16, "swatch", kColours[i]);
    svg.text({x + 21, y + 13}, i == 0                  ? fmt::format("below {:g}", kFrom[1])
                               : i + 1 == kFrom.size() ? fmt::format("{:g} and more", kFrom[i])
                                                       : fmt::format("{:g} to {:g}", kFrom[i], kFrom[i + 1]));
  }
  return svg.finish();
}

std::string count_cell(long count) { return fmt::format("<td>{}</td>", count); }

std::string row_of(const std::string& name, const PointCounts& counts, double all) {
  if (counts.points == 0) return "";
  return "<tr>" + text_cell(name) + count_cell(long(counts.points)) +
         (all > 0 ? fmt::format("<td>{:.1f}</td>", 100 * double(counts.points) / all) : "<td></td>") +
         count_cell(long(counts.rays)) + count_cell(counts.observations) + count_cell(counts.unknowns) +
         cell(counts.tested > 0 ? counts.redundancy : std::nan(""), 1) + cell(counts.mean(), 2) + "</tr>\n";
}

std::string unknowns_table(const NetworkCounts& counts, long all) {
  std::string html =
      "<table><thead><tr><th class=\"l\">unknowns</th><th>how many</th><th>each</th><th>n</th></tr></thead><tbody>\n";
  const auto row = [&](const char* name, long many, long each, long n) {
    if (n != 0)
      html += "<tr>" + text_cell(name) + (many > 0 ? count_cell(many) : "<td></td>") +
              (each > 0 ? count_cell(each) : "<td></td>") + count_cell(n) + "</tr>\n";
  };
  row("images", counts.images, 6, counts.image_unknowns);
  row("tie points", counts.tie_unknowns / 3, 3, counts.tie_unknowns);
  row("parameters of cameras", 0, 0, counts.camera_unknowns);
  row("control points, instruments, shapes", 0, 0, counts.other_unknowns);
  return html + "<tr class=\"total\">" + text_cell("all") + "<td></td><td></td>" + count_cell(all) +
         "</tr>\n</tbody></table>\n";
}

std::string points_table(const NetworkCounts& counts) {
  double all = 0;
  for (const auto& [rays, its] : counts.tie) all += double(its.points);
  std::string html =
      "<table><thead><tr><th class=\"l\">tie points</th><th>points</th><th>share [%]</th><th>rays</th><th>observations "
      "m</th><th>unknowns n</th><th>redundancy</th><th>per observation</th></tr></thead><tbody>\n";
  for (const auto& [rays, its] : counts.tie)
    html += row_of(fmt::format("in {} {}", rays,
                               rays == kMostRays ? "or more"
                               : rays == 1       ? "image"
                                                 : "images"),
                   its, all);
  return html + row_of("control points", counts.control, 0) + row_of("check points", counts.check, 0) +
         "</tbody></table>\n";
}

json points_json(const PointCounts& counts) {
  return {{"points", counts.points},
          {"rays", counts.rays},
          {"observations", counts.observations},
          {"unknowns", counts.unknowns},
          {"redundancy", number(counts.tested > 0 ? counts.redundancy : std::nan(""))},
          {"mean_redundancy_number", number(counts.mean())}};
}

}  // namespace

std::string network_section(const AdjustmentReport& report) {
  const Examined& adjusted = report.adjusted;
  const NetworkCounts counts = counts_of(report);
  if (counts.tie.empty() && counts.control.points == 0) return "";
  const long m = adjusted.observation_count, n = adjusted.unknown_count;
  std::string html = fmt::format(
      "<section><h2>Network</h2>\n<p>m = {} observations, n = {} unknowns, rank defect d = {}: redundancy m - n + d = "
      "{}, {:.2f} of each observation.</p>\n",
      m, n, adjusted.rank_defect, adjusted.redundancy, m > 0 ? double(adjusted.redundancy) / double(m) : 0.0);
  html += unknowns_table(counts, n) +
          "<p>Observability: in how many images a point is seen. Redundancy: the sum of the redundancy numbers of its "
          "observations, after images and cameras have taken their part; an observation with 1 is checked by the "
          "others completely, one with 0 not at all. A point in two images has little: an error along its epipolar "
          "lines does not show.</p>\n" +
          points_table(counts);
  const RedundancyGrid grid = grid_of(report);
  if (grid.count.empty()) return html + "</section>\n";
  const bool metric = report.block.georeference || !adjusted.control.empty() || adjusted.rank_defect == 0;
  return html + "<figure class=\"map\"><h3>Local redundancy</h3>" + redundancy_map(grid, metric ? "m" : "units") +
         "<figcaption>Mean redundancy number of the image coordinates of the tie points in each square, in plan. Red: "
         "seen in two images; a gross error there stays unseen more easily. White: no tie "
         "point, or few far off.</figcaption></figure>\n</section>\n";
}

json network_json(const AdjustmentReport& report) {
  const NetworkCounts counts = counts_of(report);
  json tie = json::array();
  for (const auto& [rays, its] : counts.tie) {
    json one = {{"images", rays}, {"and_more", rays == kMostRays}};
    one.update(points_json(its));
    tie.push_back(one);
  }
  json j = {{"observations", report.adjusted.observation_count},
            {"unknowns", report.adjusted.unknown_count},
            {"rank_defect", report.adjusted.rank_defect},
            {"redundancy", report.adjusted.redundancy},
            {"unknowns_of",
             {{"images", counts.image_unknowns},
              {"tie_points", counts.tie_unknowns},
              {"cameras", counts.camera_unknowns},
              {"others", counts.other_unknowns}}},
            {"tie_points", tie},
            {"control_points", points_json(counts.control)},
            {"check_points", points_json(counts.check)}};
  const RedundancyGrid grid = grid_of(report);
  if (grid.count.empty()) return j;
  json means = json::array();
  for (std::size_t i = 0; i < grid.count.size(); ++i) means.push_back(number(grid.mean(i)));
  j["map"] = {{"low_in_world", {grid.low.x(), grid.low.y()}},
              {"cell_m", grid.cell_m},
              {"columns", grid.columns},
              {"rows", grid.rows},
              {"mean_redundancy_number", means}};
  return j;
}

}  // namespace collinea
