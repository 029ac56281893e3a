// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/snooping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "collinea/adjust/control_check.h"
#include "collinea/adjust/intersect.h"

namespace collinea {
namespace {

using Group = ObservationGroup;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastRedundancy = 0.1;  // below, Foerstner calls an observation not controllable
constexpr int kLeastRaysOfImage = 6;      // twice what orients it
constexpr double kSame = 0.99;            // of |w|
constexpr double kGross = 100;            // sigmas: such a ray of control bends the images it is in
// A blunder in one of n rays of an image shows in another as h / r of itself; h of the six unknowns of the image is 3 /
// n on average, and three times that in corners.
constexpr double kSpoiltByRay = 10;

bool is_ray(Group group) { return group == Group::kTieImages || group == Group::kControlImages; }
// Of the third axis; of the others of its kind are both.
bool is_height(Group group) {
  return group == Group::kControlHeight || group == Group::kPositionHeight || group == Group::kAttitudeHeading;
}
bool is_ground(Group group) { return group >= Group::kDistance && group <= Group::kOnLine; }
bool is_attitude(Group group) { return group == Group::kAttitudeLevel || group == Group::kAttitudeHeading; }
bool is_position(Group group) { return group == Group::kPositionPlan || group == Group::kPositionHeight; }

// What an observation is, whatever place it has in a block.
using Key = std::tuple<Group, std::uint32_t, std::uint32_t>;

template <class T>
void erase(std::vector<T>& all, std::vector<std::uint32_t>& places) {
  std::sort(places.begin(), places.end());
  std::size_t next = 0, to = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (next < places.size() && places[next] == i)
      ++next;
    else
      all[to++] = all[i];
  }
  all.resize(to);
}

class Snooper {
 public:
  Snooper(const Block& block, const AdjustScope& scope, const AdjustOptions& options, int most, const Run& run)
      : given_(block), scope_(scope), options_(options), most_(most), run_(run) {
    options_.reliability = true;
    for (const auto& [id, camera] : block.cameras) scope_.first_cameras.try_emplace(id, camera);
    out_.block = block;
  }

  Result<Snooped> snoop() {
    if (scope_.use_control) take_out_gross();
    for (bool first = true;;) {
      Result<Adjusted> adjusted = adjuster_.adjust(out_.block, scope_, options_, run_);
      if (!adjusted && (adjusted.error().code != Errc::kIllPosed || gone_.empty()))
        return tl::unexpected(std::move(adjusted).error());
      ++out_.rounds;
      const bool determined = adjusted && adjusted->reliability && (first || adjusted->rank_defect <= rank_defect_);
      if (!determined && !gone_.empty()) {
        put_back();
        continue;
      }
      if (!determined) return fail(Errc::kIllPosed, "data snooping: " + adjusted->undetermined);
      rank_defect_ = adjusted->rank_defect;
      if (first) {
        out_.sigma0_before = adjusted->sigma0;
        out_.with = adjusted->control;
      }
      first = false;
      if (most_in_round_ < kAll / 2) most_in_round_ *= 2;
      apply(*adjusted, out_.block);
      out_.kept.clear();
      keep_for_return();
      take_out_worst(*adjusted);
      out_.finished = gone_.empty() && !full_;
      if (gone_.empty()) {
        out_.adjusted = std::move(*adjusted);
        out_.attitudes = scope_.attitudes;
        tell_blunders();
        return std::move(out_);
      }
    }
  }

 private:
  struct Seen {  // what is left of a measurement
    ImageId image;
    PointId point;
    ControlId control;
    std::uint32_t ground = 0;
  };

  [[nodiscard]] Seen seen_by(const TestedObservation& one) const {
    Seen seen{};
    if (one.group == Group::kTieImages) {
      seen.image = out_.block.observations[one.source].image;
      seen.point = out_.block.observations[one.source].point;
    } else if (one.group == Group::kControlImages) {
      seen.image = out_.block.control_observations[one.source].image;
      seen.control = out_.block.control_observations[one.source].point;
    } else if (is_position(one.group) || is_attitude(one.group)) {
      seen.image = ImageId{one.source};
    } else if (is_ground(one.group)) {
      seen.ground = one.source;
    } else {
      seen.control = ControlId{one.source};
    }
    return seen;
  }
  [[nodiscard]] static Key key_of(Group group, const Seen& seen) {
    if (is_ground(group)) return {group, seen.ground, 0};
    return {group, seen.image.value, group == Group::kTieImages ? seen.point.value : seen.control.value};
  }

  // Before a round: what it takes may have to be put back.
  void keep_for_return() {
    before_ = out_.block;
    attitudes_before_ = scope_.attitudes;
    taken_before_ = out_.taken_out.size();
    gone_.clear();
  }
  // Without it something would not be determined. Which of many that is shows when fewer go.
  void put_back() {
    out_.block = before_;
    scope_.attitudes = attitudes_before_;
    out_.taken_out.resize(taken_before_);
    given_of_.resize(taken_before_);
    if (gone_.size() == 1) stays_[gone_.front()] = "without it the block is not determined";
    most_in_round_ = gone_.size() == 1 ? kAll : gone_.size() / 2;
    gone_.clear();
  }

  void take_out_gross() {
    keep_for_return();
    std::vector<std::uint32_t> gross;
    const ControlDiagnosis diagnosis = check_control(given_, run_.seed);
    for (const std::size_t place : diagnosis.excluded_observations) {
      const ControlObservation& seen = given_.control_observations[place];
      double off_px = 0;
      for (const Finding& finding : diagnosis.findings)
        if (finding.point == seen.point && finding.image == seen.image) off_px = std::max(off_px, finding.size);
      if (off_px < kGross * seen.sigma_px || static_cast<int>(out_.taken_out.size()) >= most_) continue;
      gross.push_back(static_cast<std::uint32_t>(place));
      TakenOut gone{Group::kControlImages, seen.image, {}, seen.point};
      gone.w = off_px / seen.sigma_px;
      gone.redundancy = gone.pulled = kNaN;
      gone.sigma = kNaN;
      out_.taken_out.push_back(gone);
      given_of_.push_back({seen.sigma_px, seen.pixel});
      gone_.push_back(key_of(gone.group, {seen.image, {}, seen.point}));
    }
    erase(out_.block.control_observations, gross);
  }

  // One pass over the suspects, worst first.
  void take_out_worst(const Adjusted& adjusted) {
    const Reliability& tests = *adjusted.reliability;
    count_rays(adjusted);
    std::map<ImageId, double> worse_in_image;  // sum of |w| of worse suspects
    std::set<PointId> points;
    std::set<ControlId> controls;
    bool ground = false;
    std::set<Key> this_round;
    full_ = false;
    std::vector<std::uint32_t> ties, control_rays;
    for (const TestedObservation& one : tests.suspects) {
      const Seen seen = seen_by(one);
      const Key key = key_of(one.group, seen);
      if (this_round.contains(key)) continue;  // its other coordinate
      if (const std::string reason = reason_to_stay(one, seen, tests); !reason.empty()) {
        out_.kept.push_back({one, reason});
        continue;
      }
      bool waits = false;
      if (is_ray(one.group)) {
        double& worse = worse_in_image[seen.image];
        const double spoilt = worse * std::min(1.0, kSpoiltByRay / rays_[seen.image]);
        waits = std::isfinite(one.w) && std::abs(one.w) - spoilt < tests.limit;
        waits |=
            one.group == Group::kTieImages ? !points.insert(seen.point).second : !controls.insert(seen.control).second;
        if (std::isfinite(one.w)) worse += std::abs(one.w);
      } else {
        waits = ground || (seen.control.valid() && controls.contains(seen.control));
        ground = true;
      }
      if (waits) continue;
      if (static_cast<int>(out_.taken_out.size()) >= most_) {
        full_ = true;
        break;
      }
      if (gone_.size() == most_in_round_) break;
      this_round.insert(key);
      gone_.push_back(key);
      take_out(one, seen, adjusted, ties, control_rays);
    }
    erase(out_.block.observations, ties);
    erase(out_.block.control_observations, control_rays);
  }

  // Only what takes part keeps an image where it is.
  void count_rays(const Adjusted& adjusted) {
    rays_.clear();
    of_point_.clear();
    for (const std::uint32_t place : adjusted.observations) {
      const Observation& seen = out_.block.observations[place];
      ++rays_[seen.image];
      ++of_point_[seen.point];
    }
    for (const TestedObservation& one : adjusted.reliability->others)
      if (one.group == Group::kControlImages && one.axis == 0)
        ++rays_[out_.block.control_observations[one.source].image];
  }

  [[nodiscard]] std::string reason_to_stay(const TestedObservation& one, const Seen& seen,
                                           const Reliability& tests) const {
    if (const auto why = stays_.find(key_of(one.group, seen)); why != stays_.end()) return why->second;
    if (!std::isfinite(one.w)) return "";
    if (one.redundancy < kLeastRedundancy) return "too little checks it";
    if (is_ray(one.group))
      return rays_.at(seen.image) <= kLeastRaysOfImage ? "its image would keep too few measurements" : "";
    for (const TestedObservation& other : tests.suspects) {
      if (is_ray(other.group) || &other == &one) continue;
      const bool same = key_of(other.group, seen_by(other)) == key_of(one.group, seen);
      const double ratio = std::abs(other.w / one.w);
      if (!same && ratio > kSame && ratio < 1 / kSame) return "others are suspect to the same degree";
    }
    return "";
  }

  void take_out(const TestedObservation& one, const Seen& seen, const Adjusted& adjusted,
                std::vector<std::uint32_t>& ties, std::vector<std::uint32_t>& control_rays) {
    TakenOut gone{one.group, seen.image, seen.point, seen.control, seen.ground, one.axis, one.w, one.redundancy};
    gone.pulled = one.blunder - one.residual;
    gone.sigma = variance_by_others(one, adjusted);
    gone.round = out_.rounds;
    Given given{one.sigma, {}};
    if (one.group == Group::kTieImages) {
      given.pixel = out_.block.observations[one.source].pixel;
      ties.push_back(one.source);
      --rays_[seen.image];
      if (--of_point_[seen.point] < 2) {
        gone.as_pair = std::isfinite(one.w);
        take_out_partner(one.source, ties);
      }
    } else if (one.group == Group::kControlImages) {
      given.pixel = out_.block.control_observations[one.source].pixel;
      control_rays.push_back(one.source);
      --rays_[seen.image];
    } else {
      disbelieve(one.group, seen);
    }
    out_.taken_out.push_back(gone);
    given_of_.push_back(given);
  }

  // A point with one ray is none.
  void take_out_partner(std::uint32_t source, std::vector<std::uint32_t>& ties) {
    const auto& all = out_.block.observations;
    for (const std::int64_t step : {-1, 1})
      for (std::int64_t i = source + step; i >= 0 && i < static_cast<std::int64_t>(all.size()) &&
                                           all[static_cast<std::size_t>(i)].point == all[source].point;
           i += step) {
        if (std::find(ties.begin(), ties.end(), i) == ties.end()) {
          ties.push_back(static_cast<std::uint32_t>(i));
          --rays_[all[static_cast<std::size_t>(i)].image];
        }
      }
  }

  // The variance of what the others foretell, in sigmas^2 of image points: from w, which has it.
  [[nodiscard]] double variance_by_others(const TestedObservation& one, const Adjusted& adjusted) const {
    if (!std::isfinite(one.w)) return kNaN;
    const double sigma0 = sigma0_of(adjusted), own = is_ray(one.group) ? sigma0 : 1;
    const double spread = one.blunder / one.w / one.sigma;
    return std::max(0.0, (spread * spread - own * own) / (sigma0 * sigma0));
  }
  [[nodiscard]] double sigma0_of(const Adjusted& adjusted) const {
    return options_.sigma0_known ? 1 : std::max(sigma_scale(adjusted), 1e-12);
  }

  void disbelieve(Group group, const Seen& seen) {
    if (is_ground(group)) {
      out_.block.ground[seen.ground].role = ControlRole::kCheck;
      return;
    }
    Eigen::Vector3d& sigma = is_attitude(group)   ? scope_.attitudes.at(seen.image).sigma_rad
                             : is_position(group) ? out_.block.images.at(seen.image).position->sigma_m
                                                  : out_.block.control.at(seen.control).sigma_m;
    if (is_height(group))
      sigma.z() = kInfinity;
    else
      sigma.head<2>().setConstant(kInfinity);
  }

  // Measured minus what the last adjustment says.
  void tell_blunders() {
    const double sigma0 = sigma0_of(out_.adjusted);
    for (std::size_t i = 0; i < out_.taken_out.size(); ++i) {
      TakenOut& gone = out_.taken_out[i];
      if (gone.group == Group::kTieImages) {
        if (!gone.as_pair) tell(gone, given_of_[i].pixel, out_.block.points.at(gone.point).position_in_world);
      } else if (gone.group == Group::kControlImages) {
        if (const auto place = place_of(gone.control)) tell(gone, given_of_[i].pixel, *place);
      } else if (is_position(gone.group)) {
        // With unknowns between antenna and camera what was told when it went stays.
        const Eigen::Vector3d& place = given_.images.at(gone.image).position->position_in_world;
        if (scope_.lever_arms.empty() && scope_.position_tracks.empty())
          tell(gone, place - centre_of(out_.block.cam_from_world.at(gone.image)));
      } else if (is_ground(gone.group)) {
        for (const GroundDifference& one : out_.adjusted.ground)
          if (one.observation == gone.ground) gone.blunder.x() = -one.difference;
      } else if (is_attitude(gone.group)) {
        for (const AttitudeDifference& one : out_.adjusted.attitudes)
          if (one.image == gone.image) tell(gone, -one.difference_rad);
      } else if (const auto place = place_of(gone.control)) {
        tell(gone, given_.control.at(gone.control).position_in_world - *place);
      }
      if (gone.round == 0) {
        const double size = gone.blunder.head<2>().norm();
        gone.axis = std::abs(gone.blunder.y()) > std::abs(gone.blunder.x()) ? 1 : 0;
        gone.sigma = variance_by_rays(gone) / (given_of_[i].sigma * given_of_[i].sigma);
        if (std::isfinite(size)) gone.w = size / given_of_[i].sigma;
      }
      const double own = is_ray(gone.group) ? sigma0 : 1;
      gone.sigma = given_of_[i].sigma * std::sqrt(own * own + sigma0 * sigma0 * gone.sigma);
    }
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> place_of(ControlId id) const {
    for (const ControlDifference& one : out_.adjusted.control)
      if (one.point == id) return one.position_in_world;
    return std::nullopt;
  }
  // Of a coordinate of the image of a control point where its other rays meet, all images being exact.
  [[nodiscard]] double variance_by_rays(const TakenOut& gone) const {
    const auto met = intersect(sight_lines(out_.block, gone.control));
    const Rigid3& pose = out_.block.cam_from_world.at(gone.image);
    Matrix23 by_cam;
    if (!met || !project(out_.block.camera_of(gone.image), pose * met->point_in_world, &by_cam, nullptr)) return kNaN;
    const Eigen::RowVector3d by_world = by_cam.row(gone.axis) * pose.rotation.toRotationMatrix();
    return by_world * met->covariance * by_world.transpose();
  }
  void tell(TakenOut& gone, const Eigen::Vector2d& pixel, const Eigen::Vector3d& place) const {
    const Rigid3& pose = out_.block.cam_from_world.at(gone.image);
    if (const auto expected = project(out_.block.camera_of(gone.image), pose * place))
      gone.blunder.head<2>() = pixel - *expected;
  }
  static void tell(TakenOut& gone, const Eigen::Vector3d& difference) {
    if (is_height(gone.group))
      gone.blunder.z() = difference.z();
    else
      gone.blunder.head<2>() = difference.head<2>();
  }

  const Block& given_;
  AdjustScope scope_;
  AdjustOptions options_;
  int most_;
  const Run& run_;
  Adjuster adjuster_;
  Snooped out_;
  struct Given {  // of what was taken out
    double sigma;
    Eigen::Vector2d pixel;  // of rays
  };
  std::vector<Given> given_of_;  // parallel to Snooped::taken_out
  std::map<ImageId, int> rays_;
  std::map<PointId, int> of_point_;
  std::map<Key, std::string> stays_;
  Block before_;  // the last round
  std::map<ImageId, GivenAttitude> attitudes_before_;
  std::size_t taken_before_ = 0;
  std::vector<Key> gone_;  // in the last round
  static constexpr std::size_t kAll = ~std::size_t{0};
  std::size_t most_in_round_ = kAll;
  int rank_defect_ = 0;
  bool full_ = false;
};

}  // namespace

Result<Snooped> snoop(const Block& block, const AdjustScope& scope, const AdjustOptions& options, int most,
                      const Run& run) {
  return Snooper(block, scope, options, most, run).snoop();
}

}  // namespace collinea
