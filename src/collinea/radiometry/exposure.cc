// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/exposure.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "collinea/base/parallel.h"

namespace collinea {
namespace {

constexpr int kNodes = 17;             // of the directions along each side
constexpr float kLargestLogGain = 1;   // of images, of directions, and of corners by the fall-off
constexpr std::size_t kMostSeen = 20;  // sightings of a point: more tell little new

ChannelTable directions() {
  ChannelTable table;
  table.origin = {-1, -1};
  table.step = 2.0 / (kNodes - 1);
  table.width = table.height = kNodes;
  return table;
}

// A point as one image shows it: what the logarithm of its colour depends on besides the point itself.
struct Sighting {
  std::uint32_t image, camera;
  float r2;
  ChannelTable::Interpolation direction;
  std::array<float, 3> log_colour;
};

// All sightings of points that two images and more see, point by point.
struct Sightings {
  std::vector<Sighting> all;
  std::vector<std::size_t> first;  // of each point, and the end
};

Sightings sightings_of(std::span<const std::vector<ColourSample>> samples, std::span<const std::uint32_t> cameras) {
  struct Seen {
    std::uint32_t position_index, image;
    const ColourSample* sample;
  };
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < samples.size(); ++i)
    for (const ColourSample& s : samples[i]) seen.push_back({s.position_index, std::uint32_t(i), &s});
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) {
    return std::pair(a.position_index, a.image) < std::pair(b.position_index, b.image);
  });
  Sightings sightings;
  const ChannelTable table = directions();
  for (std::size_t begin = 0, end = 0; begin < seen.size(); begin = end) {
    while (end < seen.size() && seen[end].position_index == seen[begin].position_index) ++end;
    if (end - begin < 2) continue;
    sightings.first.push_back(sightings.all.size());
    const std::size_t count = std::min(end - begin, kMostSeen);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = begin + k * (end - begin) / count;
      const ColourSample& s = *seen[i].sample;
      sightings.all.push_back(
          {seen[i].image, cameras[seen[i].image], s.r2, table.interpolation_at(s.direction), s.log_colour});
    }
  }
  sightings.first.push_back(sightings.all.size());
  return sightings;
}

// The unknowns of a channel: one of each image, one of each camera, one of each node of the directions.
struct Unknowns {
  std::size_t images, cameras;
  [[nodiscard]] std::size_t camera(std::size_t i) const { return images + i; }
  [[nodiscard]] std::size_t node(std::size_t i) const { return images + cameras + i; }
  [[nodiscard]] std::size_t size() const { return node(std::size_t(kNodes) * kNodes); }
};

using Vector = std::vector<double>;

double dot(const Vector& a, const Vector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// The trends of the gains in plan, along the long and the short axis of the block, as vectors of length 1 over the
// images. A strip has but one, as its images stand hardly aside of it.
std::vector<Vector> trends_of(const Sightings& sightings, std::span<const Standpoint> standpoints) {
  constexpr double kLeastWidth = 0.1;  // of the length
  std::vector<bool> counts(standpoints.size());
  for (const Sighting& s : sightings.all) counts[s.image] = true;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double images = 0;
  for (std::size_t i = 0; i < standpoints.size(); ++i)
    if (counts[i]) mean += standpoints[i].at, ++images;
  if (images < 2) return {};
  mean /= images;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < standpoints.size(); ++i)
    if (counts[i]) scatter += (standpoints[i].at - mean) * (standpoints[i].at - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);
  std::vector<Vector> trends;
  for (const int axis : {1, 0}) {  // eigenvalues ascend
    if (!(axes.eigenvalues()[axis] > kLeastWidth * kLeastWidth * axes.eigenvalues()[1])) continue;
    Vector trend(standpoints.size());
    for (std::size_t i = 0; i < trend.size(); ++i)
      if (counts[i]) trend[i] = axes.eigenvectors().col(axis).dot(standpoints[i].at - mean);
    const double length = std::sqrt(dot(trend, trend));
    if (!(length > 0)) continue;
    for (double& value : trend) value /= length;
    trends.push_back(std::move(trend));
  }
  return trends;
}

// One channel's least squares. The logarithm of a sighting is that of the point + x[image] - x[camera] r2 +
// x[direction]; the points are eliminated: the mean over a point's sightings is taken off both sides.
class ChannelFit {
 public:
  ChannelFit(const Sightings& sightings, const Unknowns& unknowns, const std::vector<Vector>& trends,
             std::size_t channel, const Run& run)
      : sightings_(sightings),
        unknowns_(unknowns),
        trends_(trends),
        channel_(channel),
        run_(run),
        weights_(sightings.all.size(), 1.0f) {}

  // Not to be used when run.stopped().
  Vector solve() {
    Vector x(unknowns_.size());
    for (int round = 0; round < 10 && !run_.stopped(); ++round) {
      prepare();
      improve(x);
      weigh(x, round);
    }
    return x;
  }

 private:
  const Sightings& sightings_;
  const Unknowns& unknowns_;
  const std::vector<Vector>& trends_;
  std::size_t channel_;
  const Run& run_;
  std::vector<float> weights_;
  Vector prior_weight_, diagonal_, right_;
  double smoothness_ = 0, steadiness_ = 0;
  std::vector<double> values_;  // of a point's sightings

  [[nodiscard]] double value(const Vector& x, const Sighting& s) const {
    double sum = x[s.image] - x[unknowns_.camera(s.camera)] * double(s.r2);
    for (std::size_t k = 0; k < 4; ++k)
      sum += double(s.direction.weight[k]) * x[unknowns_.node(std::size_t(s.direction.node[k]))];
    return sum;
  }
  void add(Vector& y, const Sighting& s, double v) const {
    y[s.image] += v;
    y[unknowns_.camera(s.camera)] -= v * double(s.r2);
    for (std::size_t k = 0; k < 4; ++k)
      y[unknowns_.node(std::size_t(s.direction.node[k]))] += v * double(s.direction.weight[k]);
  }

  // Sum over all sightings of weight * (of - its mean over the point) times what each depends on.
  template <class Of>
  void collect(Vector& y, const Of& of) {
    for (std::size_t p = 0; p + 1 < sightings_.first.size(); ++p) {
      double sum = 0, weight = 0;
      values_.clear();
      for (std::size_t i = sightings_.first[p]; i < sightings_.first[p + 1]; ++i) {
        values_.push_back(of(sightings_.all[i]));
        sum += double(weights_[i]) * values_.back(), weight += double(weights_[i]);
      }
      for (std::size_t i = sightings_.first[p]; i < sightings_.first[p + 1]; ++i)
        add(y, sightings_.all[i], double(weights_[i]) * (values_[i - sightings_.first[p]] - sum / weight));
    }
  }

  // Beliefs, all in the weight that an image's points have in the mean. An image's gain is drawn to 1 by a five
  // hundredth, so that chains of images do not drift. A trend of the gains by a tenth, but the directions, all
  // together, by a fiftieth only: over many images a trend is the directions', between two it is their exposure. The
  // gains of directions are smooth: a node with two sightings and a fiftieth of the usual number believes its
  // neighbours as much as these.
  void prepare() {
    prior_weight_.assign(unknowns_.size(), 0), diagonal_.assign(unknowns_.size(), 0),
        right_.assign(unknowns_.size(), 0);
    double total = 0;
    for (std::size_t i = 0; i < sightings_.all.size(); ++i) {
      const Sighting& s = sightings_.all[i];
      const double w = double(weights_[i]);
      total += w;
      diagonal_[s.image] += w;
      diagonal_[unknowns_.camera(s.camera)] += w * double(s.r2) * double(s.r2);
      for (std::size_t k = 0; k < 4; ++k)
        diagonal_[unknowns_.node(std::size_t(s.direction.node[k]))] +=
            w * double(s.direction.weight[k]) * double(s.direction.weight[k]);
    }
    constexpr double kNodesOfAll = double(kNodes) * kNodes;
    const double of_an_image = total / double(unknowns_.images);
    steadiness_ = 0.1 * of_an_image;
    smoothness_ = 0.02 * total / kNodesOfAll + 2;
    for (std::size_t i = 0; i < unknowns_.size(); ++i) {
      prior_weight_[i] = i < unknowns_.images    ? 0.002 * diagonal_[i] + 1e-3
                         : i < unknowns_.node(0) ? 0.1
                                                 : 0.02 * of_an_image / kNodesOfAll + 1e-6;
      diagonal_[i] += prior_weight_[i] + (i < unknowns_.node(0) ? 0 : 10 * smoothness_);
    }
    collect(right_, [this](const Sighting& s) { return double(s.log_colour[channel_]); });
  }

  [[nodiscard]] Vector times(const Vector& x) {
    Vector y(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = prior_weight_[i] * x[i];
    collect(y, [&](const Sighting& s) { return value(x, s); });
    for (const Vector& trend : trends_) {
      double found = 0;
      for (std::size_t i = 0; i < trend.size(); ++i) found += trend[i] * x[i];
      for (std::size_t i = 0; i < trend.size(); ++i) y[i] += steadiness_ * found * trend[i];
    }
    const double* nodes = x.data() + unknowns_.node(0);
    double* sums = y.data() + unknowns_.node(0);
    for (int row = 0; row < kNodes; ++row) {
      for (int middle = 1; middle + 1 < kNodes; ++middle) {
        add_curvature(nodes, sums, row * kNodes + middle, 1);
        add_curvature(nodes, sums, middle * kNodes + row, kNodes);
      }
    }
    return y;
  }
  void add_curvature(const double* nodes, double* sums, int at, int step) const {
    const double force = smoothness_ * (nodes[at - step] - 2 * nodes[at] + nodes[at + step]);
    sums[at - step] += force, sums[at] -= 2 * force, sums[at + step] += force;
  }

  // Conjugate gradients, preconditioned by the diagonal. What 500 steps leave is smooth over the block, and small.
  void improve(Vector& x) {
    Vector r = times(x), z(x.size()), p(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) r[i] = right_[i] - r[i];
    double wanted = 0, previous = 0;
    for (std::size_t i = 0; i < x.size(); ++i) wanted += 1e-10 * right_[i] * right_[i] / diagonal_[i];
    for (int step = 0; step < 500 && !run_.stopped(); ++step) {
      for (std::size_t i = 0; i < x.size(); ++i) z[i] = r[i] / diagonal_[i];
      const double now = dot(r, z);
      if (!(now > wanted)) break;
      for (std::size_t i = 0; i < x.size(); ++i) p[i] = z[i] + (step == 0 ? 0 : now / previous) * p[i];
      const Vector q = times(p);
      const double length = now / dot(p, q);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += length * p[i], r[i] -= length * q[i];
      previous = now;
    }
  }

  // A sighting further off than this shows something that moved, shines or is hidden: Huber's weights until all gains
  // are about right, then those of Geman and McClure, for which it soon counts for nothing.
  void weigh(const Vector& x, int round) {
    constexpr double kLargest = 0.05;
    constexpr int kHuberRounds = 4;
    for (std::size_t p = 0; p + 1 < sightings_.first.size(); ++p) {
      double sum = 0, weight = 0;
      for (std::size_t i = sightings_.first[p]; i < sightings_.first[p + 1]; ++i) {
        const Sighting& s = sightings_.all[i];
        sum += double(weights_[i]) * (double(s.log_colour[channel_]) - value(x, s)), weight += double(weights_[i]);
      }
      for (std::size_t i = sightings_.first[p]; i < sightings_.first[p + 1]; ++i) {
        const Sighting& s = sightings_.all[i];
        const double off = std::abs(double(s.log_colour[channel_]) - value(x, s) - sum / weight);
        const double share = off / (2 * kLargest), less = 1 / (1 + share * share);
        weights_[i] = float(round < kHuberRounds ? std::min(1.0, kLargest / off) : less * less);
      }
    }
  }
};

// Whether directions or images get the brightness common to all is arbitrary: the mean of what was seen stays.
std::vector<float> darkness_of_directions(const Vector& x, const Unknowns& unknowns, const Sightings& sightings) {
  const std::size_t nodes = std::size_t(kNodes) * kNodes;
  double mean = 0;
  for (const Sighting& s : sightings.all)
    for (std::size_t k = 0; k < 4; ++k)
      mean += double(s.direction.weight[k]) * x[unknowns.node(std::size_t(s.direction.node[k]))];
  mean /= double(std::max<std::size_t>(1, sightings.all.size()));
  std::vector<float> gains(nodes);
  for (std::size_t i = 0; i < nodes; ++i)
    gains[i] = std::clamp(float(mean - x[unknowns.node(i)]), -kLargestLogGain, kLargestLogGain);
  return gains;
}

// Smoothed over a quarter of the mean distance of the points that an image shows.
ChannelTable darkness_at(const ChannelTable& darkness, std::span<const Eigen::Vector2d> positions,
                         std::span<const std::vector<ColourSample>> samples, std::span<const Standpoint> standpoints) {
  std::vector<ChannelValues> sums(positions.size());
  std::vector<int> counts(positions.size());
  double distance = 0, count = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (const ColourSample& sample : samples[i]) {
      const auto values = darkness.at(sample.direction);
      for (std::size_t c = 0; c < 3; ++c) sums[sample.position_index].values[c] += values[c];
      ++counts[sample.position_index];
      distance += (positions[sample.position_index] - standpoints[i].at).norm(), ++count;
    }
  }
  std::vector<ChannelValues> means;
  for (std::size_t position_index = 0; position_index < positions.size(); ++position_index) {
    if (counts[position_index] == 0) continue;
    ChannelValues mean{positions[position_index], sums[position_index].values};
    for (float& value : mean.values) value /= float(counts[position_index]);
    means.push_back(mean);
  }
  return smoothed_table(means, count > 0 ? distance / count / 4 : 0);
}

std::optional<ColourSample> sample_at(const View& view, const ColourImage& image, const Eigen::Vector3d& position) {
  const auto pixel = pixel_of(view, position);
  if (!pixel || !shows(view, *pixel)) return std::nullopt;
  ColourSample sample;
  sample.r2 = float(relative_radius2(view.camera, *pixel));
  sample.direction = (view.centre_in_world - position).normalized().head<2>();
  for (int c = 0; c < 3; ++c) {
    const float value = bilinear(image, pixel->x() * image.width / view.camera.width_px,
                                 pixel->y() * image.height / view.camera.height_px, c);
    if (value < 10 || value > 245) return std::nullopt;  // cut off, or nothing but noise
    sample.log_colour[std::size_t(c)] = std::log(value);
  }
  return sample;
}

}  // namespace

std::array<float, 3> ColourBalance::factor(std::size_t view_index, const View& view,
                                           const Eigen::Vector3d& position_in_world,
                                           const Eigen::Vector2d& pixel) const {
  const Exposure& exposure = exposures[view_index];
  std::array<float, 3> darker{0, 0, 0}, factor = exposure.gain;
  if (directions.width == 0 && exposure.falloff == darker) return factor;
  const float r2 = float(relative_radius2(view.camera, pixel));
  if (directions.width > 0) {
    darker = directions.at((view.centre_in_world - position_in_world).normalized().head<2>());
    const auto usual = mean_darkness.at(position_in_world.head<2>());
    for (std::size_t c = 0; c < 3; ++c) darker[c] -= usual[c];
  }
  for (std::size_t c = 0; c < 3; ++c) factor[c] *= std::exp(darker[c] + exposure.falloff[c] * r2);
  return factor;
}

double relative_radius2(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double half_width = camera.width_px / 2.0, half_height = camera.height_px / 2.0;
  const double x = pixel.x() - half_width, y = pixel.y() - half_height;
  return (x * x + y * y) / (half_width * half_width + half_height * half_height);
}

Result<ColourBalance> balance_exposures(std::span<const Eigen::Vector2d> positions,
                                        std::span<const std::vector<ColourSample>> samples,
                                        std::span<const Standpoint> standpoints, const Run& run) {
  std::map<CameraId, std::uint32_t> index_of;
  for (const Standpoint& from : standpoints) index_of.emplace(from.camera, std::uint32_t(index_of.size()));
  std::vector<std::uint32_t> camera_of;
  for (const Standpoint& from : standpoints) camera_of.push_back(index_of.at(from.camera));
  const Sightings sightings = sightings_of(samples, camera_of);
  const std::vector<Vector> trends = trends_of(sightings, standpoints);
  const Unknowns unknowns{samples.size(), index_of.size()};
  ColourBalance balance{std::vector<Exposure>(samples.size()), directions(), {}};
  parallel_for(run, 3, [&](std::size_t channel) {
    const Vector x = ChannelFit(sightings, unknowns, trends, channel, run).solve();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      Exposure& exposure = balance.exposures[i];
      exposure.gain[channel] = std::exp(-std::clamp(float(x[i]), -kLargestLogGain, kLargestLogGain));
      exposure.falloff[channel] =
          std::clamp(float(x[unknowns.camera(camera_of[i])]), -kLargestLogGain, kLargestLogGain);
    }
    balance.directions.values[channel] = darkness_of_directions(x, unknowns, sightings);
  });
  if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
  balance.mean_darkness = darkness_at(balance.directions, positions, samples, standpoints);
  return balance;
}

Result<ColourBalance> balance_of(const std::vector<View>& views, std::span<const Eigen::Vector3d> positions_in_world,
                                 const PixelSource& pixels, const Run& run) {
  std::vector<std::vector<ColourSample>> samples(views.size());
  std::vector<Result<>> results(views.size());
  parallel_for(run, views.size(), [&](std::size_t i) {
    const auto image = pixels(views[i].image, 8);
    if (!image) {
      results[i] = tl::unexpected(image.error());
      return;
    }
    for (std::size_t position_index = 0; position_index < positions_in_world.size(); ++position_index) {
      auto sample = sample_at(views[i], *image, positions_in_world[position_index]);
      if (!sample) continue;
      sample->position_index = std::uint32_t(position_index);
      samples[i].push_back(*sample);
    }
  });
  if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
  for (auto& result : results)
    if (!result) return tl::unexpected(std::move(result).error());
  std::vector<Standpoint> standpoints;
  for (const View& view : views) standpoints.push_back({view.camera_id, view.centre_in_world.head<2>()});
  std::vector<Eigen::Vector2d> positions;
  for (const Eigen::Vector3d& position : positions_in_world) positions.push_back(position.head<2>());
  return balance_exposures(positions, samples, standpoints, run);
}

}  // namespace collinea
