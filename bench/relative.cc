// SPDX-License-Identifier: Apache-2.0
// Relative orientation of random pairs with known truth: how often each start finds it, whether covariances tell the
// truth, and how long it takes.   collinea_bench_relative [PAIRS]
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "collinea/epipolar/model_points.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace {

using namespace collinea;
using Eigen::Vector3d;

constexpr double kSigma = 5e-5;     // of a coordinate: 7.5 um at c = 150 mm
constexpr double kChi95 = 11.0705;  // chi-squared with five degrees of freedom

struct Pair {
  Rigid3 truth;
  std::vector<PairPoint> points;
};

Eigen::Vector2d noisy(const Vector3d& p, Random& random) {
  return p.hnormalized() + kSigma * Eigen::Vector2d(random.normal(), random.normal());
}

// Photographs as of a flight: attitudes within 5 degrees, relief of a fifth of the height.
Pair vertical(int count, Random& random) {
  const auto small = [&] { return random.uniform(-0.087, 0.087); };
  Pair pair{motion_of(DependentElements{1, small(), small(), small(), small(), small()}), {}};
  while (static_cast<int>(pair.points.size()) < count) {
    const Vector3d x(random.uniform(-0.2, 1.2), random.uniform(-1.2, 1.2), random.uniform(1.5, 1.9));
    pair.points.push_back({noisy(x, random), noisy(pair.truth * x, random), kSigma, kSigma});
  }
  return pair;
}

// A turntable's worth: any base, any rotation about the view, convergent by up to 60 degrees.
Pair general(int count, Random& random) {
  Pair pair;
  const double convergence = random.uniform(0, 1.05), depth = random.uniform(1.5, 6);
  const Vector3d axis = Vector3d(random.normal(), random.normal(), 0.2 * random.normal()).normalized();
  const Eigen::Quaterniond turn = rotation_by({0, 0, random.uniform(-3.14, 3.14)}) * rotation_by(convergence * axis);
  const Vector3d middle(0, 0, depth);
  Vector3d base(random.normal(), random.normal(), 0.4 * random.normal());
  base.normalize();
  pair.truth = {turn, -(turn * base)};
  // The second camera looks at the middle of the points.
  const Vector3d seen = pair.truth * middle;
  pair.truth.rotation = Eigen::Quaterniond::FromTwoVectors(seen, Vector3d::UnitZ()) * turn;
  pair.truth.translation = -(pair.truth.rotation * base);
  while (static_cast<int>(pair.points.size()) < count) {
    const Vector3d x =
        middle + 0.35 * depth * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if ((pair.truth * x).z() < 0.3) continue;
    pair.points.push_back({noisy(x, random), noisy(pair.truth * x, random), kSigma, kSigma});
  }
  return pair;
}

double chi_squared(const RelativeOrientation& found, const Rigid3& truth) {
  Vector5 e;
  e.head<3>() = rotation_vector(truth.rotation * found.second_from_first.rotation.conjugate());
  const Vector3d base = base_in_first(found.second_from_first);
  e.tail<2>() = tangents_of(base).transpose() * base_in_first(truth) / base.dot(base_in_first(truth));
  return e.dot(found.covariance.ldlt().solve(e));
}

void judge(const char* title, Pair (*make)(int, Random&), PairStart start, int pairs) {
  RelativeOptions options;
  options.start = start;
  options.rejection = PairRejection::kNone;
  options.sigma_known = true;
  int found = 0, within = 0;
  double sum = 0, sigma = 0;
  for (int i = 0; i < pairs; ++i) {
    Random random(1, static_cast<std::uint64_t>(i));
    const Pair pair = make(20, random);
    const auto answer = relative_orientation(pair.points, options, 1);
    const double chi2 = answer ? chi_squared(*answer, pair.truth) : INFINITY;
    if (!(chi2 < 40)) continue;  // one in 10 million of the right ones
    ++found;
    within += chi2 < kChi95;
    sum += chi2;
    sigma += answer->sigma0 * answer->sigma0;
  }
  std::printf("%-10s %-14s %4d of %d   within 95 %%: %.1f %%   mean chi2 / 5: %.3f   sigma0^2: %.3f\n", title,
              std::string(word_of(start)).c_str(), found, pairs, 100.0 * within / found, sum / found / 5,
              sigma / found);
}

double milliseconds(const Pair& pair, PairStart start, PairRejection rejection, bool model) {
  RelativeOptions options;
  options.start = start;
  options.rejection = rejection;
  const std::clock_t begin = std::clock();  // of the processor
  constexpr int kTimes = 50;
  for (int i = 0; i < kTimes; ++i) {
    const auto answer = relative_orientation(pair.points, options, 1);
    if (answer && model) (void)model_points(*answer, pair.points);
  }
  return 1000.0 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / kTimes;
}

}  // namespace

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 500;
  for (const PairStart start : {PairStart::kNearVertical, PairStart::kLinear, PairStart::kRobust, PairStart::kGrid})
    judge("vertical", vertical, start, pairs);
  for (const PairStart start : {PairStart::kNearVertical, PairStart::kLinear, PairStart::kRobust, PairStart::kGrid})
    judge("general", general, start, pairs);
  Random random(7);
  const Pair pair = vertical(1000, random);
  std::printf(
      "1000 points: near_vertical %.2f ms, linear %.2f ms, with snooping %.2f ms, with model coordinates %.2f ms\n",
      milliseconds(pair, PairStart::kNearVertical, PairRejection::kNone, false),
      milliseconds(pair, PairStart::kLinear, PairRejection::kNone, false),
      milliseconds(pair, PairStart::kLinear, PairRejection::kSnooping, false),
      milliseconds(pair, PairStart::kLinear, PairRejection::kNone, true));
}
