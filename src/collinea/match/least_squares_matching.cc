// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/least_squares_matching.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr int kHalf = kWindow / 2, kPoints = kWindow * kWindow;
constexpr double kWeightSigma = 0.6;  // of the half width: the corners count by 1/16
constexpr int kMostIterations = 20;
constexpr double kSettled = 0.003;  // spacings: a tenth of what a good match is worth
constexpr double kLeastCorrelation = 0.8;
constexpr double kLargestChange = 0.5;  // of the map against its start
constexpr double kLargestSigma = 0.25;  // spacings: less is no better than a feature's own position
constexpr double kLeastNoise_grey = 1;  // of any image: what is smaller is no texture

// The points of a window, in spacings from its middle, and their weights; what fills the arrays up has none.
struct Points {
  std::array<float, kWindowFloats> u{}, v{}, weight{};
  double weights = 0;

  Points() {
    for (int k = 0; k < kPoints; ++k) {
      const auto i = static_cast<std::size_t>(k);
      u[i] = static_cast<float>(k % kWindow - kHalf);
      v[i] = static_cast<float>(k / kWindow - kHalf);
      const double square = (u[i] * u[i] + v[i] * v[i]) / double{kHalf * kHalf};
      weight[i] = static_cast<float>(std::exp(-0.5 * square / (kWeightSigma * kWeightSigma)));
      weights += weight[i];
    }
  }
};

const Points& points() {
  static const Points all;
  return all;
}

// Grey values where a window whose position lies at `position` from its middle [spacings] is put.
bool sample(const Patch& patch, const Placement& placement, const Eigen::Vector2d& position, double spacing_px,
            const float* u, const float* v, float* out) {
  const Eigen::Matrix2d step = placement.warp * (spacing_px / patch.pixel_px);
  const Eigen::Vector2d middle =
      (placement.position_px - patch.corner_px) / patch.pixel_px - Eigen::Vector2d(0.5, 0.5) - step * position;
  if (!(middle.norm() + step.norm() < 1e6)) return false;
  return sample_window({patch.grey.data(), Patch::kSize},
                       {static_cast<float>(middle.x()), static_cast<float>(middle.y()), static_cast<float>(step(0, 0)),
                        static_cast<float>(step(0, 1)), static_cast<float>(step(1, 0)), static_cast<float>(step(1, 1))},
                       u, v, out);
}

double weighted_mean(const std::array<float, kWindowFloats>& values) {
  double sum = 0;
  for (std::size_t i = 0; i < kPoints; ++i) sum += double{points().weight[i]} * values[i];
  return sum / points().weights;
}

double largest_eigenvalue(const Eigen::Matrix2d& m) {
  const double half = m.trace() / 2;
  return half + std::sqrt(std::max(0.0, half * half - m.determinant()));
}

// By Sobel's operator: along `step`, smoothed across it.
float slope(const std::uint8_t* pixel, int across, int step) {
  const auto difference = [&](const std::uint8_t* p) { return static_cast<float>(p[step] - p[-step]); };
  return 0.125f * (difference(pixel - across) + 2 * difference(pixel) + difference(pixel + across));
}

constexpr double kSlopeNoise = 12.0 / 64;  // variance of Sobel's slope for noise of 1

// The four weights of cubic convolution (Keys 1981, a = -1/2), as the kernels have them.
std::array<double, 4> cubic_weights(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {-t3 / 2 + t2 - t / 2, 1.5 * t3 - 2.5 * t2 + 1, -1.5 * t3 + 2 * t2 + t / 2, t3 / 2 - t2 / 2};
}
double squared_norm(const std::array<double, 4>& w) { return w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]; }

// What noise of 1 in the pixels of the reference adds to J'W J: its slopes and grey values share none.
Eigen::Matrix<double, kUnknowns, kUnknowns> noise_of_normal(const Eigen::Vector2d& position) {
  const Points& p = points();
  Eigen::Matrix<double, kUnknowns, kUnknowns> out = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d by(1, p.u[i] - position.x(), p.v[i] - position.y());
    const Eigen::Matrix3d squares = p.weight[i] * kSlopeNoise * by * by.transpose();
    const int along_x[] = {0, 2, 3}, along_y[] = {1, 4, 5};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        out(along_x[a], along_x[b]) += squares(a, b);
        out(along_y[a], along_y[b]) += squares(a, b);
      }
  }
  out(6, 6) = p.weights;
  return out;
}

}  // namespace

std::optional<Patch> cut_patch(const GreyImage& level, double pixel_px, const Eigen::Vector2d& position_px) {
  if (std::min(level.width, level.height) < Patch::kSize) return std::nullopt;
  const auto first = [&](double position, int end) {
    const double wanted =
        std::clamp(std::round(position / pixel_px) - Patch::kSize / 2, 0.0, double(end - Patch::kSize));
    return static_cast<int>(wanted);
  };
  const int left = first(position_px.x(), level.width), top = first(position_px.y(), level.height);
  Patch patch;
  patch.pixel_px = pixel_px;
  patch.corner_px = {left * pixel_px, top * pixel_px};
  for (int y = 0; y < Patch::kSize; ++y)
    std::copy_n(level.row(top + y) + left, Patch::kSize, patch.grey.data() + y * Patch::kSize);
  return patch;
}

// Between pixels noise is smoothed, the more the farther from their centres, and so it would have a mean gradient of
// its own where points lie alike between pixels: positions would be off by tenths of a pixel in noisy images. At the
// pixels themselves a grey value and the slopes there share no noise.
std::optional<ReferenceWindow> ReferenceWindow::of(const Patch& patch, const Eigen::Vector2d& position_px) {
  ReferenceWindow window;
  window.spacing_px_ = patch.pixel_px;
  const Eigen::Vector2d position = (position_px - patch.corner_px) / patch.pixel_px - Eigen::Vector2d(0.5, 0.5);
  const Eigen::Vector2d middle(std::round(position.x()), std::round(position.y()));
  window.position_ = position - middle;
  constexpr double kInside = kHalf + 1;  // slopes
  if (!(middle.minCoeff() >= kInside && middle.maxCoeff() <= Patch::kSize - 1 - kInside)) return std::nullopt;

  const Points& p = points();
  const std::uint8_t* centre =
      patch.grey.data() + static_cast<int>(middle.y()) * Patch::kSize + static_cast<int>(middle.x());
  const auto pixel_of = [&](std::size_t i) {
    return centre + static_cast<int>(p.v[i]) * Patch::kSize + static_cast<int>(p.u[i]);
  };
  for (std::size_t i = 0; i < kPoints; ++i) window.grey_[i] = *pixel_of(i);
  const auto mean = static_cast<float>(weighted_mean(window.grey_));
  Values squares{};
  for (std::size_t i = 0; i < kPoints; ++i) {
    window.grey_[i] -= mean;
    squares[i] = window.grey_[i] * window.grey_[i];
  }
  window.grey_square_ = weighted_mean(squares);

  std::array<float, kUnknowns * kWindowFloats> derivatives{};
  for (std::size_t i = 0; i < kPoints; ++i) {
    const std::uint8_t* pixel = pixel_of(i);
    const float x = slope(pixel, Patch::kSize, 1), y = slope(pixel, 1, Patch::kSize);
    const float u = p.u[i] - static_cast<float>(window.position_.x()),
                v = p.v[i] - static_cast<float>(window.position_.y());
    const float of[kUnknowns] = {x, y, x * u, x * v, y * u, y * v, window.grey_[i], 1};
    for (std::size_t k = 0; k < kUnknowns; ++k) {
      derivatives[k * kWindowFloats + i] = of[k];
      window.weighted_[k * kWindowFloats + i] = of[k] * p.weight[i];
    }
  }
  Matrix8d& normal = window.normal_;
  Matrix8d& twice = window.twice_weighted_;
  for (int k = 0; k < kUnknowns; ++k) {
    float once[kUnknowns], squared[kUnknowns];
    const std::ptrdiff_t column = std::ptrdiff_t{k} * kWindowFloats;
    window_products(window.weighted_.data(), derivatives.data() + column, once);
    window_products(window.weighted_.data(), window.weighted_.data() + column, squared);
    for (int i = 0; i < kUnknowns; ++i) {
      normal(i, k) = once[i];
      twice(i, k) = squared[i];
    }
  }
  // In units in which the diagonal is one.
  const Eigen::Matrix<double, kUnknowns, 1> scale = normal.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix8d> solver(scale.asDiagonal() * normal * scale.asDiagonal());
  if (!(solver.eigenvalues()[0] > 1e-6)) return std::nullopt;
  window.inverse_ = scale.asDiagonal() * solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() *
                    solver.eigenvectors().transpose() * scale.asDiagonal();
  const Matrix8d spread = window.inverse_ * twice;
  window.cofactor_ = (spread * window.inverse_).topLeftCorner<2, 2>();
  window.redundancy_ = p.weights - spread.trace();
  if (largest_eigenvalue(window.cofactor_) * std::pow(kLeastNoise_grey, 2) > kLargestSigma * kLargestSigma)
    return std::nullopt;
  return window;
}

ReferenceWindow::BentPoints ReferenceWindow::bent(const WindowBend& bend) const {
  BentPoints out{points().u, points().v};
  if (bend.by_squares.isZero(0)) return out;
  const Eigen::Matrix<double, 2, 3> by_spacings = spacing_px_ * bend.by_squares;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double x = out.u[i] - position_.x(), y = out.v[i] - position_.y();
    const Eigen::Vector2d more = by_spacings * Eigen::Vector3d(x * x, x * y, y * y);
    out.u[i] += static_cast<float>(more.x());
    out.v[i] += static_cast<float>(more.y());
  }
  return out;
}

std::optional<LeastSquaresMatch> ReferenceWindow::find(const Patch& other, const Placement& start, double farthest_px,
                                                       const WindowBend& bend) const {
  const Points& p = points();
  const BentPoints at = bent(bend);
  Placement now = start;
  const Eigen::Matrix2d first_inverse = start.warp.inverse();
  Values seen, left_over;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    if (!sample(other, now, position_, spacing_px_, at.u.data(), at.v.data(), seen.data())) return std::nullopt;
    const double mean = weighted_mean(seen);
    double square = 0, common = 0;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const double value = seen[i] - mean, weighted = p.weight[i] * value;
      square += weighted * value;
      common += weighted * grey_[i];
    }
    square /= p.weights;
    common /= p.weights;
    const double correlation = common / std::sqrt(square * grey_square_);
    if (!(correlation > 0)) return std::nullopt;
    const double gain = common / grey_square_;
    double squares_left = 0;
    for (std::size_t i = 0; i < kWindowFloats; ++i) {
      left_over[i] = static_cast<float>((seen[i] - mean) / gain) - grey_[i];
      squares_left += double{p.weight[i]} * left_over[i] * left_over[i];
    }
    float right_side[kUnknowns];
    window_products(weighted_.data(), left_over.data(), right_side);
    Eigen::Matrix<double, kUnknowns, 1> b;
    for (int k = 0; k < kUnknowns; ++k) b[k] = right_side[k];
    const Eigen::Matrix<double, 6, 1> step = inverse_.topRows<6>() * b;
    // The reference, so moved, is what is seen here: the window goes the other way.
    Eigen::Matrix2d stretch;
    stretch << 1 + step[2], step[3], step[4], 1 + step[5];
    if (!(stretch.determinant() > 0.1)) return std::nullopt;
    now.warp = now.warp * stretch.inverse();
    const Eigen::Vector2d moved_px = now.warp * step.head<2>() * spacing_px_;
    now.position_px -= moved_px;
    if (!((now.position_px - start.position_px).norm() <= farthest_px)) return std::nullopt;
    if (!((first_inverse * now.warp - Eigen::Matrix2d::Identity()).norm() <= kLargestChange)) return std::nullopt;
    if (step.head<2>().norm() > kSettled) continue;
    // A sigma as if the residuals were white: too small (covariance()), but what is refused was settled with it.
    const Eigen::Matrix2d cofactor = cofactor_ * (squares_left / redundancy_);
    if (correlation < kLeastCorrelation || largest_eigenvalue(cofactor) > kLargestSigma * kLargestSigma)
      return std::nullopt;
    return LeastSquaresMatch{now, correlation, gain, squares_left};
  }
  return std::nullopt;
}

// N is J'W J of the noisy slopes: too large by their noise, the step that a change of the other image makes is
// M^-1 J'W of it, M = N less that noise. J'W r is a linear form of the pixels, those of the other image through the
// weights of the interpolation.
std::optional<MatchCovariance> ReferenceWindow::covariance(const Patch& other, const LeastSquaresMatch& match,
                                                           const WindowBend& bend) const {
  const Points& p = points();
  const BentPoints bent_to = bent(bend);
  const Eigen::Matrix2d step = match.placement.warp * (spacing_px_ / other.pixel_px);
  const Eigen::Vector2d middle =
      (match.placement.position_px - other.corner_px) / other.pixel_px - Eigen::Vector2d(0.5, 0.5) - step * position_;
  const double other_noise = 1 / (match.gain * match.gain);  // variance in grey values of the reference
  // Noise of the grey values: r'W r has on an average `expected` times its variance.
  const Eigen::Matrix<double, kUnknowns, kUnknowns> lost = inverse_ * twice_weighted_;
  double expected = p.weights - lost.trace();
  const auto weights_of = [&](std::size_t i, std::array<double, 4>& across, std::array<double, 4>& down) {
    const Eigen::Vector2d at = middle + step * Eigen::Vector2d(bent_to.u[i], bent_to.v[i]);
    const Eigen::Vector2d low = at.array().floor();
    across = cubic_weights(at.x() - low.x());
    down = cubic_weights(at.y() - low.y());
    return Eigen::Vector2i(low.cast<int>() - Eigen::Vector2i(1, 1));
  };
  std::array<double, 4> across, down;
  Eigen::Matrix<double, kUnknowns, Eigen::Dynamic> forms =
      Eigen::Matrix<double, kUnknowns, Eigen::Dynamic>::Zero(kUnknowns, Patch::kSize * Patch::kSize);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Eigen::Vector2i corner = weights_of(i, across, down);
    if (corner.minCoeff() < 0 || corner.maxCoeff() + 4 > Patch::kSize) return std::nullopt;
    expected += other_noise * p.weight[i] * squared_norm(across) * squared_norm(down);
    Eigen::Matrix<double, kUnknowns, 1> c;
    for (int k = 0; k < kUnknowns; ++k) c[k] = weighted_[std::size_t(k) * kWindowFloats + i];
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x)
        forms.col((corner.y() + y) * Patch::kSize + corner.x() + x) +=
            across[std::size_t(x)] * down[std::size_t(y)] * c;
  }
  const Eigen::Matrix<double, kUnknowns, kUnknowns> of_other = other_noise * (forms * forms.transpose());
  expected -= (inverse_ * of_other).trace();
  if (!(expected > 0)) return std::nullopt;
  const double variance = match.squares_left / expected;
  const Matrix8d without_noise = normal_ - variance * noise_of_normal(position_);
  const Eigen::LDLT<Matrix8d> solver(without_noise);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
  const Eigen::Matrix<double, kUnknowns, 2> rows = solver.solve(Matrix8d::Identity()).leftCols<2>();
  const auto of_position = [&](const Matrix8d& noise, const Eigen::Matrix2d& px_from_spacings) {
    return Eigen::Matrix2d(variance * px_from_spacings * rows.transpose() * noise * rows *
                           px_from_spacings.transpose());
  };
  return MatchCovariance{of_position(of_other, match.placement.warp * spacing_px_),
                         of_position(twice_weighted_, spacing_px_ * Eigen::Matrix2d::Identity()), match.placement.warp};
}

}  // namespace collinea
