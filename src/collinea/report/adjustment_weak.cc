// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "collinea/math/median.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr double kWeak = 5;  // times the median standard deviation, as where weak images are named
constexpr std::size_t kShown = 10, kListed = 100;

// An image or a tie point and how well its position is known.
struct Known {
  std::uint32_t id = 0;
  double sigma_m = 0;  // of the worst direction
  int rays = 0;        // measurements that took part
};

struct Ranking {
  std::vector<Known> worst;  // first the worst
  double median_m = 0;
  std::size_t weak = 0, all = 0;
  [[nodiscard]] double times(const Known& one) const { return one.sigma_m / median_m; }
};

double largest_sigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(eigen.eigenvalues()[2], 0.0));
}

Ranking ranking_of(std::vector<Known> all) {
  Ranking ranking;
  ranking.all = all.size();
  if (all.empty()) return ranking;
  std::vector<double> sigmas;
  for (const Known& one : all) sigmas.push_back(one.sigma_m);
  ranking.median_m = median(sigmas);
  std::stable_sort(all.begin(), all.end(), [](const Known& a, const Known& b) { return a.sigma_m > b.sigma_m; });
  while (ranking.weak < all.size() && ranking.times(all[ranking.weak]) > kWeak) ++ranking.weak;
  ranking.worst = std::move(all);
  return ranking;
}

Ranking images_of(const AdjustmentReport& report) {
  std::map<ImageId, int> rays;
  for (const std::uint32_t index : report.adjusted.observations) ++rays[report.block.observations[index].image];
  std::vector<Known> all;
  for (const auto& [id, covariance] : report.adjusted.pose_covariance)
    all.push_back(
        {id.value, largest_sigma(covariance.bottomRightCorner<3, 3>()) * sigma_scale(report.adjusted), rays[id]});
  return ranking_of(std::move(all));
}

Ranking points_of(const AdjustmentReport& report) {
  std::map<PointId, int> rays;
  for (const std::uint32_t index : report.adjusted.observations) ++rays[report.block.observations[index].point];
  std::vector<Known> all;
  for (std::size_t i = 0; i < report.adjusted.point_covariance.size(); ++i)
    all.push_back({report.adjusted.points[i].first.value,
                   largest_sigma(report.adjusted.point_covariance[i]) * sigma_scale(report.adjusted),
                   rays[report.adjusted.points[i].first]});
  return ranking_of(std::move(all));
}

std::string name_of_image(const AdjustmentReport& report, const Known& one) {
  return report.block.images.at(ImageId{one.id}).file;
}

std::string table(const Ranking& ranking, const char* title, const auto& name) {
  std::string html = fmt::format(
      "<p>{} of {} {} are known more than {:.0f} times worse than the median of {:.3g} m; the weakest:</p>\n"
      "<table><thead><tr><th class=\"l\">{}</th><th>&sigma;, worst direction [m]</th><th>times the median</th>"
      "<th>measurements</th></tr></thead><tbody>\n",
      ranking.weak, ranking.all, title, kWeak, ranking.median_m, title);
  const int decimals = decimals_for(ranking.median_m, 4);
  for (std::size_t i = 0; i < std::min(kShown, ranking.worst.size()); ++i) {
    const Known& one = ranking.worst[i];
    html += "<tr>" + text_cell(name(one)) + cell(one.sigma_m, decimals) +
            fmt::format("<td{}>{:.1f}</td><td>{}</td></tr>\n", ranking.times(one) > kWeak ? " class=\"bad\"" : "",
                        ranking.times(one), one.rays);
  }
  return html + "</tbody></table>\n";
}

json list(const Ranking& ranking, const auto& name) {
  json worst = json::array();
  for (std::size_t i = 0; i < std::min(kListed, ranking.worst.size()); ++i)
    worst.push_back({{"name", name(ranking.worst[i])},
                     {"sigma_m", number(ranking.worst[i].sigma_m)},
                     {"times_the_median", number(ranking.times(ranking.worst[i]))},
                     {"measurements", ranking.worst[i].rays}});
  return {{"all", ranking.all}, {"weak", ranking.weak}, {"median_sigma_m", number(ranking.median_m)}, {"worst", worst}};
}

std::string point_name(const Known& one) { return std::to_string(one.id); }

}  // namespace

std::string weak_section(const AdjustmentReport& report) {
  const Ranking images = images_of(report), points = points_of(report);
  if (images.all == 0) return "";
  std::string html = "<section><h2>Weakest images and points</h2>\n" +
                     table(images, "images", [&](const Known& one) { return name_of_image(report, one); });
  if (points.all > 0) html += table(points, "tie points", point_name);
  return html + "</section>\n";
}

json weak_json(const AdjustmentReport& report) {
  return {{"images", list(images_of(report), [&](const Known& one) { return name_of_image(report, one); })},
          {"points", list(points_of(report), point_name)}};
}

}  // namespace collinea
