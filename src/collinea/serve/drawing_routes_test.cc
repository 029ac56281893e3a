// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/block/transform.h"
#include "collinea/edit/make_edits.h"
#include "collinea/jobs/measure.h"
#include "collinea/jobs/plot_features.h"
#include "collinea/jobs/test_plot_project.h"
#include "collinea/math/random.h"
#include "collinea/serve/drawing_json.h"
#include "collinea/serve/drawing_routes.h"
#include "collinea/serve/internal/target.h"

namespace collinea {
namespace {

using nlohmann::json;

class DrawingRoutes : public testing::PlotProjectTest {
 protected:
  HttpResponse ask(const std::string& what, const std::string& body, const std::string& method = "POST") {
    const std::string path = "/api/projects/1/" + what;
    return drawing_response({method, path, {{"content-type", "application/json"}}, body}, *parsed_target(path),
                            {"1", "village", project()}, views_)
        .value_or(HttpResponse{.status = 404});
  }
  json answer(const std::string& what, const json& body) {
    const HttpResponse response = ask(what, body.dump());
    EXPECT_EQ(response.status, 200) << response.body;
    return json::parse(response.body);
  }
  json drawing(const std::string& query = "") { return json::parse(ask("drawing" + query, "", "GET").body); }
  [[nodiscard]] json mark(std::uint32_t image, const Eigen::Vector3d& on_map) const {
    const Eigen::Vector2d at = pixel(image, on_map);
    return {{"image", image}, {"pixel", {at.x(), at.y()}}, {"sigma_px", 0.3}};
  }
  // The roof: two corners by two marks, one by one mark, one on the map.
  [[nodiscard]] json corners() const {
    const auto at = roof();
    return {{{"marks", {mark(1, at[0]), mark(2, at[0])}}},
            {{"marks", {mark(1, at[1]), mark(2, at[1])}}},
            {{"marks", {mark(1, at[2])}}},
            {{"surface", {at[3].x(), at[3].y()}}, {"sigma_m", 0.1}}};
  }
  void edit(const std::vector<std::string>& words) {
    Journal journal(project());
    const std::vector<Edit> edits = {parse_edit(words).value()};
    const auto made = make_edits(project(), journal, edits);
    ASSERT_TRUE(made) << made.error().message;
  }
  ProjectViews views_;
};

std::vector<std::string> draw_command(const json& vertices) {
  std::vector<std::string> words = {"draw", "*", "roof", "polygon"};
  const auto number = [](const json& value) { return value.dump(); };
  for (const json& vertex : vertices) {
    words.push_back(vertex.at("source"));
    for (const json& value : vertex.at("position")) words.push_back(number(value));
    words.emplace_back("cov");
    for (const json& value : vertex.at("covariance_m2")) words.push_back(number(value));
    for (const json& one : vertex.at("marks"))
      words.insert(words.end(), {"mark", one.at("file"), number(one.at("pixel")[0]), number(one.at("pixel")[1]),
                                 number(one.at("sigma_px"))});
  }
  return words;
}

TEST_F(DrawingRoutes, FiguresAreThoseOfTheCommandLine) {
  std::string table = "feature vertex kind image x[px] y[px] sigma[px] E[m] N[m] sigma_m\n";
  for (std::size_t i = 0; i < 4; ++i) {
    const json corner = corners()[i];
    if (corner.contains("surface"))
      table +=
          fmt::format("A {} polygon - - - - {} {} 0.1\n", i, corner["surface"][0].dump(), corner["surface"][1].dump());
    else
      for (const json& one : corner["marks"])
        table += fmt::format("A {} polygon IMG_{}.jpg {} {} 0.3 - - -\n", i, one["image"].dump(),
                             one["pixel"][0].dump(), one["pixel"][1].dump());
  }
  ASSERT_TRUE(write_file(folder_ / "table.txt", table));
  const auto report =
      plot_features(project(), folder_ / "table.txt",
                    {.figures = "area A; plan_area A; length A; distance A.1 A.3; angle A.1 A.2 A.3"}, {});
  ASSERT_TRUE(report) << report.error().message;
  const json all = answer("figures", {{"figures", {"area", "plan_area", "length", "slope"}}, {"vertices", corners()}});
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(all["figures"][i]["value"].get<double>() / report->figures[i].measured->value, 1, 1e-9) << i;
    EXPECT_NEAR(all["figures"][i]["sigma"].get<double>() / report->figures[i].measured->sigma, 1, 1e-9) << i;
  }
  EXPECT_EQ(all["figures"][0]["unit"], "m2");
  EXPECT_TRUE(all["figures"][3].contains("error"));  // of four vertices there is no slope
  // The same vertices as they are drawn by now: the same errors in common.
  const auto drawn = [](int vertex) { return json{{"feature", "A"}, {"vertex", vertex}}; };
  const json again = answer("figures", {{"kind", "distance"}, {"vertices", {drawn(0), drawn(2)}}});
  EXPECT_NEAR(again["value"].get<double>() / report->figures[3].measured->value, 1, 1e-9);
  EXPECT_NEAR(again["sigma"].get<double>() / report->figures[3].measured->sigma, 1, 1e-6);
}

TEST_F(DrawingRoutes, WhatIsDrawnIsListedAndShownInPhotographsUntilItIsUndone) {
  const json plotted = answer("vertices", {{"vertices", corners()}, {"image", 2}})["vertices"];
  const char* sources[] = {"stereo", "stereo", "mono", "surface"};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(plotted[i]["source"], sources[i]);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(plotted[i]["position"][std::size_t(axis)].get<double>(), roof()[i][axis], 1e-3);
    EXPECT_NEAR(plotted[i]["pixel"][0].get<double>(), pixel(2, roof()[i]).x(), 0.05);
  }
  EXPECT_TRUE(drawing()["features"].empty());
  edit(draw_command(plotted));
  const json shown = drawing("?image=1")["features"];
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0]["id"], "F1");
  EXPECT_EQ(shown[0]["vertices"][0]["marks"][1]["image"], 2);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(shown[0]["vertices"][i]["pixel"][1].get<double>(), pixel(1, roof()[i]).y(), 0.05);
    EXPECT_EQ(shown[0]["vertices"][i]["covariance_m2"], plotted[i]["covariance_m2"]);
  }
  edit({"attribute", "F1", "use", "shed"});
  EXPECT_EQ(drawing()["features"][0]["attributes"]["use"], "shed");
  edit({"undo"});
  edit({"undo"});
  EXPECT_TRUE(drawing()["features"].empty());
  EXPECT_FALSE(drawing()["layers"].empty());  // of the code list
}

// The page shows where vertices with marks are by the adjustment in force, and says how far that is from where they
// were drawn; without an adjustment or a surface that can be read it shows what was drawn, and why.
TEST_F(DrawingRoutes, WhatIsDrawnFollowsTheAdjustment) {
  const json plotted = answer("vertices", {{"vertices", corners()}})["vertices"];
  edit(draw_command(plotted));
  const json unmoved = drawing();
  EXPECT_TRUE(unmoved["as_drawn"].is_null());
  EXPECT_EQ(unmoved["features"][0]["moved_m"], 0.0);
  EXPECT_TRUE(unmoved["features"][0]["not_computed"].empty());
  const Eigen::Vector3d shift(0.5, -0.25, 0.75);
  Block moved = block_;
  transform(moved, Similarity3{1, Eigen::Quaterniond::Identity(), shift});
  remove_pose(moved, ImageId{3});
  {
    auto store = ProjectStore::open(project());
    BlockCovariances covariances = *store->read_covariances();
    covariances.poses.erase(ImageId{3});
    ASSERT_TRUE(store && store->write_adjustment(moved, covariances));
  }
  const json feature = drawing()["features"][0];
  EXPECT_NEAR(feature["moved_m"].get<double>(), shift.norm(), 2e-3);
  EXPECT_GT(feature["moved_sigmas"].get<double>(), 3);
  EXPECT_NEAR(feature["vertices"][0]["position"][2].get<double>() - roof()[0].z(), shift.z(), 2e-3);
  EXPECT_EQ(feature["vertices"][3]["position"], plotted[3]["position"]);  // on the surface
  // A vertex of it is measured where it is now.
  const json vertex = answer("vertices", {{"vertices", {{{"feature", "F1"}, {"vertex", 0}}}}})["vertices"][0];
  EXPECT_NEAR(vertex["position"][2].get<double>(), feature["vertices"][0]["position"][2].get<double>(), 1e-9);
  // A photograph that it is marked in is no longer oriented.
  remove_pose(moved, ImageId{2});
  {
    auto store = ProjectStore::open(project());
    BlockCovariances covariances = *store->read_covariances();
    covariances.poses.erase(ImageId{2});
    ASSERT_TRUE(store && store->write_adjustment(moved, covariances));
  }
  const json kept = drawing()["features"][0];
  ASSERT_EQ(kept["not_computed"].size(), 2u);
  EXPECT_EQ(kept["not_computed"][1]["vertex"], 1);
  EXPECT_EQ(kept["not_computed"][1]["error"], "image IMG_2.jpg is not oriented");
  EXPECT_EQ(kept["vertices"][1]["position"], plotted[1]["position"]);
  ASSERT_TRUE(write_file(project() / "products" / "dsm.tif", "broken"));
  const json as_drawn = drawing();
  EXPECT_TRUE(as_drawn["as_drawn"].is_string()) << as_drawn;
  EXPECT_EQ(as_drawn["features"][0]["vertices"][0]["position"], plotted[0]["position"]);
  EXPECT_TRUE(as_drawn["features"][0]["moved_m"].is_null());
}

TEST_F(DrawingRoutes, VolumesAndProfilesAreThoseOfTheCommands) {
  json ring = json::array();
  std::string area;
  for (const Eigen::Vector3d& corner : roof()) {
    ring.push_back({corner.x(), corner.y()});
    area += fmt::format("{:.9f} {:.9f}\n", corner.x(), corner.y());
  }
  ASSERT_TRUE(write_file(folder_ / "area.txt", area));
  const double base = roof()[0].z() - 2;
  const MeasureVolumeOptions asked{.base = fmt::format("{}", base), .area = folder_ / "area.txt", .output = {}};
  const auto measured = measure_volume(project() / "products" / "dsm.tif", asked, {}, {});
  ASSERT_TRUE(measured) << measured.error().message;
  const json volume = answer("volume", {{"ring", ring}, {"base", base}});
  EXPECT_NEAR(volume["net_m3"].get<double>() / measured->volume.net_m3(), 1, 1e-6);  // nine decimals of the corners
  EXPECT_NEAR(volume["sigma_m3"].get<double>() / measured->volume.sigma_m3(), 1, 1e-6);
  EXPECT_NEAR(volume["net_m3"].get<double>(), 160, 0.1);
  const json profile = answer("profile", {{"line", {ring[0], ring[1]}}});
  EXPECT_NEAR(profile["distance_m"].back().get<double>(), 10, 1e-6);
  EXPECT_NEAR(profile["height_m"][5].get<double>(), roof()[0].z(), 1e-3);
  EXPECT_NEAR(profile["sigma_m"][5].get<double>(), 0.06, 1e-6);
}

TEST_F(DrawingRoutes, OddRequestsAreRefused) {
  const char* bodies[] = {"",
                          "[]",
                          "{}",
                          "null",
                          "{\"vertices\": {}}",
                          "{\"vertices\": []}",
                          "{\"vertices\": [1]}",
                          "{\"vertices\": [{}]}",
                          "{\"vertices\": [{\"marks\": []}]}",
                          "{\"vertices\": [{\"marks\": [{\"image\": -1, \"pixel\": [1, 2]}]}]}",
                          "{\"vertices\": [{\"marks\": [{\"image\": 1, \"pixel\": [1]}]}]}",
                          "{\"vertices\": [{\"surface\": [1e999, 2]}]}",
                          "{\"vertices\": [{\"at\": [1, 2, \"3\"]}]}",
                          "{\"vertices\": [{\"at\": [1, 2, 3], \"sigma_m\": -1}]}",
                          "{\"vertices\": [{\"feature\": \"F9\", \"vertex\": 0}]}",
                          "{\"vertices\": [[[[[[[[[[[[]]]]]]]]]]]]}",
                          "{\"line\": [[0, 0], [1e300, 0]]}",
                          "{\"line\": [[0, 0], [1, 0]], \"step_m\": 0}",
                          "{\"ring\": [[0, 0], [1, 1]]}",
                          "{\"ring\": [[0, 0], [1, 1], [2, 0]], \"base\": \"hill\"}"};
  for (const char* body : bodies)
    for (const char* what : {"vertices", "figures", "volume", "profile"}) {
      const HttpResponse response = ask(what, body);
      EXPECT_GE(response.status, 400) << what << " " << body;
      EXPECT_LT(response.status, 500) << what << " " << body << response.body;
    }
  EXPECT_EQ(ask("figures", R"({"kind": "distance", "vertices": [{"surface": [0, 0]}]})").status,
            422);  // no surface there
  EXPECT_EQ(ask("vertices", "", "GET").status, 405);
  EXPECT_EQ(ask("drawing", "{}").status, 405);
  EXPECT_EQ(ask("drawing?image=77", "", "GET").status, 404);
  EXPECT_EQ(ask("drawing?image=x", "", "GET").status, 400);
  // A feature that was just taken away, or a vertex of it, has no figures: each says why.
  for (const json& removed : {json{{"feature", "F9"}, {"vertex", 0}}, json{{"feature", "A"}, {"vertex", 99}}}) {
    const json none = answer("figures", {{"figures", {"distance", "slope"}}, {"vertices", {removed, removed}}})["figures"];
    ASSERT_EQ(none.size(), 2u);
    EXPECT_EQ(none[0]["kind"], "distance");
    EXPECT_TRUE(none[1].contains("error")) << none.dump();
  }
  // A vertex that cannot be had says why; the others are answered.
  const json some =
      answer("vertices",
             {{"vertices",
               {{{"surface", {0, 0}}}, corners()[3], {{"marks", {{{"image", 1}, {"pixel", {-5, 5}}}}}}}}})["vertices"];
  EXPECT_TRUE(some[0].contains("error"));
  EXPECT_TRUE(some[1].contains("position"));
  EXPECT_NE(some[2]["error"].get<std::string>().find("not inside"), std::string::npos);
}

}  // namespace
}  // namespace collinea
