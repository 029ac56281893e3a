// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/journal.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

NewEdit mark(int i) {
  return {MarkPoint{.point = "P" + std::to_string(i % 7), .image = "a.jpg", .pixel = {i + 0.5, 1}, .sigma_px = 0.5},
          {{"unmark", "P" + std::to_string(i % 7), "a.jpg"}}};
}

Result<std::uint64_t> append(Journal& journal, std::vector<NewEdit> edits) {
  return journal.append([&](const EditHistory&) -> Result<std::vector<NewEdit>> { return edits; });
}

class JournalTest : public ::testing::Test {
 protected:
  [[nodiscard]] Journal opened() const { return Journal(folder_ / ""); }
  [[nodiscard]] std::filesystem::path file() const { return folder_ / "journal.jsonl"; }
  [[nodiscard]] std::string text() const { return read_file(file()).value_or(""); }
  void write(const std::string& bytes) const { std::ofstream(file(), std::ios::binary) << bytes; }
  TestFolder folder_;
};

TEST_F(JournalTest, EntriesComeBackAfterReopening) {
  Journal journal = opened();
  ASSERT_TRUE(journal.refresh());  // no file is no edit
  EXPECT_EQ(journal.number(), 0u);
  EXPECT_EQ(journal.history().next_undo(), nullptr);
  ASSERT_EQ(append(journal, {mark(1), mark(2)}), 2u);
  ASSERT_EQ(append(journal, {{Undo{}}}), 3u);
  ASSERT_EQ(append(journal, {{Undo{}}}), 4u);
  ASSERT_EQ(append(journal, {{Redo{}}}), 5u);
  Journal again = opened();
  ASSERT_TRUE(again.refresh());
  const EditHistory& history = again.history();
  ASSERT_EQ(history.number(), 5u);
  EXPECT_EQ(words_of(history.at(2).edit), words_of(mark(2).edit));
  EXPECT_FALSE(history.at(1).undone);
  EXPECT_TRUE(history.at(2).undone);
  EXPECT_EQ(history.at(3).target, 2u);
  EXPECT_EQ(history.at(5).target, 1u);
  EXPECT_EQ(history.at(1).changed, 5u);
  EXPECT_EQ(history.next_undo()->number, 1u);
  EXPECT_EQ(history.next_redo()->number, 2u);
  const std::string& time = history.at(1).time;
  ASSERT_EQ(time.size(), 20u) << time;
  EXPECT_TRUE(time[10] == 'T' && time.back() == 'Z') << time;
  ASSERT_EQ(append(again, {mark(3)}), 6u);
  EXPECT_EQ(again.history().next_redo(), nullptr);  // a new edit ends what could be redone
}

TEST_F(JournalTest, LinesComeBackWithWhatTheyReplaced) {
  const JournalLine line{7, "2026-11-28T01:02:03Z", mark(3).edit, {{"mark", "P \"3\"", "\xc3\xa9.jpg", "1", "2"}, {}}};
  const auto again = parse_journal_line(text_of(line));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->number, 7u);
  EXPECT_EQ(again->time, line.time);
  EXPECT_EQ(words_of(again->edit), words_of(line.edit));
  EXPECT_EQ(again->replaced, line.replaced);
}

TEST_F(JournalTest, ALastLineCutAnywhereIsCutOffByTheNextEdit) {
  Journal journal = opened();
  ASSERT_TRUE(append(journal, {mark(1), mark(2)}));
  const std::string whole = text();
  const std::size_t last = whole.find('\n') + 1;
  for (std::size_t size = last; size < whole.size(); ++size) {
    write(whole.substr(0, size));
    Journal reader = opened();
    ASSERT_TRUE(reader.refresh()) << size;
    EXPECT_EQ(reader.number(), 1u) << size;
    EXPECT_EQ(text().size(), size);  // who reads changes nothing
    ASSERT_EQ(append(reader, {mark(3)}), 2u) << size;
    Journal again = opened();
    ASSERT_TRUE(again.refresh()) << size;
    ASSERT_EQ(again.number(), 2u) << size;
    EXPECT_EQ(words_of(again.history().at(2).edit), words_of(mark(3).edit));
  }
}

TEST_F(JournalTest, BlocksOfZerosThatACrashLeftAreCutOff) {
  Journal journal = opened();
  ASSERT_TRUE(append(journal, {mark(1)}));
  write(text() + std::string(4096, '\0'));
  Journal again = opened();
  ASSERT_EQ(append(again, {mark(2)}), 2u);
  EXPECT_EQ(text().find('\0'), std::string::npos);
}

TEST_F(JournalTest, ABrokenLineElsewhereIsNamedAndNothingIsWritten) {
  Journal journal = opened();
  ASSERT_TRUE(append(journal, {mark(1), mark(2), mark(3)}));
  const std::string whole = text();
  const std::size_t second = whole.find('\n') + 1, third = whole.find('\n', second) + 1;
  const std::string first = whole.substr(0, second), last = whole.substr(third);
  const std::string head = "{\"number\":2,\"time\":\"\",\"command\":[";
  for (const std::string& line : {std::string("x"), std::string(), head + "\"undo\"", head + "\"paint\"]}",
                                  head + "1]}", std::string("[[[[[[]]]]]]"), std::string("{\"number\":-2}"),
                                  std::string("{\"number\":3,\"time\":\"\",\"command\":[\"undo\"]}"),
                                  whole.substr(0, second - 1), whole.substr(second, 20), head + "\"redo\"]}"}) {
    write(first + line + "\n" + last);
    Journal again = opened();
    const auto read = again.refresh();
    ASSERT_FALSE(read) << line;
    EXPECT_EQ(read.error().code, Errc::kBadFormat);
    EXPECT_NE(read.error().message.find("journal.jsonl: line 2: "), std::string::npos) << read.error().message;
    EXPECT_EQ(again.number(), 1u);
    const std::string before = text();
    EXPECT_FALSE(append(again, {mark(4)}));
    EXPECT_EQ(text(), before);
  }
}

TEST_F(JournalTest, WhatOthersAppendIsReadOn) {
  Journal one = opened(), other = opened();
  ASSERT_TRUE(append(one, {mark(1)}));
  ASSERT_EQ(append(other, {mark(2)}), 2u);
  ASSERT_EQ(append(one, {{Undo{}}}), 3u);
  ASSERT_TRUE(other.refresh());
  EXPECT_TRUE(other.history().at(2).undone);
}

TEST_F(JournalTest, AFileThatWasReplacedIsReadAnew) {
  Journal journal = opened();
  ASSERT_TRUE(append(journal, {mark(1), mark(2)}));
  std::filesystem::remove(file());
  ASSERT_TRUE(journal.refresh());
  EXPECT_EQ(journal.number(), 0u);
  ASSERT_EQ(append(journal, {mark(3)}), 1u);
  const std::string text_of_one = text();
  ASSERT_TRUE(append(journal, {mark(4)}));
  write(text_of_one);  // became shorter
  ASSERT_TRUE(journal.refresh());
  EXPECT_EQ(journal.number(), 1u);
}

TEST_F(JournalTest, NothingToUndoOrRedoIsAnErrorAndNoEntry) {
  Journal journal = opened();
  EXPECT_FALSE(append(journal, {{Undo{}}}));
  EXPECT_FALSE(append(journal, {{Redo{}}}));
  EXPECT_EQ(text(), "");
  ASSERT_TRUE(append(journal, {mark(1)}));
  EXPECT_FALSE(append(journal, {{Redo{}}}));
}

// Every line is whole and of the number that it has in the file; none is lost.
TEST_F(JournalTest, ThreadsThatEditAtOnceLoseNothing) {
  constexpr int kThreads = 4, kEdits = 25;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t)
      threads.emplace_back([&, t] {
        Journal journal = opened();
        for (int i = 0; i < kEdits; ++i) EXPECT_TRUE(append(journal, {mark(kEdits * t + i)}));
      });
  }
  Journal journal = opened();
  ASSERT_TRUE(journal.refresh());
  EXPECT_EQ(journal.number(), std::uint64_t{kThreads * kEdits});
  std::set<double> seen;
  for (const EditEntry& entry : journal.history().entries()) seen.insert(std::get<MarkPoint>(entry.edit).pixel.x());
  EXPECT_EQ(seen.size(), std::size_t{kThreads * kEdits});
}

TEST_F(JournalTest, AHundredThousandEntriesAreReadOnceAndThenOnlyWhatIsNew) {
  constexpr int kMany = 100'000;
  std::vector<NewEdit> edits;
  for (int i = 0; i < kMany; ++i) edits.push_back(mark(i));
  Journal journal = opened();
  ASSERT_EQ(append(journal, edits), std::uint64_t{kMany});
  Journal reader = opened();
  ASSERT_TRUE(reader.refresh());
  ASSERT_EQ(reader.number(), std::uint64_t{kMany});
  EXPECT_EQ(reader.history().edits_of("P3").size(), std::size_t{(kMany + 3) / 7});
  // Bytes before the position are not read again: a change of them stays unseen.
  {
    std::fstream changed(file(), std::ios::in | std::ios::out | std::ios::binary);
    changed << "{{{{";
  }
  ASSERT_TRUE(append(journal, {mark(0)}));
  ASSERT_TRUE(reader.refresh());
  EXPECT_EQ(reader.number(), std::uint64_t{kMany + 1});
  EXPECT_FALSE(opened().refresh());
}

}  // namespace
}  // namespace collinea
