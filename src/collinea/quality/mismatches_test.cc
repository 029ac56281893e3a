// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/mismatches.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

constexpr double kLevel = 0.001, kSigma_px = 0.5;

struct Spoilt {
  Block truth, block;
  std::set<std::uint32_t> wrong;  // indices of observations
};

// `rays`: most a point has, two of a third of them. Errors normal (nu = 0) or Student's; the share `wrong` of the rays
// is up to 20 px off.
Spoilt spoilt_block(int nu, double wrong, std::uint64_t seed, int rays = 6, int points = 2500) {
  Spoilt made{.truth = test_block({.rows = 4, .columns = 5, .points = points, .position_sigma_m = 0.02, .seed = seed})};
  Random random(seed, 3);
  std::vector<Observation> chosen;
  for (auto ray = made.truth.observations.begin(); ray != made.truth.observations.end();) {
    const auto end = std::find_if(ray, made.truth.observations.end(),
                                  [&](const Observation& one) { return one.point != ray->point; });
    const auto count = std::min<long>(end - ray, ray->point.value % 3 == 0 ? 2 : rays);
    std::vector<Observation> all(ray, end);
    for (long i = 0; i < count; ++i)  // any of them
      std::swap(all[std::size_t(i)], all[std::size_t(i) + std::size_t(random.uniform() * double(all.size() - i))]);
    all.resize(std::size_t(count));
    std::ranges::sort(all, {}, &Observation::image);
    chosen.insert(chosen.end(), all.begin(), all.end());
    ray = end;
  }
  made.truth.observations = chosen;
  made.block = made.truth;
  for (std::uint32_t i = 0; i < chosen.size(); ++i) {
    double sigma_px = kSigma_px;
    double chi2 = 0;
    for (int k = 0; k < nu; ++k) chi2 += std::pow(random.normal(), 2);
    if (nu > 0) sigma_px *= std::sqrt((nu - 2) / chi2);  // the variance is that of the normal errors
    Observation& seen = made.block.observations[i];
    seen.sigma_px = kSigma_px;
    seen.pixel += sigma_px * Eigen::Vector2d(random.normal(), random.normal());
    if (random.uniform() >= wrong) continue;
    seen.pixel += Eigen::Vector2d(random.uniform(-20, 20), random.uniform(-20, 20));
    made.wrong.insert(i);
  }
  return made;
}

WithoutMismatches cleaned(const Block& block) {
  auto clean = reject_mismatches(block, {}, testing::plain(), kLevel, {});
  EXPECT_TRUE(clean) << clean.error().message;
  return std::move(*clean);
}

double rms_centre_error(const Block& block, const Block& truth) {
  const auto adjusted = adjust(block, {}, testing::plain(), {});
  double squares = 0;
  for (const auto& [id, pose] : adjusted->cam_from_world)
    squares += (centre_of(pose) - centre_of(pose_of(truth, id))).squaredNorm();
  return std::sqrt(squares / double(adjusted->cam_from_world.size()));
}

// No ray of a block whose errors are normal, or have long tails, is called a mismatch beyond the level.
TEST(Mismatches, GoodRaysStay) {
  for (const int nu : {0, 3, 5, 8}) {
    const Spoilt made = spoilt_block(nu, 0, 1);  // eight degrees of freedom show only where there are many rays
    const WithoutMismatches clean = cleaned(made.block);
    EXPECT_GT(clean.found.tested, 5000);
    EXPECT_LE(double(clean.found.wrong.size()), kLevel * double(clean.found.tested)) << nu;
    EXPECT_EQ(clean.block.observations.size() + clean.found.size(), made.block.observations.size());
    ASSERT_FALSE(clean.found.errors.classes.empty());
    for (const TieErrors::Class& one : clean.found.errors.classes) {
      if (nu != 8) {
        EXPECT_EQ(one.distribution.is_normal(), nu == 0) << nu << " " << one.least_rays;
      }
      if (nu == 0) {
        EXPECT_NEAR(one.distribution.scale, 1, 0.05);
      }
    }
  }
}

// Mismatches of 8 sigmas and more that the other rays check are found, good rays go only with wrong ones of their
// point, and the poses are as good as those of the same measurements without mismatches.
TEST(Mismatches, AreFoundAndNothingElseGoes) {
  for (const double share : {0.01, 0.05}) {
    double square = 0, square_without = 0;
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
      const Spoilt made = spoilt_block(0, share, seed);
      const WithoutMismatches clean = cleaned(made.block);
      std::set<std::uint32_t> rejected(clean.found.wrong.begin(), clean.found.wrong.end());
      rejected.insert(clean.found.with_them.begin(), clean.found.with_them.end());
      std::set<PointId> spoilt;
      std::map<PointId, int> rays;
      for (const std::uint32_t i : made.wrong) spoilt.insert(made.block.observations[i].point);
      for (const Observation& seen : made.block.observations) ++rays[seen.point];
      double large = 0, found = 0, lost = 0;
      for (const std::uint32_t i : made.wrong) {
        const double error_px = (made.block.observations[i].pixel - made.truth.observations[i].pixel).norm();
        if (rays[made.block.observations[i].point] < 4 || error_px < 8 * kSigma_px) continue;
        large += 1;
        found += rejected.contains(i) || !clean.block.points.contains(made.block.observations[i].point);
      }
      for (const std::uint32_t i : rejected) lost += !spoilt.contains(made.block.observations[i].point);
      EXPECT_GT(found / large, 0.97) << share << " " << large;
      EXPECT_LE(lost, kLevel * double(clean.found.tested)) << share;
      EXPECT_NEAR(clean.found.expected_good, lost, 10);
      EXPECT_LT(double(clean.found.with_them.size()), 3.0 * double(made.wrong.size()));
      Block without = made.block;
      std::vector<Observation> good;
      for (std::uint32_t i = 0; i < without.observations.size(); ++i)
        if (!made.wrong.contains(i)) good.push_back(without.observations[i]);
      without.observations = good;
      square += std::pow(rms_centre_error(clean.block, made.truth), 2);
      square_without += std::pow(rms_centre_error(without, made.truth), 2);
    }
    EXPECT_LT(std::sqrt(square / square_without), 1.15) << share;
  }
}

// The tests of tie points keep their level whatever the errors are distributed like, also when mismatches were
// rejected.
TEST(Mismatches, SuspectsAgreeWithTheLevel) {
  struct Case {
    int nu;
    double wrong;
  };
  for (const Case one : {Case{0, 0}, {0, 0.02}, {3, 0}, {5, 0}, {8, 0.01}}) {
    const Spoilt made = spoilt_block(one.nu, one.wrong, 5);
    const WithoutMismatches clean = cleaned(made.block);
    const auto adjusted = examine(clean.block, {}, testing::tested(), {});
    ASSERT_TRUE(adjusted && adjusted->reliability);
    const Reliability& tests = *adjusted->reliability;
    long suspects = 0;
    for (const TestedObservation& suspect : tests.suspects) suspects += suspect.group == ObservationGroup::kTieImages;
    const double expected = kLevel * double(tests.groups[0].observations);
    EXPECT_GT(expected, 15);
    // Both rays of a point with two are suspect together, four coordinates in all.
    EXPECT_NEAR(double(suspects), expected, 5 * std::sqrt(2 * expected)) << one.nu << " " << one.wrong;
    EXPECT_EQ(tests.tie_limits.size(), tests.tie_errors.classes.size());
    if (one.nu == 0 && one.wrong == 0)
      for (const double limit : tests.tie_limits) EXPECT_NEAR(limit, tests.limit, 0.2);
    if (one.nu == 3)
      for (const double limit : tests.tie_limits) EXPECT_GT(limit, 1.1 * tests.limit);
  }
}

// Both rays of points with two show what lies across their epipolar line, and nothing along it.
TEST(Mismatches, OfTwoRaysBothGo) {
  const Spoilt made = spoilt_block(0, 0.02, 3, 2);
  const WithoutMismatches clean = cleaned(made.block);
  EXPECT_GT(clean.found.wrong.size(), 20U);
  EXPECT_EQ(clean.found.wrong.size(), clean.found.with_them.size());
  for (const TieErrors::Class& one : clean.found.errors.classes) EXPECT_EQ(one.distribution.directions, 1);
  for (const std::uint32_t i : clean.found.wrong)
    EXPECT_FALSE(clean.block.points.contains(made.block.observations[i].point));
}

// With the loss of the distribution that the errors show poses are nearer to the truth than by least squares. Their
// sigmas (times sigma0, which is 1.28 for three degrees of freedom) are true to a seventh: where a third of the points
// has two rays they are an eighth too large, because what weights say of points with few rays is not exact.
TEST(Mismatches, LongTailsAreModelledByTheLossThatBelongsToThem) {
  double squares = 0, squares_plain = 0, chi2 = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 15; ++seed) {
    const Spoilt made = spoilt_block(3, 0, seed, 6, 500);
    const WithoutMismatches clean = cleaned(made.block);
    const auto shown = loss_of(clean.found.errors);
    ASSERT_TRUE(shown);
    EXPECT_EQ(shown->loss, Loss::kCauchy);
    Block block = clean.block;
    for (Observation& seen : block.observations) seen.sigma_px *= shown->sigma_factor;
    ExamineOptions options = testing::examined();
    options.adjust.loss = shown->loss;
    options.adjust.loss_scale_sigmas = shown->loss_scale_sigmas;
    const auto adjusted = examine(block, {}, options, {});
    ASSERT_TRUE(adjusted);
    for (const auto& [id, pose] : adjusted->cam_from_world) {
      const Rigid3& truth = pose_of(made.truth, id);
      Eigen::Matrix<double, 6, 1> error;
      error << rotation_vector(pose.rotation.conjugate() * truth.rotation), centre_of(truth) - centre_of(pose);
      const Matrix6d covariance = std::pow(adjusted->sigma0, 2) * adjusted->pose_covariance.at(id);
      chi2 += error.dot(covariance.ldlt().solve(error));
      squares += error.tail<3>().squaredNorm();
      count += 1;
    }
    squares_plain += 20 * std::pow(rms_centre_error(made.block, made.truth), 2);
  }
  EXPECT_LT(squares, 0.9 * squares_plain);
  EXPECT_NEAR(std::sqrt(chi2 / count / 6), 1, 0.15);
}

TEST(Mismatches, FewPointsAndExactOnesHaveNone) {
  Block few = spoilt_block(0, 0, 2, 6, 30).block;
  few.observations[7].pixel.x() += 30;
  EXPECT_EQ(cleaned(few).found.size(), 0U);
  const Block exact = test_block({.rows = 3, .columns = 4, .points = 400});
  const WithoutMismatches clean = cleaned(exact);
  EXPECT_EQ(clean.found.size(), 0U);
  EXPECT_EQ(clean.block.observations.size(), exact.observations.size());
}

TEST(Mismatches, ThoseThatTakePartAreToldOf) {
  const auto found_in = [](const Block& block) {
    const auto adjusted = adjust(block, {}, testing::plain(), {});
    EXPECT_TRUE(adjusted);
    return mismatches_left(block, *adjusted);
  };
  EXPECT_FALSE(found_in(spoilt_block(0, 0, 1).block));
  EXPECT_FALSE(found_in(spoilt_block(3, 0, 1).block)) << "long tails are no mismatches";
  EXPECT_FALSE(found_in(spoilt_block(0, 0.5, 1, 6, 20).block)) << "too few to tell";
  const Spoilt spoilt = spoilt_block(0, 0.1, 1);
  const auto found = found_in(spoilt.block);
  ASSERT_TRUE(found);
  EXPECT_GT(found->figure(FigureName::kShare).value(), 0.03);
  EXPECT_LT(found->figure(FigureName::kShare).value(), 0.11);
  EXPECT_FALSE(found_in(cleaned(spoilt.block).block));
}

}  // namespace
}  // namespace collinea
