// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/console.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "collinea/app/json_text.h"
#include "collinea/report/error_text.h"

namespace collinea {
namespace {

TEST(JsonText, IsWhatAParserReadsBack) {
  for (const std::string text : {"plain", "a \"quoted\" \\ path", "fähre ☃ 𝄞", ""})
    EXPECT_EQ(nlohmann::json::parse("\"" + json_escaped(text) + "\"").get<std::string>(), text);
}

TEST(JsonText, BytesThatAreNoTextBecomeQuestionMarks) {
  EXPECT_EQ(json_escaped("f\xe4hre"), "f?hre");
  EXPECT_EQ(json_escaped("\xc3"), "?");
  EXPECT_EQ(json_escaped("\xc0\xaf"), "??");            // a slash, written too long
  EXPECT_EQ(json_escaped("\xed\xa0\x80"), "???");       // half of a pair of UTF-16
  EXPECT_EQ(json_escaped("\xf5\x80\x80\x80"), "????");  // beyond the last character
  EXPECT_EQ(json_escaped("two\nlines\t"), "two lines ");
}

TEST(JsonText, EveryPairOfBytesGivesValidJson) {
  for (int first = 0; first < 256; ++first)
    for (int second = 0; second < 256; ++second) {
      const std::string text = {static_cast<char>(first), static_cast<char>(second), 'x'};
      ASSERT_TRUE(nlohmann::json::accept("\"" + json_escaped(text) + "\"")) << first << " " << second;
    }
}

TEST(Console, CtrlCBecomesARequestToStop) {
  auto console = Console::create({.progress = ProgressForm::kNone});
  ASSERT_TRUE(console);
  const collinea::Run run = console->run();
  EXPECT_FALSE(run.stopped());
  raise(SIGINT);
  while (!run.stopped()) std::this_thread::yield();  // for ever, when it does not
}

TEST(Console, OneAfterTheOtherWorks) {
  for (int i = 0; i < 3; ++i) {
    auto console = Console::create({.progress = ProgressForm::kNone, .threads = 3});
    ASSERT_TRUE(console);
    EXPECT_EQ(console->run().threads, 3);
    EXPECT_FALSE(console->run().stopped());
  }
}

TEST(Console, ErrorsAreShownInTheFormOfTheProgress) {
  for (const ProgressForm progress :
       {ProgressForm::kLines, ProgressForm::kNone, ProgressForm::kBar, ProgressForm::kJson}) {
    ::testing::internal::CaptureStderr();
    auto console = Console::create({.progress = progress});
    ASSERT_TRUE(console);
    EXPECT_EQ(console->complain({Errc::kIllPosed, "no \"base\""}), 6);
    const std::string shown = ::testing::internal::GetCapturedStderr();
    if (progress == ProgressForm::kJson)
      EXPECT_EQ(nlohmann::json::parse(shown), (nlohmann::json{{"error", "no \"base\""}, {"exit_code", 6}}));
    else
      EXPECT_EQ(shown, "error: no \"base\"\n") << word_of(progress);
  }
}

TEST(Console, ErrorsNameTheirOptionsAsTheFaceSpellsThem) {
  const Error error{Errc::kBadInput, "which site?", {"east_m"_option, "area"_option}};
  const auto spelling = [](const OptionName& option) { return "<" + option.name + ">"; };
  EXPECT_EQ(text_of(error, spelling), "which site? (options <east_m>, <area>)");
  EXPECT_EQ(text_of({Errc::kBadInput, "no CRS", {"crs"_option}}, {}), "no CRS (option crs)");
  EXPECT_EQ(text_of({Errc::kBadInput, "no CRS"}, spelling), "no CRS");
}

TEST(Console, OptionsOutOfRangeAreRefused) {
  const auto refused = Console::create({.threads = -2});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().options, std::vector{"threads"_option});
}

}  // namespace
}  // namespace collinea
