// SPDX-License-Identifier: Apache-2.0
// Scans of film to a block.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_small_project.h"
#include "collinea/synthetic/film.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

FilmTruth written_film(const fs::path& folder) {
  SurveyOptions flight;
  flight.strips = 1;
  flight.images_per_strip = 2;
  flight.control_points = 3;
  flight.check_points = 1;
  flight.measurement_sigma_px = 0;
  FilmOptions film;
  film.scan_um = 100;
  // Lines of a cross are 1.2 pixels wide in such a scan: crosses are misread by 0.07 px, more than their sigmas say,
  // and the prior would take that for deformation.
  film.corner_mark = MarkKind::kDot;
  const auto done = simulate(flight, film, folder, {.threads = 2});
  EXPECT_TRUE(done) << done.error().message;
  return *make_film_survey(flight, film, {});
}

Settings settings_of(const fs::path& folder) {
  Settings settings;
  settings.photos = (folder / "images").string();
  settings.import.control = folder / "control.csv";
  settings.import.film.calibration = folder / "film_calibration.txt";
  return settings;
}

Result<Project> imported(const fs::path& project, const Settings& settings, Log& log) {
  COLLINEA_TRY(Project opened, create_project(project, settings, log.run()));
  COLLINEA_TRY(bring_up_to(opened, Step::kImport));
  return opened;
}

// Image coordinates of control, freed from film and lens, are those of the exact camera at the exact pose, but for
// refraction (which the test adds) and the local deformation that marks do not tell.
void expect_control_position(const Project& mapped, const FilmTruth& film) {
  const Block block = *mapped.store.read_block();
  const Camera& camera = block.cameras.begin()->second;
  EXPECT_NEAR(camera.focal_px(), 153.264 / 0.1, 1.5);
  EXPECT_FALSE(camera.prior.calibrate);
  ASSERT_GE(block.control_observations.size(), 6u);
  for (const ControlObservation& seen : block.control_observations) {
    const Eigen::Vector3d& mark = film.truth.marks_in_world.at(seen.point);
    const Image& image = film.truth.block.images.at(seen.image);
    const auto expected = project(camera, image.bend.bent(pose_of(film.truth.block, seen.image) * mark));
    ASSERT_TRUE(expected);
    // Three and a half of the 0.04 px of local deformation in each coordinate, and the reading of marks.
    EXPECT_LT((seen.pixel - *expected).norm(), 0.17) << seen.pixel.transpose();
  }
}

// Each scan has a camera of its own for the deformation between its marks, whose size all residuals of marks tell: 4 um
// to sqrt(1 / (2 x 20)) of it, by two scans with eight marks. A deformation of 0 leaves one camera to all.
void expect_own_cameras(const TestFolder& folder, const Settings& asked) {
  Settings settings = asked;
  Log log;
  const auto own = imported(folder / "own", settings, log);
  ASSERT_TRUE(own) << own.error().message;
  const Block block = *own->store.read_block();
  ASSERT_EQ(block.cameras.size(), 2u);
  for (const auto& [id, camera] : block.cameras) {
    ASSERT_TRUE(camera.prior.film);
    const FilmPrior& film = *camera.prior.film;
    EXPECT_EQ(film.marks.size(), 8u);
    EXPECT_EQ(film.sigma_px, block.cameras.begin()->second.prior.film->sigma_px);
    EXPECT_NEAR(film.sigma_px, 0.04, 3 * 0.04 / std::sqrt(2.0 * 20));
    EXPECT_FALSE(film.sigma_is_given || film.correlation_is_given);
    EXPECT_EQ(camera.additional, AdditionalSet::kNone);  // until the adjustment
  }
  settings.import.film_deformation_um = 6;
  settings.import.film_correlation_mm = 50;
  const Block given = *imported(folder / "given", settings, log)->store.read_block();
  const FilmPrior& film = *given.cameras.begin()->second.prior.film;
  EXPECT_NEAR(film.sigma_px, 0.06, 1e-4);
  EXPECT_NEAR(film.correlation_px, 500, 1);
  EXPECT_TRUE(film.sigma_is_given && film.correlation_is_given);
  settings.import.film_deformation_um = 0;
  EXPECT_EQ(imported(folder / "none", settings, log)->store.read_block()->cameras.size(), 1u);
}

TEST(FilmStep, ScansBecomeIdealImages) {
  const TestFolder folder;
  const FilmTruth film = written_film(folder / "block");
  fs::copy_file(folder / "block/images/IMG_0001.jpg", folder / "scan.jpg");
  ASSERT_TRUE(write_jpeg(folder / "block/images/IMG_0009.jpg", GreyImage(2320, 2320, 1, 100), 80));  // shows no marks
  Log log;
  const auto project = imported(folder / "project", settings_of(folder / "block"), log);
  ASSERT_TRUE(project) << project.error().message;
  expect_control_position(*project, film);
  expect_own_cameras(folder, settings_of(folder / "block"));

  const auto record = std::find_if(log.lines.begin(), log.lines.end(), [](const std::string& line) {
    return line.find("IMG_0009.jpg") != std::string::npos;
  });
  ASSERT_NE(record, log.lines.end());
  EXPECT_NE(record->find("of 8 marks fewer than three were found"), std::string::npos) << *record;
  const Block block = *project->store.read_block();
  for (const auto& [id, image] : block.images) {
    const auto ideal = read_grey(project->image_file(image));
    ASSERT_TRUE(ideal) << ideal.error().message;
    EXPECT_EQ(ideal->width, block.camera_of(id).width_px);
    // The scan has it all; some pixels of dust are black.
    EXPECT_LT(std::count(ideal->data.begin(), ideal->data.end(), 0), 100);
  }
  EXPECT_EQ(block.images.size(), 2u);
}

TEST(FilmStep, SaysWhatIsWrongWithACalibration) {
  const TestFolder folder;
  fs::create_directories(folder / "images");
  ASSERT_TRUE(write_jpeg(folder / "images/a.jpg", GreyImage(300, 300, 1, 100), 80));
  Settings settings;
  settings.photos = folder / "images";
  settings.import.film.calibration = folder / "calibration.txt";
  Log log;
  ASSERT_TRUE(write_file(folder / "calibration.txt", "principal_distance_mm 153\n"));
  auto none = imported(folder / "project", settings, log);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("no marks"), std::string::npos) << none.error().message;
  ASSERT_TRUE(write_file(folder / "calibration.txt",
                         "principal_distance_mm 153\nmark 1 -100 -100\nmark 2 100 100\nmark 3 100 -100\n"));
  none = imported(folder / "project", settings, log);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("no one shows the marks"), std::string::npos) << none.error().message;
  settings.import.film.calibration.reset();
  settings.import.film.pixel_um = 20;
  none = imported(folder / "project", settings, log);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().options.front().name, "film");
  settings.import.film.calibration = folder / "calibration.txt";
  settings.import.camera_params = "1000,1000,150,150";
  none = imported(folder / "project", settings, log);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("calibration"), std::string::npos) << none.error().message;
}

}  // namespace
}  // namespace collinea
