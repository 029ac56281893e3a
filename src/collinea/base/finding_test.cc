// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/finding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace collinea {
namespace {

constexpr std::string_view kWordLetters = "abcdefghijklmnopqrstuvwxyz0123456789_";

bool is_word(std::string_view word) {
  return !word.empty() && word.find_first_not_of(kWordLetters) == std::string_view::npos;
}

TEST(Finding, EveryCodeHasAWordOfItsOwn) {
  std::set<std::string_view> words;
  for (std::size_t i = 0; i < kFindingCodes; ++i) {
    const auto code = static_cast<FindingCode>(i);
    EXPECT_TRUE(is_word(word_of(code))) << i;
    EXPECT_TRUE(words.insert(word_of(code)).second) << word_of(code);
    EXPECT_EQ(finding_code_named(word_of(code)), code);
  }
  EXPECT_FALSE(finding_code_named("no_such_finding"));
}

TEST(Finding, EveryFigureRemedySubjectAndAspectHasAWordOfItsOwn) {
  const auto all_differ = []<class Enum>(Enum, std::size_t count) {
    std::set<std::string_view> words;
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(is_word(word_of(static_cast<Enum>(i)))) << i;
      words.insert(word_of(static_cast<Enum>(i)));
    }
    EXPECT_EQ(words.size(), count);
  };
  all_differ(FigureName{}, kFigureNames);
  all_differ(RemedyCode{}, kRemedyCodes);
  all_differ(SubjectKind{}, kSubjectKinds);
  all_differ(Aspect{}, kAspectsOfSubjects);
}

// A figure in metres, pixels or degrees says so in its word, as every number that crosses a border does.
TEST(Finding, UnitsAreInTheWords) {
  for (std::size_t i = 0; i < kFigureNames; ++i) {
    const auto name = static_cast<FigureName>(i);
    const std::string_view unit = unit_of(name);
    EXPECT_TRUE(unit == "1" || word_of(name).ends_with("_" + std::string(unit))) << word_of(name);
  }
}

TEST(Finding, HasTheSeverityOfItsCodeAndItsFiguresByName) {
  const Finding finding = finding_of(FindingCode::kWeakImages, {ImageId{3}, ImageId{5}},
                                     {{FigureName::kCount, 2}, {FigureName::kSigma, 0.5}, {FigureName::kSigma, 0.7}});
  EXPECT_EQ(finding.severity, Severity::kWeak);
  EXPECT_EQ(finding.figure(FigureName::kCount), 2);
  EXPECT_EQ(finding.figure(FigureName::kOffset), std::nullopt);
  EXPECT_EQ(finding.figures_of(FigureName::kSigma), (std::vector{0.5, 0.7}));
  EXPECT_EQ(finding.subjects[1].image(), ImageId{5});
  EXPECT_EQ(finding.subjects[1].camera(), std::nullopt);
}

TEST(Finding, ASubjectOfAllHasNoId) {
  EXPECT_EQ(Subject(SubjectKind::kImage, Subject::kAll, Aspect::kAttitude).image(), std::nullopt);
  EXPECT_EQ(Subject(Aspect::kScale).kind, SubjectKind::kBlock);
}

TEST(Finding, ANumberThatIsNoCodeHasSomeWord) {
  EXPECT_TRUE(is_word(word_of(static_cast<FindingCode>(255))));
  EXPECT_TRUE(is_word(word_of(static_cast<RemedyCode>(255))));
}

}  // namespace
}  // namespace collinea
