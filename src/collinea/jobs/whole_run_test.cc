// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/project.h"
#include "collinea/report/assessment_text.h"
#include "collinea/steps/flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/jobs/assess.h"
#include "collinea/jobs/export.h"
#include "collinea/jobs/info.h"
#include "collinea/jobs/verify_project.h"
#include "collinea/ortho/ortho_tile.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/test_small_project.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return std::move(bytes).str();
}

const std::vector<std::string> kProducts = {
    "cloud.copc.laz",   "dsm.tif",        "dsm_sigma.tif",          "dsm_state.tif",          "dtm.tif",
    "dtm_sigma.tif",    "dtm_state.tif",  "contours.gpkg",          "contours.dxf",           "ortho.tif",
    "ortho_source.tif", "seamlines.gpkg", "dsm_sigma_relative.tif", "dtm_sigma_relative.tif", "dsm_hillshade.tif",
    "dtm_hillshade.tif"};

class WholeProject : public SmallProject {
 public:
  void SetUp() override { map(Step::kReport); }

  void every_image_is_oriented_and_every_product_there();
  void projection_centres_are_where_they_were();
  void info_tells_what_is_known();
  void export_writes_every_format_and_refuses_others();
  void a_cloud_of_any_form_gives_the_same_surface();
  void what_is_up_to_date_is_not_done_again();
  void a_lost_cloud_comes_back_with_its_classes();
  void a_changed_option_redoes_its_step_and_what_follows();
  void another_adjustment_reaches_every_product();
  void options_of_fusion_leave_depth_maps_alone_and_others_do_not();
  void images_that_were_moved_are_only_read_again();
  void what_stands_in_the_way_of_a_product_is_named();
  void a_changed_control_file_leaves_matching_alone();
  void a_missing_product_is_made_again();
  void given_seamlines_are_followed_and_redo_the_orthophoto_when_they_change();
  void a_depth_map_that_cannot_be_kept_ends_the_step_and_the_next_run_makes_the_same();
  void stopped_in_every_step_and_continued_on_two_threads_it_is_the_same_to_the_byte();
  void files_left_half_written_are_swept_and_others_are_not();
  void a_second_program_is_kept_out_but_may_look();
  void an_image_that_breaks_off_is_named_and_the_rest_goes_on();
  void what_changed_after_the_report_is_found();
};

void WholeProject::every_image_is_oriented_and_every_product_there() {
  const auto project = open_project(root_ / "mapped", {});
  ASSERT_TRUE(project) << project.error().message;
  const auto block = project->store.read_block();
  ASSERT_TRUE(block);
  EXPECT_EQ(count_oriented(*block), 6u);
  for (const std::string& product : kProducts)
    EXPECT_GT(fs::file_size(root_ / "mapped/products" / product), 500u) << product;
  EXPECT_GT(fs::file_size(root_ / "mapped/report/report.html"), 10'000u);
  auto cloud = LasReader::open(project->cloud());
  ASSERT_TRUE(cloud);
  const auto points = cloud->read(10'000'000);
  ASSERT_TRUE(points);
  const auto of_class = [&](int number) {
    return std::count_if(points->begin(), points->end(),
                         [&](const CloudPoint& p) { return p.classification == number; });
  };
  EXPECT_EQ(of_class(1) + of_class(2), std::ptrdiff_t(points->size()));
  EXPECT_GT(of_class(2), of_class(1));  // more ground than houses and trees
}

void WholeProject::projection_centres_are_where_they_were() {
  const auto project = open_project(root_ / "mapped", {});
  const auto truth = read_truth(root_);
  ASSERT_TRUE(project && truth);
  const Block block = project->store.read_block().value();
  const auto frame = world_frame(block.georeference.value());
  ASSERT_TRUE(frame);
  for (const auto& [id, pose] : oriented_images(block)) {
    const std::string& file = block.images.at(id).file;
    EXPECT_LT((frame->map_from_local(centre_of(pose)) - truth->centre_in_map.at(file)).norm(), 2.0)
        << file;  // ten pixels
  }
}

void WholeProject::info_tells_what_is_known() {
  const auto project = open_project(root_ / "mapped", {});
  ASSERT_TRUE(project);
  const auto info = project_info(project->store);
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->setup.images.size(), 6u);
  ASSERT_NE(info->orientation(), nullptr);
  const OrientationRecord& oriented = *info->orientation();
  EXPECT_EQ(oriented.images, 6u);
  EXPECT_EQ(oriented.oriented, 6u);
  EXPECT_GT(oriented.tie_points, 100u);
  EXPECT_GT(oriented.observations, oriented.tie_points);
  EXPECT_LT(oriented.mean_reprojection_px, 1.0);
  ASSERT_TRUE(oriented.gsd_m());
  EXPECT_NEAR(*oriented.gsd_m(), 0.2, 0.04);
  ASSERT_NE(info->adjustment(), nullptr);
  const AdjustmentRecord& adjusted = *info->adjustment();
  EXPECT_TRUE(adjusted.control_rmse_m);
  EXPECT_TRUE(adjusted.check_rmse_m);
  ASSERT_FALSE(adjusted.control.empty());
  for (const ControlDifference& point : adjusted.control)
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GT(point.difference_sigma_m[axis], 0) << point.point.value;
      EXPECT_LT(point.difference_sigma_m[axis], 1) << point.point.value;
    }
  ASSERT_EQ(info->steps.size(), 11u);
  EXPECT_EQ(info->steps.front().name(), "import");
}

void WholeProject::export_writes_every_format_and_refuses_others() {
  auto project = open_project(root_ / "mapped", {});
  ASSERT_TRUE(project);
  for (const ExportFormat format : {ExportFormat::kColmap, ExportFormat::kOpk, ExportFormat::kTiePoints, ExportFormat::kLas,
                                    ExportFormat::kLaz, ExportFormat::kCopc})
    ASSERT_TRUE(export_block(*project, root_ / "export", {.format = format})) << word_of(format);
  for (const char* file : {"cameras.txt", "images.txt", "points3D.txt", "cameras.bin", "orientation.opk",
                           "tie_points.ply", "cloud.laz", "cloud.copc.laz"})
    EXPECT_TRUE(fs::exists(root_ / "export" / file)) << file;
  EXPECT_EQ(LasReader::open(root_ / "export/cloud.las")->header().points,
            LasReader::open(project->cloud())->header().points);
  // In tiles: every point in one of them, and within it.
  ASSERT_TRUE(export_block(*project, root_ / "tiles", {.format = ExportFormat::kLaz, .tile_m = 40}));
  std::uint64_t in_tiles = 0, files = 0;
  for (const auto& entry : fs::directory_iterator(root_ / "tiles")) {
    if (entry.path().extension() != ".laz") continue;
    const auto tile = LasReader::open(entry.path());
    ASSERT_TRUE(tile) << entry.path();
    const LasHeader& header = tile->header();
    for (int axis = 0; axis < 2; ++axis)
      EXPECT_EQ(std::floor((header.lowest[axis] + 1e-6) / 40), std::floor((header.highest[axis] + 1e-6) / 40));
    EXPECT_NE(bytes_of(root_ / "tiles/tiles.csv").find(entry.path().filename().string()), std::string::npos);
    in_tiles += header.points;
    ++files;
  }
  EXPECT_GT(files, 3u);
  EXPECT_EQ(in_tiles, LasReader::open(root_ / "export/cloud.las")->header().points);
  EXPECT_FALSE(export_block(*project, root_ / "tiles", {.format = ExportFormat::kLaz, .tile_m = -1}));
  EXPECT_FALSE(export_block(*project, root_ / "tiles", {.format = ExportFormat::kOpk, .tile_m = 40}));
}

void WholeProject::a_cloud_of_any_form_gives_the_same_surface() {
  fs::copy(root_ / "mapped", root_ / "other_form", fs::copy_options::recursive);
  const fs::path products = root_ / "other_form/products";
  fs::copy(products / "dsm.tif", root_ / "truth/dsm.tif");  // a truth like any other, for `assessed`
  const auto assessed = [](const fs::path& project) {
    return open_project(project, {})
        .and_then([](const Project& p) { return assess_project(p, root_).map(assessment_text); })
        .value();
  };
  std::map<LasForm, std::uintmax_t> sizes = {{LasForm::kCopc, fs::file_size(root_ / "mapped/products/cloud.copc.laz")}};
  for (const auto& [form, earlier] :
       {std::pair(LasForm::kLas, LasForm::kCopc), std::pair(LasForm::kLaz, LasForm::kLas)}) {
    Settings changed = settings();
    changed.densify.cloud = form;
    changed.densify.ply = form == LasForm::kLas;
    Log log;
    ASSERT_TRUE(bring(root_ / "other_form", changed, log, Step::kTerrain));
    EXPECT_FALSE(fs::exists(products / las_file_name("cloud", earlier)));  // that of the earlier setting
    sizes[form] = fs::file_size(products / las_file_name("cloud", form));
    EXPECT_EQ(fs::exists(products / "cloud.ply"), changed.densify.ply);
    for (const char* product : {"dsm.tif", "dtm.tif"})
      EXPECT_TRUE(bytes_of(products / product) == bytes_of(root_ / "mapped/products" / product)) << word_of(form);
    EXPECT_EQ(assessed(root_ / "other_form"), assessed(root_ / "mapped")) << word_of(form);
    if (!changed.densify.ply) continue;
    const auto ply = read_ply(products / "cloud.ply");
    ASSERT_TRUE(ply) << ply.error().message;
    EXPECT_EQ(ply->size(), LasReader::open(products / "cloud.las")->header().points);
    EXPECT_TRUE(std::all_of(ply->begin(), ply->end(), [](const CloudPoint& p) { return p.normal.norm() > 0.99F; }));
  }
  EXPECT_LT(5 * sizes[LasForm::kCopc], sizes[LasForm::kLas]);
  EXPECT_LT(5 * sizes[LasForm::kLaz], sizes[LasForm::kLas]);
  EXPECT_NE(assessed(root_ / "mapped").find("cloud, sigma"), std::string::npos);
  fs::remove(root_ / "truth/dsm.tif");
  fs::remove_all(root_ / "other_form");
}

void WholeProject::what_is_up_to_date_is_not_done_again() {
  Log log;
  ASSERT_TRUE(bring(root_ / "mapped", settings(), log, Step::kReport));
  EXPECT_TRUE(log.steps_done().empty());
}

void WholeProject::a_lost_cloud_comes_back_with_its_classes() {
  const fs::path project = copy("lost");
  fs::remove(project / "products/cloud.copc.laz");
  Log log;
  ASSERT_TRUE(bring(project, settings(), log, Step::kReport));
  EXPECT_EQ(log.steps_done(), (std::vector<std::string>{"densify", "terrain"}));
  EXPECT_TRUE(bytes_of(project / "products/cloud.copc.laz") == bytes_of(root_ / "mapped/products/cloud.copc.laz"));
}

void WholeProject::a_changed_option_redoes_its_step_and_what_follows() {
  Settings changed = settings();
  changed.surface.cell_m = 1;
  Log log;
  ASSERT_TRUE(bring(copy("option"), changed, log, Step::kReport));
  EXPECT_EQ(log.steps_done(), (std::vector<std::string>{"surface", "terrain", "ortho", "report"}));
}

std::map<fs::path, fs::file_time_type> times_of_depth_maps(const fs::path& project) {
  std::map<fs::path, fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(project / "depth"))
    if (entry.path().extension() == ".tif") times[entry.path()] = fs::last_write_time(entry.path());
  return times;
}

// What is signed is what is delivered: another adjustment gives another cloud, surface and orthophoto, with their
// sigmas, and the first one again gives the first ones.
void WholeProject::another_adjustment_reaches_every_product() {
  const fs::path project = copy("adjusted");
  Settings changed = settings();
  changed.adjust.use_control = false;
  Log log;
  ASSERT_TRUE(bring(project, changed, log, Step::kReport));
  EXPECT_EQ(log.steps_done(),
            (std::vector<std::string>{"adjust", "densify", "surface", "terrain", "ortho", "frames", "report"}));
  const std::vector<std::string> products = {"cloud.copc.laz", "dsm.tif",       "dsm_sigma.tif",
                                             "dtm.tif",        "dtm_sigma.tif", "ortho.tif"};
  for (const std::string& product : products)
    EXPECT_FALSE(bytes_of(project / "products" / product) == bytes_of(root_ / "mapped/products" / product)) << product;
  ASSERT_TRUE(bring(project, settings(), log, Step::kReport));
  for (const std::string& product : products)
    EXPECT_TRUE(bytes_of(project / "products" / product) == bytes_of(root_ / "mapped/products" / product)) << product;
}

void WholeProject::options_of_fusion_leave_depth_maps_alone_and_others_do_not() {
  Settings changed = settings();
  changed.densify.max_sigmas = 3;
  changed.densify.min_images = 2;
  changed.densify.memory_mb = 700;
  const fs::path kept = copy("fusion"), anew = copy("fusion_anew");
  fs::remove_all(anew / "depth");
  const auto times = times_of_depth_maps(kept);
  Log log;
  ASSERT_TRUE(bring(kept, changed, log, Step::kDensify));
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"densify"});
  EXPECT_TRUE(times_of_depth_maps(kept) == times);
  ASSERT_TRUE(bring(anew, changed, log, Step::kDensify));
  EXPECT_TRUE(bytes_of(kept / "products/cloud.copc.laz") == bytes_of(anew / "products/cloud.copc.laz"));
  EXPECT_FALSE(bytes_of(kept / "products/cloud.copc.laz") == bytes_of(root_ / "mapped/products/cloud.copc.laz"));
  changed.densify.min_correlation = 0.6;
  ASSERT_TRUE(bring(kept, changed, log, Step::kDensify));
  const auto later = times_of_depth_maps(kept);
  for (const auto& [path, time] : times) EXPECT_TRUE(!later.contains(path) || later.at(path) > time) << path;
}

void WholeProject::images_that_were_moved_are_only_read_again() {
  Settings changed = settings();
  changed.photos = (root_ / "moved").string();
  fs::copy(root_ / "images", root_ / "moved");
  Log log;
  ASSERT_TRUE(bring(copy("with_moved"), changed, log, Step::kReport));
  EXPECT_EQ(log.steps_done(), (std::vector<std::string>{"import", "report"}));
}

void WholeProject::what_stands_in_the_way_of_a_product_is_named() {
  const fs::path project = copy("in_the_way");
  fs::remove(project / "products/cloud.copc.laz");
  fs::create_directories(project / "products/cloud.laz/folder");
  Log log;
  const auto done = bring(project, settings(), log, Step::kDensify);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kBadInput);
  EXPECT_NE(done.error().message.find("cloud.laz"), std::string::npos) << done.error().message;
}

void WholeProject::a_changed_control_file_leaves_matching_alone() {
  Settings changed = settings();
  changed.import.control = (root_ / "other_control.csv").string();
  ASSERT_TRUE(write_file(*changed.import.control, bytes_of(root_ / "control.csv") + "# looked over\n"));
  Log log;
  const fs::path project = copy("control");
  ASSERT_TRUE(bring(project, changed, log, Step::kOrient));
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"import"});
  log.lines.clear();
  changed.import.control_sigma_px = 0.7;
  std::string without_sigmas;  // of the measurements: the last of seven fields
  std::istringstream rows(bytes_of(root_ / "control.csv"));
  for (std::string row; std::getline(rows, row);)
    without_sigmas += (row.starts_with("image") ? row.substr(0, row.rfind(',')) : row) + "\n";
  ASSERT_TRUE(write_file(*changed.import.control, without_sigmas));
  ASSERT_TRUE(bring(project, changed, log, Step::kOrient));
  EXPECT_EQ(log.steps_done(), (std::vector<std::string>{"import", "orient"}));
}

void WholeProject::a_missing_product_is_made_again() {
  const fs::path project = copy("missing");
  const std::string before = bytes_of(project / "products/ortho.tif");
  fs::remove(project / "products/ortho.tif");
  Log log;
  ASSERT_TRUE(bring(project, settings(), log, Step::kReport));
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"ortho"});
  EXPECT_EQ(bytes_of(project / "products/ortho.tif"), before);
}

void WholeProject::given_seamlines_are_followed_and_redo_the_orthophoto_when_they_change() {
  const fs::path project = copy("seamlines"), mine = project / "mine.gpkg";
  const std::string image = bytes_of(project / "products/ortho.tif");
  fs::copy_file(project / "products/seamlines.gpkg", mine);
  Settings changed = settings();
  Log log;
  // A file that holds none is refused at once and does not stay in the project.
  changed.ortho.seamlines = (project / "project.json").string();
  ASSERT_FALSE(bring(project, changed, log, Step::kOrtho));
  ASSERT_TRUE(read_settings(project));
  EXPECT_FALSE(read_settings(project)->ortho.seamlines);
  changed.ortho.seamlines = mine.string();
  ASSERT_TRUE(bring(project, changed, log, Step::kOrtho));
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"ortho"});
  EXPECT_EQ(bytes_of(project / "products/ortho.tif"), image);
  // No polygon at all: every cell goes to its cheapest view.
  ASSERT_TRUE(write_geopackage(mine, {{"seamlines", VectorKind::kPolygon, {{"photo", VectorType::kText}}, {}, true}},
                               GeoTiffReader::open(project / "products/dsm.tif")->grid().wkt));
  const auto done = bring(project, changed, log = {}, Step::kOrtho);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"ortho"});
  EXPECT_NE(bytes_of(project / "products/ortho.tif"), image);
  fs::remove(mine);
  const auto missing = bring(project, changed, log, Step::kOrtho);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("mine.gpkg does not exist"), std::string::npos) << missing.error().message;
}

void WholeProject::a_depth_map_that_cannot_be_kept_ends_the_step_and_the_next_run_makes_the_same() {
  const fs::path project = copy("full_disk");
  fs::remove(project / "products/cloud.copc.laz");
  const auto overviews = [&] {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(project / "depth/overview"))
      if (entry.path().string().ends_with(".depth.tif")) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  };
  const std::vector<fs::path> before = overviews();
  ASSERT_EQ(before.size(), 6u);
  for (const fs::path& path : before) fs::remove(path);
  const fs::path overview = before.front();
  const std::string name = overview.string();
  const fs::path in_the_way = name.substr(0, name.size() - std::string(".depth.tif").size()) + ".sigma.tif";
  fs::remove(in_the_way);
  fs::create_directories(in_the_way / "folder");
  Log log;
  const auto failed = bring(project, settings(), log, Step::kDensify);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, Errc::kBadInput);
  EXPECT_NE(failed.error().message.find(in_the_way.filename().string()), std::string::npos) << failed.error().message;
  EXPECT_TRUE(overviews().empty());  // no others were tried
  fs::remove_all(in_the_way);
  const auto done = bring(project, settings(), log, Step::kTerrain);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(bytes_of(project / "products/cloud.copc.laz") == bytes_of(root_ / "mapped/products/cloud.copc.laz"));
}

void WholeProject::stopped_in_every_step_and_continued_on_two_threads_it_is_the_same_to_the_byte() {
  const fs::path folder = root_ / "stopped";
  for (const Word<Step>& one : kStepWords) {
    const std::string step(one.word);
    std::stop_source stop;
    Log log;
    collinea::Run run = log.run(2);  // not the one of the test's base class
    run.stop = stop.get_token();
    run.progress = [&](std::string_view stage, double) {
      if (stage.starts_with(step)) stop.request_stop();
    };
    auto project = create_project(folder, settings(), run);
    ASSERT_TRUE(project) << project.error().message;
    const auto stopped = bring_up_to(*project, Step::kReport);
    ASSERT_FALSE(stopped) << step;
    EXPECT_EQ(stopped.error().code, Errc::kCancelled) << step << ": " << stopped.error().message;
    EXPECT_NE(stopped.error().message.find("goes on from here"), std::string::npos) << stopped.error().message;
    EXPECT_FALSE(project->store.read_step(step).value()) << step;
  }
  Log log;
  ASSERT_TRUE(bring(folder, settings(), log, Step::kReport, 2));
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"report"});
  for (const std::string& product : kProducts)
    EXPECT_TRUE(bytes_of(folder / "products" / product) == bytes_of(root_ / "mapped/products" / product)) << product;
}

void WholeProject::files_left_half_written_are_swept_and_others_are_not() {
  const fs::path project = copy("swept");
  for (const char* file :
       {"products/cloud.copc.laz.part123", "products/contours.part.gpkg", "products/contours.part.gpkg-journal",
        "depth/a.tif.part", "depth/overview/b.tif.part", "scratch/points_1_1.bin"}) {
    fs::create_directories((project / file).parent_path());
    ASSERT_TRUE(write_file(project / file, "half"));
  }
  ASSERT_TRUE(write_file(project / "download.part", "the user's own"));
  Log log;
  ASSERT_TRUE(bring(project, settings(), log, Step::kReport));
  EXPECT_TRUE(log.steps_done().empty());
  for (const char* file :
       {"products/cloud.copc.laz.part123", "products/contours.part.gpkg", "products/contours.part.gpkg-journal",
        "depth/a.tif.part", "depth/overview/b.tif.part", "scratch"})
    EXPECT_FALSE(fs::exists(project / file)) << file;
  EXPECT_TRUE(fs::exists(project / "download.part"));
}

void WholeProject::a_second_program_is_kept_out_but_may_look() {
  Log log;
  const auto first = create_project(root_ / "mapped", settings(), log.run());
  ASSERT_TRUE(first);
  const auto second = create_project(root_ / "mapped", settings(), log.run());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::kBadInput);
  EXPECT_NE(second.error().message.find("another collinea"), std::string::npos) << second.error().message;
  EXPECT_TRUE(open_project(root_ / "mapped", {}));
}

void WholeProject::an_image_that_breaks_off_is_named_and_the_rest_goes_on() {
  const fs::path photos = root_ / "with_broken";
  fs::copy(root_ / "images", photos);
  const fs::path broken = photos / "IMG_0002.jpg";
  fs::resize_file(broken, fs::file_size(broken) * 2 / 3);
  Settings changed = settings();
  changed.photos = photos.string();
  changed.pairs.exhaustive_below = 10;  // all with all
  Log log;
  const auto done = bring(root_ / "without_broken", changed, log, Step::kMatch);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(std::any_of(log.lines.begin(), log.lines.end(), [](const std::string& line) {
    return line.starts_with("skipped IMG_0002.jpg: ") && line.find("incomplete") != std::string::npos;
  }));
}

TEST_F(WholeProject, IsMappedChangedStoppedAndContinuedAsPromised) {
  every_image_is_oriented_and_every_product_there();
  projection_centres_are_where_they_were();
  info_tells_what_is_known();
  export_writes_every_format_and_refuses_others();
  a_cloud_of_any_form_gives_the_same_surface();
  what_is_up_to_date_is_not_done_again();
  a_lost_cloud_comes_back_with_its_classes();
  a_changed_option_redoes_its_step_and_what_follows();
  another_adjustment_reaches_every_product();
  options_of_fusion_leave_depth_maps_alone_and_others_do_not();
  images_that_were_moved_are_only_read_again();
  what_stands_in_the_way_of_a_product_is_named();
  a_changed_control_file_leaves_matching_alone();
  a_missing_product_is_made_again();
  given_seamlines_are_followed_and_redo_the_orthophoto_when_they_change();
  a_depth_map_that_cannot_be_kept_ends_the_step_and_the_next_run_makes_the_same();
  stopped_in_every_step_and_continued_on_two_threads_it_is_the_same_to_the_byte();
  files_left_half_written_are_swept_and_others_are_not();
  a_second_program_is_kept_out_but_may_look();
  an_image_that_breaks_off_is_named_and_the_rest_goes_on();
  what_changed_after_the_report_is_found();
}

void flip_byte(const fs::path& path, std::uint64_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(std::streamoff(at));
  const char byte = char(file.get() ^ 1);
  file.seekp(std::streamoff(at));
  file.put(byte);
}

// Names and states of the files that are not as they were.
std::map<std::string, FileState> differing(const fs::path& project, const VerifyProjectOptions& options = {}) {
  const auto verified = verify_project(project, options, {});
  EXPECT_TRUE(verified) << verified.error().message;
  std::map<std::string, FileState> states;
  if (!verified) return states;
  for (const auto& [file, state] : verified->files)
    if (state != FileState::kSame) states[file.name] = state;
  EXPECT_EQ(verified->agrees(), states.empty());
  return states;
}

void WholeProject::what_changed_after_the_report_is_found() {
  const fs::path project = copy("signed"), photos = root_ / "signed_images";
  fs::copy(root_ / "images", photos, fs::copy_options::recursive);
  EXPECT_TRUE(differing(project).empty());
  const auto all = verify_project(project, {}, {});
  ASSERT_TRUE(all);
  for (const FileRole role : {FileRole::kImage, FileRole::kProduct, FileRole::kReport})
    EXPECT_TRUE(std::any_of(all->files.begin(), all->files.end(), [&](const auto& one) {
      return one.file.role == role;
    })) << word_of(role);
  flip_byte(project / "products/ortho.tif", fs::file_size(project / "products/ortho.tif") / 2);
  const auto image = fs::directory_iterator(photos)->path();
  flip_byte(image, fs::file_size(image) - 1);
  fs::remove(project / "products/dsm.tif");
  flip_byte(project / "report/report.html", 5000);
  const std::map<std::string, FileState> products = {{"products/dsm.tif", FileState::kMissing},
                                                     {"products/ortho.tif", FileState::kChanged},
                                                     {"report/report.html", FileState::kChanged}};
  EXPECT_EQ(differing(project), products);
  EXPECT_EQ(differing(project, {.photos = root_ / "nowhere", .inputs = false}), products);
  auto with_image = products;
  with_image[image.filename().string()] = FileState::kChanged;
  EXPECT_EQ(differing(project, {.photos = photos}), with_image);
  fs::remove(project / kHashesFile);
  EXPECT_EQ(verify_project(project, {}, {}).error().code, Errc::kNotFound);
}

TEST(Project, ADamagedDatabaseIsNamedWithTheWayOut) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "project.json", R"({"photos": "/p"})"));
  ASSERT_TRUE(write_file(folder / "block.db", std::string(5000, 'x')));
  const auto project = open_project(folder / "", {});
  ASSERT_FALSE(project);
  EXPECT_EQ(project.error().code, Errc::kBadFormat);
  EXPECT_NE(project.error().message.find("block.db"), std::string::npos);
  EXPECT_NE(project.error().message.find("remove that file"), std::string::npos) << project.error().message;
}

TEST(Project, ImagesThatAreNoFolderAreAnErrorBeforeAnythingIsMade) {
  const TestFolder folder;
  Settings settings;
  settings.photos = (folder / "nothing").string();
  const auto project = create_project(folder / "project", settings, {});
  ASSERT_FALSE(project);
  EXPECT_EQ(project.error().code, Errc::kNotFound);
  EXPECT_FALSE(fs::exists(folder / "project"));
}

TEST(Project, AnOrientationThatIsNotThereIsAnErrorBeforeAnythingIsMade) {
  const TestFolder folder;
  Settings settings;
  settings.photos = (folder / "").string();
  for (const std::string& path : {(folder / "nowhere").string(), "/" + std::string(5000, 'x')}) {
    settings.orient.orientation = path;
    const auto project = create_project(folder / "project", settings, {});
    ASSERT_FALSE(project);
    EXPECT_NE(project.error().message.find(path), std::string::npos) << project.error().message;
  }
  EXPECT_FALSE(fs::exists(folder / "project"));
}

TEST(Project, AStepThatDoesNotExistIsNamedBesideThoseThatDo) {
  const auto known = step_named("orthophoto");
  ASSERT_FALSE(known);
  EXPECT_NE(known.error().message.find("surface, terrain, ortho, frames, report"), std::string::npos) << known.error().message;
  for (const Word<Step>& step : kStepWords) EXPECT_EQ(step_named(step.word), step.value) << step.word;
}

}  // namespace
}  // namespace collinea
