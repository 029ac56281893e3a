// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/snooping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "collinea/block/subject_label.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/quality/control_check.h"

namespace collinea {
namespace {

using Group = ObservationGroup;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Foerstner: below the first an observation is not controllable, below the second badly.
constexpr double kLeastRedundancy = 0.01, kPoorRedundancy = 0.1;
constexpr int kLeastRaysOfImage = 6;  // twice what orients it
constexpr double kSame = 0.99;        // of |w|; correlation of the tests of two observations
constexpr int kMostRepeats = 3;       // of an adjustment that has not converged
constexpr double kGross = 100;        // sigmas: such a ray of control bends the images it is in
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
  Snooper(const Block& block, const AdjustScope& scope, const ExamineOptions& options, int most, const Run& run)
      : given_(block), scope_(scope), options_(options), most_(most), run_(run), given_attitudes_(scope.attitudes) {
    options_.reliability = true;
    for (const auto& [id, camera] : block.cameras) scope_.first_cameras.try_emplace(id, camera);
    out_.block = block;
  }

  Result<Snooped> snoop() {
    if (scope_.use_control) reject_gross();
    for (bool first = true;;) {
      Result<Examined> adjusted = adjust_to_the_end();
      if (!adjusted && (adjusted.error().code != Errc::kIllPosed || gone_.empty()))
        return tl::unexpected(std::move(adjusted).error());
      const bool determined = adjusted && adjusted->reliability && (first || adjusted->rank_defect <= rank_defect_);
      if (!determined && !gone_.empty()) {
        if (gone_.size() == 1) stays_[gone_.front()] = StayReason::kBlockNeedsIt;
        take_back();
        continue;
      }
      if (!determined)
        return fail(Errc::kIllPosed,
                    "data snooping: " + (adjusted ? label_of(adjusted->undetermined, out_.block) : ""));
      if (mistakes_another(*adjusted)) {
        take_back();
        continue;
      }
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
      reject_worst(*adjusted);
      if (!gone_.empty()) continue;
      out_.finished = !full_;
      out_.adjusted = std::move(*adjusted);
      tell_gross_errors();
      if (out_.finished && put_back_what_agrees()) continue;
      out_.attitudes = scope_.attitudes;
      for (const Rejected& gone : out_.rejected) back_.erase(key_of(gone));
      out_.put_back = static_cast<int>(back_.size());
      return std::move(out_);
    }
  }

 private:
  struct Given {  // of what was taken out
    double sigma = 0;
    double cofactor = kNaN;  // of what the others predict, in sigma^2
    Observation ray{.pixel = {0, 0}};
    ControlObservation mark{.pixel = {0, 0}};
  };
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

  // A blunder far off may need more iterations than are allowed; half way everything looks wrong.
  Result<Examined> adjust_to_the_end() {
    for (int repeat = 0;; ++repeat) {
      Result<Examined> adjusted = examine(adjuster_, out_.block, scope_, options_, run_);
      ++out_.rounds;
      if (!adjusted || adjusted->converged || repeat == kMostRepeats) return adjusted;
      apply(*adjusted, out_.block);
    }
  }
  [[nodiscard]] static Key key_of(const Rejected& gone) {
    return key_of(gone.group, {gone.image, gone.point, gone.control, gone.ground});
  }

  // Before a round: what it takes may have to be taken back.
  void keep_for_return() {
    before_ = out_.block;
    attitudes_before_ = scope_.attitudes;
    taken_before_ = out_.rejected.size();
    gone_.clear();
    rivals_.clear();
  }
  // Without it something would not be determined. Which of many that is shows when fewer go.
  void take_back() {
    out_.block = before_;
    scope_.attitudes = attitudes_before_;
    out_.rejected.resize(taken_before_);
    given_of_.resize(taken_before_);
    most_in_round_ = gone_.size() == 1 ? kAll : gone_.size() / 2;
    gone_.clear();
    rivals_.clear();
  }

  // The redundancy number of another falls by the square of the correlation of both tests when an observation goes.
  // Of two that say the same of themselves none is left to check the other. One that little checks goes only where it
  // is the wrong one beyond doubt: the difference of two tests has the variance 2 (1 - correlation).
  bool mistakes_another(const Examined& adjusted) {
    if (rivals_.empty()) return false;
    const double limit = adjusted.reliability->limit;
    std::set<Key> alike;
    for (const TestedObservation& one : adjusted.reliability->others) {
      const auto before = rivals_.find({key_of(one.group, seen_by(one)), one.axis});
      if (before == rivals_.end()) continue;
      const double correlation = std::sqrt(std::max(0.0, 1 - one.redundancy / before->second.redundancy));
      const bool explained =
          worst_is_poor_ && std::abs(one.w) < limit && before->second.behind < limit * std::sqrt(2 * (1 - correlation));
      if (correlation > kSame || explained) alike.insert(before->first.first);
    }
    if (alike.empty()) return false;
    stays_[worst_] = worst_is_poor_ ? StayReason::kTooLittleChecks : StayReason::kSameDegree;
    if (!worst_is_poor_)
      for (const Key& key : alike) stays_[key] = StayReason::kSameDegree;
    return true;
  }

  void reject_gross() {
    keep_for_return();
    std::vector<std::uint32_t> gross;
    const ControlDiagnosis diagnosis = check_control(given_, run_.seed);
    for (const std::size_t place : diagnosis.excluded_observations) {
      const ControlObservation& seen = given_.control_observations[place];
      double off_px = 0;
      for (const Finding& finding : diagnosis.findings)
        if (finding.code == FindingCode::kControlMeasurement && finding.subjects[0].control() == seen.point &&
            finding.subjects[1].image() == seen.image)
          off_px = std::max(off_px, finding.figure(FigureName::kOffsetPx).value_or(0));
      if (off_px < kGross * seen.sigma_px || static_cast<int>(out_.rejected.size()) >= most_) continue;
      gross.push_back(static_cast<std::uint32_t>(place));
      Rejected gone{Group::kControlImages, seen.image, {}, seen.point};
      gone.w = off_px / seen.sigma_px;
      gone.redundancy = gone.influence = kNaN;
      out_.rejected.push_back(gone);
      given_of_.push_back({.sigma = seen.sigma_px, .mark = seen});
      gone_.push_back(key_of(gone.group, {seen.image, {}, seen.point}));
    }
    erase(out_.block.control_observations, gross);
  }

  // One pass over the suspects, worst first.
  void reject_worst(const Examined& adjusted) {
    const Reliability& tests = *adjusted.reliability;
    count_rays(adjusted);
    std::map<ImageId, double> worse_in_image;  // sum of |w| of worse suspects
    std::set<PointId> points;
    std::set<ControlId> controls, doubtful;
    bool ground = false, worse_stays = false;
    std::set<Key> this_round;
    full_ = false;
    std::vector<std::uint32_t> ties, control_rays;
    for (const TestedObservation& one : tests.suspects) {
      const Seen seen = seen_by(one);
      const Key key = key_of(one.group, seen);
      if (this_round.contains(key)) continue;  // its other coordinate
      if (const auto reason = reason_to_stay(one, seen, worse_stays)) {
        out_.kept.push_back({one, *reason});
        worse_stays |= !is_ray(one.group);
        if (!is_ray(one.group)) doubtful.merge(points_of(one.group, seen));
        continue;
      }
      bool waits = false;
      if (is_ray(one.group)) {
        if (ground) continue;  // what is worse may have spoilt it
        if (doubtful.contains(seen.control)) {
          out_.kept.push_back({one, StayReason::kWorseOfItsPoint});
          continue;
        }
        double& worse = worse_in_image[seen.image];
        const double spoilt = worse * std::min(1.0, kSpoiltByRay / rays_[seen.image]);
        waits = std::isfinite(one.w) && std::abs(one.w) - spoilt < tests.limit;
        waits |=
            one.group == Group::kTieImages ? !points.insert(seen.point).second : !controls.insert(seen.control).second;
        if (std::isfinite(one.w)) worse += std::abs(one.w);
      } else {
        const std::set<ControlId> its = points_of(one.group, seen);
        waits = ground || std::ranges::any_of(its, [&](ControlId id) { return controls.contains(id); });
        ground = true;
      }
      if (waits) continue;
      if (static_cast<int>(out_.rejected.size()) >= most_) {
        full_ = true;
        break;
      }
      if (gone_.size() == most_in_round_) break;
      this_round.insert(key);
      gone_.push_back(key);
      if (!is_ray(one.group)) remember_rivals(one, key, tests);
      reject(one, seen, adjusted, ties, control_rays);
    }
    erase(out_.block.observations, ties);
    erase(out_.block.control_observations, control_rays);
  }

  // Those that a measurement on the ground or coordinates are of.
  [[nodiscard]] std::set<ControlId> points_of(Group group, const Seen& seen) const {
    if (is_ground(group)) return {out_.block.ground[seen.ground].from, out_.block.ground[seen.ground].to};
    return seen.control.valid() ? std::set{seen.control} : std::set<ControlId>{};
  }

  // What might be wrong instead of this one: as suspect, or hardly less than one that little checks.
  void remember_rivals(const TestedObservation& one, const Key& key, const Reliability& tests) {
    worst_ = key;
    worst_is_poor_ = one.redundancy < kPoorRedundancy;
    for (const TestedObservation& other : tests.suspects) {
      if (is_ray(other.group)) continue;
      const Key its = key_of(other.group, seen_by(other));
      const double own = std::abs(one.suspicion), its_own = std::abs(other.suspicion);
      const bool near = worst_is_poor_ ? own - its_own < tests.limit * std::numbers::sqrt2
                                       : its_own > kSame * own && own > kSame * its_own;
      if (its != key && near) rivals_[{its, other.axis}] = {other.redundancy, own - its_own};
    }
  }

  // Only what takes part keeps an image where it is.
  void count_rays(const Examined& adjusted) {
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

  // `worse_stays`: by which it may be spoilt.
  [[nodiscard]] std::optional<StayReason> reason_to_stay(const TestedObservation& one, const Seen& seen,
                                                         bool worse_stays) const {
    if (const auto why = stays_.find(key_of(one.group, seen)); why != stays_.end()) return why->second;
    if (!std::isfinite(one.w)) return std::nullopt;
    if (one.redundancy < (is_ray(one.group) || worse_stays ? kPoorRedundancy : kLeastRedundancy))
      return StayReason::kTooLittleChecks;
    if (is_ray(one.group) && rays_.at(seen.image) <= kLeastRaysOfImage) return StayReason::kImageNeedsIt;
    return std::nullopt;
  }

  void reject(const TestedObservation& one, const Seen& seen, const Examined& adjusted,
              std::vector<std::uint32_t>& ties, std::vector<std::uint32_t>& control_rays) {
    Rejected gone{one.group, seen.image, seen.point, seen.control, seen.ground, one.axis, one.w, one.redundancy};
    gone.influence = one.gross_error - one.residual;
    gone.round = out_.rounds;
    Given given{.sigma = one.sigma, .cofactor = variance_by_others(one, adjusted)};
    if (one.group == Group::kTieImages) {
      given.ray = out_.block.observations[one.source];
      ties.push_back(one.source);
      --rays_[seen.image];
      if (--of_point_[seen.point] < 2) {
        gone.as_pair = std::isfinite(one.w);
        reject_partner(one.source, ties);
      }
    } else if (one.group == Group::kControlImages) {
      given.mark = out_.block.control_observations[one.source];
      control_rays.push_back(one.source);
      --rays_[seen.image];
    } else {
      disbelieve(one.group, seen);
    }
    out_.rejected.push_back(gone);
    given_of_.push_back(given);
  }

  // A point with one ray is none.
  void reject_partner(std::uint32_t source, std::vector<std::uint32_t>& ties) {
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

  // The variance of what the others predict, in sigmas^2 of image points: from w, which has it.
  [[nodiscard]] double variance_by_others(const TestedObservation& one, const Examined& adjusted) const {
    if (!std::isfinite(one.w)) return kNaN;
    const double sigma0 = sigma0_of(adjusted), own = is_ray(one.group) ? sigma0 : 1;
    const double spread = one.gross_error / one.w / one.sigma;
    return std::max(0.0, (spread * spread - own * own) / (sigma0 * sigma0));
  }
  [[nodiscard]] double sigma0_of(const Examined& adjusted) const {
    return options_.test.sigma0_known ? 1 : std::max(sigma_scale(adjusted), 1e-12);
  }

  void disbelieve(Group group, const Seen& seen) {
    if (is_ground(group)) {
      out_.block.ground[seen.ground].role = ControlRole::kCheck;
      return;
    }
    Eigen::Vector3d& sigma = sigma_of(group, seen.image, seen.control);
    if (is_height(group))
      sigma.z() = kInfinity;
    else
      sigma.head<2>().setConstant(kInfinity);
  }
  Eigen::Vector3d& sigma_of(Group group, ImageId image, ControlId control) {
    return is_attitude(group)   ? scope_.attitudes.at(image).sigma_rad
           : is_position(group) ? out_.block.images.at(image).position->sigma_m
                                : out_.block.control.at(control).sigma_m;
  }

  // Measured minus what the last adjustment says.
  void tell_gross_errors() {
    const double sigma0 = sigma0_of(out_.adjusted);
    for (std::size_t i = 0; i < out_.rejected.size(); ++i) {
      Rejected& gone = out_.rejected[i];
      Given& given = given_of_[i];
      if (gone.group == Group::kTieImages) {
        if (!gone.as_pair) tell(gone, given.ray.pixel, out_.block.points.at(gone.point).position_in_world);
      } else if (gone.group == Group::kControlImages) {
        if (const auto place = place_of(gone.control)) tell(gone, given.mark.pixel, *place);
      } else if (is_position(gone.group)) {
        // With unknowns between antenna and camera what was told when it went stays.
        const Eigen::Vector3d& place = given_.images.at(gone.image).position->position_in_world;
        if (scope_.lever_arms.empty() && scope_.position_tracks.empty())
          tell(gone, place - centre_of(pose_of(out_.block, gone.image)));
      } else if (is_ground(gone.group)) {
        for (const GeodeticDifference& one : out_.adjusted.ground)
          if (one.observation == gone.ground) gone.gross_error.x() = -one.difference;
      } else if (is_attitude(gone.group)) {
        for (const AttitudeDifference& one : out_.adjusted.attitudes)
          if (one.image == gone.image) tell(gone, -one.difference_rad);
      } else if (const auto place = place_of(gone.control)) {
        tell(gone, given_.control.at(gone.control).position_in_world - *place);
      }
      if (gone.round == 0) {
        const double size = gone.gross_error.head<2>().norm();
        gone.axis = std::abs(gone.gross_error.y()) > std::abs(gone.gross_error.x()) ? 1 : 0;
        given.cofactor = variance_by_rays(gone) / (given.sigma * given.sigma);
        if (std::isfinite(size)) gone.w = size / given.sigma;
      }
      const double own = is_ray(gone.group) ? sigma0 : 1;
      gone.sigma = given.sigma * std::sqrt(own * own + sigma0 * sigma0 * given.cofactor);
      if (const auto sigma = sigma_of_correlated(gone, sigma0)) gone.sigma = *sigma;
    }
  }

  // The test of a correlated coordinate was that beside the others of its point, which have gone with it.
  [[nodiscard]] std::optional<double> sigma_of_correlated(const Rejected& gone, double sigma0) const {
    if (gone.group != Group::kControlPlan && gone.group != Group::kControlHeight) return std::nullopt;
    const ControlPoint& given = given_.control.at(gone.control);
    if (given.correlation.isZero(0)) return std::nullopt;
    for (const ControlDifference& now : out_.adjusted.control)
      if (now.point == gone.control && now.covariance_m2)
        return std::hypot(given.sigma_m[gone.axis], sigma0 * std::sqrt((*now.covariance_m2)(gone.axis, gone.axis)));
    return std::nullopt;
  }

  // Another blunder, which has gone since, had spoilt it. Each once: what is suspect again goes for good.
  bool put_back_what_agrees() {
    std::map<PointId, int> rays;
    for (const Observation& seen : out_.block.observations) ++rays[seen.point];
    std::vector<Rejected> gone_still;
    std::vector<Given> given_still;
    for (std::size_t i = 0; i < out_.rejected.size(); ++i) {
      const Rejected& gone = out_.rejected[i];
      const bool point_is_there = gone.group != Group::kTieImages || rays[gone.point] >= 2;
      if (!gone.as_pair && point_is_there &&
          std::abs(gone.gross_error[gone.axis]) < out_.adjusted.reliability->limit * gone.sigma &&
          back_.insert(key_of(gone)).second) {
        put_back(gone, given_of_[i]);
        continue;
      }
      gone_still.push_back(gone);
      given_still.push_back(given_of_[i]);
    }
    const bool any = gone_still.size() < out_.rejected.size();
    out_.rejected = std::move(gone_still);
    given_of_ = std::move(given_still);
    return any;
  }

  void put_back(const Rejected& gone, const Given& given) {
    if (gone.group == Group::kTieImages) {
      auto& all = out_.block.observations;
      const auto order = [](const Observation& seen) { return std::pair(seen.point, seen.image); };
      all.insert(std::upper_bound(all.begin(), all.end(), given.ray,
                                  [&](const auto& a, const auto& b) { return order(a) < order(b); }),
                 given.ray);
    } else if (gone.group == Group::kControlImages) {
      out_.block.control_observations.push_back(given.mark);
    } else if (is_ground(gone.group)) {
      out_.block.ground[gone.ground].role = ControlRole::kControl;
    } else {
      const Eigen::Vector3d& as_given = is_attitude(gone.group)   ? given_attitudes_.at(gone.image).sigma_rad
                                        : is_position(gone.group) ? given_.images.at(gone.image).position->sigma_m
                                                                  : given_.control.at(gone.control).sigma_m;
      Eigen::Vector3d& sigma = sigma_of(gone.group, gone.image, gone.control);
      if (is_height(gone.group))
        sigma.z() = as_given.z();
      else
        sigma.head<2>() = as_given.head<2>();
    }
  }

  [[nodiscard]] std::optional<Eigen::Vector3d> place_of(ControlId id) const {
    for (const ControlDifference& one : out_.adjusted.control)
      if (one.point == id) return one.position_in_world;
    return std::nullopt;
  }
  // Of a coordinate of the image of a control point where its other rays meet, all images being exact.
  [[nodiscard]] double variance_by_rays(const Rejected& gone) const {
    const auto met = intersect(sight_lines(out_.block, gone.control));
    const Rigid3& pose = pose_of(out_.block, gone.image);
    Matrix23 by_cam;
    if (!met || !project(out_.block.camera_of(gone.image), pose * met->point_in_world, &by_cam, nullptr)) return kNaN;
    const Eigen::RowVector3d by_world = by_cam.row(gone.axis) * pose.rotation.toRotationMatrix();
    return by_world * met->covariance * by_world.transpose();
  }
  void tell(Rejected& gone, const Eigen::Vector2d& pixel, const Eigen::Vector3d& place) const {
    const Rigid3& pose = pose_of(out_.block, gone.image);
    if (const auto expected = project(out_.block.camera_of(gone.image), pose * place))
      gone.gross_error.head<2>() = pixel - *expected;
  }
  static void tell(Rejected& gone, const Eigen::Vector3d& difference) {
    if (is_height(gone.group))
      gone.gross_error.z() = difference.z();
    else
      gone.gross_error.head<2>() = difference.head<2>();
  }

  const Block& given_;
  AdjustScope scope_;
  ExamineOptions options_;
  int most_;
  const Run& run_;
  Adjuster adjuster_;
  Snooped out_;
  std::vector<Given> given_of_;  // parallel to Snooped::rejected
  std::map<ImageId, GivenAttitude> given_attitudes_;
  std::map<ImageId, int> rays_;
  std::map<PointId, int> of_point_;
  std::map<Key, StayReason> stays_;
  struct Rival {
    double redundancy, behind;  // the worst [of suspicion]
  };
  Key worst_{};  // of the last round, if no ray
  bool worst_is_poor_ = false;
  std::map<std::pair<Key, int>, Rival> rivals_;
  std::set<Key> back_;
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

Result<Snooped> snoop(const Block& block, const AdjustScope& scope, const ExamineOptions& options, int most,
                      const Run& run) {
  return Snooper(block, scope, options, most, run).snoop();
}

}  // namespace collinea
