// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/render.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/synthetic/survey.h"

namespace collinea {
namespace {

SurveyOptions tiny_survey() {
  SurveyOptions o;
  o.images = 3;
  o.gsd_m = 0.1;
  o.camera.width_px = 320;
  o.camera.height_px = 240;
  o.control_points = 2;
  o.check_points = 2;
  return o;
}

ColourImage image_of(const Truth& truth, ImageId image, int threads = 1) {
  Run run;
  run.threads = threads;
  return *render(truth, image, RayTable(truth.block.camera_of(image), run), run);
}

TEST(Render, DoesNotDependOnThreads) {
  const Truth truth = *make_survey(tiny_survey());
  EXPECT_EQ(image_of(truth, ImageId{1}).data, image_of(truth, ImageId{1}, 2).data);
}

// Green keeps its exposure; the light of red and blue is changed by one factor each, in grey levels by factor^(1
// / 2.2).
TEST(Render, WhiteBalanceChangesRedAndBlueOfAnImageAsAWhole) {
  SurveyOptions o = tiny_survey();
  o.light.noise_grey = 0;
  const ColourImage plain = image_of(*make_survey(o), ImageId{1});
  o.white_balance_sigma = 0.1;
  const Truth truth = *make_survey(o);
  const ColourImage tinted = image_of(truth, ImageId{1});
  const auto& white = truth.white.at(ImageId{1});
  EXPECT_EQ(white[1], 1);
  EXPECT_NE(white[0], white[2]);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < plain.data.size(); ++i) {
    if (plain.data[i] > 200) continue;  // may be clipped: 255 / 200 is five sigmas
    ++compared;
    ASSERT_NEAR(tinted.data[i], plain.data[i] * std::pow(white[i % 3], 1 / 2.2), 1.2) << i;  // both are rounded
  }
  EXPECT_GT(compared, plain.data.size() / 2);
}

TEST(Render, UsesTheWholeRangeOfGreys) {
  const ColourImage image = image_of(*make_survey(tiny_survey()), ImageId{1});
  double sum = 0, squares = 0;
  for (std::uint8_t value : image.data) {
    sum += value;
    squares += double(value) * value;
  }
  const double mean = sum / double(image.data.size());
  EXPECT_GT(mean, 60);
  EXPECT_LT(mean, 180);
  EXPECT_GT(std::sqrt(squares / double(image.data.size()) - mean * mean), 15);
}

// Two exposures that differ by noise alone; rounding to whole levels adds 1/12 to each variance.
TEST(Render, NoiseHasItsStandardDeviation) {
  SurveyOptions o = tiny_survey();
  o.light.noise_grey = 0;
  const ColourImage clean = image_of(*make_survey(o), ImageId{1});
  o.light.noise_grey = 3;
  const ColourImage noisy = image_of(*make_survey(o), ImageId{1});
  double sum = 0, squares = 0, n = 0;
  for (std::size_t i = 0; i < clean.data.size(); i += 3) {
    if (clean.data[i] < 20 || clean.data[i] > 235) continue;  // clipped
    const double difference = double(noisy.data[i]) - clean.data[i];
    sum += difference;
    squares += difference * difference;
    ++n;
  }
  EXPECT_NEAR(sum / n, 0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(9 + 1.0 / 6), 0.05);
}

// A mark is symmetric about its centre. The position about which the image is most symmetric is where the centre is
// projected: within a step of the search and the ground's own asymmetry outside the board.
TEST(Render, MarksAppearWhereTheyAreProjected) {
  SurveyOptions o = tiny_survey();
  o.light.noise_grey = 0;
  const Truth truth = *make_survey(o);
  int looked_at = 0;
  for (const auto& [id, mark] : truth.marks_in_world) {
    const ImageId image{1};
    const auto pixel = seen_at(truth, image, mark, 15);
    if (!pixel) continue;
    const ColourImage raster = image_of(truth, image);
    double best = 1e30;
    Eigen::Vector2d found = *pixel;
    for (double dy = -1; dy <= 1; dy += 0.05)
      for (double dx = -1; dx <= 1; dx += 0.05) {
        const Eigen::Vector2d centre = *pixel + Eigen::Vector2d(dx, dy);
        double asymmetry = 0;
        for (int j = 0; j <= 3; ++j)
          for (int i = -3; i <= 3; ++i)
            asymmetry += std::pow(bilinear(raster, centre.x() + i, centre.y() + j, 1) -
                                      bilinear(raster, centre.x() - i, centre.y() - j, 1),
                                  2);
        if (asymmetry < best) {
          best = asymmetry;
          found = centre;
        }
      }
    EXPECT_LT((found - *pixel).norm(), 0.12) << "mark " << id.value;
    ++looked_at;
  }
  EXPECT_GE(looked_at, 2);
}

TEST(Render, TheRayTableAgreesWithTheCamera) {
  const Truth truth = *make_survey(tiny_survey());
  const Camera& camera = truth.block.camera_of(ImageId{0});
  const RayTable table(camera, {});
  for (int row = 0; row < 240; row += 7)
    for (int column = 0; column < 320; column += 7)
      for (double offset : {-0.33, 0.0, 0.33}) {
        const auto pixel = project(camera, table.direction(column, row, offset, -offset));
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - Eigen::Vector2d(column + 0.5 + offset, row + 0.5 - offset)).norm(), 1e-3);
      }
  const auto pixel = project(camera, table.direction(17, 211));
  EXPECT_LT((*pixel - Eigen::Vector2d(17.5, 211.5)).norm(), 1e-4);
}

TEST(Render, StopsWhenAsked) {
  const Truth truth = *make_survey(tiny_survey());
  const RayTable rays(truth.block.camera_of(ImageId{0}), {});
  std::stop_source source;
  source.request_stop();
  collinea::Run run;
  run.stop = source.get_token();
  const auto image = render(truth, ImageId{0}, rays, run);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, Errc::kCancelled);
}

TEST(Render, ToneGoesFromBlackToWhite) {
  EXPECT_EQ(tone(-1), 0);
  EXPECT_EQ(tone(0), 0);
  EXPECT_EQ(tone(1), 255);
  EXPECT_EQ(tone(7), 255);
  EXPECT_NEAR(tone(0.5f), 255 * std::pow(0.5, 1 / 2.2), 0.01);
}

}  // namespace
}  // namespace collinea
