// SPDX-License-Identifier: Apache-2.0
// What once broke a reader is read again, and what fuzzing starts from is really valid.
#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/base/source_tree.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

const std::filesystem::path kCorpus = std::filesystem::path(source_tree()) / "fuzz" / "corpus";

TEST(FuzzTargets, AcceptTheirSeeds) {
  for (const Target& target : all_targets()) {
    EXPECT_FALSE(target.seeds.empty()) << target.name;
    for (std::size_t i = 0; i < target.seeds.size(); ++i)
      EXPECT_TRUE(target.accepts(target.seeds[i])) << target.name << " seed " << i;
  }
}

TEST(FuzzTargets, ComeBackFromNothingAndFromGarbage) {
  for (const Target& target : all_targets())
    for (const std::string_view bytes : {std::string_view(""), std::string_view("\0", 1), kCut, std::string_view("#")})
      EXPECT_NO_THROW((void)target.accepts(bytes)) << target.name;
}

// A file is named after what it broke. That the call returns, without an exception, is the test.
TEST(FuzzCorpus, IsRead) {
  std::size_t files = 0;
  for (const Target& target : all_targets()) {
    const std::filesystem::path corpus = kCorpus / target.name;
    if (!std::filesystem::exists(corpus)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(corpus)) {
      SCOPED_TRACE(entry.path().string());
      EXPECT_NO_THROW((void)target.accepts(bytes_of(entry.path())));
      ++files;
    }
  }
  EXPECT_GE(files, 14u);  // as many as there were: they may only become more
}

TEST(FuzzCorpus, BelongsToTargets) {
  const std::vector<Target> targets = all_targets();
  ASSERT_TRUE(std::filesystem::exists(kCorpus));
  for (const auto& entry : std::filesystem::directory_iterator(kCorpus))
    EXPECT_TRUE(std::ranges::any_of(targets, [&](const Target& t) { return t.name == entry.path().filename(); }))
        << entry.path();
}

}  // namespace
}  // namespace collinea::fuzz
