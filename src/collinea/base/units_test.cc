// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/units.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <set>
#include <thread>

namespace collinea {
namespace {

UnitList images(std::uint32_t count, double begin = 0, double end = 1) {
  UnitList list{.stage = "detect", .begin = begin, .end = end};
  for (std::uint32_t i = 0; i < count; ++i) list.units.push_back(Unit::of(UnitKind::kImage, ImageId{i}));
  return list;
}

// What a run shows.
struct Shown {
  std::vector<double> done;
  std::vector<std::string> stages, lines;

  collinea::Run run(int threads = 1, std::stop_token stop = {}) {
    return {.stop = std::move(stop),
            .progress =
                [this](std::string_view stage, double part) {
                  stages.emplace_back(stage);
                  done.push_back(part);
                },
            .log = [this](std::string_view line) { lines.emplace_back(line); },
            .threads = threads};
  }
};

// Results that outlive a run, as files of a project do.
struct Results {
  std::mutex mutex;
  std::multiset<std::size_t> made;

  [[nodiscard]] bool has(std::size_t unit) const { return made.contains(unit); }
  void add(std::size_t unit) {
    const std::lock_guard lock(mutex);
    made.insert(unit);
  }
};

TEST(Units, AreNamedByKindAndNumbers) {
  EXPECT_EQ(name_of(Unit::file(4)), "file 4");
  EXPECT_EQ(name_of(Unit::of(UnitKind::kImage, ImageId{12})), "image 12");
  EXPECT_EQ(name_of(Unit::of(UnitKind::kOverview, ImageId{0})), "overview 0");
  EXPECT_EQ(name_of(Unit::of(UnitKind::kDepthMap, ImageId{12})), "depth map 12");
  EXPECT_EQ(name_of(Unit::pair(ImageId{3}, ImageId{7})), "pair 3-7");
  EXPECT_EQ(name_of(Unit::tile(4, -2)), "tile 4,-2");
  EXPECT_EQ(name_of(Unit::window(512, 0)), "window 512,0");
  EXPECT_EQ(Unit::of(UnitKind::kDepthMap, ImageId{12}).image(), ImageId{12});
}

TEST(Units, TilesCoverARasterRowByRow) {
  const std::vector<Unit> tiles = tiles_over(1025, 512, 512, 256);
  const std::vector<Unit> wanted{Unit::tile(0, 0), Unit::tile(1, 0), Unit::tile(2, 0),
                                 Unit::tile(0, 1), Unit::tile(1, 1), Unit::tile(2, 1)};
  EXPECT_EQ(tiles, wanted);
  EXPECT_TRUE(tiles_over(0, 5, 512, 512).empty());
}

TEST(RunUnits, KeepsWhatIsThereAndMakesTheRest) {
  for (const int threads : {1, 3}) {
    Shown shown;
    Results results;
    const UnitList list = images(40);
    const auto done = run_units(shown.run(threads), list,
                                {.is_done = [](std::size_t unit) { return unit % 4 == 0; },
                                 .work = [&](std::size_t unit, const collinea::Run& run) -> Result<UnitWorked> {
                                   EXPECT_EQ(run.threads, 1);
                                   EXPECT_FALSE(run.progress);
                                   results.add(unit);
                                   return UnitWorked{};
                                 }});
    ASSERT_TRUE(done);
    for (std::size_t unit = 0; unit < 40; ++unit) {
      EXPECT_EQ(done->ends[unit], unit % 4 == 0 ? UnitEnd::kKept : UnitEnd::kMade) << unit;
      EXPECT_EQ(results.made.count(unit), unit % 4 == 0 ? 0u : 1u) << unit;
    }
    EXPECT_EQ(done->count(UnitEnd::kMade), 30u);
    EXPECT_EQ(shown.done.size(), 30u);  // what remained counts
    say_kept(shown.run(), list, *done);
    EXPECT_EQ(shown.lines, std::vector<std::string>{"detect: 10 of 40 images kept from before"});
  }
}

TEST(RunUnits, ProgressNeverFallsAndEndsWithTheList) {
  for (const int threads : {1, 4}) {
    Shown shown;
    ASSERT_TRUE(run_units(shown.run(threads), images(200, 0.2, 0.7), {.work = [](std::size_t, const collinea::Run&) {
                            return Result<UnitWorked>(UnitWorked{});
                          }}));
    ASSERT_EQ(shown.done.size(), 200u);
    EXPECT_TRUE(std::is_sorted(shown.done.begin(), shown.done.end()));
    EXPECT_NEAR(shown.done.front(), 0.2 + 0.5 / 200, 1e-12);
    EXPECT_EQ(shown.done.back(), 0.7);
    EXPECT_EQ(std::count(shown.stages.begin(), shown.stages.end(), "detect"), 200);
  }
}

TEST(RunUnits, WhereNothingRemainsTheProgressIsAtItsEnd) {
  const UnitJob job{.is_done = [](std::size_t) { return true; },
                    .work = [](std::size_t, const collinea::Run&) -> Result<UnitWorked> {
                      ADD_FAILURE();
                      return UnitWorked{};
                    }};
  for (const std::uint32_t count : {0u, 5u}) {
    Shown shown;
    const auto done = run_units(shown.run(), images(count), job);
    ASSERT_TRUE(done);
    EXPECT_EQ(done->count(UnitEnd::kKept), count);
    EXPECT_EQ(shown.done, std::vector<double>{1.0});
  }
}

TEST(RunUnits, ABrokenImageDoesNotStopTheOthers) {
  for (const int threads : {1, 3}) {
    Shown shown;
    const auto done = run_units(shown.run(threads), images(20), {.work = [](std::size_t unit, const collinea::Run&) {
                                  UnitWorked worked;
                                  if (unit == 3 || unit == 11)
                                    worked.skipped_because = {Errc::kBadFormat, "is incomplete"};
                                  return Result<UnitWorked>(worked);
                                }});
    ASSERT_TRUE(done);
    EXPECT_EQ(done->count(UnitEnd::kMade), 18u);
    EXPECT_EQ(done->ends[11], UnitEnd::kSkipped);
    ASSERT_EQ(done->skipped_because.size(), 2u);
    EXPECT_EQ(done->skipped_because.at(3).message, "is incomplete");
    EXPECT_EQ(shown.done.back(), 1);
    say_kept(shown.run(), images(20), *done);
    EXPECT_TRUE(shown.lines.empty());  // nothing was kept
  }
}

TEST(RunUnits, AFullDiskEndsItAndTheUnitIsNamed) {
  const auto full_at = [](std::size_t full, std::atomic<int>& tried) {
    return UnitJob{.work = [full, &tried](std::size_t unit, const collinea::Run&) -> Result<UnitWorked> {
      ++tried;
      if (unit >= full) return fail(Errc::kBadInput, "the disk is full");
      return UnitWorked{};
    }};
  };
  std::atomic<int> tried = 0;
  const auto alone = run_units({}, images(1000), full_at(2, tried));
  ASSERT_FALSE(alone);
  EXPECT_EQ(alone.error().code, Errc::kBadInput);
  EXPECT_EQ(alone.error().message, "image 2: the disk is full");
  EXPECT_EQ(tried, 3);
  tried = 0;
  const auto side_by_side = run_units({.threads = 4}, images(1000), full_at(2, tried));
  ASSERT_FALSE(side_by_side);
  EXPECT_TRUE(side_by_side.error().message.ends_with(": the disk is full")) << side_by_side.error().message;
  EXPECT_LE(tried, 6);  // each thread meets it once at most
}

TEST(RunUnits, StoppedItIsCancelledAndTheNextRunMakesOnlyWhatIsMissing) {
  for (const int threads : {1, 2}) {
    Results results;
    std::stop_source stop;
    const UnitList list = images(50);
    UnitJob job{.is_done = [&](std::size_t unit) { return results.has(unit); },
                .work = [&](std::size_t unit, const collinea::Run&) -> Result<UnitWorked> {
                  results.add(unit);
                  if (unit == 20) stop.request_stop();
                  while (unit > 20 && !stop.stop_requested()) std::this_thread::yield();
                  return UnitWorked{};
                }};
    const auto stopped = run_units({.stop = stop.get_token(), .threads = threads}, list, job);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Errc::kCancelled);
    const std::size_t before = results.made.size();
    EXPECT_GE(before, 21u);
    EXPECT_LE(before, 22u);
    Shown shown;
    const auto resumed = run_units(shown.run(threads), list, job);
    ASSERT_TRUE(resumed);
    EXPECT_EQ(resumed->count(UnitEnd::kKept), before);
    EXPECT_EQ(resumed->count(UnitEnd::kMade), 50 - before);
    EXPECT_EQ(shown.done.size(), 50 - before);
    EXPECT_EQ(results.made.size(), 50u);
    for (std::size_t unit = 0; unit < 50; ++unit) EXPECT_EQ(results.made.count(unit), 1u) << unit;
  }
}

TEST(RunUnits, AFailureIsNoReasonOnceItIsStopped) {
  std::stop_source stop;
  const auto done = run_units({.stop = stop.get_token()}, images(3),
                              {.work = [&](std::size_t, const collinea::Run&) -> Result<UnitWorked> {
                                stop.request_stop();
                                return fail(Errc::kBadInput, "was broken off");
                              }});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kCancelled);
}

// Units whose results are kept several at a time.
struct Batches {
  std::mutex mutex;
  std::set<std::size_t> fresh;
  std::vector<std::set<std::size_t>> kept;

  UnitJob job(std::size_t batch) {
    return {.work = [this](std::size_t unit, const collinea::Run&) -> Result<UnitWorked> {
              const std::lock_guard lock(mutex);
              fresh.insert(unit);
              return UnitWorked{};
            },
            .batch = batch,
            .keep = [this]() -> Result<> {
              kept.push_back(std::exchange(fresh, {}));
              return {};
            }};
  }
};

TEST(RunUnits, ResultsOfABatchAreKeptTogether) {
  for (const int threads : {1, 3}) {
    Batches batches;
    UnitJob job = batches.job(4);
    job.is_done = [](std::size_t unit) { return unit == 1; };
    ASSERT_TRUE(run_units({.threads = threads}, images(10), job));
    const std::vector<std::set<std::size_t>> wanted{{0, 2, 3, 4}, {5, 6, 7, 8}, {9}};
    EXPECT_EQ(batches.kept, wanted);
  }
}

TEST(RunUnits, WhatABatchHasMadeWhenItIsStoppedIsKept) {
  Batches batches;
  std::stop_source stop;
  UnitJob job = batches.job(4);
  job.work = [&, work = job.work](std::size_t unit, const collinea::Run& run) {
    if (unit == 5) stop.request_stop();
    return work(unit, run);
  };
  const auto done = run_units({.stop = stop.get_token()}, images(10), job);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kCancelled);
  const std::vector<std::set<std::size_t>> wanted{{0, 1, 2, 3}, {4, 5}};
  EXPECT_EQ(batches.kept, wanted);
}

TEST(RunUnits, WhatABatchHasMadeBeforeAUnitEndsItIsKept) {
  Batches batches;
  Shown shown;
  UnitJob job = batches.job(4);
  job.work = [work = job.work](std::size_t unit, const collinea::Run& run) -> Result<UnitWorked> {
    if (unit == 5) return fail(Errc::kBadInput, "five");
    return work(unit, run);
  };
  const auto done = run_units(shown.run(), images(10), job);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message, "image 5: five");
  const std::vector<std::set<std::size_t>> wanted{{0, 1, 2, 3}, {4}};
  EXPECT_EQ(batches.kept, wanted);
  EXPECT_EQ(shown.done.back(), 0.5);  // the unit that failed is not counted
}

TEST(RunUnits, ABatchThatCannotBeKeptEndsIt) {
  Batches batches;
  UnitJob job = batches.job(4);
  int calls = 0;
  job.keep = [&]() -> Result<> {
    ++calls;
    return fail(Errc::kBadInput, "the disk is full");
  };
  const auto done = run_units({}, images(10), job);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message, "the disk is full");
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(batches.fresh.size(), 4u);
}

TEST(RunUnitsOneByOne, GoesThroughTheListUntilAnErrorOrAStop) {
  Shown shown;
  std::vector<std::int64_t> seen;
  const auto see = [&](const Unit& unit) -> Result<> {
    seen.push_back(unit.first);
    if (unit.first == 6) return fail(Errc::kBadFormat, "six");
    return {};
  };
  EXPECT_TRUE(run_units_one_by_one(shown.run(4), images(4, 0.5, 1), see));
  EXPECT_EQ(seen, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(shown.done, (std::vector<double>{0.625, 0.75, 0.875, 1}));
  const auto failed = run_units_one_by_one({}, images(10), see);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "six");
  EXPECT_EQ(seen.back(), 6);
  // Also in the last unit: what it made may be made in part.
  std::stop_source stop;
  const auto stopped = run_units_one_by_one({.stop = stop.get_token()}, images(3), [&](const Unit& unit) -> Result<> {
    if (unit.first == 2) stop.request_stop();
    return {};
  });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::kCancelled);
}

TEST(RunUnitsInOrder, PartsOfAProductAreTakenInOrderAndCounted) {
  for (const int threads : {1, 4}) {
    Shown shown;
    const UnitList list{"ortho", tiles_over(1000, 700, 100, 100), 0, 1};
    std::vector<Unit> taken;
    const auto done = run_units_in_order(
        shown.run(threads), list,
        [](const Unit& unit) -> Result<std::unique_ptr<std::int64_t>> {
          return std::make_unique<std::int64_t>(unit.first * unit.second);
        },
        [&](const Unit& unit, std::unique_ptr<std::int64_t> product) -> Result<> {
          EXPECT_EQ(*product, unit.first * unit.second);
          taken.push_back(unit);
          return {};
        });
    EXPECT_TRUE(done);
    EXPECT_EQ(taken, list.units);
    ASSERT_EQ(shown.done.size(), 70u);
    EXPECT_TRUE(std::is_sorted(shown.done.begin(), shown.done.end()));
    EXPECT_EQ(shown.done.back(), 1);
  }
}

TEST(RunUnitsInOrder, EndsWithTheFirstErrorAndWhenItIsStopped) {
  const UnitList list{"ortho", tiles_over(10, 1, 1, 1)};
  const auto make = [](const Unit& unit) { return Result<std::int64_t>(unit.first); };
  const auto failed = run_units_in_order({}, list, make, [](const Unit& unit, std::int64_t) -> Result<> {
    if (unit.first >= 4) return fail(Errc::kBadInput, name_of(unit));
    return {};
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "tile 4,0");
  std::stop_source stop;
  const auto stopped =
      run_units_in_order({.stop = stop.get_token()}, list, make, [&](const Unit&, std::int64_t) -> Result<> {
        stop.request_stop();
        return {};
      });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::kCancelled);
}

}  // namespace
}  // namespace collinea
