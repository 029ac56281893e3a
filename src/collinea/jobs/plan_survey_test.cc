// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/plan_survey.h"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/control_file.h"
#include "collinea/plan/test_flight.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

using nlohmann::json;

const Run kSerial;

struct GdalClose {
  void operator()(void* dataset) const { GDALClose(dataset); }
};

TEST(PlanSurvey, TellsTheSameInTextJsonRasterAndGeoPackage) {
  const TestFolder folder;
  FlightOptions flight = small_flight();
  flight.west_m = 546000;
  flight.south_m = 5338000;
  MeasurementOptions measurements = small_measurements();
  measurements.map_cell_m = 10;
  const auto text = plan_survey(flight, {}, measurements, {.crs = "EPSG:32633", .candidates = 2, .trials = 2},
                                folder / "out", kSerial);
  ASSERT_TRUE(text) << text.error().message;
  const json plan = json::parse(read_file(folder / "out" / "plan.json").value());
  EXPECT_EQ(plan.at("crs"), "WGS 84 / UTM zone 33N");
  EXPECT_EQ(plan.at("gains").size(), 3u);
  EXPECT_EQ(plan.at("trials").at("blocks"), 2);
  const double height_m = plan.at("area").at("rms_m").at(2).get<double>();
  EXPECT_GT(height_m, 0);

  // The raster's root mean square is that of the table.
  const auto raster = GeoTiffReader::open(folder / "out" / "sigma.tif");
  ASSERT_TRUE(raster) << raster.error().message;
  EXPECT_EQ(raster->grid().width, 9);
  EXPECT_EQ(raster->grid().height, 6);
  EXPECT_EQ(raster->grid().west_m, 546000);
  EXPECT_FALSE(raster->grid().wkt.empty());
  const FloatImage sigmas = raster->read_float(0, 0, 9, 6).value();
  double sum = 0;
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 9; ++x) sum += std::pow(double(sigmas.at(x, y, 2)), 2);
  EXPECT_NEAR(std::sqrt(sum / 54), height_m, 1e-6);

  // And so is that of the layer, read by GDAL.
  const std::unique_ptr<void, GdalClose> package(
      GDALOpenEx((folder / "out" / "plan.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  ASSERT_TRUE(package);
  const OGRLayerH layer = GDALDatasetGetLayerByName(package.get(), "sigma");
  ASSERT_TRUE(layer);
  sum = 0;
  int rows = 0;
  while (const OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
    sum += std::pow(OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, "sigma_h_m")), 2);
    ++rows;
    OGR_F_Destroy(feature);
  }
  EXPECT_EQ(rows, 54);
  EXPECT_NEAR(std::sqrt(sum / 54), height_m, 1e-12);
  for (const char* name : {"site", "images", "control"})
    EXPECT_TRUE(GDALDatasetGetLayerByName(package.get(), name)) << name;

  const std::string page = read_file(folder / "out" / "plan.html").value();
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_NE(page.find("<svg"), std::string::npos);
}

TEST(PlanSurvey, TheControlItWritesCanBePlannedAgain) {
  const TestFolder folder;
  const PlanOptions plain{.gains = false};
  ASSERT_TRUE(plan_survey(small_flight(), {}, small_measurements(), plain, folder / "a", kSerial));
  const ControlFile control = read_control(folder / "a" / "control.csv").value();
  ASSERT_EQ(control.points.size(), 5u);
  EXPECT_EQ(control.points[4].name, "G5");
  LayoutOptions layout;
  layout.control = (folder / "a" / "control.csv").string();
  ASSERT_TRUE(plan_survey(small_flight(), layout, small_measurements(), plain, folder / "b", kSerial));
  const json first = json::parse(read_file(folder / "a" / "plan.json").value()),
             second = json::parse(read_file(folder / "b" / "plan.json").value());
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(first.at("points").at(i).at("name"), second.at("points").at(i).at("name"));
    EXPECT_EQ(first.at("points").at(i).at("survey_sigma_m"), second.at("points").at(i).at("survey_sigma_m"));
  }
  for (std::size_t axis = 0; axis < 3; ++axis)  // positions are written in millimetres
    EXPECT_NEAR(first.at("area").at("rms_m").at(axis).get<double>(),
                second.at("area").at("rms_m").at(axis).get<double>(), 1e-9);
}

TEST(PlanSurvey, TheSameBitsOnAnyNumberOfThreads) {
  const TestFolder folder;
  collinea::Run one, four;
  four.threads = 4;
  ASSERT_TRUE(plan_survey(small_flight(), {}, small_measurements(), {.candidates = 2}, folder / "one" / "s", one));
  ASSERT_TRUE(plan_survey(small_flight(), {}, small_measurements(), {.candidates = 2}, folder / "four" / "s", four));
  for (const char* file : {"plan.json", "plan.html", "stations.csv", "plan.gpkg", "sigma.tif"})
    EXPECT_TRUE(read_file(folder / "one" / "s" / file).value() == read_file(folder / "four" / "s" / file).value())
        << file;
}

TEST(PlanSurvey, WhatIsWrongIsNamed) {
  const TestFolder folder;
  const auto error = [&](const FlightOptions& flight, const LayoutOptions& layout, const PlanOptions& options) {
    const auto done = plan_survey(flight, layout, small_measurements(), options, folder / "out", kSerial);
    return done ? std::string() : done.error().message;
  };
  FlightOptions flight = small_flight();
  LayoutOptions layout;
  layout.control = "nowhere.csv";
  EXPECT_NE(error(flight, layout, {}).find("nowhere.csv"), std::string::npos);
  EXPECT_NE(error(flight, {}, {.area = "missing.csv"}).find("missing.csv"), std::string::npos);
  EXPECT_NE(error(flight, {}, {.crs = "EPSG:4326"}).find("degrees"), std::string::npos);
  ASSERT_TRUE(write_file(folder / "area.csv", "0, 0\n9, nine\n"));
  EXPECT_NE(error(flight, {}, {.area = (folder / "area.csv").string()}).find("line 2"), std::string::npos);
}

}  // namespace
}  // namespace collinea
