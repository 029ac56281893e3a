// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/snooping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "collinea/block/subject_label.h"
#include "collinea/quality/divergence.h"
#include "collinea/quality/internal/gross_choice.h"
#include "collinea/quality/internal/gross_control.h"
#include "collinea/quality/internal/gross_error.h"
#include "collinea/quality/internal/masked.h"
#include "collinea/quality/internal/rejection.h"
#include "collinea/quality/internal/suspect_choice.h"

namespace collinea {
namespace {

constexpr std::size_t kNoBound = std::numeric_limits<std::size_t>::max();

// A round: what is left after it, which an adjustment is to confirm, and what it began with.
struct Round {
  Remaining after, before;
  std::vector<Measurement> rejected;  // from the one to the other
  std::optional<Rivals> rivals;       // of one of them
};

// What the rounds so far have shown.
struct Experience {
  StayReasons stays;
  std::size_t most_in_round = kNoBound;
  std::set<Measurement> put_back;
  std::optional<int> rank_defect;  // of the last adjustment that was confirmed
};

// By what sigmas are multiplied where gross errors are compared with what is left: sigma0 of the tests
// (reliability_of()), but where observations agree to rounding, as exact ones do once the gross errors are gone. There
// the tests take what rounding makes of sigma0, and this is 1 as for all reported standard deviations (sigma_scale()):
// a gross error is then as uncertain as its sigma states, not a billionth of that, by which nothing that went beside
// others could ever agree again. What goes after such an adjustment gets the cofactor 0 (cofactor_by_others()).
double sigma0_of_tests(const Adjusted& adjusted, const TestOptions& options) {
  return options.sigma0_known ? 1 : std::max(sigma_scale(adjusted), 1e-12);
}

Round first_round(Measurements all, int most, const Run& run) {
  if (!all.scope.use_control) return {.after = {.measurements = std::move(all)}};
  Round round;
  round.before.measurements = all;
  round.after = without_gross_control(std::move(all), most, run.seed);
  for (const Rejection& rejected : round.after.rejections) round.rejected.push_back(rejected.rejected);
  return round;
}

bool is_determined(const Result<Examined>& adjusted, const std::optional<int>& rank_defect_before) {
  return adjusted && adjusted->reliability && (!rank_defect_before || adjusted->rank_defect <= *rank_defect_before);
}

// Why a round has to be taken back: what of it must stay, which may show only when fewer go. Nothing: it holds.
std::optional<StayReasons> why_taken_back(const Result<Examined>& adjusted, const Round& round,
                                          const std::optional<int>& rank_defect_before) {
  if (!is_determined(adjusted, rank_defect_before)) {
    if (round.rejected.empty()) return std::nullopt;  // nothing to take back
    if (round.rejected.size() > 1) return StayReasons{};
    return StayReasons{{round.rejected.front(), StayReason::kBlockNeedsIt}};
  }
  if (!round.rivals) return std::nullopt;
  StayReasons stay = doubts(*round.rivals, *adjusted->reliability, round.after.measurements.block);
  return stay.empty() ? std::nullopt : std::optional(std::move(stay));
}

Experience after_taking_back(Experience known, const Round& round, const StayReasons& stay) {
  for (const auto& [measurement, reason] : stay) known.stays[measurement] = reason;
  known.most_in_round = round.rejected.size() == 1 ? kNoBound : round.rejected.size() / 2;
  return known;
}

Experience after_confirming(Experience known, const Examined& adjusted) {
  known.rank_defect = adjusted.rank_defect;
  if (known.most_in_round < kNoBound / 2) known.most_in_round *= 2;
  return known;
}

ChoiceBounds bounds_of(const Remaining& remaining, const Experience& known, int most) {
  return {known.most_in_round, most - static_cast<int>(remaining.rejections.size())};
}

Round next_round(Remaining before, const SuspectChoice& choice, double sigma0, int adjustments) {
  Round round{.after = reject(before, choice, sigma0, adjustments), .rivals = choice.rivals};
  for (const ChosenSuspect& one : choice.suspects) round.rejected.push_back(one.measurement);
  round.before = std::move(before);
  return round;
}

// Nothing is put back while more is suspect than may go.
std::vector<std::size_t> agreeing_of(const Remaining& remaining, const SuspectChoice& choice, const Examined& adjusted,
                                     const Experience& known) {
  if (choice.bound_is_reached) return {};
  return agreeing(remaining, adjusted.reliability->limit, known.put_back);
}

// What a block that is not determined lacks.
tl::unexpected<Error> undetermined(const Examined& adjusted, const Block& block) {
  if (adjusted.undetermined) return fail(Errc::kIllPosed, "data snooping: " + label_of(adjusted.undetermined, block));
  return fail(Errc::kIllPosed, "data snooping: without what was rejected the datum has a larger defect than before");
}

// The end of the rounds.
struct Ended {
  Remaining remaining;
  SuspectChoice choice;
  Result<Examined> adjusted;  // the last; an error only of one that is bent
  Experience known;
  int rounds = 0;
  double sigma0_before = 0;
  std::vector<ControlDifference> with;
  std::vector<InseparableSets> inseparable;
  bool bent = false;  // the first adjustment, after which nothing was done
};

// Those that are no tie points, worst first. (Of all suspects only the worst are kept, which tie points may fill.)
std::vector<TestedObservation> given_suspects(const Reliability& tests) {
  std::vector<TestedObservation> suspects;
  for (const TestedObservation& one : tests.others)
    if (!(std::abs(one.w) <= one.limit)) suspects.push_back(one);
  std::stable_sort(suspects.begin(), suspects.end(), [](const TestedObservation& a, const TestedObservation& b) {
    return std::abs(a.suspicion) > std::abs(b.suspicion);
  });
  return suspects;
}

class Rounds {
 public:
  Rounds(const ExamineOptions& options, int most, const Run& run, SnoopedKinds kinds, StayReasons stays = {})
      : options_(options), most_(most), run_(run), kinds_(kinds), known_{.stays = std::move(stays)} {}

  // Ends after the first adjustment if that is bent and `may_be_bent` is false.
  Result<Ended> from(Round round, bool may_be_bent) {
    for (;;) {
      Measurements& left = round.after.measurements;
      Result<Examined> adjusted = examine_to_the_end(adjuster_, left.block, left.scope, options_, run_, ended_.rounds);
      if (!adjusted && adjusted.error().code != Errc::kIllPosed) return tl::unexpected(std::move(adjusted).error());
      if (!may_be_bent && !known_.rank_defect && is_bent(adjusted, options_.test)) return bent(round, adjusted);
      if (!adjusted && round.rejected.empty()) return tl::unexpected(std::move(adjusted).error());
      if (const auto stay = why_taken_back(adjusted, round, known_.rank_defect)) {
        known_ = after_taking_back(std::move(known_), round, *stay);
        round = {.after = std::move(round.before)};
        continue;
      }
      if (!is_determined(adjusted, known_.rank_defect)) return undetermined(*adjusted, left.block);
      confirm(*adjusted);
      apply(*adjusted, left.block);
      if (!go_on(round, *adjusted)) return ended(std::move(round.after), std::move(*adjusted));
    }
  }

 private:
  Ended bent(const Round& round, const Result<Examined>& adjusted) {
    ended_.bent = true;
    ended_.remaining = round.after;
    ended_.adjusted = adjusted;
    return std::move(ended_);
  }

  Ended ended(Remaining remaining, Examined adjusted) {
    ended_.remaining = std::move(remaining);
    ended_.adjusted = std::move(adjusted);
    ended_.known = std::move(known_);
    return std::move(ended_);
  }

  void confirm(const Examined& adjusted) {
    if (!known_.rank_defect) {
      ended_.sigma0_before = adjusted.sigma0;
      ended_.with = adjusted.control;
    }
    known_ = after_confirming(std::move(known_), adjusted);
  }

  // The next round; false when there is none.
  bool go_on(Round& round, Examined& adjusted) {
    const double sigma0 = sigma0_of_tests(adjusted, options_.test);
    const Block& block = round.after.measurements.block;
    std::vector<TestedObservation>& suspects = adjusted.reliability->suspects;
    std::vector<TestedObservation> all = suspects;
    if (kinds_ == SnoopedKinds::kGiven) suspects = given_suspects(*adjusted.reliability);
    ended_.choice = choose_suspects(adjusted, block, known_.stays, bounds_of(round.after, known_, most_));
    suspects = std::move(all);
    if (!ended_.choice.suspects.empty()) {
      round = next_round(std::move(round.after), ended_.choice, sigma0, ended_.rounds);
      return true;
    }
    round.after.rejections =
        with_gross_errors(std::move(round.after.rejections), round.after.measurements, adjusted, sigma0);
    const auto agree = agreeing_of(round.after, ended_.choice, adjusted, known_);
    if (agree.empty()) return false;
    for (const std::size_t i : agree) known_.put_back.insert(round.after.rejections[i].rejected);
    round = {.after = put_back(std::move(round.after), agree)};
    return true;
  }

  const ExamineOptions& options_;
  const int most_;
  const Run& run_;
  const SnoopedKinds kinds_;
  Adjuster adjuster_;
  Experience known_;
  Ended ended_;
};

Snooped finished(Ended ended) {
  Snooped out;
  std::set<Measurement> put_back = ended.known.put_back;
  for (const Rejection& rejected : ended.remaining.rejections) {
    out.rejected.push_back(rejected.rejected);
    put_back.erase(rejected.rejected);
  }
  out.put_back = static_cast<int>(put_back.size());
  out.block = std::move(ended.remaining.measurements.block);
  out.attitudes = std::move(ended.remaining.measurements.scope.attitudes);
  out.kept = std::move(ended.choice.kept);
  out.inseparable = std::move(ended.inseparable);
  out.finished = !ended.choice.bound_is_reached;
  out.rounds = ended.rounds;
  out.sigma0_before = ended.sigma0_before;
  out.with = std::move(ended.with);
  out.adjusted = std::move(*ended.adjusted);
  return out;
}

// Nothing that has diverged is an end. `left`: that was adjusted, which may have led poses and points anywhere;
// `given`: where they began.
Result<> refused(const Result<Examined>& adjusted, const Measurements& left, const Measurements& given,
                 const ExamineOptions& options, const Run& run) {
  if (!is_bent(adjusted, options.test)) return {};
  Block block = left.block;
  block.poses = given.block.poses;
  block.points = given.block.points;
  block.cameras = given.block.cameras;
  return refuse_diverged(adjusted, block, left.scope, options, run).map_error([](Error error) {
    return std::move(error).within("data snooping");
  });
}

// What is grossly wrong and cannot be told from others stays, and nothing else is tested: it spoils all tests.
Result<Snooped> with_undecided(GrossChoice gross, const Measurements& given, const ExamineOptions& options,
                               const Run& run) {
  Ended ended{.remaining = std::move(gross.remaining)};
  Measurements& left = ended.remaining.measurements;
  Adjuster adjuster;
  ended.adjusted = examine_to_the_end(adjuster, left.block, left.scope, options, run, ended.rounds);
  COLLINEA_TRY(refused(ended.adjusted, left, given, options, run));
  const Examined& adjusted = *ended.adjusted;
  if (!adjusted.reliability) return undetermined(adjusted, left.block);
  apply(adjusted, left.block);
  ended.sigma0_before = adjusted.sigma0;
  ended.with = adjusted.control;
  ended.choice.kept = std::move(gross.kept);
  if (ended.choice.kept.empty())
    for (const TestedObservation& one : adjusted.reliability->suspects)
      if (!is_image_point(one.group)) ended.choice.kept.push_back({one, StayReason::kSameDegree});
  ended.remaining.rejections =
      with_gross_errors(std::move(ended.remaining.rejections), left, adjusted, sigma0_of_tests(adjusted, options.test));
  return finished(std::move(ended));
}

long given_of(const std::vector<Rejection>& rejections) {
  return std::ranges::count_if(rejections,
                               [](const Rejection& one) { return one.rejected.group != ObservationGroup::kTieImages; });
}
long given_of(const std::vector<KeptSuspect>& kept) {
  return std::ranges::count_if(
      kept, [](const KeptSuspect& one) { return one.observation.group != ObservationGroup::kTieImages; });
}

// What was chosen has gone, and no more than that has been given up for it.
bool is_better(const Ended& other, const Ended& ended, const std::vector<Measurement>& chosen, bool is_undecided) {
  if (!other.adjusted->converged || other.adjusted->reliability->unseen > 0) return false;
  for (const Measurement& one : chosen)
    if (std::ranges::none_of(other.remaining.rejections, [&](const Rejection& rejection) {
          return static_cast<const Measurement&>(rejection.rejected) == one;
        }))
      return false;
  if (is_undecided) return true;
  return given_of(other.remaining.rejections) + given_of(other.choice.kept) <=
         given_of(ended.remaining.rejections) + given_of(ended.choice.kept) + 1;
}

// Pairs and triples that mask each other: the same rounds from where a joint look at all of what was given leads.
Ended with_masked(Ended ended, const ExamineOptions& options, int most, const Run& run, SnoopedKinds kinds) {
  const Examined& adjusted = *ended.adjusted;
  auto masked = masked_choice(ended.remaining, ended.choice, options.adjust, *adjusted.reliability, run);
  if (!masked) return ended;
  if (!masked->is_other) {
    ended.inseparable = std::move(masked->inseparable);
    return ended;
  }
  const double sigma0 = sigma0_of_tests(adjusted, options.test);
  Round round = next_round(std::move(masked->before), masked->choice, sigma0, ended.rounds);
  const std::vector<Measurement> chosen = round.rejected;
  const bool is_undecided = masked->is_undecided;
  Result<Ended> other = Rounds(options, most, run, kinds, std::move(masked->stays)).from(std::move(round), true);
  if (!other || !is_better(*other, ended, chosen, is_undecided)) return ended;
  other->rounds += ended.rounds;
  other->sigma0_before = ended.sigma0_before;
  other->with = std::move(ended.with);
  other->inseparable = std::move(masked->inseparable);
  return std::move(*other);
}

}  // namespace

Result<Snooped> snoop(const Block& block, const AdjustScope& scope, const ExamineOptions& options, int most,
                      const Run& run, SnoopedKinds kinds) {
  ExamineOptions asked = options;
  asked.reliability = true;
  const Measurements given{block, with_first_cameras(scope, block.cameras)};
  COLLINEA_TRY(Ended ended, Rounds(asked, most, run, kinds).from(first_round(given, most, run), false));
  if (!ended.bent) return finished(with_masked(std::move(ended), asked, most, run, kinds));
  std::optional<GrossChoice> gross = choose_gross(given, asked, most, run);
  if (gross && (gross->contradiction || !gross->undecided.empty()))
    return with_undecided(std::move(*gross), given, asked, run);
  if (!gross) COLLINEA_TRY(refused(ended.adjusted, ended.remaining.measurements, given, asked, run));
  Round first = gross ? Round{.after = std::move(gross->remaining)} : first_round(given, most, run);
  Result<Ended> found = Rounds(asked, most, run, kinds).from(std::move(first), true);
  if (!found) {
    COLLINEA_TRY(refused(tl::unexpected(found.error()), given, given, asked, run));
    return tl::unexpected(std::move(found).error());
  }
  COLLINEA_TRY(refused(found->adjusted, found->remaining.measurements, given, asked, run));
  if (ended.adjusted && ended.adjusted->reliability) found->sigma0_before = ended.adjusted->sigma0;
  return finished(with_masked(std::move(*found), asked, most, run, kinds));
}

namespace {

std::vector<Subject> subjects_of(const Rejected& rejected) {
  switch (traits_of(rejected.group).source) {
    case ObservationSource::kControlImagePoint:
      return {rejected.control, rejected.image};
    case ObservationSource::kControlCoordinates:
      return {Subject(rejected.control,
                      rejected.group == ObservationGroup::kControlPlan ? Aspect::kPlan : Aspect::kHeight)};
    case ObservationSource::kPosition:
      return {Subject(rejected.image, Aspect::kPosition)};
    case ObservationSource::kAttitude:
      return {Subject(rejected.image, Aspect::kAttitude)};
    case ObservationSource::kGeodetic:
      return {Subject::geodetic(rejected.geodetic)};
    case ObservationSource::kTieImagePoint:
      break;
  }
  return {rejected.point, rejected.image};
}

}  // namespace

std::vector<Finding> rejected_findings(const Snooped& snooped) {
  std::vector<Finding> findings;
  for (const Rejected& rejected : snooped.rejected) {
    if (rejected.group == ObservationGroup::kTieImages) continue;
    const double unit = is_angle(rejected.group) ? 180 / std::numbers::pi : 1;
    const FigureName size = is_image_point(rejected.group) ? FigureName::kOffsetPx
                            : is_angle(rejected.group)     ? FigureName::kDifferenceAngle
                                                           : FigureName::kOffset;
    const bool in_plan = std::isfinite(rejected.gross_error.x()) && std::isfinite(rejected.gross_error.y());
    const double off = in_plan ? rejected.gross_error.head<2>().norm() : std::abs(rejected.gross_error[rejected.axis]);
    findings.push_back(finding_of(FindingCode::kGrossErrorRejected, subjects_of(rejected),
                                  {{size, unit * off},
                                   {FigureName::kSigma, unit * rejected.sigma},
                                   {FigureName::kDifference, unit * std::abs(rejected.influence)}}));
  }
  return findings;
}

}  // namespace collinea
