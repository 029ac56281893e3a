// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/window_matching.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "collinea/match/internal/window_fit.h"
#include "collinea/match/internal/window_outliers.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Selection = Eigen::Matrix<double, kWindowColumns, Eigen::Dynamic, 0, kWindowColumns, kWindowColumns>;

constexpr int kMostIterations = 30;
constexpr int kFixedMaps = 3;  // so many iterations, or until a step is small, the map is not free
constexpr double kSmallStep_px = 0.3;
constexpr double kLargestStep_px = 1.5;
constexpr double kSettled_px = 0.002;       // of any point of the window: a tenth of the sigma of the best matches
constexpr double kSoftlySettled_px = 0.05;  // while weights follow the residuals, and these the weights
constexpr double kLargestMapChange = 0.5;
constexpr double kLeastGain = 0.05;
constexpr double kLeastNoise_grey = 0.29;  // of whole grey values
constexpr double kLeastTexture_grey = 1;   // noise of any image: what a window shows less than this is no texture
constexpr double kMostNoise = 0.5;         // of the variance of the grey values: more does not correlate
constexpr int kMostRejections = 6;

int geometric_unknowns(WindowModel model) {
  switch (model) {
    case WindowModel::kTranslation:
      return 2;
    case WindowModel::kLine:
      return 1;
    case WindowModel::kScale:
      return 3;
    case WindowModel::kSimilarity:
      return 4;
    case WindowModel::kAffine:
      return 6;
  }
  return 0;
}
int light_unknowns(WindowLight light) {
  return light == WindowLight::kSame ? 0 : light == WindowLight::kOffset ? 1 : 2;
}
int positions_of(WindowModel model) { return model == WindowModel::kLine ? 1 : 2; }

// How the unknowns of the model move those of all models: columns by unknown.
Selection selection_of(WindowModel model, WindowLight light, const WindowStart& start) {
  const int geometric = geometric_unknowns(model);
  Selection out = Selection::Zero(kWindowColumns, geometric + light_unknowns(light));
  const Matrix2d& m = start.map;
  const Eigen::Vector4d scaled(m(0, 0), m(0, 1), m(1, 0), m(1, 1)), turned(-m(1, 0), -m(1, 1), m(0, 0), m(0, 1));
  if (model == WindowModel::kLine) {
    out.col(0).head<2>() = start.line.normalized();
  } else {
    out.topLeftCorner<2, 2>().setIdentity();
  }
  if (model == WindowModel::kScale || model == WindowModel::kSimilarity) out.col(2).segment<4>(2) = scaled;
  if (model == WindowModel::kSimilarity) out.col(3).segment<4>(2) = turned;
  if (model == WindowModel::kAffine) out.block<4, 4>(2, 2).setIdentity();
  if (light == WindowLight::kGainOffset) out(6, geometric) = 1;
  if (light != WindowLight::kSame) out(7, out.cols() - 1) = 1;
  return out;
}

// Columns of the reference's derivatives as the other image would have them: its slopes are map^-T times those.
ColumnMatrix seen_through(const Matrix2d& map) {
  const Matrix2d k = map.inverse().transpose();
  ColumnMatrix out = ColumnMatrix::Identity();
  for (int first : {0, 2, 3}) {
    const int step = first == 0 ? 1 : 2;  // from a derivative along x to that along y
    out(first, first) = k(0, 0);
    out(first + step, first) = k(0, 1);
    out(first, first + step) = k(1, 0);
    out(first + step, first + step) = k(1, 1);
  }
  return out;
}

double largest_eigenvalue(const Matrix2d& m) {
  const double half = m.trace() / 2;
  return half + std::sqrt(std::max(0.0, half * half - m.determinant()));
}

// A symmetric positive or nearly symmetric matrix inverted in units in which its diagonal is one; nothing where it is
// singular.
std::optional<WindowCovariance> inverse_of(const WindowCovariance& matrix) {
  const auto diagonal = matrix.diagonal();
  if (!(diagonal.minCoeff() > 1e-9 && std::isfinite(diagonal.maxCoeff()))) return std::nullopt;
  const WindowParameters scale = diagonal.cwiseSqrt().cwiseInverse();
  const WindowCovariance scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const Eigen::PartialPivLU<WindowCovariance> solver(scaled);
  if (!(solver.rcond() > 1e-7)) return std::nullopt;
  const WindowCovariance inverse = solver.inverse();
  return WindowCovariance(scale.asDiagonal() * inverse * scale.asDiagonal());
}

// One window being matched.
class Matcher {
 public:
  Matcher(WindowFit fit, const GreyImage& right, const WindowStart& start, const WindowOptions& options)
      : fit_(std::move(fit)),
        right_(right),
        start_(start),
        options_(options),
        selection_(selection_of(options.model, options.light, start)),
        placement_{start.position_px, start.map} {
    if (options.light == WindowLight::kSame) light_.offset_grey = fit_.mean_grey();
  }

  WindowMatch run() {
    WindowMatch out;
    if (!has_texture()) {
      out.outcome = WindowOutcome::kNoTexture;
      return out;
    }
    out.outcome = options_.robust ? adjust_robustly() : adjust();
    out.iterations = iterations_;
    if (out.outcome == WindowOutcome::kFound) finish(out);
    return out;
  }

 private:
  // Whether the reference alone would determine the position, were noise one grey value.
  [[nodiscard]] bool has_texture() const {
    const Selection b = seen_through(placement_.map) * selection_;
    const auto inverse = inverse_of(b.transpose() * fit_.normal() * b);
    if (!inverse) return false;
    return largest_eigenvalue(position_part(*inverse)) * kLeastTexture_grey * kLeastTexture_grey <=
           options_.largest_sigma_px * options_.largest_sigma_px;
  }
  [[nodiscard]] Matrix2d position_part(const WindowCovariance& covariance) const {
    const auto by = selection_.topRows<2>();
    return by * covariance * by.transpose();
  }

  // Equations of the unknowns at the present placement; nothing where it leaves the image.
  struct Equations {
    WindowCovariance matrix;
    WindowParameters right;
  };
  std::optional<Equations> equations() {
    if (!fit_.sample(right_, placement_)) return std::nullopt;
    squares_ = fit_.residuals(light_);
    ColumnVector score = fit_.score();
    ColumnMatrix matrix = fit_.matrix();
    // The grey values of the reference carry noise, of which its own square is in the equation of the gain.
    const double squares_of_noise =
        std::min(noise_variance() * kTemplateNoise * fit_.weights(), kMostNoise * fit_.template_square());
    if (is_near_) {
      score[6] -= light_.gain * squares_of_noise;
      matrix(6, 6) -= squares_of_noise;
    }
    const ColumnMatrix through = seen_through(placement_.map);
    const Selection b = through * selection_;
    // Far away the slopes of both images do not belong together: those of the reference alone lead on.
    if (!is_near_) {
      ColumnMatrix by_light = through;
      by_light.leftCols<6>() *= light_.gain;
      matrix = fit_.normal() * by_light;
    }
    return Equations{b.transpose() * matrix * selection_, -b.transpose() * score};
  }
  // By the residuals, their redundancy neglected: of a spline between pixels a variance of 0.23 is left.
  [[nodiscard]] double noise_variance() const {
    return squares_ / (fit_.weights() * (0.23 + light_.gain * light_.gain * kTemplateNoise));
  }

  WindowOutcome adjust() {
    bool is_map_free = geometric_unknowns(options_.model) <= positions_of(options_.model);
    is_near_ = false;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      const auto now = equations();
      if (!now) return iterations_ == 0 ? WindowOutcome::kOutside : WindowOutcome::kLeftImage;
      ++iterations_;
      const auto step = solved(*now, is_map_free);
      if (!step) return WindowOutcome::kNoTexture;
      const auto moved_px = moved_by(*step);
      if (!moved_px) return light_.gain > kLeastGain ? WindowOutcome::kDiverged : WindowOutcome::kUnlike;
      if (is_near_ && *moved_px < (is_soft_ ? kSoftlySettled_px : kSettled_px)) return WindowOutcome::kFound;
      is_near_ = is_near_ || (is_map_free && *moved_px < kSmallStep_px);
      is_map_free = is_map_free || iteration + 1 >= kFixedMaps || *moved_px < kSmallStep_px;
      if (is_soft_) fit_.reweight(outliers_.soft(fit_));
    }
    return WindowOutcome::kNotConverged;
  }

  // First with weights that fall with the residuals, then without what these tell to be gross.
  WindowOutcome adjust_robustly() {
    outliers_.begin(fit_);
    is_soft_ = true;
    if (const auto outcome = adjust(); outcome != WindowOutcome::kFound) return outcome;
    is_soft_ = false;
    for (int times = 0; times < kMostRejections; ++times) {
      const bool is_changed = outliers_.reject(fit_);
      if (!is_changed && times > 0) break;
      if (outliers_.share_used() < 0.5) return WindowOutcome::kOccluded;
      fit_.reweight(outliers_.factors());
      if (const auto outcome = adjust(); outcome != WindowOutcome::kFound) return outcome;
    }
    return WindowOutcome::kFound;
  }

  // The change of all unknowns, those of the map nothing where they are not free.
  [[nodiscard]] std::optional<ColumnVector> solved(const Equations& all, bool is_map_free) const {
    const int unknowns = int(selection_.cols()), positions = positions_of(options_.model);
    const int maps = geometric_unknowns(options_.model) - positions;
    if (is_map_free || maps == 0) {
      const auto inverse = inverse_of(all.matrix);
      if (!inverse) return std::nullopt;
      return ColumnVector(selection_ * (*inverse * all.right));
    }
    const int lights = unknowns - positions - maps;
    WindowCovariance matrix(positions + lights, positions + lights);
    WindowParameters right(positions + lights);
    const auto from = [&](int i) { return i < positions ? i : i + maps; };
    for (int i = 0; i < positions + lights; ++i) {
      right[i] = all.right[from(i)];
      for (int k = 0; k < positions + lights; ++k) matrix(i, k) = all.matrix(from(i), from(k));
    }
    const auto inverse = inverse_of(matrix);
    if (!inverse) return std::nullopt;
    const WindowParameters some = *inverse * right;
    ColumnVector out = ColumnVector::Zero();
    for (int i = 0; i < positions + lights; ++i) out += some[i] * selection_.col(from(i));
    return out;
  }

  // The largest move of a point of the window; nothing where the step leads away.
  std::optional<double> moved_by(const ColumnVector& step) {
    const double shift_px = step.head<2>().norm();
    const double share = shift_px > kLargestStep_px ? kLargestStep_px / shift_px : 1;
    placement_.position_px += share * step.head<2>();
    Matrix2d change;
    change << step[2], step[3], step[4], step[5];
    placement_.map += share * change;
    light_.gain += step[6];
    light_.offset_grey += step[7];
    if (!((placement_.position_px - start_.position_px).norm() <= options_.farthest_px)) return std::nullopt;
    if (!((start_.map.inverse() * placement_.map - Matrix2d::Identity()).norm() <= kLargestMapChange))
      return std::nullopt;
    if (!(light_.gain > kLeastGain)) return std::nullopt;
    return shift_px + change.norm() * (fit_.side() / 2) * std::sqrt(2.0);
  }

  // Noise, covariance and what is said of the match.
  void finish(WindowMatch& out) {
    const auto last = equations();
    out.outcome = WindowOutcome::kLeftImage;
    if (!last) return;
    out.outcome = WindowOutcome::kNoTexture;
    const auto inverse = inverse_of(last->matrix);
    if (!inverse) return;
    const Selection b = seen_through(placement_.map) * selection_;
    const WindowFit::Noise noise = fit_.noise(placement_, light_.gain);
    const WindowCovariance of_score = b.transpose() * noise.covariance * b;
    // What fitting takes from r'W r: tr((B'W B)^-1 cov(B'W r)), where A is B but for the gain.
    WindowCovariance lost = *inverse * of_score;
    const int geometric = geometric_unknowns(options_.model);
    lost.topRows(geometric) *= light_.gain;
    const double expected = noise.squares - lost.trace();
    if (!(expected > 0)) return;
    out.noise_grey = std::max(std::sqrt(squares_ / expected), kLeastNoise_grey);
    out.covariance = *inverse * of_score * inverse->transpose() * (out.noise_grey * out.noise_grey);
    out.covariance_px2 = position_part(out.covariance);
    if (!(largest_eigenvalue(out.covariance_px2) <= options_.largest_sigma_px * options_.largest_sigma_px)) return;
    out.correlation = fit_.correlation();
    out.outcome = out.correlation >= options_.least_correlation ? WindowOutcome::kFound : WindowOutcome::kUnlike;
    out.position_px = placement_.position_px;
    out.map = placement_.map;
    out.gain = light_.gain;
    out.offset_grey = light_.offset_grey - light_.gain * fit_.mean_grey();
    out.share_used = options_.robust ? outliers_.share_used() : 1;
    out.redundancy = out.share_used * fit_.count() - double(selection_.cols());
    state_parameters(out);
  }

  // The offset within is that of the mean of the reference, outside that of black.
  void state_parameters(WindowMatch& out) const {
    const int geometric = geometric_unknowns(options_.model), unknowns = int(selection_.cols());
    WindowParameters& p = out.parameters;
    p.resize(unknowns);
    if (options_.model == WindowModel::kLine) {
      p[0] = (out.position_px - start_.position_px).dot(start_.line.normalized());
    } else {
      p.head(2) = out.position_px;
    }
    const Matrix2d relative = out.map * start_.map.inverse();
    if (options_.model == WindowModel::kScale || options_.model == WindowModel::kSimilarity) p[2] = relative(0, 0);
    if (options_.model == WindowModel::kSimilarity) p[3] = relative(1, 0);
    if (options_.model == WindowModel::kAffine)
      p.segment(2, 4) << out.map(0, 0), out.map(0, 1), out.map(1, 0), out.map(1, 1);
    if (options_.light == WindowLight::kGainOffset) {
      p[geometric] = out.gain;
      WindowCovariance by = WindowCovariance::Identity(unknowns, unknowns);
      by(unknowns - 1, geometric) = -fit_.mean_grey();
      out.covariance = by * out.covariance * by.transpose();
    }
    if (options_.light != WindowLight::kSame) p[unknowns - 1] = out.offset_grey;
  }

  WindowFit fit_;
  const GreyImage& right_;
  const WindowStart& start_;
  const WindowOptions& options_;
  Selection selection_;
  WindowPlacement placement_;
  WindowLightValues light_;
  WindowOutliers outliers_;
  double squares_ = 0;
  bool is_near_ = false, is_soft_ = false;
  int iterations_ = 0;
};

}  // namespace

std::vector<std::string_view> window_parameter_names(WindowModel model, WindowLight light) {
  std::vector<std::string_view> names;
  if (model == WindowModel::kLine) {
    names = {"along"};
  } else {
    names = {"x", "y"};
  }
  if (model == WindowModel::kScale) names.push_back("scale");
  if (model == WindowModel::kSimilarity) names.insert(names.end(), {"a", "b"});
  if (model == WindowModel::kAffine) names.insert(names.end(), {"xx", "xy", "yx", "yy"});
  if (light == WindowLight::kGainOffset) names.push_back("gain");
  if (light != WindowLight::kSame) names.push_back("offset");
  return names;
}

WindowMatch match_window(const GreyImage& left, const Vector2d& left_px, const GreyImage& right,
                         const WindowStart& start, const WindowOptions& options) {
  if (!start.position_px.allFinite() || !start.map.allFinite() || !(start.map.determinant() > 1e-3) ||
      !(start.line.norm() > 0))
    return {};
  auto fit = WindowFit::of(left, left_px, options.window_px, false);
  if (!fit) return {};
  return Matcher(std::move(*fit), right, start, options).run();
}

}  // namespace collinea
