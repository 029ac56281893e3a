// SPDX-License-Identifier: Apache-2.0
// What masks and patches make of products, and that nothing stays of them once they are undone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/edit/make_edits.h"
#include "collinea/raster/geotiff.h"
#include "collinea/steps/test_small_project.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Steps = std::vector<std::string>;

class WorkFlow : public SmallProject {
 protected:
  void SetUp() override { map(Step::kOrtho); }

  static std::string edit(const fs::path& project, const std::vector<std::string>& words) {
    Journal journal(project);
    const std::vector<Edit> edits = {parse_edit(words).value()};
    const auto made = make_edits(project, journal, edits);
    return made ? "" : made.error().message;
  }
  static Steps redone(const fs::path& folder) {
    Log log;
    const auto done = bring(folder, settings(), log, Step::kOrtho);
    EXPECT_TRUE(done) << done.error().message;
    return log.steps_done();
  }
  static std::vector<std::uint64_t> products(const fs::path& folder) {
    std::vector<std::uint64_t> hashes;
    for (const char* file : {"cloud.copc.laz", "dsm.tif", "dtm.tif", "ortho.tif", "ortho_source.tif", "seamlines.gpkg"})
      hashes.push_back(hash_of_file(folder / "products" / file).value());
    return hashes;
  }
};

TEST_F(WorkFlow, MasksAndPatchesReachTheProductsAndUndoneLeaveNothing) {
  const fs::path folder = copy("edited");
  const auto before = products(folder);
  const auto store = ProjectStore::open(folder).value();
  const ImageId image = store.read_setup()->images.begin()->first;
  const std::string file = store.read_setup()->images.at(image).file;

  ASSERT_EQ(edit(folder, {"mask", "M", file, "100", "80", "250", "80", "250", "200", "100", "200"}), "");
  const Features all = store.read_features(image).value();
  EXPECT_EQ(redone(folder), (Steps{"detect", "match", "orient", "adjust", "densify", "surface", "terrain", "ortho"}));
  const Features left = store.read_features(image).value();
  std::size_t hidden = 0;
  for (const Keypoint& one : all.keypoints) hidden += one.x > 100 && one.x < 250 && one.y > 80 && one.y < 200;
  EXPECT_GT(hidden, 50u);
  EXPECT_EQ(left.keypoints.size(), all.keypoints.size() - hidden);
  EXPECT_NE(products(folder), before);
  ASSERT_EQ(edit(folder, {"undo"}), "");
  EXPECT_EQ(redone(folder).size(), 8u);
  EXPECT_EQ(products(folder), before);

  // A patch in the middle of the map, from the photograph that leads least of those that lead there.
  const auto source = GeoTiffReader::open(folder / "products/ortho_source.tif").value();
  const MapGrid grid = source.grid();
  const double e = grid.east_of(grid.width / 2), n = grid.north_of(grid.height / 2);
  std::vector<std::string> words = {"patch", "P", file};
  for (const auto& [east, north] : {std::pair(e - 4, n - 4), {e + 4, n - 4}, {e + 4, n + 4}, {e - 4, n + 4}})
    for (const double value : {east, north}) words.push_back(std::to_string(value));
  ASSERT_EQ(edit(folder, words), "");
  EXPECT_EQ(redone(folder), Steps{"ortho"});
  const auto now = products(folder);
  EXPECT_NE(now[4], before[4]);
  const auto patched = GeoTiffReader::open(folder / "products/ortho_source.tif").value();
  const auto cells = patched
                         .read_float(int(grid.column_of(e - 3.5)), int(grid.row_of(n + 3.5)), int(7 / grid.cell_m),
                                     int(7 / grid.cell_m))
                         .value();
  const auto of_image = std::count(cells.data.begin(), cells.data.end(), 1.0F);
  EXPECT_GT(double(of_image), 0.9 * double(cells.data.size()));  // the rest it does not see: behind houses
  ASSERT_EQ(edit(folder, {"undo"}), "");
  EXPECT_EQ(redone(folder), Steps{"ortho"});
  EXPECT_EQ(products(folder), before);
  // Made from nothing the patched one is the same.
  ASSERT_EQ(edit(folder, {"redo"}), "");
  fs::remove_all(folder / "ortho");
  EXPECT_EQ(redone(folder), Steps{"ortho"});
  EXPECT_EQ(products(folder), now);
}

// Words for a square about a place of the map.
std::vector<std::string> on_square(std::vector<std::string> words, double e, double n, double half_m) {
  for (const auto& [east, north] : {std::pair(-half_m, -half_m), {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}})
    for (const double value : {e + east, n + north}) words.push_back(std::to_string(value));
  return words;
}

struct CellsOfSquare {
  std::ptrdiff_t all, measured;
};
CellsOfSquare cells_of(const fs::path& state, double e, double n, double half_m) {
  const auto raster = GeoTiffReader::open(state).value();
  const MapGrid grid = raster.grid();
  const int side = int(2 * half_m / grid.cell_m);
  const auto cells = raster
                         .read_byte(int(std::ceil(grid.column_of(e - half_m))),
                                    int(std::ceil(grid.row_of(n + half_m))), side - 1, side - 1)
                         .value();
  return {std::ptrdiff_t(cells.data.size()), std::ranges::count(cells.data, std::uint8_t{1})};
}

TEST_F(WorkFlow, EditsOfTheCloudReachSurfaceAndTerrainAndUndoneLeaveNothing) {
  const fs::path folder = copy("edited_cloud"), products_folder = folder / "products";
  const auto before = products(folder);
  const MapGrid grid = GeoTiffReader::open(products_folder / "dsm.tif")->grid();
  const double e = grid.east_of(grid.width / 2), n = grid.north_of(grid.height / 2), half_m = 4;
  const fs::path surface = products_folder / "dsm_state.tif", terrain = products_folder / "dtm_state.tif";
  const double inner_m = half_m - 0.5;  // points beside a cell make it, too
  const CellsOfSquare at_first = cells_of(surface, e, n, inner_m);
  ASSERT_GT(at_first.measured, at_first.all / 2);

  // What is cut or called noise is measured no more, whether the cloud has classes already or not.
  for (const auto& words : {std::vector<std::string>{"cut", "-", "-"}, {"classify", "7", "-", "-"}}) {
    ASSERT_EQ(edit(folder, on_square(words, e, n, half_m)), "");
    EXPECT_EQ(redone(folder), (Steps{"surface", "terrain", "ortho"})) << words[0];
    EXPECT_EQ(cells_of(surface, e, n, inner_m).measured, 0) << words[0];
    EXPECT_EQ(products(folder)[0], before[0]) << "the file of the cloud stays";
    ASSERT_EQ(edit(folder, {"undo"}), "");
    EXPECT_EQ(redone(folder), (Steps{"surface", "terrain", "ortho"}));
    EXPECT_EQ(products(folder), before) << words[0];
  }

  // Classes that are no noise are for the terrain alone: all of a square is no ground, or all of it is.
  ASSERT_EQ(edit(folder, on_square({"classify", "6", "-", "-"}, e, n, half_m)), "");
  EXPECT_EQ(redone(folder), (Steps{"terrain", "ortho"}));
  EXPECT_EQ(cells_of(terrain, e, n, inner_m).measured, 0);
  EXPECT_EQ(cells_of(surface, e, n, inner_m).measured, at_first.measured);
  ASSERT_EQ(edit(folder, on_square({"classify", "2", "-", "-"}, e, n, half_m)), "");
  EXPECT_EQ(redone(folder), (Steps{"terrain", "ortho"}));
  EXPECT_EQ(cells_of(terrain, e, n, inner_m).measured, at_first.measured);
  for (int i = 0; i < 2; ++i) ASSERT_EQ(edit(folder, {"undo"}), "");
  redone(folder);
  EXPECT_EQ(products(folder), before);
}

}  // namespace
}  // namespace collinea
