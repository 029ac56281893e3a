// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/file.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

TEST(File, WhatIsWrittenIsReadAgain) {
  const TestFolder folder;
  const std::string bytes("a\0b\r\n\xff", 6);
  ASSERT_TRUE(write_file(folder / "deep/inside/a.bin", bytes));
  EXPECT_EQ(read_file(folder / "deep/inside/a.bin").value(), bytes);
  EXPECT_FALSE(read_file(folder / "deep/inside/a.bin", 5));  // larger than the limit
  ASSERT_TRUE(remove_file(folder / "deep/inside/a.bin"));
  EXPECT_EQ(read_file(folder / "deep/inside/a.bin").error().code, Errc::kNotFound);
}

TEST(File, FoldersAndDevicesAreNotRead) {
  const TestFolder folder;
  EXPECT_NE(read_file(folder / "").error().message.find("a folder"), std::string::npos);
  for (const char* device : {"/dev/zero", "/dev/null"})
    EXPECT_NE(read_file(device).error().message.find("a device"), std::string::npos);
}

TEST(File, AFileThatIsNotFinishedLeavesWhatWasThere) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "a.txt", "before"));
  {
    auto file = OutputFile::create(folder / "a.txt");
    ASSERT_TRUE(file);
    file->write("half");
  }
  EXPECT_EQ(read_file(folder / "a.txt").value(), "before");
  auto file = OutputFile::create(folder / "a.txt");
  ASSERT_TRUE(file);
  file->write("0123456789");
  file->write_at(2, "ab");
  file->write("end");
  EXPECT_EQ(file->size(), 13u);
  ASSERT_TRUE(file->finish());
  EXPECT_EQ(read_file(folder / "a.txt").value(), "01ab456789end");
}

}  // namespace
}  // namespace collinea
