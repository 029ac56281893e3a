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
  for (const char* units : {" units=\"radians\"", ""}) {
    const auto file = read(with(" units=\"degrees\"", units));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_NEAR(omega_phi_kappa(pose_of(file->block, {3}).rotation).omega_deg, 1, 1e-4);
  }
  EXPECT_NE(error_of(with("units=\"degrees\"", "units=\"gon\"")).find("angles in gon"), std::string::npos);
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
  EXPECT_EQ(error_of(with("<ctrl_pts>", many + "<ctrl_pts>")), "read");
  EXPECT_NE(error_of(with("<ctrl_pts>", many + "<ctrl_pts")).find("line 30000"), std::string::npos);
}

TEST_F(DbatScript, SurvivesTruncationAndGarbage) {
  read_damaged(
      kScript, [&](const std::string& text) { (void)read(text); }, 300, 3);
}

}  // namespace
}  // namespace collinea
