// SPDX-License-Identifier: Apache-2.0
// Least squares matching of windows with known truth: errors, and whether the standard deviations are those of the
// errors.   collinea_bench_window_matching WINDOWS [PHOTOGRAPHS]
// Rendered windows are waves, blobs and edges, blurred and sampled as formulas. Real ones come from photographs: both
// images of a pair are the photograph under a Gaussian, at a quarter of its size, at positions between its pixels
// that differ by the true map; neither is made from the other. Both get noise of their own and whole grey values.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <numbers>
#include <vector>

#include "collinea/match/window_matching.h"
#include "collinea/math/random.h"
#include "collinea/raster/image_file.h"

namespace {

using namespace collinea;
using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kSide_px = 64;
constexpr double kBlur_px = 0.6;  // standard deviation of the point spread of both images
constexpr double kNoise_grey = 2;
constexpr int kReduced = 4;      // pixels of a photograph to one of the images made of it
constexpr double kStart_px = 1;  // the start is off by so much in each direction
constexpr double kWanted_px = 0.05;
constexpr double kChi95[] = {0, 3.8415, 5.9915};

using Grey = std::function<double(const Vector2d&)>;  // of a surface, in pixels of the images, blurred

// Waves of 3 to 40 px, blobs and edges.
Grey rendered(Random& random) {
  struct Wave {
    Vector2d k;
    double phase, amplitude;
  };
  struct Blob {
    Vector2d middle;
    double square_px2, amplitude;
  };
  struct Edge {
    Vector2d normal;
    double at, amplitude;
  };
  std::vector<Wave> waves(16);
  std::vector<Blob> blobs(12);
  std::vector<Edge> edges(3);
  const double contrast = random.uniform(0.3, 1.5);
  const auto direction = [&] {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    return Vector2d(std::cos(angle), std::sin(angle));
  };
  for (Wave& wave : waves) {
    const double length_px = 3 * std::pow(40.0 / 3, random.uniform()), k = 2 * std::numbers::pi / length_px;
    wave = {k * direction(), random.uniform(0, 6.283),
            contrast * 1.5 * std::sqrt(length_px) * std::exp(-0.5 * k * k * kBlur_px * kBlur_px)};
  }
  for (Blob& blob : blobs) {
    const double sigma_px = random.uniform(0.7, 3), all = sigma_px * sigma_px + kBlur_px * kBlur_px;
    blob = {{random.uniform(0, kSide_px), random.uniform(0, kSide_px)},
            all,
            contrast * random.uniform(-40, 40) * sigma_px * sigma_px / all};
  }
  for (Edge& edge : edges) {
    edge.normal = direction();
    edge.at = edge.normal.dot(Vector2d(random.uniform(16, 48), random.uniform(16, 48)));
    edge.amplitude = contrast * random.uniform(-20, 20);
  }
  return [=](const Vector2d& p) {
    double sum = 128;
    for (const Wave& wave : waves) sum += wave.amplitude * std::sin(wave.k.dot(p) + wave.phase);
    for (const Blob& blob : blobs)
      sum += blob.amplitude * std::exp(-0.5 * (p - blob.middle).squaredNorm() / blob.square_px2);
    for (const Edge& edge : edges)
      sum += edge.amplitude * std::erf((edge.normal.dot(p) - edge.at) / (std::numbers::sqrt2 * kBlur_px));
    return sum;
  };
}

// A part of a photograph, (32, 32) being its middle.
Grey real(const GreyImage& photograph, Random& random) {
  const int margin = kReduced * (kSide_px * 3 / 4 + 4);
  const Vector2d middle(random.uniform(margin, photograph.width - margin),
                        random.uniform(margin, photograph.height - margin));
  return [&photograph, middle](const Vector2d& p) {
    constexpr int kReach = 10, kTaps = 2 * kReach + 1;
    const double sigma_px = kBlur_px * kReduced;
    const Vector2d at = middle + kReduced * (p - Vector2d(kSide_px / 2.0, kSide_px / 2.0)) - Vector2d(0.5, 0.5);
    const int column = int(std::lround(at.x())), row = int(std::lround(at.y()));
    double across[kTaps], down[kTaps], all_across = 0, all_down = 0;
    for (int i = 0; i < kTaps; ++i) {
      const auto weight = [&](double d) { return std::exp(-0.5 * d * d / (sigma_px * sigma_px)); };
      all_across += across[i] = weight(column - kReach + i - at.x());
      all_down += down[i] = weight(row - kReach + i - at.y());
    }
    double sum = 0;
    for (int j = 0; j < kTaps; ++j) {
      double line = 0;
      const std::uint8_t* pixel = photograph.row(row - kReach + j) + column - kReach;
      for (int i = 0; i < kTaps; ++i) line += across[i] * pixel[i];
      sum += down[j] * line;
    }
    return sum / (all_across * all_down);
  };
}

struct Case {
  const char* title;
  WindowModel model;
  WindowLight light;
  bool robust = false, blot = false;
};
constexpr Case kCases[] = {
    {"translation", WindowModel::kTranslation, WindowLight::kGainOffset},
    {"line", WindowModel::kLine, WindowLight::kGainOffset},
    {"scale", WindowModel::kScale, WindowLight::kGainOffset},
    {"similarity", WindowModel::kSimilarity, WindowLight::kGainOffset},
    {"affine", WindowModel::kAffine, WindowLight::kGainOffset},
    {"affine, offset", WindowModel::kAffine, WindowLight::kOffset},
    {"affine, same light", WindowModel::kAffine, WindowLight::kSame},
    {"affine, robust", WindowModel::kAffine, WindowLight::kGainOffset, true},
    {"affine, robust, blot", WindowModel::kAffine, WindowLight::kGainOffset, true, true},
    {"affine, blot", WindowModel::kAffine, WindowLight::kGainOffset, false, true},
};

struct Pair {
  GreyImage left{kSide_px, kSide_px}, right{kSide_px, kSide_px};
  Vector2d left_px, right_px;
  Matrix2d map;
  double gain = 1;
  WindowStart start;
};

Matrix2d map_of(WindowModel model, Random& random) {
  const auto small = [&] { return random.uniform(-0.1, 0.1); };
  Matrix2d map = Matrix2d::Identity();
  const double scale = 1 + small();
  if (model == WindowModel::kScale) map *= scale;
  if (model == WindowModel::kSimilarity) {
    const double b = small();
    map << scale, -b, b, scale;
  }
  if (model == WindowModel::kAffine) map << 1 + small(), small(), small(), 1 + small();
  return map;
}

std::uint8_t pixel_of(double grey, Random& random) {
  return std::uint8_t(std::clamp(std::round(grey + kNoise_grey * random.normal()), 0.0, 255.0));
}

Pair pair_of(const Case& what, const Grey& grey, Random& random) {
  Pair pair;
  const Vector2d middle(kSide_px / 2.0, kSide_px / 2.0);
  const auto within = [&](double reach) {
    return Vector2d(random.uniform(-reach, reach), random.uniform(-reach, reach));
  };
  pair.left_px = middle + within(0.5);
  pair.right_px = middle + within(0.5);
  pair.map = map_of(what.model, random);
  const Matrix2d back = pair.map.inverse();
  pair.gain = what.light == WindowLight::kGainOffset ? random.uniform(0.8, 1.2) : 1;
  const double offset = what.light == WindowLight::kSame ? 0 : random.uniform(-15, 15);
  for (int y = 0; y < kSide_px; ++y)
    for (int x = 0; x < kSide_px; ++x) {
      const Vector2d at(x + 0.5, y + 0.5);
      pair.left.at(x, y) = pixel_of(grey(at), random);
      pair.right.at(x, y) =
          pixel_of(pair.gain * (grey(pair.left_px + back * (at - pair.right_px)) - 128) + 128 + offset, random);
    }
  pair.start.position_px = pair.right_px + within(kStart_px);
  if (what.model == WindowModel::kLine) {
    const double angle = random.uniform(0, 6.283);
    pair.start.line = {std::cos(angle), std::sin(angle)};
    pair.start.position_px = pair.right_px + random.uniform(-1.4, 1.4) * kStart_px * pair.start.line;
  }
  if (what.blot) {
    const Vector2d corner = pair.right_px + within(6);
    const auto dark = std::uint8_t(random.uniform(0, 255));
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x) pair.right.at(int(corner.x()) - 2 + x, int(corner.y()) - 2 + y) = dark;
  }
  return pair;
}

// The variance that no unbiased estimate of the position from the pixels of the window undercuts (Cramer, Rao), both
// coordinates together: every pixel of the left window tells by its noise and that of the other image what the true
// slopes there are worth, the other unknowns taken off. Whole grey values are noise of 1 / 12 besides.
double least_variance_px2(const Case& what, const Grey& grey, const Pair& pair) {
  using Row = Eigen::Matrix<double, 8, 1>;
  constexpr double kStep_px = 0.01;
  const double noise = (kNoise_grey * kNoise_grey + 1.0 / 12) * (1 + pair.gain * pair.gain);
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  const int half = WindowOptions().window_px / 2;
  const Vector2d middle = pair.left_px.array().floor() + 0.5;
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) {
      const Vector2d at = middle + Vector2d(x, y), u = at - pair.left_px;
      const auto slope = [&](const Vector2d& step) { return (grey(at + step) - grey(at - step)) / (2 * kStep_px); };
      const Vector2d own(slope({kStep_px, 0}), slope({0, kStep_px}));
      const Vector2d there = pair.gain * pair.map.inverse().transpose() * own;
      Row row;
      row << there, there.x() * u, there.y() * u, grey(at) - 128, 1;
      normal += row * row.transpose() / noise;
    }
  // What the model has not free is left out.
  Eigen::Matrix<double, 8, Eigen::Dynamic> free = Eigen::Matrix<double, 8, Eigen::Dynamic>::Zero(8, 0);
  const auto add = [&](const Row& column) {
    free.conservativeResize(8, free.cols() + 1);
    free.rightCols<1>() = column;
  };
  const Vector2d along = pair.start.line;
  if (what.model == WindowModel::kLine) {
    add((Row() << along, 0, 0, 0, 0, 0, 0).finished());
  } else {
    add(Row::Unit(0));
    add(Row::Unit(1));
  }
  if (what.model == WindowModel::kScale || what.model == WindowModel::kSimilarity)
    add((Row() << 0, 0, 1, 0, 0, 1, 0, 0).finished());
  if (what.model == WindowModel::kSimilarity) add((Row() << 0, 0, 0, -1, 1, 0, 0, 0).finished());
  if (what.model == WindowModel::kAffine)
    for (int i = 2; i < 6; ++i) add(Row::Unit(i));
  if (what.light == WindowLight::kGainOffset) add(Row::Unit(6));
  if (what.light != WindowLight::kSame) add(Row::Unit(7));
  const Eigen::MatrixXd covariance = (free.transpose() * normal * free).inverse();
  return what.model == WindowModel::kLine ? covariance(0, 0) : covariance(0, 0) + covariance(1, 1);
}

double part(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, std::size_t(share * double(sorted.size())))];
}

void judge(const char* kind, const Case& what, int windows, const std::function<Grey(Random&)>& texture) {
  WindowOptions options;
  options.model = what.model;
  options.light = what.light;
  options.robust = what.robust;
  const int dimensions = what.model == WindowModel::kLine ? 1 : 2;
  std::vector<double> errors;
  double squares = 0, bounds = 0, statistics = 0, variances = 0, noise = 0, iterations = 0, clocks = 0;
  int inside = 0, within = 0, certain = 0;
  double certain_squares = 0;
  for (int i = 0; i < windows; ++i) {
    Random random(7, std::uint64_t(i));
    const Grey grey = texture(random);
    const Pair pair = pair_of(what, grey, random);
    const std::clock_t begin = std::clock();
    const WindowMatch match = match_window(pair.left, pair.left_px, pair.right, pair.start, options);
    clocks += double(std::clock() - begin);
    if (match.outcome != WindowOutcome::kFound) continue;
    const Vector2d error = match.position_px - pair.right_px;
    double statistic = 0;
    if (dimensions == 1) {
      const double along = error.dot(pair.start.line);
      statistic = along * along / match.covariance(0, 0);
    } else {
      statistic = error.dot(match.covariance_px2.inverse() * error);
    }
    errors.push_back(error.norm());
    squares += error.squaredNorm();
    bounds += least_variance_px2(what, grey, pair);
    variances += match.covariance_px2.trace();
    statistics += statistic;
    inside += statistic < kChi95[dimensions];
    within += error.norm() <= kWanted_px;
    if (match.covariance_px2.trace() <= dimensions * kWanted_px * kWanted_px) {
      ++certain;
      certain_squares += error.squaredNorm();
    }
    noise += match.noise_grey;
    iterations += match.iterations;
  }
  if (errors.empty()) return;
  std::sort(errors.begin(), errors.end());
  const double n = double(errors.size());
  const auto per_coordinate = [&](double sum, double count) {
    return std::sqrt(sum / std::max(count, 1.0) / dimensions);
  };
  std::printf(
      "| %s | %s | %.1f | %.4f | %.4f | %.3f | %.1f | %.4f | %.4f | %.4f | %.4f | %.3f | %.1f | %.3f | %.1f | %.2f | "
      "%.1f "
      "| %.0f |\n",
      kind, what.title, 100 * n / windows, per_coordinate(squares, n), per_coordinate(bounds, n),
      std::sqrt(variances / squares), 100 * certain / n, per_coordinate(certain_squares, certain), part(errors, 0.5),
      part(errors, 0.95), part(errors, 0.99), errors.back(), 100 * within / n, std::sqrt(statistics / n / dimensions),
      100 * inside / n, noise / n, iterations / n, 1e6 * clocks / CLOCKS_PER_SEC / windows);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int windows = argc > 1 ? std::atoi(argv[1]) : 1000;
  std::vector<GreyImage> photographs;
  for (int i = 2; i < argc; ++i) {
    auto image = read_grey(argv[i], 1);
    if (!image) {
      std::fprintf(stderr, "%s: %s\n", argv[i], image.error().message.c_str());
      return 1;
    }
    photographs.push_back(std::move(*image));
  }
  std::printf(
      "| texture | model | found [%%] | RMS of a coordinate [px] | Cramer-Rao bound | sigma / error | sigma <= 0.05 px "
      "[%%] "
      "| RMS of these | median length | 95 %% | 99 %% | largest | within 0.05 px [%%] | errors in sigmas | in 95 %% "
      "ellipse "
      "[%%] | noise [grey] | iterations | time [us] |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Case& what : kCases) judge("rendered", what, windows, rendered);
  if (photographs.empty()) return 0;
  for (const Case& what : kCases)
    judge("real", what, windows,
          [&](Random& random) { return real(photographs[random.below(std::uint32_t(photographs.size()))], random); });
  return 0;
}
