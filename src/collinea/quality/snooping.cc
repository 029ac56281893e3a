// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/snooping.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "collinea/block/subject_label.h"
#include "collinea/quality/internal/gross_control.h"
#include "collinea/quality/internal/gross_error.h"
#include "collinea/quality/internal/rejection.h"
#include "collinea/quality/internal/suspect_choice.h"

namespace collinea {
namespace {

constexpr int kMostRepeats = 3;  // of an adjustment that has not converged
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

// A gross error far off may need more iterations than are allowed; half way everything looks wrong.
Result<Examined> adjust_to_the_end(Adjuster& adjuster, Measurements& left, const ExamineOptions& options,
                                   const Run& run, int& adjustments) {
  for (int repeat = 0;; ++repeat) {
    Result<Examined> adjusted = examine(adjuster, left.block, left.scope, options, run);
    ++adjustments;
    if (!adjusted || adjusted->converged || repeat == kMostRepeats) return adjusted;
    apply(*adjusted, left.block);
  }
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

Snooped finished(Snooped out, Remaining remaining, SuspectChoice choice, Examined adjusted, const Experience& known) {
  std::set<Measurement> put_back = known.put_back;
  for (const Rejection& rejected : remaining.rejections) {
    out.rejected.push_back(rejected.rejected);
    put_back.erase(rejected.rejected);
  }
  out.put_back = static_cast<int>(put_back.size());
  out.block = std::move(remaining.measurements.block);
  out.attitudes = std::move(remaining.measurements.scope.attitudes);
  out.kept = std::move(choice.kept);
  out.finished = !choice.bound_is_reached;
  out.adjusted = std::move(adjusted);
  return out;
}

}  // namespace

Result<Snooped> snoop(const Block& block, const AdjustScope& scope, const ExamineOptions& options, int most,
                      const Run& run) {
  ExamineOptions asked = options;
  asked.reliability = true;
  Adjuster adjuster;
  Snooped out;
  Experience known;
  Round round = first_round({block, with_first_cameras(scope, block.cameras)}, most, run);
  for (;;) {
    Measurements& left = round.after.measurements;
    Result<Examined> adjusted = adjust_to_the_end(adjuster, left, asked, run, out.rounds);
    if (!adjusted && (adjusted.error().code != Errc::kIllPosed || round.rejected.empty()))
      return tl::unexpected(std::move(adjusted).error());
    if (const auto stay = why_taken_back(adjusted, round, known.rank_defect)) {
      known = after_taking_back(std::move(known), round, *stay);
      round = {.after = std::move(round.before)};
      continue;
    }
    if (!is_determined(adjusted, known.rank_defect))
      return fail(Errc::kIllPosed, "data snooping: " + label_of(adjusted->undetermined, left.block));
    if (!known.rank_defect) {
      out.sigma0_before = adjusted->sigma0;
      out.with = adjusted->control;
    }
    known = after_confirming(std::move(known), *adjusted);
    apply(*adjusted, left.block);

    const double sigma0 = sigma0_of_tests(*adjusted, asked.test);
    SuspectChoice choice = choose_suspects(*adjusted, left.block, known.stays, bounds_of(round.after, known, most));
    if (!choice.suspects.empty()) {
      round = next_round(std::move(round.after), choice, sigma0, out.rounds);
      continue;
    }
    round.after.rejections = with_gross_errors(std::move(round.after.rejections), left, *adjusted, sigma0);
    if (const auto agree = agreeing_of(round.after, choice, *adjusted, known); !agree.empty()) {
      for (const std::size_t i : agree) known.put_back.insert(round.after.rejections[i].rejected);
      round = {.after = put_back(std::move(round.after), agree)};
      continue;
    }
    return finished(std::move(out), std::move(round.after), std::move(choice), std::move(*adjusted), known);
  }
}

}  // namespace collinea
