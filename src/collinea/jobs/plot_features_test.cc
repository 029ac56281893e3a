// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/plot_features.h"

#include <fmt/format.h>
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include "collinea/base/file.h"
#include "collinea/block/transform.h"
#include "collinea/edit/make_edits.h"
#include "collinea/jobs/drawing_files.h"
#include "collinea/jobs/test_plot_project.h"
#include "collinea/raster/gdal_access.h"

namespace collinea {
namespace {

class PlotFeatures : public testing::PlotProjectTest {
 protected:
  Result<PlotReport> plot(const std::string& table, const PlotOptions& options = {}) {
    EXPECT_TRUE(write_file(folder_ / "features.txt", table));
    return plot_features(project(), folder_ / "features.txt", options, {});
  }
  // A roof by marks in two images, one in a single image, one by clicks on the map, one by coordinates.
  [[nodiscard]] std::string four_roofs() const {
    std::string text = "feature vertex code kind image x[px] y[px] sigma[px] E[m] N[m] H[m] sigma_m\n";
    const auto corners = roof();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (const std::uint32_t image : {1u, 2u})
        text += fmt::format("both {} R - IMG_{}.jpg {:.6f} {:.6f} 0.3 - - - -\n", i, image,
                            pixel(image, corners[i]).x(), pixel(image, corners[i]).y());
      text += fmt::format("one {} R - IMG_1.jpg {:.6f} {:.6f} - - - - -\n", i, pixel(1, corners[i]).x(),
                          pixel(1, corners[i]).y());
      text += fmt::format("map - - polygon - - - - {:.6f} {:.6f} - 0.1\n", corners[i].x(), corners[i].y());
      text += fmt::format("typed - - polygon - - - - {:.6f} {:.6f} {:.6f} 0.02\n", corners[i].x(), corners[i].y(),
                          corners[i].z());
    }
    return text;
  }
};

// Everything is exact but for six decimals of pixels and heights as floats: a millimetre.
TEST_F(PlotFeatures, EachWayOfPlottingGivesTheRoof) {
  const auto report = plot(four_roofs(), {.figures = "area both; area map; distance one.1 one.2; height_difference "
                                                     "typed.1 both.1"});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->crs, "EPSG:32633");
  ASSERT_EQ(report->features.size(), 4u);
  const VertexSource sources[] = {VertexSource::kStereo, VertexSource::kMono, VertexSource::kSurface,
                                  VertexSource::kTyped};
  for (std::size_t f = 0; f < 4; ++f) {
    const PlotReport::Feature& feature = report->features[f];
    EXPECT_EQ(feature.kind, VectorKind::kPolygon);
    ASSERT_EQ(feature.vertices.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_TRUE(feature.vertices[i].drawn) << feature.vertices[i].refused;
      EXPECT_EQ(feature.vertices[i].drawn->source, sources[f]);
      EXPECT_LT((feature.vertices[i].drawn->position - roof()[i]).norm(), 1e-3) << feature.id << " " << i;
      EXPECT_TRUE(feature.vertices[i].drawn->covariance_m2) << feature.id;
    }
  }
  // Lengths on the ground, not of the map: 3e-4 shorter or longer.
  for (const int figure : {0, 1}) EXPECT_NEAR(report->figures[std::size_t(figure)].measured->value, 80, 0.1);
  EXPECT_NEAR(report->figures[2].measured->value, 10, 0.01);
  EXPECT_NEAR(report->figures[3].measured->value, 0, 1e-3);
  for (const auto& figure : report->figures) EXPECT_GT(figure.measured->sigma, 1e-3);
  EXPECT_NE(plot_text(*report).find("4 features drawn, in EPSG:32633: products/drawing.gpkg"), std::string::npos)
      << plot_text(*report);
}

TEST_F(PlotFeatures, FilesOfTheDrawingAreReadByGdalWithTheirCrs) {
  ASSERT_TRUE(plot(four_roofs()));
  set_up_gdal();
  const GdalDataset file(
      GDALOpenEx((project() / "products" / "drawing.gpkg").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  const OGRLayerH roofs = GDALDatasetGetLayerByName(file.get(), "roof_polygon");
  ASSERT_TRUE(roofs);
  EXPECT_EQ(std::string(OSRGetAuthorityCode(OGR_L_GetSpatialRef(roofs), nullptr)), "32633");
  EXPECT_EQ(OGR_L_GetFeatureCount(roofs, 1), 2);
  const OGRFeatureH feature = OGR_L_GetNextFeature(roofs);
  EXPECT_NEAR(OGR_G_Area(OGR_F_GetGeometryRef(feature)), 80, 1e-2);
  EXPECT_EQ(std::string(OGR_F_GetFieldAsString(feature, OGR_F_GetFieldIndex(feature, "code"))), "R");
  EXPECT_GT(OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, "sigma_h_m")), 0);
  OGR_F_Destroy(feature);
  EXPECT_EQ(OGR_L_GetFeatureCount(GDALDatasetGetLayerByName(file.get(), "vertices"), 1), 16);
  const GdalDataset drawing(
      GDALOpenEx((project() / "products" / "drawing.dxf").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(drawing);
  const OGRLayerH entities = GDALDatasetGetLayer(drawing.get(), 0);
  EXPECT_EQ(OGR_L_GetFeatureCount(entities, 1), 4);
  const OGRFeatureH entity = OGR_L_GetNextFeature(entities);
  EXPECT_EQ(OGR_G_GetPointCount(OGR_F_GetGeometryRef(entity)), 5);  // closed
  EXPECT_NEAR(OGR_G_GetZ(OGR_F_GetGeometryRef(entity), 0), roof()[0].z(), 1e-3);
  OGR_F_Destroy(entity);
  // A DXF has no CRS of its own: beside it stands what gives its layers to GDAL in theirs, and the CRS alone.
  const GdalDataset in_crs(
      GDALOpenEx((project() / "products" / "drawing.vrt").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(in_crs);
  std::map<std::string, std::int64_t> counts;
  for (int i = 0; i < GDALDatasetGetLayerCount(in_crs.get()); ++i) {
    const OGRLayerH layer = GDALDatasetGetLayer(in_crs.get(), i);
    counts[OGR_L_GetName(layer)] = OGR_L_GetFeatureCount(layer, 1);
    ASSERT_TRUE(OGR_L_GetSpatialRef(layer));
    EXPECT_EQ(std::string(OSRGetAuthorityCode(OGR_L_GetSpatialRef(layer), nullptr)), "32633");
  }
  EXPECT_EQ(counts, (std::map<std::string, std::int64_t>{{"drawing", 2}, {"roof", 2}}));
  const auto prj = read_file(project() / "products" / "drawing.prj");
  ASSERT_TRUE(prj);
  const OGRSpatialReferenceH srs = OSRNewSpatialReference(prj->c_str());
  EXPECT_EQ(std::string(OSRGetAuthorityCode(srs, nullptr)), "32633");
  OSRRelease(srs);
}

TEST_F(PlotFeatures, NoCrsStaysBesideADrawingWithout) {
  ASSERT_TRUE(plot(four_roofs()));
  const auto is_left = [&](const char* name) { return is_there(project() / "products" / name); };
  ASSERT_TRUE(is_left("drawing.vrt") && is_left("drawing.prj"));
  Block block = block_;
  block.georeference.reset();
  ASSERT_TRUE(ProjectStore::open(project())->write_setup(block));
  const auto opened = open_project(project(), {});
  ASSERT_TRUE(opened) << opened.error().message;
  const auto written = write_drawing(*opened, {}, {});
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(written->files.size(), 2u);
  EXPECT_TRUE(is_left("drawing.dxf"));
  EXPECT_FALSE(is_left("drawing.vrt") || is_left("drawing.prj"));
}

// The block is adjusted again and comes to lie elsewhere: what was drawn by marks follows, as it would be drawn now;
// what was typed stays; what was marked in a photograph that is gone stays where it was drawn. The journal does not
// change.
TEST_F(PlotFeatures, WhatIsDrawnByMarksFollowsTheAdjustment) {
  ASSERT_TRUE(plot(four_roofs()));
  const std::string journal = read_file(project() / "journal.jsonl").value();
  const auto unmoved = plot_features(project(), std::nullopt, {}, {});
  ASSERT_TRUE(unmoved) << unmoved.error().message;
  EXPECT_EQ(unmoved->recomputed, 8u);
  EXPECT_TRUE(unmoved->moved.empty() && unmoved->as_drawn.empty());
  const Eigen::Vector3d shift(0.5, -0.25, 0.75);
  Block moved = block_;
  transform(moved, Similarity3{1, Eigen::Quaterniond::Identity(), shift});
  {
    auto store = ProjectStore::open(project());
    ASSERT_TRUE(store && store->write_adjustment(moved, *store->read_covariances()));
  }
  const auto report = plot_features(project(), std::nullopt, {.figures = "area both"}, {});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->moved.size(), 2u);  // both and one
  EXPECT_EQ(report->moved[0].id, "both");
  EXPECT_NEAR(report->moved[0].moved_m, shift.norm(), 2e-3);
  EXPECT_GT(report->moved[0].moved_sigmas, 3);
  EXPECT_NE(plot_text(*report).find("feature both: computed anew, it moved by 0.9"), std::string::npos)
      << plot_text(*report);
  ASSERT_TRUE(report->figures[0].measured) << report->figures[0].refused;
  EXPECT_NEAR(report->figures[0].measured->value, 80, 0.1);
  set_up_gdal();
  const GdalDataset file(
      GDALOpenEx((project() / "products" / "drawing.gpkg").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  const OGRLayerH vertices = GDALDatasetGetLayerByName(file.get(), "vertices");
  std::map<std::string, double> first_east;
  while (const OGRFeatureH vertex = OGR_L_GetNextFeature(vertices)) {
    const std::string id = OGR_F_GetFieldAsString(vertex, OGR_F_GetFieldIndex(vertex, "feature"));
    first_east.try_emplace(id, OGR_G_GetX(OGR_F_GetGeometryRef(vertex), 0) - roof()[0].x());
    OGR_F_Destroy(vertex);
  }
  // The world's x axis is east but for the convergence of the map.
  EXPECT_NEAR(first_east.at("both"), shift.x(), 0.01);
  EXPECT_NEAR(first_east.at("typed"), 0, 1e-5);
  EXPECT_EQ(read_file(project() / "journal.jsonl").value(), journal);
  // A photograph is no longer oriented: what is marked in it stays as it was drawn.
  remove_pose(moved, ImageId{2});
  {
    auto store = ProjectStore::open(project());
    BlockCovariances covariances = *store->read_covariances();
    covariances.poses.erase(ImageId{2});
    ASSERT_TRUE(store->write_adjustment(moved, covariances));
  }
  const auto kept = plot_features(project(), std::nullopt, {}, {});
  ASSERT_TRUE(kept) << kept.error().message;
  ASSERT_EQ(kept->as_drawn.size(), 1u);
  EXPECT_EQ(kept->as_drawn[0].id, "both");
  EXPECT_EQ(kept->as_drawn[0].kept.size(), 4u);
  EXPECT_NE(
      plot_text(*kept).find("feature both: 4 of its vertices cannot be computed anew and stay as drawn: vertex 1: "
                            "image IMG_2.jpg is not oriented"),
      std::string::npos)
      << plot_text(*kept);
}

TEST_F(PlotFeatures, WhatCannotBePlottedIsStatedAndNotDrawn) {
  const auto report = plot("feature,image,x,y\na,IMG_1.jpg,500,400\nb,IMG_1.jpg,1,1\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->features[0].vertices[0].drawn);
  EXPECT_FALSE(report->features[1].vertices[0].drawn);  // beside the surface
  EXPECT_EQ(report->features_in_force, 1u);
  EXPECT_NE(plot_text(*report).find("feature b is not drawn: vertex 1: the ray does not meet"), std::string::npos)
      << plot_text(*report);
  const struct {
    const char *table, *part;
  } cases[] = {{"feature image x y\na IMG_7.jpg 1 1\n", "row 1: there is no image \"IMG_7.jpg\""},
               {"feature image x y\na - 1 1\n", "row 1: it gives neither an image"},
               {"feature image x y\na IMG_1.jpg 1 -\n", "row 1: the mark has no x, y"},
               {"feature E N kind\na 1 1 blob\n", "\"blob\" is no kind"},
               {"feature E N code\na 1 1 ZZ\n", "no code \"ZZ\""},
               {"name E N\na 1 1\n", "feature"}};
  for (const auto& [table, part] : cases) {
    const auto refused = plot(table);
    ASSERT_FALSE(refused) << table;
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
  }
}

// What a journal could not be read with is refused before it is written.
TEST_F(PlotFeatures, FeaturesThatCannotBeReadAgainAreRefusedAndTheJournalStaysWhole) {
  ASSERT_TRUE(plot("feature,E,N,H\na,546800,5338600,300\n"));
  const std::string before = read_file(project() / "journal.jsonl").value();
  const struct {
    std::string table, part;
    PlotOptions options;
  } cases[] = {{"feature,E,N,H,kind\nb,1,2,3,polygon\n", "a polygon has 3 vertices or more", {}},
               {"feature,E,N,H,kind\nb,1,2,3,point\nb,2,3,4,point\n", "a point has 1 vertex", {}},
               {"feature,E,N,H\nb,1,2,3\n", "LAYER", {.layer = ""}},
               {"feature,E,N,H\n*,1,2,3\n", "* is no feature", {}},
               {"feature,E,N,H\nF123456789012345,1,2,3\n", "more than 14 digits", {}}};
  for (const auto& [table, part, options] : cases) {
    const auto refused = plot(table, options);
    ASSERT_FALSE(refused) << table;
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
    EXPECT_EQ(read_file(project() / "journal.jsonl").value(), before);
  }
  EXPECT_TRUE(plot_features(project(), std::nullopt, {}, {}));
}

TEST_F(PlotFeatures, AFigureThatCannotBeMeasuredSaysSoAndTheRestIsDone) {
  const auto report = plot(four_roofs(), {.figures = "area both; distance both.1 none; distance one.1 one.9"});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->features_in_force, 4u);
  EXPECT_TRUE(report->figures[0].measured);
  for (const std::size_t i : {1u, 2u})
    EXPECT_NE(report->figures[i].refused.find("no vertex is called"), std::string::npos) << report->figures[i].refused;
  // Features that were drawn before can be named, and one of them is all that is plotted anew.
  const auto again = plot_features(project(), std::nullopt, {.figures = "area both"}, {});
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_TRUE(again->figures[0].measured) << again->figures[0].refused;
  EXPECT_NEAR(again->figures[0].measured->value, report->figures[0].measured->value, 1e-6);
}

TEST_F(PlotFeatures, WithoutATableTheFilesFollowTheEdits) {
  ASSERT_TRUE(plot(four_roofs()));
  Journal journal(project());
  const std::vector<Edit> undo = {Undo{}};
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(make_edits(project(), journal, undo));  // codes come and go with features
  const auto report = plot_features(project(), std::nullopt, {}, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->features_in_force, 0u);
}

}  // namespace
}  // namespace collinea
