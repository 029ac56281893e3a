// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/cloud/ply.h"
#include "collinea/io/number_rows.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/pair_steps.h"
#include "collinea/jobs/internal/village_pair_for_tests.h"
#include "collinea/jobs/pair.h"
#include "collinea/math/median.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using testing::kVillageFocal_px;
using testing::VillagePair;

// The drawing of that name on a page.
std::string drawing_of(const std::string& page, const std::string& name) {
  const auto from = page.find("aria-label=\"" + name + "\"");
  return from == page.npos ? "" : page.substr(from, page.find("</svg>", from) - from);
}

// The exterior orientation as a table has it, under the names of the images.
std::string exterior_of(const VillagePair& village, bool is_swapped = false, bool has_sigmas = true) {
  std::string table = "image X[m] Y[m] Z[m] omega[deg] phi[deg] kappa[deg]";
  if (has_sigmas) table += " sigma_X[m] sigma_Y[m] sigma_Z[m] sigma_omega[deg] sigma_phi[deg] sigma_kappa[deg]";
  table += "\n";
  for (int i = 0; i < 2; ++i) {
    const Rigid3 pose = village.pose(is_swapped ? 1 - i : i);
    const OmegaPhiKappa angles = omega_phi_kappa(pose.rotation);
    const Eigen::Vector3d centre = centre_of(pose);
    table += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f}{}\n",
                         (i == 0 ? village.left : village.right).filename().string(), centre.x(), centre.y(),
                         centre.z(), angles.omega_deg, angles.phi_deg, angles.kappa_deg,
                         has_sigmas ? " 0.01 0.01 0.01 0.001 0.001 0.001" : "");
  }
  return table;
}

TEST(Pair, TakesAnExteriorOrientationAsGiven) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.surface = PairSurface::kDense;
  options.cell_m = 0.2;
  options.exterior = village.folder / "exterior.txt";
  ASSERT_TRUE(write_file(*options.exterior, exterior_of(village)));
  const auto folder = village.folder / "pair";
  const auto report = orient_and_match(village.left, village.right, folder, options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->is_given);
  const RelativeOrientation& found = report->orientations.back().orientation;
  EXPECT_LT(angle_between(found.second_from_first.rotation, village.right_from_left().rotation), 1e-9);
  EXPECT_LT(report->orientations.back().sigma0_px, 0.1);  // as of the pair that is oriented by its points
  // Flat ground says nothing against an orientation that points do not determine.
  for (const Finding& finding : report->findings) EXPECT_NE(finding.code, FindingCode::kPairGeometry);
  EXPECT_NE(pair_text(*report).find("the orientation is as given"), std::string::npos);
  ASSERT_TRUE(report->map);
  EXPECT_EQ(*report->exterior[0].elements[0].sigma, 0.01);
  EXPECT_NEAR(*report->exterior[1].elements[4].sigma, 0.001, 1e-12);
  std::vector<double> errors = village.height_errors(folder / "dsm.tif");
  ASSERT_GT(errors.size(), 5000u);
  EXPECT_NEAR(median(errors), 0, 0.01);  // of thousands of cells, as with control
  // What it wrote is taken again, and orients alike.
  options.exterior = folder / "exterior.txt";
  const auto again = orient_and_match(village.left, village.right, village.folder / "again", options, {.threads = 2});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_LT((again->absolute->ground_from_model.translation - report->absolute->ground_from_model.translation).norm(),
            1e-7);  // eight decimals
}

TEST(Pair, AnOrientationInUnitsOfTheBaseGivesAModel) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.levels.levels = 1;
  const auto by_points =
      orient_and_match(village.left, village.right, village.folder / "first", options, {.threads = 2});
  ASSERT_TRUE(by_points) << by_points.error().message;
  EXPECT_GT(by_points->relative->solutions[0].in_front, by_points->relative->solutions[1].in_front);
  EXPECT_NE(read_file(village.folder / "first/pair.txt")->find("the four solutions"), std::string::npos);
  options.exterior = village.folder / "first/exterior.txt";
  const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->is_metric());
  EXPECT_FALSE(report->map);
  const std::string text = *read_file(village.folder / "pair/pair.txt");
  EXPECT_EQ(text.find("solutions"), std::string::npos) << text;  // there is but the one that is given
  // The left image is the datum, so that sigmas and correlations of the right one are all that is known of the pair.
  // Derivatives over a sigma of some 1e-4 rad leave the square of it, decimals and their steps less.
  const Matrix5 expected = by_points->orientations.back().orientation.stated_covariance(),
                found = report->orientations.back().orientation.stated_covariance();
  for (Eigen::Index i = 0; i < 5; ++i)
    for (Eigen::Index k = 0; k < 5; ++k)
      EXPECT_NEAR(found(i, k), expected(i, k), 1e-5 * std::sqrt(expected(i, i) * expected(k, k))) << i << ' ' << k;
  // Eight decimals of degrees and bases are 1e-5 px, less than a hundredth of a grey value: what is rounded differs by
  // one.
  const auto first = read_grey(village.folder / "first/epipolar_left.png"),
             second = read_grey(village.folder / "pair/epipolar_left.png");
  ASSERT_TRUE(first && second);
  ASSERT_EQ(first->data.size(), second->data.size());
  for (std::size_t i = 0; i < first->data.size(); ++i)
    ASSERT_LE(std::abs(int(first->data[i]) - int(second->data[i])), 1) << i;
}

TEST(Pair, AnOrientationWithoutSigmasIsExact) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.levels.levels = 1;
  options.exterior = village.folder / "exterior.txt";
  ASSERT_TRUE(write_file(*options.exterior, exterior_of(village, false, false)));
  const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  for (const PairExterior& image : report->exterior)
    for (const Estimate& element : image.elements) EXPECT_FALSE(element.sigma);
  EXPECT_EQ(report->orientations.back().orientation.stated_covariance().norm(), 0);
  EXPECT_EQ(read_file(village.folder / "pair/pair.txt")->find("nan"), std::string::npos);
}

TEST(Pair, RefusesExteriorOrientationsThatCannotBe) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.exterior = village.folder / "exterior.txt";
  const auto refused = [&](const std::string& table) {
    EXPECT_TRUE(write_file(*options.exterior, table));
    const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
    return !report && !report.error().options.empty() && report.error().options.front().name == "exterior";
  };
  const std::string table = exterior_of(village);
  EXPECT_TRUE(refused(table.substr(0, table.rfind(village.right.filename().string()))));  // one image
  EXPECT_TRUE(refused(exterior_of(village, true)));                                       // points behind the cameras
  const auto row = [](const char* name) { return std::string(name) + " 1 2 3 0 0 0 0 0 0 0 0 0\n"; };
  EXPECT_TRUE(refused(table.substr(0, table.find('\n') + 1) + row("left") + row("right")));  // no base
  options.base_m = 5;
  EXPECT_TRUE(refused(table));
  options.base_m.reset();
  options.relative.weights = PairWeights::kCells;
  EXPECT_TRUE(refused(table));
}

// Points of the area alone, as good as those of the whole pair.
TEST(Pair, AnAreaIsWorkedOnAlone) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.surface = PairSurface::kDense;
  options.exterior = village.folder / "exterior.txt";
  ASSERT_TRUE(write_file(*options.exterior, exterior_of(village)));
  options.area = "300,200,500,420";
  const auto folder = village.folder / "pair";
  const auto report = orient_and_match(village.left, village.right, folder, options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->shrink, 1);
  const auto cloud = read_ply(folder / "cloud.ply");
  ASSERT_TRUE(cloud);
  ASSERT_GT(cloud->size(), 30'000u);  // of 44,000 pixels
  EXPECT_LT(cloud->size(), 60'000u);  // the rectangle of epipolar pixels that holds them
  // The epipolar image is the smallest that holds the corners: each side touches one within the rounding to whole
  // pixels.
  const Camera& camera = village.truth.cameras.begin()->second;
  const EpipolarPair& epipolar = report->epipolar;
  Eigen::Vector2d least(1e9, 1e9), most(-1e9, -1e9);
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(300, 200), {500, 200}, {500, 420}, {300, 420}}) {
    const Eigen::Vector2d at = in_epipolar(camera, epipolar.left_from_image, epipolar.left, corner);
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  }
  const Eigen::Vector2d size(epipolar.left.width_px, epipolar.left.height_px);
  EXPECT_TRUE(least.minCoeff() >= -1e-9 && least.maxCoeff() < 1) << least.transpose();
  EXPECT_TRUE((size - most).minCoeff() >= -1e-9 && (size - most).maxCoeff() < 1) << most.transpose();
  std::vector<double> errors;
  for (const CloudPoint& point : *cloud) {
    const auto at = project(camera, village.pose(0) * point.position);
    ASSERT_TRUE(at);
    const Eigen::Vector2d there = in_epipolar(camera, epipolar.left_from_image, epipolar.left, *at);
    // Coordinates of clouds are floats: some 1e-5 m, 1e-4 pixels.
    EXPECT_TRUE(there.minCoeff() > -1e-3 && (size - there).minCoeff() > -1e-3) << there.transpose();
    errors.push_back(point.position.z() - village.scene->surface_height(point.position.x(), point.position.y()));
  }
  EXPECT_NEAR(median(errors), 0, 0.01);
  for (double& error : errors) error = std::abs(error);
  EXPECT_LT(median(errors), 0.04);  // as of the whole pair
}

TEST(Pair, RefusesAreasWithoutSurface) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  for (const char* area : {"1,2,3", "a,b,c,d", "500,200,300,400", "900,100,1000,200", "400,300,403,303"}) {
    options.area = area;
    const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
    ASSERT_FALSE(report) << area;
    EXPECT_EQ(report.error().options.front().name, "area") << area;
  }
}

// The page shows what the folder holds, and points lie on the epipolar lines that are drawn over them.
TEST(Pair, PageAndJsonHoldTheRecord) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.surface = PairSurface::kDense;
  options.cell_m = 0.4;
  ASSERT_TRUE(write_file(village.folder / "control.txt", village.control_table()));
  options.control = village.folder / "control.txt";
  const auto folder = village.folder / "pair";
  const auto report = orient_and_match(village.left, village.right, folder, options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  const std::string page = *read_file(folder / "pair.html");
  const auto count = [&](std::string_view part) {
    std::size_t n = 0;
    for (auto at = page.find(part); at != page.npos; at = page.find(part, at + 1)) ++n;
    return n;
  };
  // Two photographs with lines, one with parallaxes, epipolar images, orthophoto, heights, sigmas.
  EXPECT_EQ(count("data:image/jpeg;base64,/9j/"), 7u);
  EXPECT_EQ(count("href=\"http") + count("src=\"http"), 0u);
  EXPECT_NE(page.find("Seven parameters"), page.npos);
  const auto json = nlohmann::json::parse(*read_file(folder / "pair.json"));
  EXPECT_EQ(json["relative"].size(), 2u);
  EXPECT_EQ(json["relative"][1]["sigma0_px"].get<double>(), report->orientations.back().sigma0_px);
  EXPECT_EQ(json["absolute"]["points"].size(), report->control->points.size());
  EXPECT_EQ(json["absolute"]["covariance"].size(), 7u);
  EXPECT_EQ(json["map"]["measured_cells"].get<std::uint64_t>(), report->map->measured_cells);
  EXPECT_EQ(json["findings"].size(), report->findings.size());
  for (const int image : {0, 1}) {
    const std::string drawing = drawing_of(page, image == 0 ? "Left photograph" : "Right photograph");
    std::vector<std::vector<Eigen::Vector2d>> lines;
    int points = 0;
    for (const std::string_view line : lines_of(drawing)) {
      if (const auto at = line.find("points=\""); at != line.npos && line.starts_with("<polyline")) {
        lines.emplace_back();
        for (const std::string_view pair : fields_of(line.substr(at + 8, line.find('"', at + 8) - at - 8), ' '))
          if (const auto xy = parse_numbers(pair); xy && xy->size() == 2) lines.back().emplace_back((*xy)[0], (*xy)[1]);
      }
      double x = 0, y = 0;
      if (std::sscanf(std::string(line).c_str(), "<circle class=\"control\" cx=\"%lf\" cy=\"%lf\"", &x, &y) != 2)
        continue;
      ++points;
      ASSERT_FALSE(lines.empty());
      double nearest = 1e9;
      for (std::size_t k = 1; k < lines.back().size(); ++k) {
        const Eigen::Vector2d a = lines.back()[k - 1], along = lines.back()[k] - a, to = Eigen::Vector2d(x, y) - a;
        const double share = std::clamp(to.dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
        nearest = std::min(nearest, (to - share * along).norm());
      }
      // The largest parallax that is left is about 0.3 px of 800, drawn 460 wide and in tenths.
      EXPECT_LT(nearest, 0.4);
    }
    EXPECT_EQ(points, 12);
  }
}

}  // namespace
}  // namespace collinea
