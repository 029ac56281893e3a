// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/sha256.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

// The examples of FIPS 180-4.
TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(Sha256().add("abc").hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256().hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256().add("abcdbcdecdefdefgefghfghighijhi").add("jkijkljklmklmnlmnomnopnopq").hex(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, OfAFileIsThatOfItsBytesAlsoOverManyPieces) {
  const TestFolder folder;
  std::string bytes((std::size_t{5} << 20) + 17, 'x');
  bytes[std::size_t{3} << 20] = 'y';
  ASSERT_TRUE(write_file(folder / "long", bytes));
  EXPECT_EQ(sha256_of_file(folder / "long", collinea::Run{}).value(), Sha256().add(bytes).hex());
  EXPECT_EQ(sha256_of_file(folder / "none", collinea::Run{}).error().code, Errc::kNotFound);
  EXPECT_EQ(sha256_of_file(folder / "", collinea::Run{}).error().code, Errc::kNotFound);  // a folder
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(sha256_of_file(folder / "long", collinea::Run{.stop = stop.get_token()}).error().code, Errc::kCancelled);
}

}  // namespace
}  // namespace collinea
