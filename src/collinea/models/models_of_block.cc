// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/models_of_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "collinea/epipolar/model_points.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

struct Seen {
  Vector2d ray;  // undistorted, X/Z and Y/Z
  double sigma = 1;
};
using SeenByName = std::map<std::string, Seen>;

struct Measurements {
  std::map<ImageId, SeenByName> of_image;
  std::map<std::string, int> images;  // that see a point
  std::set<std::string> control;
};

void add(Measurements& all, const Block& block, ImageId image, const std::string& name, const Vector2d& pixel,
         const Vector2d& sigmas_px) {
  const Camera& camera = block.camera_of(image);
  if (all.of_image[image]
          .try_emplace(name, Seen{normalized(camera, pixel), sigmas_px.mean() / camera.focal_px()})
          .second)
    ++all.images[name];
}

Measurements measurements_of(const Block& block) {
  Measurements all;
  for (const Observation& one : block.observations)
    add(all, block, one.image, std::to_string(one.point.value), one.pixel, one.sigmas_px());
  for (const ControlObservation& one : block.control_observations) {
    const auto point = block.control.find(one.point);
    if (point == block.control.end()) continue;
    all.control.insert(point->second.name);
    add(all, block, one.image, point->second.name, one.pixel, one.sigmas_px());
  }
  return all;
}

std::vector<std::string> common(const SeenByName& a, const SeenByName& b) {
  std::vector<std::string> names;
  for (const auto& [name, seen] : a)
    if (b.contains(name)) names.push_back(name);
  return names;
}

// What the model keeps: control, then what most images see, evenly.
std::vector<std::size_t> kept(const std::vector<std::string>& names, const std::vector<bool>& usable,
                              const Measurements& all, int most) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (usable[i]) order.push_back(i);
  if (static_cast<int>(order.size()) <= most) return order;
  const auto rank = [&](std::size_t i) { return all.control.contains(names[i]) ? 1000 : all.images.at(names[i]); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    // Of the same rank in an order that has nothing to do with where they lie.
    const auto mixed = [](std::size_t i) { return (i + 1) * 0x9e3779b97f4a7c15u >> 20; };
    return rank(a) != rank(b) ? rank(a) > rank(b) : mixed(a) < mixed(b);
  });
  order.resize(static_cast<std::size_t>(most));
  std::sort(order.begin(), order.end());
  return order;
}

// The frame of the left photograph, projection centres first.
StereoModel model_of(const Block& block, const FormedModel& formed, const std::vector<std::string>& names,
                     const std::vector<std::size_t>& which, const PairModel& pair, const Matrix5& orientation) {
  PairModel some;
  some.second_centre = pair.second_centre;
  for (const std::size_t i : which) some.points.push_back(pair.points[i]);
  const Eigen::MatrixXd covariance = full_covariance(some, orientation);
  const std::string &left = block.images.at(formed.left).file, &right = block.images.at(formed.right).file;
  StereoModel model{left + "+" + right, {}, Eigen::MatrixXd::Zero(covariance.rows() + 3, covariance.cols() + 3)};
  const auto count = static_cast<Index>(which.size());
  for (Index i = 0; i < count; ++i)
    model.points.push_back({names[which[static_cast<std::size_t>(i)]],
                            some.points[static_cast<std::size_t>(i)]->position, covariance.block<3, 3>(3 * i, 3 * i)});
  model.points.push_back({right, some.second_centre.position, covariance.bottomRightCorner<3, 3>()});
  model.points.push_back({left, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()});
  model.covariance.topLeftCorner(covariance.rows(), covariance.cols()) = covariance;
  return model;
}

Result<StereoModel> formed_model(const Block& block, const Measurements& all, FormedModel& formed,
                                 const ModelPairChoice& choice, bool sigmas_known, std::uint64_t seed) {
  const SeenByName &left = all.of_image.at(formed.left), &right = all.of_image.at(formed.right);
  const std::vector<std::string> names = common(left, right);
  formed.points = static_cast<int>(names.size());
  std::vector<PairPoint> points;
  for (const std::string& name : names) {
    const Seen &first = left.at(name), &second = right.at(name);
    points.push_back({first.ray, second.ray, first.sigma, second.sigma});
  }
  RelativeOptions options;
  options.sigma_known = sigmas_known;
  COLLINEA_TRY(const RelativeOrientation orientation, relative_orientation(points, options, seed));
  formed.rejected = static_cast<int>(orientation.rejected.size());
  formed.sigma0 = orientation.sigma0;
  const PairModel pair = model_points(orientation, points, 1, true);
  std::vector<bool> usable;
  for (std::size_t i = 0; i < points.size(); ++i)
    usable.push_back(orientation.residuals[i].used && pair.points[i] && pair.points[i]->in_front);
  return model_of(block, formed, names, kept(names, usable, all, choice.most_points), pair,
                  orientation.stated_covariance());
}

Result<> check_names(const Block& block, const Measurements& all) {
  std::set<std::string> names;
  for (const auto& [id, image] : block.images)
    if (!names.insert(image.file).second || all.images.contains(image.file))
      return fail(Errc::kBadInput,
                  fmt::format("{} is the name of an image and of a point or another image", image.file));
  for (const Observation& one : block.observations)
    if (all.control.contains(std::to_string(one.point.value)))
      return fail(Errc::kBadInput, fmt::format("{} is the name of a tie point and of control", one.point.value));
  return {};
}

}  // namespace

std::vector<std::pair<ImageId, ImageId>> model_pairs(const Block& block, const ModelPairChoice& choice) {
  const Measurements all = measurements_of(block);
  std::map<std::string, std::vector<ImageId>> seen;
  for (const auto& [image, points] : all.of_image)
    for (const auto& [name, one] : points) seen[name].push_back(image);
  std::map<std::pair<ImageId, ImageId>, int> counts;
  for (const auto& [name, images] : seen)
    for (std::size_t i = 0; i < images.size(); ++i)
      for (std::size_t k = i + 1; k < images.size(); ++k) ++counts[{images[i], images[k]}];
  std::map<ImageId, int> best;
  std::vector<std::pair<int, std::pair<ImageId, ImageId>>> order;
  for (const auto& [pair, count] : counts) {
    order.emplace_back(-count, pair);
    best[pair.first] = std::max(best[pair.first], count);
    best[pair.second] = std::max(best[pair.second], count);
  }
  std::sort(order.begin(), order.end());
  std::map<ImageId, int> used;
  std::map<ImageId, ImageId> chain;  // to any other of its chain; a chain's root is its own
  const auto root = [&](ImageId image) {
    while (chain.contains(image) && chain.at(image) != image) image = chain.at(image);
    return image;
  };
  std::vector<std::pair<ImageId, ImageId>> pairs;
  for (const auto& [minus_count, pair] : order) {
    const int count = -minus_count;
    const int least = static_cast<int>(choice.least_share * std::max(best[pair.first], best[pair.second]));
    if (count < choice.least_points || count < least || used[pair.first] > 1 || used[pair.second] > 1) continue;
    if (root(pair.first) == root(pair.second)) continue;
    chain[root(pair.first)] = root(pair.second);
    ++used[pair.first];
    ++used[pair.second];
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Result<ModelsOfBlock> models_of_block(const Block& block, const std::vector<std::pair<ImageId, ImageId>>& pairs,
                                      const ModelPairChoice& choice, bool sigmas_known, const Run& run) {
  const Measurements all = measurements_of(block);
  COLLINEA_TRY(check_names(block, all));
  ModelsOfBlock out;
  for (const auto& [id, point] : block.control)
    out.control.push_back({point.name, point.position_in_world, point.sigma_m, point.role == ControlRole::kCheck});
  for (const auto& [left, right] : pairs) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    FormedModel& formed = out.pairs.emplace_back(FormedModel{left, right, 0, 0, 0, {}});
    if (!all.of_image.contains(left) || !all.of_image.contains(right)) {
      formed.failure = "no measurements";
      continue;
    }
    auto model = formed_model(block, all, formed, choice, sigmas_known, run.seed);
    if (model)
      out.models.push_back(*std::move(model));
    else
      formed.failure = model.error().message;
  }
  if (!out.models.empty()) return out;
  return fail(Errc::kIllPosed, out.pairs.empty()
                                   ? fmt::format("no two images have {} points in common", choice.least_points)
                                   : fmt::format("no pair could be oriented; of the first: {}", out.pairs[0].failure));
}

}  // namespace collinea
