// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/model_tables.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TextTable table(std::string_view text) { return *parse_text_table(text); }

TEST(ModelTables, ModelsAreReadInTheirUnit) {
  const auto given = models_of(table("model point U[mm] V[mm] W[mm] sigma_U[um] sigma_V[um] sigma_W[um]\n"
                                     "a 1 10 20 30 5 5 8\n"
                                     "b 1 1 2 3 5 5 8\n"
                                     "a 2 11 21 31 6 6 9\n"),
                               {});
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_TRUE(given->sigmas_given);
  EXPECT_EQ(given->unit, "mm");
  ASSERT_EQ(given->models.size(), 2);
  EXPECT_EQ(given->models[0].points[1].position, Eigen::Vector3d(11, 21, 31));
  EXPECT_NEAR(given->models[0].points[1].covariance(2, 2), 0.009 * 0.009, 1e-15);
}

TEST(ModelTables, MissingSigmasAreGuessedOrAsked) {
  const TextTable text = table("model point U V W\na 1 0 0 0\na 2 200 0 0\n");
  EXPECT_FALSE(models_of(text, {})->sigmas_given);
  EXPECT_NEAR(models_of(text, {})->sigma, 0.01, 1e-12);
  EXPECT_TRUE(models_of(text, 0.5)->sigmas_given);
  EXPECT_NEAR(models_of(text, 0.5)->models[0].points[0].covariance(0, 0), 0.25, 1e-12);
}

TEST(ModelTables, CovariancesGoBetweenPoints) {
  auto given = *models_of(table("model point U V W\na 1 0 0 0\na 2 2 0 0\n"), {});
  const std::string titles = "model point other UU UV UW VU VV VW WU WV WW\n";
  const auto add = [&](const std::string& rows) { return add_covariances(given, table(titles + rows)); };
  ASSERT_TRUE(add("a 1 1 1 0 0 0 1 0 0 0 4\na 2 2 1 0 0 0 1 0 0 0 4\na 1 2 .1 .2 .3 .4 .5 .6 .7 .8 .9\n"));
  EXPECT_TRUE(given.sigmas_given);
  EXPECT_EQ(given.models[0].covariance(0, 4), 0.2);
  EXPECT_EQ(given.models[0].covariance(4, 0), 0.2);
  EXPECT_EQ(given.models[0].covariance(2, 2), 4);
  EXPECT_FALSE(add("c 1 1 1 0 0 0 1 0 0 0 4\n"));
  EXPECT_FALSE(add("a 7 1 1 0 0 0 1 0 0 0 4\n"));
  EXPECT_FALSE(add("a 1 1 1 9 0 0 1 0 0 0 4\n"));
  EXPECT_FALSE(add("a 1 2 1 0 0 0 1 0 0 0 4\na 2 1 1 0 0 0 1 0 0 0 4\n"));
}

TEST(ModelTables, ControlMayBeOfPlanOrOfHeight) {
  const auto points = surveyed_points_of(table("point,X[km],Y[km],Z[m],sigma[cm],role\n"
                                               "1, 1.5, 2, 30, 2,\n"
                                               "2, 1, 2, -, 0, control\n"
                                               "3, -, -, 31, 1, check\n"),
                                         0.1);
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_EQ((*points)[0].position, Eigen::Vector3d(1500, 2000, 30));
  EXPECT_NEAR((*points)[0].sigma.x(), 0.02, 1e-12);
  EXPECT_TRUE((*points)[1].has_plan());
  EXPECT_FALSE((*points)[1].has(2));
  EXPECT_FALSE((*points)[2].has_plan());
  EXPECT_TRUE((*points)[2].is_check);
  EXPECT_FALSE(surveyed_points_of(table("point X Y Z\n1 1 - 2\n"), 0));
  EXPECT_FALSE(surveyed_points_of(table("point X Y Z\n1 - - -\n"), 0));
  EXPECT_FALSE(surveyed_points_of(table("point X Y Z role\n1 1 1 1 checked\n"), 0));
  EXPECT_FALSE(surveyed_points_of(table("point X Y Z sigma\n1 1 1 1 -3\n"), 0));
}

}  // namespace
}  // namespace collinea
