// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/dbat_script.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/test_damage.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

const std::string kScript = R"(<?xml version="1.0" encoding="UTF-8"?>
<document dbat_script_version="1.0.0">
  <c>Remarks may hold <!-- anything --> .</c>
  <input base_dir="$HERE">
    <ctrl_pts><file format="id,label,x,y,z,sxyz">control.txt</file></ctrl_pts>
    <images image_base_dir="$DBAT"><file format="id,path">images.txt</file></images>
    <prior_eo><file format="id,x,y,z,omega,phi,kappa" units="degrees">eo.txt</file></prior_eo>
    <image_pts><file format="im,id,x,y" sxy="0.5">marks.txt</file></image_pts>
    <cameras><camera>
      <name>test</name><unit>mm</unit><sensor>auto,6</sensor><image>2000,1500</image>
      <focal>8</focal><model>3</model><K>1e-3,0,0</K>
    </camera></cameras>
  </input>
  <operations>
    <operation min_rays="2">check_ray_count</operation>
    <operation><set_bundle_estimate_params>
      <io><all>true</all><skew>false</skew><K3>false</K3></io>
    </set_bundle_estimate_params></operation>
    <operation><set_datum ref_cam="1" ref_base="longest">depend</set_datum></operation>
    <operation>bundle_adjustment</operation>
  </operations>
</document>
)";

class DbatScript : public ::testing::Test {
 protected:
  DbatScript() {
    put("control.txt", "# id, label, x, y, z, s\n1001, CP1, 0, 1, 0, 0.001\n1002,, 1, 1, 0, 0\n");
    put("images.txt", " 1, data/one.JPG\n 2, data/two.JPG\n 3, three.JPG\n");
    put("eo.txt", "1, 0, 0, 10, 0, 0, 0\n2, 3, -4, 10, 0, 0, 0\n3, 1, 1, 9, 1, 2, 3\n");
    put("marks.txt", "2, 5, 100, 200\n1, 5, 110.5, 210\n1, 1001, 7, 8\n");
  }
  void put(const char* name, const std::string& text) { ASSERT_TRUE(write_file(folder_ / name, text)); }
  Result<AdjustmentFile> read(const std::string& script) {
    put("script.xml", script);
    return read_dbat_script(folder_ / "script.xml");
  }
  static std::string with(std::string_view was, std::string_view is) {
    std::string text = kScript;
    return text.replace(text.find(was), was.size(), is);
  }
  std::string error_of(const std::string& script) {
    const auto file = read(script);
    return file ? std::string("read") : file.error().message;
  }
  const TestFolder folder_;
};

TEST_F(DbatScript, IsReadWithItsTables) {
  EXPECT_TRUE(is_dbat_script(kScript));
  const auto file = read(kScript);
  ASSERT_TRUE(file) << file.error().message;
  const Block& block = file->block;
  EXPECT_EQ(block.images.at({2}).file, "two.JPG");
  EXPECT_EQ(block.control.at({1001}).name, "CP1");
  EXPECT_EQ(block.control.at({1002}).name, "1002");
  EXPECT_EQ(block.control.at({1001}).sigma_m, Eigen::Vector3d::Constant(0.001));
  ASSERT_EQ(block.observations.size(), 2u);
  EXPECT_EQ(block.observations[0].pixel, Eigen::Vector2d(110.5, 210));
  EXPECT_EQ(block.observations[0].sigma_px, 0.5);
  EXPECT_EQ(block.control_observations.size(), 1u);
  const auto& sigmas = file->camera_sigmas.at({0});
  EXPECT_TRUE(std::isinf(sigmas[Camera::kB1]));
  EXPECT_EQ(sigmas[Camera::kB2], 0);
  EXPECT_EQ(sigmas[Camera::kK3], 0);
  EXPECT_TRUE(std::isinf(sigmas[Camera::kK2]));
  EXPECT_NEAR(block.cameras.at({0}).params[Camera::kK1], 0.064, 1e-12);
  EXPECT_NEAR(block.cameras.at({0}).params[Camera::kCx], 1000, 1e-9);
  // Of the second image y is farthest from the first.
  EXPECT_TRUE(file->fixed_images.contains({1}));
  ASSERT_TRUE(block.images.at({2}).position);
  EXPECT_TRUE(std::isinf(block.images.at({2}).position->sigma_m.x()));
  EXPECT_LT(block.images.at({2}).position->sigma_m.y(), 1e-8);
  EXPECT_EQ(block.images.at({2}).position->position_in_world.y(), -4);
}

TEST_F(DbatScript, TablesLieWhereTheScriptSays) {
  std::filesystem::create_directories(folder_ / "tables");
  for (const char* name : {"control.txt", "images.txt", "eo.txt", "marks.txt"})
    std::filesystem::rename(folder_ / name, folder_ / "tables" / name);
  EXPECT_NE(error_of(kScript), "read");
  for (const char* base : {"$HERE/tables", "tables"}) {
    const auto file = read(with("base_dir=\"$HERE\"", std::string("base_dir=\"") + base + "\""));
    ASSERT_TRUE(file) << base << ": " << file.error().message;
    EXPECT_EQ(file->block.images.size(), 3u);
  }
}

TEST_F(DbatScript, AnglesAreInTheirUnits) {
  const double degree = std::numbers::pi / 180;
  put("eo.txt", "1, 0, 0, 10, 0, 0, 0\n2, 3, -4, 10, 0, 0, 0\n3, 1, 1, 9, " + std::to_string(degree) + ", 0, 0\n");
  for (const char* unit : {"radians", "radian"}) {
    const auto file = read(with("degrees", unit));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_NEAR(omega_phi_kappa(pose_of(file->block, {3}).rotation).omega_deg, 1, 1e-4);
  }
  put("eo.txt", "1, 0, 0, 10, 0, 0, 0\n2, 3, -4, 10, 0, 0, 0\n3, 1, 1, 9, 10, 0, 0\n");
  const auto in_gon = read(with("degrees", "gon"));
  ASSERT_TRUE(in_gon) << in_gon.error().message;
  EXPECT_NEAR(omega_phi_kappa(pose_of(in_gon->block, {3}).rotation).omega_deg, 9, 1e-9);
  EXPECT_NE(error_of(with("degrees", "arcmin")).find("angles in arcmin"), std::string::npos);
  EXPECT_NE(error_of(with(" units=\"degrees\"", "")).find("eo.txt: line 1: angles of no unit"), std::string::npos);
}

// As in DBAT's Strasbourg demo: one file for control and check points, two files of marks with sigmas of their own.
TEST_F(DbatScript, AllFilesAndFiltersOfAnElementCount) {
  put("all.txt", "1, A, 0, 1, 0, 0.1, 0.1, 0.2\n2, B, 1, 1, 0, 0.1, 0.1, 0.2\n3, C, 1, 0, 0, 0.1, 0.1, 0.2\n");
  put("more.txt", "4, D, 5, 6, 7, 0.3, 0.3, 0.3\n");
  put("marks.txt", "2, 1, 100, 200, 9\n2, 2, 110.5, 210, 9\n1, 2, 9, 9, 9\n2, 3, 7, 8, 9\n1, 3, 8, 9, 9\n");
  put("smart.txt", "77, 1, 5, 6\n77, 2, 6, 7\n");
  std::string script = with(R"(<ctrl_pts><file format="id,label,x,y,z,sxyz">control.txt</file></ctrl_pts>)",
                            R"(<ctrl_pts>
      <file format='id,label,x,y,z,sx,sy,sz'>all.txt</file><!-- both, less the check point -->
      <file format="id,label,x,y,z,sx,sy,sz">more.txt</file>
      <filter id="2,3">remove</filter></ctrl_pts>
    <check_pts><file format="id,label,x,y,z,sx,sy,sz">all.txt</file><filter id="2,3">keep</filter>
      <filter id="2">remove</filter></check_pts>)");
  const std::string was = R"(<file format="im,id,x,y" sxy="0.5">marks.txt</file>)";
  script.replace(script.find(was), was.size(),
                 R"(<file format="im,id,x,y,sxy" sxy="0.5">marks.txt</file>
      <file format="id,im,x,y" sx="1.0" sy="1.0">smart.txt</file>)");
  const auto file = read(script);
  ASSERT_TRUE(file) << file.error().message;
  const Block& block = file->block;
  ASSERT_EQ(block.control.size(), 3u);
  EXPECT_EQ(block.control.at({1}).role, ControlRole::kControl);
  EXPECT_EQ(block.control.at({3}).role, ControlRole::kCheck);
  EXPECT_EQ(block.control.at({4}).sigma_m, Eigen::Vector3d::Constant(0.3));
  EXPECT_EQ(block.control_observations.size(), 3u);  // one of A, two of C
  // B is neither control nor check; C takes part with its marks besides. What the file says goes before its columns.
  ASSERT_EQ(block.observations.size(), 6u);
  EXPECT_EQ(block.observations[0].point, PointId{2});
  EXPECT_EQ(block.observations[0].sigma_px, 0.5);
  EXPECT_EQ(block.observations[2].point, PointId{3});
  EXPECT_EQ(block.observations[4].point, PointId{77});
  EXPECT_EQ(block.observations[4].sigma_px, 1);
}

TEST_F(DbatScript, WhatAFilterCannotDoIsAnError) {
  const auto filtered = [&](const std::string& filter) {
    return error_of(with("</ctrl_pts>", filter + "</ctrl_pts>"));
  };
  EXPECT_EQ(filtered("<filter id=\"1002\">remove</filter>"), "read");
  EXPECT_NE(filtered("<filter id=\"9\">remove</filter>").find("line 5: filter: \"9\" is no number of a point"),
            std::string::npos);
  EXPECT_NE(filtered("<filter id=\"1001-1002\">keep</filter>").find("\"1001-1002\" is no number"), std::string::npos);
  EXPECT_NE(filtered("<filter id=\"1002\">hide</filter>").find("filter hide: keep or remove"), std::string::npos);
  EXPECT_NE(filtered("<filter label=\"CP1\">keep</filter>").find("attribute label of filter"), std::string::npos);
  EXPECT_NE(error_of(with("</images>", "<filter id=\"1\">keep</filter></images>")).find("element filter in images"),
            std::string::npos);
  const std::string check = R"(<check_pts><file format="id,label,x,y,z,sxyz">control.txt</file></check_pts><images)";
  EXPECT_NE(error_of(with("<images", check)).find("is a control point and a check point"), std::string::npos);
}

TEST_F(DbatScript, XmlIsReadAsFarAsAnyoneWritesIt) {
  EXPECT_EQ(error_of(with("<input", "<!-- a comment, with <elements> -- and so on -->\n<input")), "read");
  EXPECT_EQ(error_of("<!-- in front -->\n" + kScript), "read");
  EXPECT_EQ(error_of(with("base_dir=\"$HERE\"", "base_dir='$HERE'")), "read");
  const auto named = read(with("<name>test</name>", "<name>A &amp; <![CDATA[B <1>]]>&#33;</name>"));
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->block.cameras.at({0}).name, "A & B <1>!");
  const auto with_comment = read(with("<focal>8", "<focal><!-- nominal -->8"));
  ASSERT_TRUE(with_comment) << with_comment.error().message;
  EXPECT_NEAR(with_comment->block.cameras.at({0}).params[Camera::kF], 2000, 1e-9);
  EXPECT_NE(error_of(with("<name>test", "<name>a & b")).find("line 10: & b"), std::string::npos);
  EXPECT_NE(error_of(with("<input", "<!-- <input")).find("<!-- does not end"), std::string::npos);
  EXPECT_NE(error_of("<!DOCTYPE document>\n" + kScript).find("line 1: <!...>"), std::string::npos);
  EXPECT_NE(error_of(with("ref_cam=\"1\"", "ref_cam=\"1\" ref_cam=\"2\"")).find("a second attribute ref_cam"),
            std::string::npos);
}

// Of lens model 3 a measured point is sheared first and corrected then, as ours is: x = (1 + b1) x' + b2 y', y upwards.
TEST_F(DbatScript, TheSkewOfModel3IsOurs) {
  const auto file = read(with("<model>", "<aspect>0.99</aspect><skew>2e-3</skew><model>"));
  ASSERT_TRUE(file) << file.error().message;
  const Camera& camera = file->block.cameras.at({0});
  const double f = camera.params[Camera::kF], mm = 6.0 / 1500, focal_mm = f * mm;
  EXPECT_NEAR(camera.params[Camera::kB2], f * 2e-3 / 1.01, 1e-9);
  const Eigen::Vector2d pixel(1634.5, 402.25);
  const double y = mm * (camera.params[Camera::kCy] - pixel.y());
  const double x = mm * (pixel.x() - camera.params[Camera::kCx]) * 1.01 + 2e-3 * y, r2 = x * x + y * y;
  const Eigen::Vector2d corrected = Eigen::Vector2d(x, -y) * (1 + 1e-3 * r2) / focal_mm;  // K1 of the script
  EXPECT_LT((normalized(camera, pixel) - corrected).norm(), 1e-12);
  for (const char* model : {"4", "5"})
    EXPECT_NE(error_of(with("<model>3", std::string("<model>") + model)).find("behind the correction of the lens"),
              std::string::npos);
}

TEST_F(DbatScript, MarksMayHaveAStandardDeviationForEachAxis) {
  const auto file = read(with("sxy=\"0.5\"", "sx=\"0.5\" sy=\"0.6\""));
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_FALSE(file->block.observations.empty());
  for (const Observation& seen : file->block.observations)
    EXPECT_LT((seen.sigmas_px() - Eigen::Vector2d(0.5, 0.6)).norm(), 1e-7);
}

TEST_F(DbatScript, WhatIsNotKnownIsAnErrorByName) {
  const std::pair<std::string, const char*> scripts[] = {
      {with("<images", "<scale_bars/><images"), "line 6: element scale_bars in input"},
      {with("</document>", "<plugin/></document>"), "element plugin in document"},
      {with("format=\"im,id,x,y\"", "format=\"im,id,x,y,weight\""), "format: \"weight\" is no column"},
      {with("format=\"im,id,x,y\"", "format=\"im,id,x,x\""), "column x is there twice"},
      {with("sxy=\"0.5\"", "sigma=\"0.5\""), "attribute sigma of file"},
      {with("<unit>mm", "<fiducials>8</fiducials><unit>mm"), "element fiducials in camera"},
      {with("<K>1e-3,0,0", "<K>1e-3,0,0,1e-9"), "K has 4 numbers; 0 to 3 are expected"},
      {with("<K>1e-3,0,0", "<nK>2</nK><K>1e-3,0,0"), "K has 3 numbers; 2 are expected"},
      {with("<sensor>auto,6", "<sensor>9,6"), "by sensor and image a pixel is 1.125"},
      {with("base_dir=\"$HERE\"", "base_dir=\"$DBAT/data\""), "line 4: $DBAT/data: where DBAT is installed"},
      {with("dbat_script_version=\"1.0.0\"", "dbat_script_version=\"2.0\""), "dbat_script_version 2.0"},
      {with(">check_ray_count", ">count_rays"), "operation count_rays: this reader does not know it"},
      {with("min_rays=\"2\"", "min_rays=\"3\""), "point 5 is marked in 2 images, fewer than min_rays = 3"},
      {with("<io><all>true", "<eo>false</eo><io><all>true"), "eo: all = false"},
      {with("<io><all>true", "<eo>default</eo><io><all>true"), "eo: all = default"},
      {with("<io><all>true", "<op>true</op><io><all>true"), "control has a standard deviation of 0"},
      {with("<io><all>true", "<io><P1>true</P1><all>true"), "io: P1: the camera has no such term"},
      {with("</operations>", "<operation><set_datum>x</set_datum></operation></operations>"), "behind the last bundle"},
      {with("set_bundle_estimate_params>\n", "set_weights>\n"), "ends as set_bundle_estimate_params"},
      {with("\"longest\"", "\"shortest\""), "datum depend shortest"},
  };
  for (const auto& [script, message] : scripts)
    EXPECT_NE(error_of(script).find(message), std::string::npos) << message << " in: " << error_of(script);
}

TEST_F(DbatScript, TermsThatTheLensLacksAreNotEstimated) {
  const auto file = read(with("<K>1e-3,0,0", "<nP>2</nP><K>1e-3,2e-5"));
  ASSERT_TRUE(file) << file.error().message;
  const auto& sigmas = file->camera_sigmas.at({0});
  EXPECT_TRUE(std::isinf(sigmas[Camera::kK2]) && std::isinf(sigmas[Camera::kP2]));
  EXPECT_EQ(sigmas[Camera::kK3], 0);
  EXPECT_EQ(read(kScript)->camera_sigmas.at({0})[Camera::kP1], 0);  // neither nP nor P
}

TEST_F(DbatScript, CamerasAreReadInAllTheirForms) {
  const auto params = [&](std::string_view was, std::string_view is) {
    const auto file = read(with(was, is));
    EXPECT_TRUE(file) << is << ": " << file.error().message;
    return file ? file->block.cameras.at({0}).params : decltype(Camera::params){};
  };
  EXPECT_NEAR(params("<model>", "<pp>4.1,-2.9</pp><model>")[Camera::kCy], 725, 1e-9);
  EXPECT_NEAR(params("<model>", "<pp>4.1,2.9</pp><model>")[Camera::kCy], 725, 1e-9);
  EXPECT_NEAR(params("<model>", "<pp>default</pp><cc>focal</cc><model>")[Camera::kCx], 1000, 1e-9);
  // 2000 x 1500 px of 8.08 x 6 mm: pixels 1.01 times as wide as high.
  const double b1 = 2000 * (1 / 1.01 - 1);
  EXPECT_NEAR(params("<sensor>auto,6</sensor>", "<sensor>8.08,6</sensor><aspect>auto</aspect>")[Camera::kB1], b1, 1e-9);
  EXPECT_NEAR(params("<sensor>auto,6</sensor>", "<sensor>8.08,6</sensor><aspect>0.99</aspect>")[Camera::kB1], b1, 1e-9);
  const auto initial = [](const std::string& io) {
    return "<operation><set_initial_values>" + io + "</set_initial_values></operation>\n    <operation><set_datum";
  };
  const char* datum = "<operation><set_datum";
  EXPECT_NEAR(params(datum, initial("<io>default</io>"))[Camera::kK1], 0, 1e-15);
  EXPECT_NEAR(params(datum, initial("<io><all>default</all><K>2e-3,0,0</K></io>"))[Camera::kK1], 0.128, 1e-12);
  EXPECT_NEAR(params(datum, initial("<io><cc>9</cc><pp>5,-3.5</pp></io>"))[Camera::kF], 2250, 1e-9);
  EXPECT_NEAR(params(datum, initial("<io><cc>9</cc><pp>5,-3.5</pp></io>"))[Camera::kCy], 875, 1e-9);
  EXPECT_EQ(params(datum, initial("<io>loaded</io><eo>loaded</eo><op><all>loaded</all></op>")),
            read(kScript)->block.cameras.at({0}).params);
}

TEST_F(DbatScript, TheBaseMayBeAlongAnAxis) {
  const auto file = read(with("\"longest\"", "\"x\""));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_LT(file->block.images.at({2}).position->sigma_m.x(), 1e-8);
  EXPECT_TRUE(std::isinf(file->block.images.at({2}).position->sigma_m.y()));
}

// Positions without angles are no poses to begin with; DBAT takes neither them nor standard deviations as observed.
TEST_F(DbatScript, PriorPositionsWithoutAnglesAreNoPoses) {
  put("eo.txt", "1, 0, 0, 10, 0.1\n2, 3, -4, 10, 0.1\n");
  std::string script = with("id,x,y,z,omega,phi,kappa\" units=\"degrees\"", "id,x,y,z,sxyz\"");
  const std::string datum = R"(<operation><set_datum ref_cam="1" ref_base="longest">depend</set_datum></operation>)";
  const auto file = read(script.replace(script.find(datum), datum.size(), ""));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(count_oriented(file->block), 0u);
  EXPECT_FALSE(file->block.images.at({1}).position);
}

TEST_F(DbatScript, FixedImagesAndPointsAreRefused) {
  EXPECT_NE(error_of(with("<io><all>true", "<eo><all>false</all></eo><io><all>true")).find("eo: all = false"),
            std::string::npos);
  EXPECT_NE(error_of(with("<io><all>true", "<op><all>false</all></op><io><all>true")).find("op: all = false"),
            std::string::npos);
  EXPECT_EQ(error_of(with("<io><all>true", "<eo><all>true</all></eo><io><all>true")), "read");
}

TEST_F(DbatScript, SaysWhereWhatIsWrong) {
  EXPECT_NE(error_of(with("<model>3", "<model>4")).find("script.xml: line 11: lens model 4"), std::string::npos);
  EXPECT_NE(error_of(with("marks.txt", "none.txt")).find("none.txt"), std::string::npos);
  EXPECT_NE(error_of(with("depend", "inner")).find("line 19: datum inner"), std::string::npos);
  EXPECT_NE(error_of(with("<all>true", "<focus>true</focus><all>true")).find("line 17: io: focus"), std::string::npos);
  EXPECT_NE(error_of(with("</cameras>", "</camera>")).find("element cameras ends as camera"), std::string::npos);
  put("marks.txt", "1, 5, 100, 200\n1, 6, 100\n");
  EXPECT_NE(error_of(kScript).find("marks.txt: line 2: 3 fields"), std::string::npos);
  put("marks.txt", "1, 5, 100, 200\n9, 6, 100, 100\n");
  EXPECT_NE(error_of(kScript).find("marks.txt: line 2: there is no image 9"), std::string::npos);
  put("marks.txt", "1, 5, 100, 200\n1, 5, 100, 100\n");
  EXPECT_NE(error_of(kScript).find("marked twice"), std::string::npos);
}

// Lines counted anew for each of them would take a minute.
TEST_F(DbatScript, ManyElementsTakeNoMoreThanTheirNumber) {
  std::string many;
  for (int i = 0; i < 300'000; ++i) many += "<x/>\n";
  EXPECT_EQ(error_of(with("<operations>", "<output>" + many + "</output><operations>")), "read");
  EXPECT_NE(error_of(with("<operations>", "<output>" + many + "</outputs><operations>")).find("line 3000"),
            std::string::npos);
}

TEST_F(DbatScript, SurvivesTruncationAndGarbage) {
  read_damaged(
      kScript, [&](const std::string& text) { (void)read(text); }, 300, 3);
}

}  // namespace
}  // namespace collinea
