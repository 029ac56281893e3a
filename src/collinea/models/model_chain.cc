// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/model_chain.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

namespace collinea {
namespace {

using Eigen::Vector3d;
using Positions = std::map<std::string, Vector3d>;

Result<> check(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control) {
  if (models.empty()) return fail(Errc::kBadInput, "there is no model");
  for (const StereoModel& model : models) {
    std::set<std::string> names;
    for (const NamedPoint& point : model.points) {
      if (!names.insert(point.name).second)
        return fail(Errc::kBadInput, fmt::format("model {}: point {} stands there twice", model.name, point.name));
      if (!point.position.allFinite() || !point.covariance.allFinite())
        return fail(Errc::kBadInput, fmt::format("model {}: point {} has no coordinates or standard deviations",
                                                 model.name, point.name));
    }
    const auto size = static_cast<Eigen::Index>(3 * model.points.size());
    if (model.covariance.size() > 0 && (model.covariance.rows() != size || model.covariance.cols() != size))
      return fail(Errc::kBadInput, fmt::format("model {}: its covariance is not that of its points", model.name));
  }
  std::set<std::string> names;
  for (const SurveyedPoint& point : control)
    if (!names.insert(point.name).second)
      return fail(Errc::kBadInput, fmt::format("control point {} stands there twice", point.name));
  return {};
}

// Means of what several models say of a point.
class Means {
 public:
  void add(const StereoModel& model, const Similarity3& frame_from_model) {
    for (const NamedPoint& point : model.points) {
      auto& [sum, count] = sums_[point.name];
      sum += frame_from_model * point.position;
      ++count;
    }
  }
  [[nodiscard]] bool has(const std::string& name) const { return sums_.contains(name); }
  [[nodiscard]] Vector3d at(const std::string& name) const {
    const auto& [sum, count] = sums_.at(name);
    return sum / count;
  }
  [[nodiscard]] Positions all() const {
    Positions positions;
    for (const auto& [name, sum] : sums_) positions[name] = sum.first / sum.second;
    return positions;
  }

 private:
  struct Sum {
    Vector3d first = Vector3d::Zero();
    int second = 0;
  };
  std::map<std::string, Sum> sums_;
};

struct Part {
  std::map<std::size_t, Similarity3> part_from_model;
  ChainPart links;
  Means means;
};

template <class Known>
std::optional<Similarity3> joined(const StereoModel& model, const Known& known) {
  std::vector<Vector3d> in_model, in_part;
  for (const NamedPoint& point : model.points)
    if (known.has(point.name)) {
      in_model.push_back(point.position);
      in_part.push_back(known.at(point.name));
    }
  return align(in_model, in_part);
}

// Whether a point is in a model, and where.
class PointsOf {
 public:
  explicit PointsOf(const StereoModel& model) {
    for (const NamedPoint& point : model.points) positions_[point.name] = &point.position;
  }
  [[nodiscard]] bool has(const std::string& name) const { return positions_.contains(name); }
  [[nodiscard]] const Vector3d& at(const std::string& name) const { return *positions_.at(name); }

 private:
  std::map<std::string, const Vector3d*> positions_;
};

// How well shared points fix the attitude of a model: the second axis of their spread (about the first one it turns
// most easily), summed over them, in squares of the model's own extent.
double strength_of(const StereoModel& model, const PointsOf& known) {
  Vector3d centre = Vector3d::Zero(), middle = Vector3d::Zero();
  double shared = 0, extent_squared = 0;
  for (const NamedPoint& point : model.points) {
    middle += point.position / double(model.points.size());
    if (!known.has(point.name)) continue;
    centre += point.position;
    ++shared;
  }
  if (shared < 3) return 0;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const NamedPoint& point : model.points) {
    extent_squared += (point.position - middle).squaredNorm() / double(model.points.size());
    const Vector3d reduced = point.position - centre / shared;
    if (known.has(point.name)) scatter += reduced * reduced.transpose();
  }
  const Vector3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  return extent_squared > 0 ? axes[1] / extent_squared : 0;
}

// By what a model hangs on a part: on one of its models, or (strength 0) on points of several.
struct Hold {
  double strength = 0;
  std::size_t partner = 0;
};

Similarity3 operator*(const Similarity3& c_from_b, const Similarity3& b_from_a) {
  return {c_from_b.scale * b_from_a.scale, (c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b * b_from_a.translation};
}

class Concatenation {
 public:
  explicit Concatenation(const std::vector<StereoModel>& models) : models_(models), open_(models.size(), true) {
    std::map<std::string, std::vector<std::size_t>> seen;
    for (std::size_t m = 0; m < models.size(); ++m)
      for (const NamedPoint& point : models[m].points) seen[point.name].push_back(m);
    links_.resize(models.size());
    for (const auto& [name, where] : seen)
      for (const std::size_t m : where)
        for (const std::size_t other : where)
          if (m != other) ++links_[m][other];
  }

  // All parts, the largest first.
  std::vector<Part> parts() {
    std::vector<Part> found;
    while (const auto first = best_start()) found.push_back(grown(*first));
    std::stable_sort(found.begin(), found.end(),
                     [](const Part& a, const Part& b) { return a.part_from_model.size() > b.part_from_model.size(); });
    return found;
  }

 private:
  [[nodiscard]] std::optional<std::size_t> best_start() const {
    std::optional<std::size_t> best;
    int most = -1;
    for (std::size_t m = 0; m < models_.size(); ++m) {
      int shared = 0;
      for (const auto& [other, count] : links_[m]) shared += open_[other] ? count : 0;
      if (!open_[m] || shared <= most) continue;
      most = shared;
      best = m;
    }
    return best;
  }

  // The tree of the strongest links between two models (Prim 1957). A model is joined to one other where that is
  // enough: errors then add up along the tree, while points that several models have carried on would multiply them
  // from strip to strip.
  Part grown(std::size_t first) {
    Part part;
    std::map<std::size_t, Hold> holds;  // of open models that share points with the part
    const auto take = [&](const ChainLink& link, const Similarity3& part_from_model) {
      const std::size_t m = link.model;
      part.part_from_model[m] = part_from_model;
      part.links.push_back(link);
      part.means.add(models_[m], part_from_model);
      open_[m] = false;
      holds.erase(m);
      const PointsOf points(models_[m]);
      for (const auto& [other, count] : links_[m]) {
        if (!open_[other]) continue;
        Hold& hold = holds[other];
        const double strength = strength_of(models_[other], points);
        if (strength > hold.strength) hold = {strength, m};
      }
    };
    take({first, {}}, {});
    while (const auto next = strongest(part, holds)) take(next->first, next->second);
    return part;
  }

  [[nodiscard]] std::optional<std::pair<ChainLink, Similarity3>> strongest(
      const Part& part, const std::map<std::size_t, Hold>& holds) const {
    std::vector<std::pair<double, std::size_t>> order;
    for (const auto& [m, hold] : holds) order.emplace_back(-hold.strength, m);
    std::sort(order.begin(), order.end());
    for (const auto& [minus_strength, m] : order) {
      const Hold& hold = holds.at(m);
      if (hold.strength > 0)
        if (const auto partner_from_model = joined(models_[m], PointsOf(models_[hold.partner])))
          return std::pair(ChainLink{m, hold.partner}, part.part_from_model.at(hold.partner) * *partner_from_model);
      if (const auto part_from_model = joined(models_[m], part.means))
        return std::pair(ChainLink{m, {}}, *part_from_model);
    }
    return std::nullopt;
  }

  const std::vector<StereoModel>& models_;
  std::vector<bool> open_;
  std::vector<std::map<std::size_t, int>> links_;  // points in common
};

// Known positions on the ground, of any kind.
struct Ground {
  std::map<std::string, ControlPair> known;

  [[nodiscard]] std::vector<ControlPair> pairs_of(const Part& part) const {
    std::vector<ControlPair> pairs;
    for (const auto& [name, given] : known)
      if (part.means.has(name)) {
        pairs.push_back(given);
        pairs.back().in_model = part.means.at(name);
      }
    return pairs;
  }
  void take(ModelChain& chain, const std::vector<StereoModel>& models, const Part& part,
            const Similarity3& ground_from_part) {
    for (const auto& [m, part_from_model] : part.part_from_model)
      chain.ground_from_model[m] = ground_from_part * part_from_model;
    chain.parts.push_back(part.links);
    Means means;
    for (const auto& [m, unused] : part.part_from_model) means.add(models[m], *chain.ground_from_model[m]);
    for (const auto& [name, position] : means.all())
      known[name] = ControlPair{Vector3d::Zero(), position, {true, true, true}};
  }
};

LeftOutModel left_out(const std::vector<StereoModel>& models, std::size_t m, const Part& part, const Ground& ground) {
  if (part.part_from_model.size() > 1) return {m, LeftOutReason::kNoControl, 0};
  int shared = 0;
  for (const NamedPoint& point : models[m].points) shared += ground.known.contains(point.name) ? 1 : 0;
  return {m,
          shared == 0  ? LeftOutReason::kNoPoint
          : shared < 3 ? LeftOutReason::kTooFew
                       : LeftOutReason::kOnLine,
          shared};
}

tl::unexpected<Error> lacking(const ControlRank& rank) {
  return fail(Errc::kIllPosed,
              fmt::format("the control fixes {} of the 7 parameters of the block: {} of its points have a position in "
                          "plan and {} a height; two in plan and three heights that are not on a line are the least",
                          rank.rank, rank.plan, rank.heights));
}

}  // namespace

Result<ModelChain> chain_models(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control) {
  COLLINEA_TRY(check(models, control));
  std::vector<Part> parts = Concatenation(models).parts();
  ModelChain chain;
  chain.ground_from_model.resize(models.size());
  Ground ground;
  for (const SurveyedPoint& point : control) {
    if (point.is_check) continue;
    ControlPair& pair = ground.known[point.name];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pair.has[axis] = point.has(static_cast<int>(axis));
      pair.on_ground[static_cast<Eigen::Index>(axis)] = pair.has[axis] ? point.position[static_cast<int>(axis)] : 0;
    }
  }
  chain.on_ground = !ground.known.empty();
  chain.reference = parts.front().part_from_model.begin()->first;
  if (!chain.on_ground && parts.front().part_from_model.size() < 2)
    return fail(Errc::kIllPosed, models.size() == 1
                                     ? "a single model without control: there is nothing to join it with"
                                     : "no two models have three points in common that are not on a line");
  if (!chain.on_ground) {
    const Similarity3 part_from_first = parts.front().part_from_model.at(chain.reference);
    ground.take(chain, models, parts.front(), inverse(part_from_first));
    parts.erase(parts.begin());
  }
  for (bool more = true; more;) {
    more = false;
    for (auto part = parts.begin(); part != parts.end(); ++part) {
      const auto similarity = control_similarity(ground.pairs_of(*part));
      if (!similarity) continue;
      ground.take(chain, models, *part, *similarity);
      parts.erase(part);
      more = true;
      break;
    }
  }
  const bool nothing = std::none_of(chain.ground_from_model.begin(), chain.ground_from_model.end(),
                                    [](const auto& one) { return one.has_value(); });
  if (nothing) return lacking(rank_of(ground.pairs_of(parts.front()), {}));
  for (const Part& part : parts)
    for (const auto& [m, unused] : part.part_from_model) chain.left_out.push_back(left_out(models, m, part, ground));
  Means means;
  for (std::size_t m = 0; m < models.size(); ++m)
    if (chain.ground_from_model[m]) means.add(models[m], *chain.ground_from_model[m]);
  chain.points = means.all();
  return chain;
}

}  // namespace collinea
