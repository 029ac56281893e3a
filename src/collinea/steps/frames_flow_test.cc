// SPDX-License-Identifier: Apache-2.0
// A facade from photographs to its surface and orthophoto, beside the exact wall.
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/raster/geotiff.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_small_project.h"
#include "collinea/synthetic/render.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

class FacadeFlow : public ::testing::Test {
 protected:
  static FacadeOptions facade() {
    FacadeOptions options;
    options.stations = 5;
    options.arc_deg = 50;
    options.camera.width_px = 640;
    options.camera.height_px = 480;
    options.camera.principal_x_px = options.camera.principal_y_px = 1;
    return options;
  }
  void SetUp() override {
    fs::remove_all(root_);
    ASSERT_TRUE(truth_) << truth_.error().message;
    fs::create_directories(root_ / "images");
    ASSERT_TRUE(write_images(*truth_, root_ / "images", {.threads = 2}));
    ASSERT_TRUE(write_tables(*truth_, root_));
    settings_.photos = (root_ / "images").string();
    settings_.import.control = (root_ / "control.csv").string();
    settings_.import.crs = "EPSG:32633";
  }
  void TearDown() override {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  FramesRecord mapped(Step last = Step::kFrames) {
    auto project = create_project(root_ / "mapped", settings_, log_.run(2));
    EXPECT_TRUE(project) << project.error().message;
    const auto done = bring_up_to(*project, last);
    EXPECT_TRUE(done) << done.error().message;
    return project->store.read_outcome<FramesRecord>().value();
  }
  [[nodiscard]] fs::path file(const std::string& frame, const std::string& name) const {
    return root_ / "mapped/products/frames" / frame / name;
  }

  const fs::path root_ = fs::path(::testing::TempDir()) / ("collinea_Facade_" + std::to_string(::getpid()));
  const Result<Truth> truth_ = make_facade(facade());
  Settings settings_;
  Log log_;
};

// The cells of a frame in the world of the truth.
struct TrueWall {
  const Truth& truth;
  Vector3d origin, right, up, normal;

  TrueWall(const Truth& its, const FrameRecord& frame) : truth(its), origin(its.frame.local_from_map(frame.origin)) {
    const auto axis = [&](const Vector3d& on_map) {
      return Vector3d((its.frame.local_from_map(frame.origin + on_map) - origin).normalized());
    };
    right = axis(frame.right), up = axis(frame.up), normal = axis(frame.normal);
  }
  [[nodiscard]] std::optional<Hit> hit(double x, double y) const {
    return truth.scene.cast(origin + x * right + y * up + 2 * normal, -normal);
  }
  [[nodiscard]] std::optional<double> distance(double x, double y) const {
    const auto found = hit(x, y);
    return found ? std::optional(2 - found->distance_m) : std::nullopt;
  }
};

struct Errors {
  std::vector<double> of_distance, sigma_m;
  std::vector<Eigen::Vector2d> at;

  // Without what displaces and turns the wall as a whole, which is one error for all cells.
  [[nodiscard]] std::vector<double> against_those_around() const {
    Eigen::MatrixX3d columns(std::ptrdiff_t(at.size()), 3);
    for (std::size_t i = 0; i < at.size(); ++i) columns.row(std::ptrdiff_t(i)) << 1, at[i].x(), at[i].y();
    const Eigen::Map<const Eigen::VectorXd> all(of_distance.data(), std::ptrdiff_t(of_distance.size()));
    const Eigen::VectorXd left = all - columns * columns.colPivHouseholderQr().solve(all);
    return {left.begin(), left.end()};
  }
};

// Where the wall is flat over some cells around.
constexpr int kFlat = 8;  // cells: matching looks at windows, and at reveals that few images see
Errors errors_of(const TrueWall& wall, const fs::path& dsm, const fs::path& sigma, const fs::path& state) {
  const auto heights = GeoTiffReader::open(dsm).value(), sigmas = GeoTiffReader::open(sigma).value();
  const MapGrid grid = heights.grid();
  const FloatImage all = heights.read_known(0, 0, grid.width, grid.height).value();
  const auto states = GeoTiffReader::open(state)->read_byte(0, 0, grid.width, grid.height).value();
  const FloatImage its_sigma = sigmas.read_known(0, 0, grid.width, grid.height).value();
  Errors errors;
  for (int row = kFlat; row < grid.height - kFlat; row += 3)
    for (int column = kFlat; column < grid.width - kFlat; column += 3) {
      if (states.at(column, row) != 1) continue;  // not measured
      const auto at = [&](int c, int r) { return wall.distance(grid.east_of(c + 0.5), grid.north_of(r + 0.5)); };
      const auto middle = at(column, row);
      if (!middle) continue;
      bool is_flat = true;
      for (int dy = -kFlat; dy <= kFlat && is_flat; dy += 2)
        for (int dx = -kFlat; dx <= kFlat && is_flat; dx += 2) {
          const auto beside = at(column + dx, row + dy);
          is_flat = beside && std::abs(*beside - *middle) < 0.01;
        }
      if (!is_flat) continue;
      errors.of_distance.push_back(double(all.at(column, row)) - *middle);
      errors.sigma_m.push_back(double(its_sigma.at(column, row)));
      errors.at.emplace_back(grid.east_of(column + 0.5), grid.north_of(row + 0.5));
    }
  return errors;
}

// By how much windows of the orthophoto are displaced against the exact colours, in cells along both axes.
std::vector<double> shifts_of(const TrueWall& wall, const fs::path& ortho) {
  constexpr int kHalf = 16, kReach = 2;
  const auto reader = GeoTiffReader::open(ortho).value();
  const MapGrid grid = reader.grid();
  const auto pixels = reader.read_byte(0, 0, grid.width, grid.height).value();
  FloatImage shown(grid.width, grid.height), exact(grid.width, grid.height);
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      shown.at(column, row) = pixels.at(column, row, 3) ? float(pixels.at(column, row, 1)) : -1;
      const auto hit = wall.hit(grid.east_of(column + 0.5), grid.north_of(row + 0.5));
      if (!hit) continue;
      const Scene& scene = wall.truth.scene;
      exact.at(column, row) = tone(scene.shaded(*hit, grid.cell_m, scene.in_sun(hit->point, hit->normal)).g);
    }
  std::vector<double> shifts;
  for (int row = kHalf + kReach; row + kHalf + kReach < grid.height; row += kHalf)
    for (int column = kHalf + kReach; column + kHalf + kReach < grid.width; column += kHalf) {
      const auto alike = [&](int dx, int dy) {
        double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
        for (int y = -kHalf; y < kHalf; ++y)
          for (int x = -kHalf; x < kHalf; ++x) {
            const double s = shown.at(column + x + dx, row + y + dy), e = exact.at(column + x, row + y);
            if (s < 0) return 0.0;
            n += 1, a += s, b += e, aa += s * s, bb += e * e, ab += s * e;
          }
        const double variances = (aa - a * a / n) * (bb - b * b / n);
        return variances > n * n * 100 ? (ab - a * b / n) / std::sqrt(variances) : 0.0;
      };
      int best_x = 0, best_y = 0;
      double best = 0.9;  // others show nothing that could be displaced
      for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx)
          if (const double one = alike(dx, dy); one > best) best = one, best_x = dx, best_y = dy;
      if (best == 0.9) continue;
      const auto peak = [](double before, double at, double after) {
        const double bend = before - 2 * at + after;
        return bend < 0 ? (before - after) / (2 * bend) : 0.0;
      };
      shifts.push_back(best_x + peak(alike(best_x - 1, best_y), best, alike(best_x + 1, best_y)));
      shifts.push_back(best_y + peak(alike(best_x, best_y - 1), best, alike(best_x, best_y + 1)));
    }
  return shifts;
}

double rms(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / double(values.size()));
}

TEST_F(FacadeFlow, TheWallIsMappedAsTheGroundIs) {
  const FramesRecord record = mapped(Step::kReport);
  ASSERT_FALSE(record.frames.empty());  // its neighbours' walls stand at its sides
  const FrameRecord& frame = record.frames[0];
  const TrueWall wall(*truth_, frame);
  EXPECT_LT(std::acos(std::min(1.0, wall.normal.dot(-Vector3d::UnitY()))), 0.005);
  EXPECT_NEAR(frame.width_m, 24, 1);
  EXPECT_NEAR(frame.height_m, 10.5, 0.5);
  EXPECT_LT(std::acos(std::min(1.0, wall.up.dot(Vector3d::UnitZ()))), 0.005);

  const double gsd_m = frame.ortho.cell_m;
  const Errors errors = errors_of(wall, file("plane1", "dsm.tif"), file("plane1", "dsm_sigma_relative.tif"),
                                  file("plane1", "dsm_state.tif"));
  ASSERT_GT(errors.of_distance.size(), 5'000u);
  EXPECT_LT(rms(errors.of_distance), 1.5 * gsd_m);
  const std::vector<double> around = errors.against_those_around();
  std::size_t within = 0;
  for (std::size_t i = 0; i < around.size(); ++i) within += std::abs(around[i]) < 1.96 * errors.sigma_m[i];
  EXPECT_GT(double(within) / double(around.size()), 0.7);  // of 0.95: matching takes poses as exact
  EXPECT_LT(double(within) / double(around.size()), 0.995);

  // What displaces the wall as a whole stands in the other sigmas, which hold what images and cameras add.
  double mean_m = 0;
  for (const double one : errors.of_distance) mean_m += one / double(errors.of_distance.size());
  const Errors whole =
      errors_of(wall, file("plane1", "dsm.tif"), file("plane1", "dsm_sigma.tif"), file("plane1", "dsm_state.tif"));
  double added = 0;
  for (std::size_t i = 0; i < whole.sigma_m.size(); ++i) {
    EXPECT_GT(whole.sigma_m[i], errors.sigma_m[i]);
    added += (std::pow(whole.sigma_m[i], 2) - std::pow(errors.sigma_m[i], 2)) / double(whole.sigma_m.size());
  }
  EXPECT_LT(std::abs(mean_m), 3 * std::sqrt(added));

  const std::vector<double> shifts = shifts_of(wall, file("plane1", "ortho.tif"));
  ASSERT_GT(shifts.size(), 100u);
  EXPECT_LT(rms(shifts), 1);
  for (const char* name : {"dsm_hillshade.tif", "dsm_state.tif", "dsm_count.tif", "dsm_sigma_relative.tif",
                           "ortho_source.tif", "seamlines.gpkg", "contours.gpkg", "contours.dxf", "elevation.pdf"})
    EXPECT_TRUE(is_there(file("plane1", name))) << name;
  EXPECT_EQ(GeoTiffReader::open(file("plane1", "ortho.tif"))->grid().wkt.find("GEOGCS"), std::string::npos);
  EXPECT_GT(frame.scale, 1);
  const std::string report = read_file(root_ / "mapped/report/report.html").value();
  EXPECT_NE(report.find("Planes of the object"), std::string::npos);
  const std::string list = read_file(root_ / "mapped/products/frames/frames.txt").value();
  EXPECT_NE(list.find("plane1"), std::string::npos);

  // What is there is not made again; another cell is.
  log_.lines.clear();
  mapped();
  EXPECT_TRUE(log_.steps_done().empty());
  const auto drawing = hash_of_file(file("plane1", "elevation.pdf")).value();
  settings_.frames.scale = 10;
  EXPECT_EQ(mapped().frames.at(0).scale, 10);
  EXPECT_EQ(log_.steps_done(), std::vector<std::string>{"frames"});
  EXPECT_NE(hash_of_file(file("plane1", "elevation.pdf")).value(), drawing);
  settings_.frames = {};
  mapped();
  EXPECT_EQ(hash_of_file(file("plane1", "elevation.pdf")).value(), drawing);

  // So does another option of the orthophoto, a lost file, and another form of the cloud; it is the same again.
  const auto surface = hash_of_file(file("plane1", "dsm.tif")).value();
  const auto orthophoto = hash_of_file(file("plane1", "ortho.tif")).value();
  settings_.ortho.feather_cells = 20;
  log_.lines.clear();
  mapped();
  EXPECT_EQ(log_.steps_done(), (std::vector<std::string>{"ortho", "frames"}));
  EXPECT_NE(hash_of_file(file("plane1", "ortho.tif")).value(), orthophoto);
  settings_.ortho = {};
  mapped();
  for (const char* lost : {"dsm_sigma.tif", "elevation.pdf", "../frames.txt"}) {
    fs::remove(file("plane1", lost));
    mapped();
    EXPECT_TRUE(is_there(file("plane1", lost))) << lost;
  }
  settings_.densify.cloud = LasForm::kLas;
  mapped();
  EXPECT_EQ(hash_of_file(file("plane1", "dsm.tif")).value(), surface);
  EXPECT_EQ(hash_of_file(file("plane1", "ortho.tif")).value(), orthophoto);
  ASSERT_TRUE(write_file(root_ / "mapped/products/frames/mine.txt", "notes"));
  ASSERT_TRUE(write_file(file("plane1", "mine.txt"), "notes"));

  // A plane that is given.
  const Vector3d corners[] = {{-4, 0, 1}, {4, 0, 1}, {4, 0, 6}, {-4, 0, 6}};
  std::string text = "# name easting northing height\n";
  for (const Vector3d& corner : corners) {
    const Vector3d on_map = truth_->frame.map_from_local(corner);
    text += "front " + std::to_string(on_map.x()) + " " + std::to_string(on_map.y()) + " " +
            std::to_string(on_map.z()) + "\n";
  }
  ASSERT_TRUE(write_file(root_ / "walls.txt", text));
  settings_.frames.frames = (root_ / "walls.txt").string();
  const FramesRecord given = mapped();
  ASSERT_EQ(given.frames.size(), 1u);
  EXPECT_EQ(given.frames[0].name, "front");
  EXPECT_NEAR(given.frames[0].width_m, 8 * 1.02, 0.01);
  EXPECT_NEAR(given.frames[0].height_m, 5 * 1.02, 0.01);
  EXPECT_TRUE(is_there(file("front", "ortho.tif")));
  EXPECT_FALSE(is_there(file("plane1", "ortho.tif")));
  for (const auto& [wrong, why] :
       {std::pair("a/b 1 2 3\na/b 2 3 4\na/b 1 3 9\n", "a name is of"),
        std::pair("a 1 2 3\na 2 3 4\na 3 4 5\n", "three points"), std::pair("a 1 2 3\na 2 3 x\n", "walls.txt")}) {
    ASSERT_TRUE(write_file(root_ / "walls.txt", wrong));
    auto project = create_project(root_ / "mapped", settings_, log_.run(2));
    const auto done = bring_up_to(*project, Step::kFrames);
    ASSERT_FALSE(done) << wrong;
    EXPECT_NE(done.error().message.find(why), std::string::npos) << done.error().message;
  }
  EXPECT_TRUE(is_there(file("front", "ortho.tif"))) << "a wrong file takes nothing away";
  settings_.frames.frames = (root_ / "nowhere.txt").string();
  const auto missing = create_project(root_ / "mapped", settings_, log_.run(2));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("nowhere.txt does not exist"), std::string::npos) << missing.error().message;
  settings_.frames.frames = FrameChoice::kMap;
  EXPECT_FALSE(mapped().looked_for);
  EXPECT_FALSE(is_there(file("front", "ortho.tif")));
  EXPECT_TRUE(is_there(root_ / "mapped/products/frames/mine.txt")) << "what people put there stays";
  EXPECT_TRUE(is_there(file("plane1", "mine.txt")));
}

}  // namespace
}  // namespace collinea
