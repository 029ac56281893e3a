// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/content_coding.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TEST(ContentCoding, GzipWhereItIsAllowed) {
  for (const char* header : {"gzip", "gzip, deflate, br, zstd", "br;q=1.0, GZIP;q=0.5", "deflate,gzip ; q = 0.001", "*",
                             "br;q=0, *;q=0.1", "identity;q=0, gzip"})
    EXPECT_TRUE(allows_gzip(header)) << header;
  for (const char* header : {"", ",", ";", "identity", "gzip;q=0", "gzip;q=0.000", "gzip;q=0, *", "*, gzip;q=0",
                             "*;q=0", "gzipped", "br", ";q=1"})
    EXPECT_FALSE(allows_gzip(header)) << header;
}

}  // namespace
}  // namespace collinea
