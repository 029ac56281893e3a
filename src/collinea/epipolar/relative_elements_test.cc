// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_elements.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Rigid3 some_motion(Random& random) {
  return {rotation_by(scene::random_vector(random, 0.6)),
          (Eigen::Vector3d(-1, 0, 0) + scene::random_vector(random, 0.5)).normalized()};
}

Eigen::Vector3d photo_ray(const Eigen::Vector3d& in_cam) {
  return {in_cam.x() / in_cam.z(), -in_cam.y() / in_cam.z(), -1};
}

Matrix5 some_covariance(Random& random) {
  Matrix5 m;
  for (int i = 0; i < 25; ++i) m(i / 5, i % 5) = random.normal();
  return 1e-6 * m * m.transpose();
}

TEST(RelativeElements, GoThereAndBack) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Rigid3 motion = some_motion(random);
    for (const Rigid3& back : {motion_of(*dependent_elements(motion)), motion_of(symmetric_elements(motion))}) {
      EXPECT_LT(angle_between(back.rotation, motion.rotation), 1e-12);
      EXPECT_LT((back.translation - motion.translation).norm(), 1e-12);
    }
  }
}

// Angles and base of Mussio D.8, with the conversion of 2.2.5 as corrected (E18, E19).
TEST(RelativeElements, ConvertAsPublished) {
  const SymmetricElements symmetric{0.25, -0.35, 0.2, -0.3, 0.4};
  const DependentElements dependent = *dependent_elements(motion_of(symmetric));
  const Eigen::Vector3d base = Eigen::Vector3d(dependent.bx, dependent.by, dependent.bz).normalized();
  EXPECT_LT((base - Eigen::Vector3d(0.9101698901, 0.3322379450, 0.2474039593)).norm(), 1e-10);
  EXPECT_NEAR(dependent.omega, 0.4033126381, 1e-10);
  EXPECT_NEAR(dependent.phi, -0.4350897138, 1e-10);
  EXPECT_NEAR(dependent.kappa, 0.8351043313, 1e-10);
}

TEST(RelativeElements, KeepASecondPhotographOnTheLeft) {
  const DependentElements left{-1, 0.1, -0.05, 0.02, 0.03, -0.04};
  const DependentElements back = *dependent_elements(motion_of(left));
  EXPECT_EQ(back.bx, -1);
  EXPECT_LT((back.values() - left.values()).norm(), 1e-12);
}

TEST(RelativeElements, HaveNoDependentFormAcrossX) {
  EXPECT_FALSE(dependent_elements({Eigen::Quaterniond::Identity(), {0, -1, 0}}));
  EXPECT_TRUE(std::isfinite(symmetric_elements({Eigen::Quaterniond::Identity(), {0, 0, 1}}).phi2));
}

TEST(RelativeElements, DerivativesByTheChangeAreNumericOnes) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 motion = some_motion(random);
    Matrix5 dependent, symmetric;
    for (int k = 0; k < 5; ++k) {
      const double h = 1e-6;
      const Rigid3 plus = changed(motion, h * Vector5::Unit(k)), minus = changed(motion, -h * Vector5::Unit(k));
      dependent.col(k) = (dependent_elements(plus)->values() - dependent_elements(minus)->values()) / (2 * h);
      symmetric.col(k) = (symmetric_elements(plus).values() - symmetric_elements(minus).values()) / (2 * h);
    }
    EXPECT_LT((dependent - dependent_by_change(motion)).norm(), 1e-7 * dependent.norm());
    EXPECT_LT((symmetric - symmetric_by_change(motion)).norm(), 1e-7 * symmetric.norm());
  }
}

TEST(RelativeElements, CovariancesSurviveTheWayThereAndBack) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const DependentWithCovariance given{*dependent_elements(some_motion(random)), some_covariance(random)};
    const DependentWithCovariance back = *dependent_of(symmetric_of(given));
    EXPECT_LT((back.elements.values() - given.elements.values()).norm(), 1e-10);
    EXPECT_LT((back.covariance - given.covariance).norm(), 1e-9 * given.covariance.norm());
  }
}

TEST(Coplanarity, HasOneValueInAllItsForms) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 motion = some_motion(random);
    const Eigen::Vector3d one(random.normal(), random.normal(), -1), two(random.normal(), random.normal(), -1);
    const DependentElements d = *dependent_elements(motion);
    const Eigen::Vector3d base = Eigen::Vector3d(d.bx, d.by, d.bz);
    const Eigen::Quaterniond turn(0, 1, 0, 0);
    const Eigen::Matrix3d second = (turn * motion.rotation * turn.conjugate()).toRotationMatrix();
    const double value = coplanarity(d, one, two).value;
    EXPECT_NEAR(value, coplanarity_in_first(base, second, one, two), 1e-12);
    EXPECT_NEAR(value, coplanarity_in_second(second * base, second.transpose(), one, two), 1e-12);
    const Eigen::Matrix3d model = rotation_by(scene::random_vector(random, 1)).toRotationMatrix();
    EXPECT_NEAR(value, coplanarity_in_model(model.transpose() * base, model, second * model, one, two), 1e-12);
    EXPECT_NEAR(value, base.norm() * coplanarity(symmetric_elements(motion), one, two).value, 1e-12);
  }
}

template <class Elements>
void expect_numeric_derivatives(const Elements& elements, const Eigen::Vector3d& one, const Eigen::Vector3d& two,
                                double Elements::*const (&members)[5]) {
  const Coplanarity at = coplanarity(elements, one, two);
  const double h = 1e-6;
  for (int k = 0; k < 5; ++k) {
    Elements plus = elements, minus = elements;
    plus.*members[k] += h;
    minus.*members[k] -= h;
    EXPECT_NEAR((coplanarity(plus, one, two).value - coplanarity(minus, one, two).value) / (2 * h), at.by_elements(k),
                1e-8);
  }
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d d1 = k < 2 ? Eigen::Vector3d(h * Eigen::Vector3d::Unit(k)) : Eigen::Vector3d(0, 0, 0),
                          d2 = k < 2 ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(h * Eigen::Vector3d::Unit(k - 2));
    const double slope =
        (coplanarity(elements, one + d1, two + d2).value - coplanarity(elements, one - d1, two - d2).value) / (2 * h);
    EXPECT_NEAR(slope, at.by_coordinates(k), 1e-8);
  }
}

// The derivatives of Mussio 2.2.2 and 2.2.4 with their errata (E12-E17) are those of the conditions.
TEST(Coplanarity, DerivativesAreNumericOnes) {
  using D = DependentElements;
  using S = SymmetricElements;
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 motion = some_motion(random);
    const Eigen::Vector3d one(random.normal(), random.normal(), -1.3), two(random.normal(), random.normal(), -1.3);
    expect_numeric_derivatives<D>(*dependent_elements(motion), one, two,
                                  {&D::by, &D::bz, &D::omega, &D::phi, &D::kappa});
    expect_numeric_derivatives<S>(symmetric_elements(motion), one, two,
                                  {&S::phi1, &S::kappa1, &S::omega2, &S::phi2, &S::kappa2});
  }
}

// The four solutions of Mussio 3.1.4, in the closed form of his elements.
TEST(Coplanarity, HoldsForTheFourSolutionsOfTheSymmetricForm) {
  constexpr double pi = std::numbers::pi;
  const SymmetricElements truth{0.5, 2.2, 1.0, -0.4, 5.0};
  const SymmetricElements four[] = {truth,
                                    {truth.phi1, truth.kappa1, truth.omega2 - pi, truth.phi2, truth.kappa2},
                                    {-truth.phi1, truth.kappa1 - pi, pi - truth.omega2, -truth.phi2, truth.kappa2 + pi},
                                    {-truth.phi1, truth.kappa1 - pi, -truth.omega2, -truth.phi2, truth.kappa2 + pi}};
  const Rigid3 motion = motion_of(truth);
  Random random(6);
  for (int i = 0; i < 15; ++i) {
    const Eigen::Vector3d point = scene::random_vector(random, 5);
    const Eigen::Vector3d one = photo_ray(point), two = photo_ray(motion * point);
    for (const SymmetricElements& elements : four) EXPECT_NEAR(coplanarity(elements, one, two).value, 0, 1e-11);
  }
}

// Karfis W9: rotations and image points [mm] of Volos and Kea, with the published by and bz (his equation 13).
TEST(Coplanarity, HoldsForThePairsOfKarfisW9) {
  struct Pair {
    Eigen::Matrix3d rotation;
    double by, bz, c_mm;
    double right[4][2];
  };
  const double left[4][2] = {{0, 0}, {80, 60}, {-20, -90}, {100, -100}};
  Pair volos{{},
             0.0382,
             -0.0084,
             153.353,
             {{-83.826856, -3.207517}, {-2.071617, 54.127716}, {-103.447910, -93.167428}, {8.472589, -108.208376}}};
  volos.rotation << 0.9994332072, 0.0317482902, -0.0111942098, -0.0315516317, 0.9993519182, 0.0173273797, 0.0117370697,
      -0.0169643631, 0.9997872031;
  Pair kea{{},
           -0.0450,
           -0.0085,
           152.52,
           {{-83.333569, -4.517426}, {-5.676905, 58.602027}, {-97.047350, -97.428211}, {17.532139, -102.271057}}};
  kea.rotation << 0.9989809981, -0.0451312892, -0.0003636471, 0.0451223582, 0.9985455404, 0.0295089239, -0.0009686576,
      -0.0294952628, 0.9995644507;
  for (const Pair& pair : {volos, kea})
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d one(left[i][0], left[i][1], -pair.c_mm),
          two(pair.right[i][0], pair.right[i][1], -pair.c_mm);
      // A y-parallax of half a unit of the last digit, 5e-7 mm, times c.
      EXPECT_NEAR(coplanarity_in_first({1, pair.by, pair.bz}, pair.rotation, one, two), 0, 1e-6 * pair.c_mm);
    }
}

// The same elements as printed, to four digits of a degree: his rotation matrices.
TEST(RelativeElements, RotationsOfKarfisW9AreThoseOfTheirElements) {
  const DependentElements volos{1, 0.0382, -0.0084, 0.9721 * kDegree, 0.6725 * kDegree, 1.8082 * kDegree},
      kea{1, -0.0450, -0.0085, 1.6902 * kDegree, -0.0555 * kDegree, -2.5862 * kDegree};
  const Eigen::Quaterniond turn(0, 1, 0, 0);
  const auto rotation = [&](const DependentElements& of) {
    return (turn * motion_of(of).rotation * turn.conjugate()).toRotationMatrix();
  };
  Eigen::Matrix3d of_volos, of_kea;
  of_volos << 0.9994332072, 0.0317482902, -0.0111942098, -0.0315516317, 0.9993519182, 0.0173273797, 0.0117370697,
      -0.0169643631, 0.9997872031;
  of_kea << 0.9989809981, -0.0451312892, -0.0003636471, 0.0451223582, 0.9985455404, 0.0295089239, -0.0009686576,
      -0.0294952628, 0.9995644507;
  EXPECT_LT((rotation(volos) - of_volos).cwiseAbs().maxCoeff(), 5.1e-11);
  EXPECT_LT((rotation(kea) - of_kea).cwiseAbs().maxCoeff(), 5.1e-11);
}

// Central differences: rounding 1e-16 / 1e-6 and truncation 1e-12 leave 1e-9.
TEST(RelativeElements, DerivativesOfThePoseInTheModelAreThoseOfDifferences) {
  Random random(12);
  const Eigen::Quaterniond model_from_camera(0, 1, 0, 0);  // y and z the other way
  for (int i = 0; i < 20; ++i) {
    const Rigid3 motion = some_motion(random);
    const double base = random.uniform(0.5, 700), step = 1e-6;
    const Eigen::Matrix<double, 6, 6> by = pose_by_change(motion, base);
    for (int k = 0; k < 6; ++k) {
      Rigid3 side[2];
      Eigen::Vector3d centre[2];
      for (int way = 0; way < 2; ++way) {
        const double h = way == 0 ? -step : step;
        Vector5 change = Vector5::Zero();
        if (k < 5) change(k) = h;
        side[way] = changed(motion, change);
        centre[way] = (k == 5 ? base * (1 + h) : base) * (model_from_camera * base_in_first(side[way]));
      }
      // The attitude of the camera in the model, and how it turns about the axes of the model.
      const Eigen::Quaterniond before = model_from_camera * side[0].rotation.conjugate(),
                               after = model_from_camera * side[1].rotation.conjugate();
      const double length = k == 5 ? base : 1;
      const Eigen::Vector3d turn = rotation_vector(after * before.conjugate()) / (2 * step * length),
                            shift = (centre[1] - centre[0]) / (2 * step * length);
      EXPECT_LT((by.col(k).head<3>() - turn).norm(), 1e-8) << k;
      EXPECT_LT((by.col(k).tail<3>() - shift).norm(), 1e-8 * base) << k;
    }
  }
}

}  // namespace
}  // namespace collinea
