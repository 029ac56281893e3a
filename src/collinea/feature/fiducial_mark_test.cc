// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/fiducial_mark.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "collinea/feature/fiducial_search.h"
#include "collinea/feature/scan_for_tests.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr MarkKind kKinds[] = {MarkKind::kCross, MarkKind::kDot, MarkKind::kRing, MarkKind::kCorner, MarkKind::kNotch};

// A small film with one mark in its lower left.
FilmCalibration one_mark(MarkKind kind) {
  FilmCalibration c;
  c.marks = {{.name = "1", .film_mm = {-1, -1}, .kind = kind}};
  c.mark_size_mm = kind == MarkKind::kDot ? 0.4 : 1;
  c.line_mm = 0.12;
  c.size_mm = {4, 4};
  return c;
}

FilmTransformation scan_of(double column, double row, double rotation) {
  FilmTransformation t;
  t.model = FilmModel::kAffine;
  t.parameters = (Eigen::VectorXd(6) << column, row, rotation, 40.03, 39.97, 1e-3).finished();
  return t;
}

// Positions to a tenth of a pixel, and what they claim to know is true: chi-squared of errors over covariances, with
// grain that neighbours share.
class MarkOfAKind : public ::testing::TestWithParam<MarkKind> {};
TEST_P(MarkOfAKind, ItsPositionIsExactAndItsCovarianceTrue) {
  const MarkKind kind = GetParam();
  const FilmCalibration c = one_mark(kind);
  const MarkModel drawn = drawn_mark(kind, 40 * c.mark_size_mm, 40 * c.line_mm,
                                     kind == MarkKind::kCorner || kind == MarkKind::kNotch ? -std::numbers::pi / 4 : 0);
  const int seeds = 24;
  double chi2 = 0, squares = 0, largest = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Random random(3, std::uint64_t(seed));
    const double rotation = random.uniform(-0.01, 0.01);
    const FilmTransformation truth = scan_of(100 + random.uniform(), 100 + random.uniform(), rotation);
    const ScanLook look{.blur_px = random.uniform(0.7, 1.8), .grain = 4, .grain_blur_px = 0.6};
    const GreyImage scan = rendered_scan(c, truth, 200, 200, look, 1.0, random);
    const Vector2d at = truth.pixel_of(c.marks[0].film_mm);
    const auto found = match_mark(scan, drawn, at + Vector2d(random.uniform(-2, 2), random.uniform(-2, 2)),
                                  {rotation, 0.001, 0.03, 0.001});
    ASSERT_TRUE(found) << at.transpose() << word_of(kind) << seed;
    const Vector2d off = found->pixel - at;
    chi2 += off.dot(found->covariance.inverse() * off);
    squares += off.squaredNorm();
    largest = std::max(largest, off.norm());
  }
  // One side of a corner or a notch is all that holds it.
  EXPECT_LT(largest, kind == MarkKind::kCorner || kind == MarkKind::kNotch ? 0.2 : 0.1) << word_of(kind);
  EXPECT_NEAR(chi2 / seeds / 2, 1, 4 / std::sqrt(double(seeds))) << word_of(kind);
}

INSTANTIATE_TEST_SUITE_P(All, MarkOfAKind, ::testing::ValuesIn(kKinds));

// Without grain what is left is of the drawing and of its interpolation: edges along the rows and along their
// diagonals. Points of a lattice that lie upon an edge through the middle would shift a notch by 0.007 px.
TEST(FiducialMark, EdgesOnOneSideShiftNoMark) {
  for (const MarkKind kind : {MarkKind::kCorner, MarkKind::kNotch})
    for (const double y_mm : {-1.0, 0.0}) {
      FilmCalibration c = one_mark(kind);
      c.marks[0].film_mm.y() = y_mm;
      const MarkModel drawn = drawn_mark(kind, 40 * c.mark_size_mm, 40 * c.line_mm, mark_axis_rad(c.marks[0]));
      Vector2d mean = Vector2d::Zero();
      const int phases = 6;
      for (int phase = 0; phase < phases; ++phase) {
        Random random(5, std::uint64_t(phase));
        const FilmTransformation truth = scan_of(100 + phase / 6.0, 100 + phase * phase / 6.0, 0);
        const ScanLook look{.blur_px = 0.7 + 0.2 * phase, .grain = 0};
        const Vector2d at = truth.pixel_of(c.marks[0].film_mm);
        const auto found =
            match_mark(rendered_scan(c, truth, 200, 200, look, 1.0, random), drawn, at, {0, 0.001, 0.03, 0.001});
        ASSERT_TRUE(found) << word_of(kind) << y_mm << phase;
        mean += (found->pixel - at) / phases;
      }
      // 0.001 px is left of Catmull and Rom's interpolation and of grey values that are whole numbers.
      EXPECT_LT(mean.norm(), 0.003) << word_of(kind) << y_mm;
    }
}

TEST(FiducialMark, NothingIsFoundWhereNothingIs) {
  const MarkModel drawn = drawn_mark(MarkKind::kCross, 40, 5, 0);
  const GreyImage flat(200, 200, 1, 90);
  EXPECT_FALSE(match_mark(flat, drawn, {100, 100}));
  EXPECT_FALSE(match_mark(flat, drawn, {2, 100}));
  EXPECT_FALSE(match_mark(flat, drawn, {std::nan(""), 100}));
  EXPECT_FALSE(match_mark(GreyImage(5, 5), drawn, {2, 2}));
  EXPECT_TRUE(search_mark(flat, drawn, {100, 100}, 80, 3).empty());
  EXPECT_TRUE(search_mark(flat, drawn, {-500, 100}, 80, 3).empty());
  EXPECT_FALSE(learnt_mark(flat, {100, 100}, 40));
  EXPECT_FALSE(learnt_mark(flat, {5, 100}, 40));
  Random random(2);
  GreyImage noise(200, 200);
  for (auto& value : noise.data) value = std::uint8_t(random.below(256));
  EXPECT_TRUE(search_mark(noise, drawn, {100, 100}, 60, 3).empty());
}

TEST(FiducialMark, OneClickTeachesAMark) {
  FilmCalibration c = one_mark(MarkKind::kRing);
  Random random(9);
  const FilmTransformation truth = scan_of(100.3, 100.8, 0), other = scan_of(101.7, 99.2, 0.01);
  const GreyImage scan = rendered_scan(c, truth, 200, 200, {}, 1.0, random);
  const GreyImage second = rendered_scan(c, other, 200, 200, {}, 1.0, random);
  const auto learnt = learnt_mark(scan, truth.pixel_of({-1, -1}) + Vector2d(2, -3), 56);
  ASSERT_TRUE(learnt);
  EXPECT_TRUE(learnt->is_symmetric);
  const auto found = search_mark(second, learnt->model, {70, 130}, 30, 1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT((found[0].pixel - other.pixel_of({-1, -1})).norm(), 0.1);
}

// One corner teaches all four, turned and mirrored; marks of a kind that the calibration states otherwise are drawn.
TEST(FiducialSearch, OneClickTeachesMarksThatLieTurned) {
  for (const MarkKind kind : {MarkKind::kCorner, MarkKind::kNotch}) {
    FilmCalibration c = one_mark(kind);
    c.size_mm = {30, 30};
    c.marks.clear();
    for (const double x : {-12.0, 12.0})
      for (const double y : {-12.0, 12.0}) c.marks.push_back({.name = "", .film_mm = {x, y}, .kind = kind});
    c.marks.push_back({.name = "", .film_mm = {12, 0}, .kind = MarkKind::kDot});
    for (std::size_t i = 0; i < c.marks.size(); ++i) c.marks[i].name = std::to_string(i);
    Random random(23, std::uint64_t(kind));
    const FilmTransformation truth = scan_of(612.4, 588.7, 0.01);
    const GreyImage scan = rendered_scan(c, truth, 1200, 1200, {}, 1.1, random);
    auto learnt = learnt_mark(scan, truth.pixel_of(c.marks[1].film_mm), 56);
    ASSERT_TRUE(learnt) << word_of(kind);
    EXPECT_FALSE(learnt->is_symmetric) << word_of(kind);
    EXPECT_EQ(likenesses(*learnt).size(), 8u);
    learnt->mark = c.marks[1];
    for (const bool is_stated : {true, false}) {
      FilmCalibration known = c;
      if (!is_stated)
        for (std::size_t i = 0; i < 4; ++i) known.marks[i].kind.reset();
      learnt->mark = known.marks[1];
      const auto found = find_fiducials(
          scan, known, {.predicted = predicted_scan(c, 1200, 1200, {}, 0), .radius_mm = 1.2, .learnt = {*learnt}}, {});
      ASSERT_EQ(found.size(), 5u) << word_of(kind) << is_stated;
      // A likeness has grain of its own: twice the bound of those that are drawn.
      for (std::size_t i = 0; i < 5; ++i)
        EXPECT_LT((found[i].mark.pixel - truth.pixel_of(c.marks[i].film_mm)).norm(), 0.4) << word_of(kind) << i;
    }
  }
}

// Eight marks of a kind, in a scan that is turned, sheared and shifted from where it is expected.
TEST_P(MarkOfAKind, EightAreFoundWhereTheyAre) {
  const MarkKind kind = GetParam();
  FilmCalibration c = one_mark(kind);
  c.size_mm = {30, 30};
  c.marks.clear();
  for (int i = 0; i < 8; ++i) {
    const double angle = i * std::numbers::pi / 4, r = i % 2 == 0 ? 12 : 12 * std::numbers::sqrt2;
    c.marks.push_back({.name = std::to_string(i), .film_mm = {r * std::cos(angle), r * std::sin(angle)}, .kind = kind});
  }
  Random random(17, std::uint64_t(kind));
  const FilmTransformation truth = scan_of(612.4, 588.7, 0.02);
  const GreyImage scan = rendered_scan(c, truth, 1200, 1200, {}, 1.1, random);
  const auto found = find_fiducials(scan, c, {.predicted = predicted_scan(c, 1200, 1200, {}, 0), .radius_mm = 1.2}, {});
  ASSERT_EQ(found.size(), 8u) << word_of(kind);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_LT((found[i].mark.pixel - truth.pixel_of(c.marks[i].film_mm)).norm(), 0.2) << word_of(kind) << i;
  EXPECT_TRUE(
      find_fiducials(GreyImage(1200, 1200), c, {.predicted = predicted_scan(c, 1200, 1200, {}, 0)}, {}).empty());
}

TEST(FiducialSearch, AScanIsPredictedFromItsSize) {
  FilmCalibration c;
  c.size_mm = {240, 120};
  const FilmTransformation t = predicted_scan(c, 1200, 2400, {}, 1);
  EXPECT_LT((t.pixel_of({0, 0}) - Vector2d(600, 1200)).norm(), 1e-9);
  EXPECT_LT((t.pixel_of({120, 0}) - Vector2d(600, 2400)).norm(), 1e-9);  // the right side of the film is below
  EXPECT_NEAR(predicted_scan(c, 1200, 2400, 0.02, 1).parameters[3], 50, 1e-12);
}

}  // namespace
}  // namespace collinea
