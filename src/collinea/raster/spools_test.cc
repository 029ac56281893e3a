// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/raster_spool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

TEST(RecordSpool, GivesBackWhatWasAppendedAndLeavesNoFile) {
  const TestFolder folder;
  RecordSpool spool = RecordSpool::create(folder / "cloud.laz").value();
  EXPECT_TRUE(std::filesystem::is_empty((folder / "cloud.laz").parent_path()));
  const std::string much(200'000, 'x');
  spool.append("first");
  spool.append(much);
  EXPECT_EQ(spool.read(0, 5), "first");
  spool.append("last");
  EXPECT_EQ(spool.size(), 200'009u);
  EXPECT_EQ(spool.read(5, 200'000), much);
  EXPECT_EQ(spool.read(200'005, 4), "last");
  EXPECT_EQ(spool.read(200'009, 0), "");
}

TEST(RecordSpool, WhatIsNotThereIsAnError) {
  const TestFolder folder;
  RecordSpool spool = RecordSpool::create(folder / "ties").value();
  spool.append("four");
  for (const auto& [at, bytes] : {std::pair<std::uint64_t, std::uint64_t>(0, 5), {3, 2}, {5, 0}, {1, UINT64_MAX}})
    EXPECT_FALSE(spool.read(at, bytes)) << at << " " << bytes;
  EXPECT_EQ(spool.read(0, 5).error().message,
            (folder / "ties").string() + ": what lies beside it for a while cannot be read: there is less of it");
  const auto nowhere = RecordSpool::create(folder / "nowhere" / "ties");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().message.find("No such file"), std::string::npos);
}

TEST(RasterSpool, GivesBackWindowsOfRasters) {
  const TestFolder folder;
  RasterSpool spool = RasterSpool::create(folder / "heights", 7, 5).value();
  FloatImage first(7, 5), second(7, 5);
  for (int i = 0; i < 35; ++i) first.data[std::size_t(i)] = float(i), second.data[std::size_t(i)] = float(100 + i);
  FloatImage upper(7, 2), lower(7, 3);
  std::copy_n(first.row(0), 14, upper.row(0));
  std::copy_n(first.row(2), 21, lower.row(0));
  for (const FloatImage* rows : {&upper, &lower, &second}) spool.append(*rows);
  EXPECT_EQ(spool.read(0, 0, 0, 7, 5)->data, first.data);
  EXPECT_EQ(spool.read(1, 0, 0, 7, 5)->data, second.data);
  EXPECT_EQ(spool.read(0, 4, 1, 2, 3)->data, (std::vector<float>{11, 12, 18, 19, 25, 26}));
  EXPECT_FALSE(spool.read(2, 0, 0, 1, 1));
}

// A limit on the size of files stands for a full disk.
TEST(RecordSpool, AFullDiskIsStatedWhenItIsRead) {
  const TestFolder folder;
  RecordSpool spool = RecordSpool::create(folder / "ties").value();
  rlimit before;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 100'000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  spool.append(std::string(1'000'000, 'x'));
  const auto read = spool.read(0, 10);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("written: File too large"), std::string::npos) << read.error().message;
}

}  // namespace
}  // namespace collinea
