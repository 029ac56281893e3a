// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/byte_range.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

using Kind = ByteRange::Kind;

TEST(ByteRange, PartsOfAFile) {
  const struct {
    const char* header;
    ByteRange wanted;
  } cases[] = {{"bytes=0-0", {Kind::kPart, 0, 1}},
               {"bytes=0-99", {Kind::kPart, 0, 100}},
               {"bytes=10-19", {Kind::kPart, 10, 10}},
               {" bytes= 10-19 ", {Kind::kPart, 10, 10}},
               {"bytes=99-", {Kind::kPart, 99, 1}},
               {"bytes=0-", {Kind::kPart, 0, 100}},
               {"bytes=90-1000", {Kind::kPart, 90, 10}},
               {"bytes=90-99999999999999999999999", {Kind::kPart, 90, 10}},
               {"bytes=-1", {Kind::kPart, 99, 1}},
               {"bytes=-100", {Kind::kPart, 0, 100}},
               {"bytes=-99999999999999999999999", {Kind::kPart, 0, 100}}};
  for (const auto& [header, wanted] : cases) EXPECT_EQ(asked_range(header, 100), wanted) << header;
}

TEST(ByteRange, OtherUnitsAreTheWholeFile) {
  for (const char* header : {"", "items=0-1", "Bytes", "bytes 0-1"})
    EXPECT_EQ(asked_range(header, 100), ByteRange{}) << header;
}

TEST(ByteRange, WhatCannotBeSatisfied) {
  for (const char* header : {"bytes=", "bytes=-", "bytes=-0", "bytes=100-", "bytes=100-200", "bytes=20-10",
                             "bytes=0-1,5-6", "bytes=0-1,", "bytes=a-b", "bytes=1", "bytes=--1", "bytes=+1-2",
                             "bytes=0x1-2", "bytes=1 -2", "bytes=99999999999999999999999-"})
    EXPECT_EQ(asked_range(header, 100).kind, Kind::kUnsatisfiable) << header;
  for (const char* header : {"bytes=0-", "bytes=-1", "bytes=0-0"})
    EXPECT_EQ(asked_range(header, 0).kind, Kind::kUnsatisfiable) << header;
}

}  // namespace
}  // namespace collinea
