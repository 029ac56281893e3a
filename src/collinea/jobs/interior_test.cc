// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/interior.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "collinea/base/file.h"
#include "collinea/base/source_tree.h"
#include "collinea/base/test_folder.h"
#include "collinea/feature/scan_for_tests.h"
#include "collinea/io/film_calibration_file.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// The camera of the pair 27/28 of film_pairs, from its certificate.
constexpr const char* kCamera =
    "camera RC30\nprincipal_distance_mm 153.358\nprincipal_point_mm -0.006 0.006\n"
    "radial_correction 0.8878e-4 -0.1528e-7 0.5256e-12\ndecentring_correction 0.1346e-6 0.1224e-7\n"
    "mark 1 -105.997 -105.995\nmark 2 106.004 106.008\nmark 3 -106.000 106.009\nmark 4 106.012 -105.995\n"
    "mark 5 -112.000 0.007\nmark 6 112.006 0.007\nmark 7 0.005 112.007\nmark 8 0.002 -111.998\n";

// The first reader's marks of image 27.
constexpr const char* kMarks =
    "image mark x[px] y[px]\n27 1 1347 19285\n27 2 19161 1470\n27 3 1345 1471\n27 4 19163 19283\n"
    "27 5 843 10379\n27 6 19666 10376\n27 7 10254 966\n27 8 10254 19789\n";

class Interior : public ::testing::Test {
 protected:
  fs::path file(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  InteriorOptions options() { return {.calibration = file("camera.txt", kCamera)}; }
  std::string message(const std::string& marks, const InteriorOptions& asked) {
    const auto done = interior_orientation(marks.empty() ? fs::path() : file("marks.txt", marks), asked, {});
    return done ? "" : done.error().message;
  }
  TestFolder folder_;
};

TEST_F(Interior, ARealPhotographIsOrientedToAPixel) {
  auto asked = options();
  asked.points = file("points.txt", "point x[px] y[px]\n100 9447 2295\n");
  asked.out = folder_ / "out";
  const auto done = interior_orientation(file("marks.txt", kMarks), asked, {});
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_EQ(done->images.size(), 1u);
  const FilmFit& fit = done->images[0].orientation.fit;
  EXPECT_LT(fit.sigma0, 1.2);
  EXPECT_FALSE(fit.transformation.is_mirrored);
  EXPECT_NEAR(done->images[0].deformation->pixel_x_um.value, 11.9, 0.05);
  ASSERT_EQ(done->points.size(), 1u);
  EXPECT_NEAR(done->points[0].film_mm.x(), -9.6, 0.1);  // left of the middle and far above it
  EXPECT_NEAR(done->points[0].film_mm.y(), 96.2, 0.2);
  EXPECT_LT((done->points[0].corrected_mm - done->points[0].film_mm - Eigen::Vector2d(0.006, -0.006)).norm(), 0.01);
  const std::string text = interior_text(*done);
  for (const char* words : {"image 27", "sigma0", "deformation", "against"})
    EXPECT_NE(text.find(words), std::string::npos) << text;
  for (const char* name : {"interior.txt", "residuals.txt", "points.txt"})
    EXPECT_TRUE(read_text_table(folder_ / "out" / name)) << name;
}

// The side marks of the same photograph as edges of the frame: they lack the coordinate along their side, which may
// then be read anywhere. 8 + 4 equations; a rigid transformation by the four alone.
TEST_F(Interior, SideMarksOfOneCoordinate) {
  std::string camera = kCamera, marks = kMarks;
  const auto replace = [](std::string& text, const std::string& what, const std::string& by) {
    ASSERT_NE(text.find(what), std::string::npos) << what;
    text.replace(text.find(what), what.size(), by);
  };
  replace(camera, "-112.000 0.007", "-112.000 (0)");
  replace(camera, "112.006 0.007", "112.006 (0)");
  replace(camera, "0.005 112.007", "(0) 112.007");
  replace(camera, "0.002 -111.998", "(0) -111.998");
  replace(marks, "843 10379", "843 10579");
  replace(marks, "19666 10376", "19666 10276");
  replace(marks, "10254 966", "10104 966");
  InteriorOptions asked{.calibration = file("camera.txt", camera)};
  asked.model = FilmModel::kAffine;
  asked.out = folder_ / "out";
  const auto done = interior_orientation(file("marks.txt", marks), asked, {});
  ASSERT_TRUE(done) << done.error().message;
  const FilmFit& fit = done->images[0].orientation.fit;
  EXPECT_EQ(fit.redundancy, 12 - 6);
  EXPECT_LT(fit.sigma0, 1.2);  // as with both coordinates read rightly
  for (const FilmMarkResidual& mark : fit.marks) EXPECT_TRUE(mark.is_used) << mark.name;
  const auto table = read_text_table(folder_ / "out/residuals.txt");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ((*table->words("coordinates"))[0], "xy");
  EXPECT_EQ((*table->words("coordinates"))[4], "x");
  EXPECT_EQ((*table->words("coordinates"))[6], "y");
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// Every mark of every type with its shape: bars of crosses, discs of dots, and those of the kinds below.
TEST_F(Interior, TheGalleryIsDrawn) {
  InteriorOptions options;
  options.drawing = folder_ / "all.svg";
  const auto all = interior_orientation({}, options, {});
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_TRUE(all->images.empty());
  const std::string drawn = read_file(*options.drawing).value_or("");
  for (const auto& type : kFilmCameraTypeWords)
    EXPECT_NE(drawn.find(">" + std::string(type.word) + ", nominal<"), std::string::npos);
  EXPECT_EQ(count_of(drawn, "transform='rotate(90)'"), 4u + 8 + 8 + 1);  // rc8, rc10, rc30, the kind
  EXPECT_EQ(count_of(drawn, "<circle r="), 4u + 1);                      // rmk_a, the kind

  options.gallery = FilmCameraType::kRmkA;
  ASSERT_TRUE(interior_orientation({}, options, {}));
  const std::string one = read_file(*options.drawing).value_or("");
  EXPECT_EQ(count_of(one, "transform='rotate(90)'"), 0u);
  EXPECT_EQ(count_of(one, "<circle r="), 5u);

  // Of a calibration, beside what is done with the measurements. Axes look to the middle of the film.
  options.gallery.reset();
  options.calibration = file("camera.txt",
                             "principal_distance_mm 150\nmark 1 -100 -100 corner\nmark 2 100 100 corner\nmark 3 0 100 "
                             "notch\nmark 4 -100 0 notch\n");
  ASSERT_TRUE(interior_orientation({}, options, {}));
  const std::string axes = read_file(*options.drawing).value_or("");
  for (const char* turned : {"rotate(-45)", "rotate(135)", "rotate(90)", "rotate(0)"})
    EXPECT_NE(axes.find(std::string(turned) + "'>"), std::string::npos) << turned << "\n" << axes;
  options.drawing = folder_ / "camera.txt" / "marks.svg";  // no folder
  EXPECT_FALSE(interior_orientation({}, options, {}));
}

TEST_F(Interior, TheGalleryOrientsWithoutACalibration) {
  const auto done = interior_orientation(file("marks.txt", kMarks), {.gallery = FilmCameraType::kRc30}, {});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(done->images[0].orientation.fit.marks.size(), 8u);
  EXPECT_LT(done->images[0].orientation.fit.sigma0, 1.5);
  EXPECT_NE(interior_text(*done).find("rc30, nominal: 8 marks, no calibration"), std::string::npos);
  auto asked = options();
  asked.gallery = FilmCameraType::kRc30;
  EXPECT_NE(message(kMarks, asked).find("marks of its own"), std::string::npos);
  asked.calibration = file("lens.txt", "principal_distance_mm 153.358\n");
  EXPECT_EQ(message(kMarks, asked), "");
  InteriorOptions bare{.gallery = FilmCameraType::kRc30};
  bare.points = file("points.txt", "point x[px] y[px]\n100 9447 2295\n");
  EXPECT_NE(message(kMarks, bare).find("needs a calibration"), std::string::npos);
  EXPECT_NE(message(kMarks, {}).find("its type"), std::string::npos);
}

TEST_F(Interior, RowsFromBelowAreAMirror) {
  std::string marks = "mark x[px] y[px]\n";
  std::istringstream rows(kMarks);
  std::string line, image, name;
  std::getline(rows, line);
  for (double x, y; rows >> image >> name >> x >> y;)
    marks += name + " " + std::to_string(x) + " " + std::to_string(20480 - y) + "\n";
  const auto done = interior_orientation(file("marks.txt", marks), options(), {});
  ASSERT_TRUE(done);
  EXPECT_TRUE(done->images[0].orientation.fit.transformation.is_mirrored);
  EXPECT_NE(interior_text(*done).find("mirror"), std::string::npos);
}

TEST_F(Interior, AComparatorMeasuresInMillimetresWithYUp) {
  const auto done = interior_orientation(
      file("marks.txt", "mark x[mm] y[mm]\n1 -95.997 -85.995\n2 116.004 126.008\n3 -96 126.009\n4 116.012 -85.995\n"),
      options(), {});
  ASSERT_TRUE(done) << done.error().message;
  const FilmTransformation& t = done->images[0].orientation.fit.transformation;
  EXPECT_EQ(t.model, FilmModel::kRigid);
  EXPECT_LT((t.pixel_of({0, 0}) - Eigen::Vector2d(10, -20)).norm(), 1e-3);
}

TEST_F(Interior, PrincipalPointAndPixelMakeAnOrientationWithoutMarks) {
  auto asked = options();
  asked.principal_point_px = "5000,4000";
  asked.dpi = 2540;
  asked.points = file("points.txt", "point x[px] y[px]\nA 6000 4000\n");
  const auto done = interior_orientation("", asked, {});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_NEAR(done->points[0].film_mm.x(), 10 - 0.006, 1e-9);
  EXPECT_NEAR(done->points[0].corrected_mm.x(), 10, 0.002);
  EXPECT_NE(interior_text(*done).find("without marks"), std::string::npos);
}

TEST_F(Interior, WrongInputIsToldWhatToDo) {
  const auto has = [](const std::string& text, const char* words) { return text.find(words) != std::string::npos; };
  auto asked = options();
  EXPECT_TRUE(has(message("", asked), "measured marks"));
  EXPECT_TRUE(has(message(kMarks, {}), "calibration"));
  EXPECT_TRUE(has(message("image mark x[px]\n27 1 5\n", asked), "column"));
  EXPECT_TRUE(has(message("mark x[px] y[px]\n1 5 5\n", asked), "do not determine"));
  EXPECT_TRUE(has(message("mark x[px] y[px]\n", asked), "no rows"));
  EXPECT_TRUE(has(message("mark x[deg] y[px]\n1 5 5\n", asked), "deg"));
  EXPECT_TRUE(has(message("mark x[px] y[px] sigma[px]\n1 5 5 0\n", asked), "zero"));
  asked.model = FilmModel::kRigid;
  EXPECT_TRUE(has(message(kMarks, asked), "size of a pixel"));
  asked = options();
  asked.points = file("points.txt", "image point x[px] y[px]\n28 A 1 1\n");
  EXPECT_TRUE(has(message(kMarks, asked), "image \"28\""));
  asked = options();
  asked.dpi = asked.pixel_um = 12;
  EXPECT_TRUE(has(message(kMarks, asked), "twice"));
  asked = options();
  asked.principal_point_px = "5,x";
  asked.dpi = 1200;
  EXPECT_TRUE(has(message("", asked), "two numbers"));
  asked.calibration = file("bare.txt", "principal_distance_mm 152\n");
  asked.principal_point_px.reset();
  EXPECT_TRUE(has(message(kMarks, asked), "no marks"));
}

// Film and scan, there and back; standard deviations without marks are those of the principal point.
TEST_F(Interior, PointsOfTheFilmAreBroughtToTheScan) {
  auto asked = options();
  asked.principal_point_px = "5000,4000";
  asked.dpi = 2540;
  asked.sigma = 0.5;
  asked.points = file("points.txt", "point x[mm] y[mm] sigma[mm]\nA 9.994 -0.006 0.02\n");
  asked.out = folder_ / "out";
  const auto done = interior_orientation("", asked, {});
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_EQ(done->scan_points.size(), 1u);
  const auto& seen = done->scan_points[0];
  const auto back = done->images[0].orientation.fit.transformation.film_of(seen.pixel);
  EXPECT_LT((*back - Eigen::Vector2d(9.994, -0.006)).norm(), 1e-9);
  EXPECT_NEAR(seen.pixel.x(), 6000, 1);
  // 0.5 px, and 0.02 mm of 0.01 mm a pixel.
  EXPECT_NEAR(seen.covariance(0, 0), 0.25 + 4, 1e-9);
  EXPECT_NEAR(seen.covariance(0, 1), 0, 1e-9);
  for (const char* name : {"covariance.txt", "model_tests.txt", "deformation.txt", "scan_points.txt"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
}

TEST_F(Interior, ReadingsThatContradictEachOtherAreWarnedOf) {
  const auto done = interior_orientation(
      file("marks.txt", "mark x[px] y[px]\n1 1347 19285\n2 19161 1470\n3 1345 1771\n4 19463 19283\n"), options(), {});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_NE(interior_text(*done).find("contradict"), std::string::npos);
  const auto good = interior_orientation(file("good.txt", kMarks), options(), {});
  ASSERT_TRUE(good);
  EXPECT_EQ(interior_text(*good).find("contradict"), std::string::npos);
}

// Corners of which the calibration states no kind, by one click; the dot that it states stays a dot.
TEST_F(Interior, MarksArePointedTo) {
  std::string camera = "principal_distance_mm 20\nfilm_size_mm 24 24\nmark_size_mm 0.8 0.12\n";
  const std::string corners[] = {"1 -10 -10", "2 10 -10", "3 10 10", "4 -10 10"};
  std::string drawn = camera, known = camera;
  for (const std::string& one : corners) drawn += "mark " + one + " corner\n", known += "mark " + one + "\n";
  const auto calibration = parse_film_calibration(drawn + "mark 5 10 0 dot\n");
  ASSERT_TRUE(calibration);
  FilmTransformation truth;
  truth.parameters = Eigen::Vector4d(483.2, 477.9, 0.01, 40);
  Random random(8);
  const fs::path scan = folder_ / "7.png";
  ASSERT_TRUE(write_png(scan, rendered_scan(*calibration, truth, 960, 960, {}, 1, random)));
  InteriorOptions asked{.calibration = file("camera.txt", known + "mark 5 10 0 dot\n")};
  asked.scans.search_mm = 1.5;
  const Eigen::Vector2d at = truth.pixel_of({10, -10}), dot = truth.pixel_of({10, 0});
  const auto click = [](const Eigen::Vector2d& p) { return std::to_string(p.x()) + "," + std::to_string(p.y()); };
  for (const std::string& clicks : {click(at), click(at) + ";" + click(dot)}) {
    asked.scans.mark_at = clicks;
    const auto done = interior_orientation(scan, asked, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->images[0].readings.marks.size(), 5u);
    // Four times the 0.05 px that a likeness with grain of its own is read to.
    EXPECT_LT((done->images[0].orientation.fit.transformation.pixel_of({3, 4}) - truth.pixel_of({3, 4})).norm(), 0.2);
  }
  for (const char* wrong : {"480,480", "5,5", "100", "100,100;", ";"}) {
    asked.scans.mark_at = wrong;
    EXPECT_FALSE(interior_orientation(scan, asked, {})) << wrong;
  }
}

// Marks are found in a scan that is turned by a quarter, and a scan without marks says so.
TEST_F(Interior, MarksAreFoundInScans) {
  const std::string camera =
      "principal_distance_mm 20\nfilm_size_mm 24 24\nmark_size_mm 0.8 0.12\nmark 1 -10 -10\nmark 2 10 -10\n"
      "mark 3 10 10\nmark 4 -10 10 dot\n";
  InteriorOptions asked{.calibration = file("camera.txt", camera)};
  const auto calibration = parse_film_calibration(camera);
  ASSERT_TRUE(calibration);
  FilmTransformation truth;
  truth.parameters = Eigen::Vector4d(483.2, 477.9, M_PI / 2 + 0.01, 40);
  Random random(8);
  fs::create_directories(folder_ / "scans");
  ASSERT_TRUE(write_png(folder_ / "scans" / "7.png", rendered_scan(*calibration, truth, 960, 960, {}, 1, random)));
  asked.scans.turned_deg = 90;
  asked.scans.search_mm = 1.5;
  const auto done = interior_orientation(folder_ / "scans", asked, {});
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_EQ(done->images.size(), 1u);
  EXPECT_EQ(done->images[0].name, "7");
  EXPECT_LT((done->images[0].orientation.fit.transformation.pixel_of({3, 4}) - truth.pixel_of({3, 4})).norm(), 0.1);
  EXPECT_NE(interior_text(*done).find("found in the scan"), std::string::npos);
  ASSERT_TRUE(write_png(folder_ / "scans" / "0.png", GreyImage(960, 960, 1, 80)));
  EXPECT_NE(interior_orientation(folder_ / "scans", asked, {}).error().message.find("fewer than three"),
            std::string::npos);
  asked.scans.turned_deg = 45;
  EXPECT_FALSE(interior_orientation(folder_ / "scans", asked, {}));
  asked.scans = {.mark_at = "5,5"};
  EXPECT_FALSE(interior_orientation(folder_ / "scans", asked, {}));
  fs::create_directories(folder_ / "none");
  EXPECT_FALSE(interior_orientation(folder_ / "none", asked, {}));
}

// All four readers of film_pairs: what the second one gives for marks 2, 3, 5, 6, 7 of image 27 are the marks of image
// 28, by 13 px wrong.
TEST_F(Interior, TheReaderOfTheOtherImageIsFound) {
  const fs::path data = fs::path(source_tree()) / "../shared/data/film_pairs/pair_27_28/measurements.csv";
  if (!fs::exists(data)) GTEST_SKIP() << data.string() << " is not here";
  const auto table = read_text_table(data);
  ASSERT_TRUE(table) << table.error().message;
  std::string marks = "image mark x[px] y[px]\n";
  for (const auto& row : table->rows)
    for (std::size_t k = 3; row[1] == "fiducial" && k < 11; k += 2)
      marks += row[0] + " " + row[2] + " " + row[k] + " " + row[k + 1] + "\n";
  const auto done = interior_orientation(file("marks.txt", marks), options(), {});
  ASSERT_TRUE(done) << done.error().message;
  for (const ReadMark& mark : done->images[0].readings.marks) {
    const bool is_other =
        mark.mark == "2" || mark.mark == "3" || mark.mark == "5" || mark.mark == "6" || mark.mark == "7";
    EXPECT_EQ(mark.gross, is_other ? std::vector<int>{2} : std::vector<int>{}) << mark.mark;
  }
  for (const auto& image : done->images) EXPECT_LT(image.orientation.fit.sigma0, 1);
}

}  // namespace
}  // namespace collinea
