// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/nearest_names.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

using Names = std::vector<std::string>;

TEST(NearestNames, AreThoseThatASlipOfTheFingerMakes) {
  const Names points{"GCP01", "GCP10", "church", "P7"};
  EXPECT_EQ(nearest_names("gcp01", points), (Names{"GCP01"}));  // three capitals
  EXPECT_EQ(nearest_names("GCP1", points), (Names{"GCP01", "GCP10"}));
  EXPECT_EQ(nearest_names("chruch", points), (Names{"church"}));
  EXPECT_EQ(nearest_names("chruch", points, 0), Names{});
  EXPECT_TRUE(nearest_names("nothing like it", points).empty());
  EXPECT_TRUE(nearest_names("x", {}).empty());
}

TEST(NearestNames, AreSaidBehindTheMessage) {
  const auto said = [](const char* name, const Names& names) {
    return with_nearest({Errc::kBadInput, "none"}, name, names).message;
  };
  EXPECT_EQ(said("los", {"loss", "folds"}), "none; did you mean loss?");
  EXPECT_EQ(said("GCP1", {"GCP01", "GCP10"}), "none; did you mean GCP01 or GCP10?");
  EXPECT_EQ(said("far", {"elsewhere"}), "none");
}

}  // namespace
}  // namespace collinea
