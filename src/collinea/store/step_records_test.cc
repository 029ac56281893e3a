// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/step_records.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/math/random.h"
#include "collinea/store/internal/finding_values.h"
#include "collinea/store/packed_fields.h"

namespace collinea {
namespace {

constexpr int kTrials = 30;

// Converts to any member, so that members of an aggregate can be counted.
struct Anything {
  template <class T>
  operator T() const;  // NOLINT: only named, never called
};
template <class T, class... Members>
constexpr std::size_t members_of() {
  if constexpr (requires { T{Members{}..., Anything{}}; })
    return members_of<T, Members..., Anything>();
  else
    return sizeof...(Members);
}

template <class T>
std::size_t members_stated() {
  std::size_t count = 0;
  packing::for_each_member<T>([&](std::string_view, auto) { ++count; });
  return count;
}

double any_number(Random& random) {
  switch (random.below(6)) {
    case 0:
      return -0.0;
    case 1:
      return std::numeric_limits<double>::quiet_NaN();
    case 2:
      return std::numeric_limits<double>::infinity();
    default:
      return random.normal() * std::pow(10, random.uniform(-20, 20));
  }
}

// Any value of any type that can be packed.
template <class T>
void randomise(Random& random, T& value) {
  using namespace packing;
  if constexpr (std::is_same_v<T, bool>) {
    value = random.below(2) == 1;
  } else if constexpr (std::is_floating_point_v<T>) {
    value = T(any_number(random));
  } else if constexpr (std::is_arithmetic_v<T>) {
    value = T(random.bits());
  } else if constexpr (is_id<T>) {
    value.value = std::uint32_t(random.bits());
  } else if constexpr (std::is_same_v<T, std::string>) {
    value.clear();
    for (std::uint32_t i = random.below(20); i > 0; --i) value += char(random.bits());  // zeros and broken UTF-8 too
  } else if constexpr (detail::kIsWordOr<T>) {
    std::string text;
    randomise(random, text);
    value = text;
  } else if constexpr (is_optional<T>) {
    value.reset();
    if (random.below(2)) randomise(random, value.emplace());
  } else if constexpr (is_list<T>) {
    value.resize(random.below(5));
    for (auto& one : value) randomise(random, one);
  } else if constexpr (is_array<T>) {
    for (auto& one : value) randomise(random, one);
  } else if constexpr (is_map<T>) {
    value.clear();
    for (std::uint32_t i = random.below(5); i > 0; --i) {
      typename T::key_type key;
      randomise(random, key);
      randomise(random, value[key]);
    }
  } else if constexpr (FixedMatrix<T>) {
    for (int i = 0; i < int(T::SizeAtCompileTime); ++i) value.data()[i] = any_number(random);
  } else if constexpr (HasFields<T> || HasDescription<T>) {
    for_each_member<T>([&](std::string_view, auto member) { randomise(random, value.*member); });
  } else if constexpr (Worded<T>) {
    const auto table = words(T{});
    value = table[random.below(std::uint32_t(table.size()))].value;
  }  // another enumeration stays as it is
}

template <class Record>
Record any_record(std::uint64_t trial) {
  Random random(31, trial);
  Record record;
  randomise(random, record);
  return record;
}

template <class Record>
class StepRecordLaws : public testing::Test {};
template <class Variant>
struct TypesOf;
template <class... Records>
struct TypesOf<std::variant<Records...>> {
  using type = testing::Types<Records...>;
};
TYPED_TEST_SUITE(StepRecordLaws, TypesOf<StepOutcome>::type);

TYPED_TEST(StepRecordLaws, ARecordComesBackBitByBit) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const StepOutcome given = any_record<TypeParam>(trial);
    const std::string bytes = packed(given);
    const auto found = unpacked_outcome(TypeParam::kStep, bytes);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(found->index(), given.index());
    EXPECT_EQ(packed(*found), bytes) << trial;
    EXPECT_EQ(step_of(*found), TypeParam::kStep);
    EXPECT_EQ(skipped_because(*found).has_value(), skipped_because(given).has_value());
  }
}

// A member that is forgotten in `fields` would be lost.
TYPED_TEST(StepRecordLaws, EveryMemberIsStated) { EXPECT_EQ(members_stated<TypeParam>(), members_of<TypeParam>()); }

TYPED_TEST(StepRecordLaws, CutBytesAreDamagedAndLongerOnesToo) {
  const std::string bytes = packed(any_record<TypeParam>(0));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto found = unpacked_outcome(TypeParam::kStep, bytes.substr(0, size));
    ASSERT_FALSE(found) << size;
    EXPECT_EQ(found.error().code, size < 9 ? Errc::kUnsupported : Errc::kBadFormat) << size;
  }
  EXPECT_EQ(unpacked_outcome(TypeParam::kStep, bytes + 'x').error().code, Errc::kBadFormat);
}

// They may mean another record; they never do harm, nor take memory without end.
TYPED_TEST(StepRecordLaws, ChangedBytesAreARecordOrAnError) {
  int refused = 0;
  for (int trial = 0; trial < 20 * kTrials; ++trial) {
    std::string bytes = packed(any_record<TypeParam>(trial % kTrials));
    Random random(5, std::uint64_t(trial));
    for (std::uint32_t i = 1 + random.below(8); i > 0; --i)
      bytes[9 + random.below(std::uint32_t(bytes.size() - 9))] = char(random.bits());
    const auto found = unpacked_outcome(TypeParam::kStep, bytes);
    refused += !found;
    if (found) {
      EXPECT_EQ(packed(*found).size(), bytes.size());
    }
  }
  if (packed(TypeParam{}).size() > 100) {
    EXPECT_GT(refused, 0);
  }
}

TYPED_TEST(StepRecordLaws, ARecordOfAnotherVersionIsToldFromADamagedOne) {
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, std::size_t{8}}) {
    std::string bytes = packed(TypeParam{});
    ++bytes[at];
    EXPECT_EQ(unpacked_outcome(TypeParam::kStep, bytes).error().code, Errc::kUnsupported) << at;
  }
}

TEST(StepRecords, PartsOfRecordsTellEveryMember) {
  EXPECT_EQ(members_stated<Finding>(), members_of<Finding>());
  EXPECT_EQ(members_stated<Figure>(), members_of<Figure>());
  EXPECT_EQ(members_stated<OptionName>(), members_of<OptionName>());
  EXPECT_EQ(members_stated<Gauge>(), members_of<Gauge>());
  // Those with constructors are no aggregates.
  [[maybe_unused]] const auto& [kind, id, aspect, axis, name] = Subject{};
  EXPECT_EQ(members_stated<Subject>(), 5u);
  [[maybe_unused]] const auto& [code, option] = Remedy{};
  EXPECT_EQ(members_stated<Remedy>(), 2u);
  EXPECT_EQ(members_stated<PairCounts>(), members_of<PairCounts>());
  [[maybe_unused]] const auto& [position, covariance] = PositionPrecision{};
  EXPECT_EQ(members_stated<PositionPrecision>(), 2u);
  [[maybe_unused]] const auto& [frame, origin, right, up, normal, width, height, depth, area, rms, points, images,
                                surface, ortho, contour, contours, scale] = FrameRecord{};
  EXPECT_EQ(members_stated<FrameRecord>(), 17u);
  EXPECT_EQ(members_stated<CalibrationRecord>(), members_of<CalibrationRecord>());
  EXPECT_EQ(members_stated<GivenSeamlines>(), members_of<GivenSeamlines>());
  EXPECT_EQ(members_stated<InstrumentOptions>(), members_of<InstrumentOptions>());
  // Eigen's matrices in an optional take Anything for too many things: the binding counts instead.
  [[maybe_unused]] const auto& [a, b, c, d, e, f, g, h] = ControlDifference{};
  EXPECT_EQ(members_stated<ControlDifference>(), 8u);
  EXPECT_EQ(members_stated<PositionDifference>(), members_of<PositionDifference>());
  EXPECT_EQ(members_stated<GeodeticDifference>(), members_of<GeodeticDifference>());
}

TEST(StepRecords, ThereIsNoRecordOfAStepThatThereIsNot) {
  EXPECT_EQ(unpacked_outcome("polish", packed(DetectRecord{})).error().code, Errc::kBadFormat);
  EXPECT_EQ(unpacked_outcome("match", packed(DetectRecord{})).error().code, Errc::kUnsupported);
}

TEST(StepRecords, AChoiceThatThereIsNotIsDamage) {
  Packer packer;
  pack(packer, CalibrationRecord{});
  std::string bytes = packer.bytes();
  CalibrationRecord record;
  Unpacker whole(bytes);
  EXPECT_TRUE(unpack(whole, record));
  bytes[0] = 77;  // Calibration comes first
  Unpacker damaged(bytes);
  EXPECT_FALSE(unpack(damaged, record));
}

// Versions of one record whose choice has other words, or the same in another order.
enum class Season : std::uint8_t { kSummer, kWinter };
constexpr Word<Season> kSeasonWords[] = {{Season::kSummer, "summer"}, {Season::kWinter, "winter"}};
constexpr std::span<const Word<Season>> words(Season) { return kSeasonWords; }
enum class Reordered : std::uint8_t { kWinter, kSummer };
constexpr Word<Reordered> kReorderedWords[] = {{Reordered::kSummer, "summer"}, {Reordered::kWinter, "winter"}};
constexpr std::span<const Word<Reordered>> words(Reordered) { return kReorderedWords; }
enum class Renamed : std::uint8_t { kSummer, kAutumn };
constexpr Word<Renamed> kRenamedWords[] = {{Renamed::kSummer, "summer"}, {Renamed::kAutumn, "autumn"}};
constexpr std::span<const Word<Renamed>> words(Renamed) { return kRenamedWords; }
enum class SeasonAgain : std::uint8_t { kSummer, kWinter };
constexpr Word<SeasonAgain> kSeasonAgainWords[] = {{SeasonAgain::kSummer, "summer"}, {SeasonAgain::kWinter, "winter"}};
constexpr std::span<const Word<SeasonAgain>> words(SeasonAgain) { return kSeasonAgainWords; }

// A choice whose words come from functions, as those of findings do.
enum class Sign : std::uint8_t { kMinus, kPlus };
constexpr bool is_known(Sign sign) { return sign <= Sign::kPlus; }
constexpr std::string_view word_of(Sign sign) { return sign == Sign::kMinus ? "minus" : "plus"; }
enum class Turned : std::uint8_t { kPlus, kMinus };
constexpr bool is_known(Turned sign) { return sign <= Turned::kMinus; }
constexpr std::string_view word_of(Turned sign) { return sign == Turned::kMinus ? "minus" : "plus"; }

template <class Choice>
struct WithChoice {
  Choice choice{};
  template <class Visit>
  static void fields(Visit&& visit) {
    visit("choice", &WithChoice::choice);
  }
};

// Its bytes would be read with another meaning.
TEST(StepRecords, AChoiceInAnotherOrderIsOfAnotherVersion) {
  const std::uint64_t written = layout<WithChoice<Season>>();
  EXPECT_EQ(layout<WithChoice<SeasonAgain>>(), written);
  EXPECT_NE(layout<WithChoice<Reordered>>(), written);
  EXPECT_NE(layout<WithChoice<Renamed>>(), written);
  EXPECT_NE(layout<WithChoice<Sign>>(), layout<WithChoice<Turned>>());
}

TEST(StepRecords, AFindingThatThereIsNotIsDamage) {
  ImportRecord record{.findings = {finding_of(FindingCode::kFocalAssumed)}};
  EXPECT_TRUE(unpacked_outcome("import", packed(record)));
  record.findings.front().code = FindingCode(kFindingCodes);
  EXPECT_EQ(unpacked_outcome("import", packed(record)).error().code, Errc::kBadFormat);
}

TEST(StepRecords, PairsAreCountedByWhatTheyAre) {
  PairCounts counts;
  counts.add(PairGeometry::kNone);
  for (const auto geometry : {PairGeometry::kGeneral, PairGeometry::kPlanar, PairGeometry::kRotation})
    counts.add(geometry);
  counts.add(PairGeometry::kGeneral);
  EXPECT_EQ(counts.unrelated, 1u);
  EXPECT_EQ(counts.general, 2u);
  EXPECT_EQ(counts.planar, 1u);
  EXPECT_EQ(counts.rotation, 1u);
  EXPECT_EQ(counts.verified(), 4u);
}

TEST(StepRecords, TheGroundSizeOfAPixelNeedsAScale) {
  OrientationRecord record{.pixel_size = 0.02};
  EXPECT_FALSE(record.gsd_m());
  record.metric = true;
  EXPECT_EQ(record.gsd_m(), 0.02);
}

}  // namespace
}  // namespace collinea
