// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/signed_files.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/sha256.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

class SignedFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_file(folder_ / "photos/b.jpg", "second"));
    ASSERT_TRUE(write_file(folder_ / "photos/a.jpg", "first"));
    ASSERT_TRUE(write_file(folder_ / "survey/control.csv", "p,1,2,3"));
    ASSERT_TRUE(write_file(folder_ / "project/products/ortho.tif", std::string(3'000'000, 'o')));
    all_.version = "0.1.0";
    all_.seed = 7;
    all_.files = {{FileRole::kImage, "a.jpg", folder_ / "photos"},
                  {FileRole::kImage, "b.jpg", folder_ / "photos"},
                  {FileRole::kGiven, "control.csv", folder_ / "survey"},
                  {FileRole::kProduct, "products/ortho.tif", {}},
                  {FileRole::kReport, "report/report.html", {}}};
    ASSERT_TRUE(write_file(folder_ / "project/report/report.html", "<html>"));
    ASSERT_TRUE(hash_files(folder_ / "project", all_.files, collinea::Run{.threads = 2}));
  }
  [[nodiscard]] Verified verified() const { return *compared(all_, folder_ / "project", all_.files, collinea::Run{}); }
  [[nodiscard]] std::string states() const {
    std::string states;
    for (const auto& [file, state] : verified().files) states += std::string(word_of(state)) + " ";
    return states;
  }
  TestFolder folder_;
  SignedFiles all_;
};

TEST_F(SignedFilesTest, WhatIsAsItWasAgrees) {
  EXPECT_EQ(all_.files[0].bytes, 5u);
  EXPECT_EQ(all_.files[0].sha256, Sha256().add("first").hex());
  EXPECT_EQ(states(), "same same same same same ");
  EXPECT_TRUE(verified().agrees());
  EXPECT_FALSE((Verified{all_, {}}.agrees()));  // nothing was looked at
}

TEST_F(SignedFilesTest, AChangedByteAMissingFileAndOneThatNeverHadAHashAreFound) {
  std::string ortho(3'000'000, 'o');
  ortho[1'999'999] = 'O';
  ASSERT_TRUE(write_file(folder_ / "project/products/ortho.tif", ortho));
  ASSERT_TRUE(write_file(folder_ / "photos/a.jpg", "First"));
  std::filesystem::remove(folder_ / "photos/b.jpg");
  all_.files[2].sha256.clear();
  EXPECT_EQ(states(), "changed missing unknown changed same ");
  EXPECT_FALSE(verified().agrees());
  const std::string text = verified_text(verified());
  EXPECT_NE(text.find("changed   products/ortho.tif\n"), std::string::npos) << text;
  EXPECT_NE(text.find("5 files: 1 same, 2 changed, 1 missing, 1 unknown."), std::string::npos) << text;
  const auto json = nlohmann::json::parse(verified_json(verified()));
  EXPECT_FALSE(json.at("agrees").get<bool>());
  EXPECT_EQ(json.at("files").at(1).at("state"), "missing");
}

TEST_F(SignedFilesTest, DigestsAreThoseOfTheListThatSha256sumPrints) {
  const std::string list = Sha256().add("first").hex() + "  a.jpg\n" + Sha256().add("second").hex() + "  b.jpg\n" +
                           Sha256().add("p,1,2,3").hex() + "  control.csv\n";
  EXPECT_EQ(digest_of(all_, SignedPart::kInputs), Sha256().add(list).hex());
  const std::string products = digest_of(all_, SignedPart::kProducts);
  all_.files[4].sha256 = std::string(64, '0');  // the report is no product
  std::swap(all_.files[0], all_.files[1]);      // and the order does not matter
  EXPECT_EQ(digest_of(all_, SignedPart::kProducts), products);
  EXPECT_EQ(digest_of(all_, SignedPart::kInputs), Sha256().add(list).hex());
  all_.files[3].sha256[5] ^= 1;
  EXPECT_NE(digest_of(all_, SignedPart::kProducts), products);
  EXPECT_EQ(digest_of({}, SignedPart::kInputs), "");
}

TEST_F(SignedFilesTest, TheRecordComesBackAsItWasWritten) {
  all_.files[1].sha256.clear();
  const auto back = signed_files_of(signed_files_json(all_));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->version, "0.1.0");
  EXPECT_EQ(back->seed, 7u);
  ASSERT_EQ(back->files.size(), all_.files.size());
  for (std::size_t i = 0; i < all_.files.size(); ++i) {
    EXPECT_EQ(back->files[i].role, all_.files[i].role);
    EXPECT_EQ(back->files[i].name, all_.files[i].name);
    EXPECT_EQ(back->files[i].folder, all_.files[i].folder);
    EXPECT_EQ(back->files[i].bytes, all_.files[i].bytes);
    EXPECT_EQ(back->files[i].sha256, all_.files[i].sha256);
  }
}

TEST_F(SignedFilesTest, ADamagedRecordIsRefused) {
  const std::string whole = signed_files_json(all_);
  EXPECT_EQ(signed_files_of(whole.substr(0, whole.size() / 2)).error().code, Errc::kBadFormat);
  EXPECT_EQ(signed_files_of("{}").error().code, Errc::kBadFormat);
  EXPECT_EQ(signed_files_of("[]").error().code, Errc::kBadFormat);
  const auto with = [&](std::string_view part, std::string_view other) {
    std::string text = whole;
    return text.replace(text.find(part), part.size(), other);
  };
  EXPECT_EQ(signed_files_of(with("hashes 1", "hashes 2")).error().code, Errc::kUnsupported);
  EXPECT_EQ(signed_files_of(with("\"image\"", "\"picture\"")).error().code, Errc::kBadFormat);
  EXPECT_EQ(signed_files_of(with(all_.files[0].sha256, "12")).error().code, Errc::kBadFormat);
  EXPECT_EQ(signed_files_of(with("\"seed\": 7", "\"seed\": \"x\"")).error().code, Errc::kBadFormat);
}

TEST_F(SignedFilesTest, AStopIsAStop) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(hash_files(folder_ / "project", all_.files, collinea::Run{.stop = stop.get_token()}).error().code,
            Errc::kCancelled);
}

}  // namespace
}  // namespace collinea
