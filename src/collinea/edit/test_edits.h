// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/test_folder.h"
#include "collinea/edit/edited_work.h"
#include "collinea/edit/make_edits.h"
#include "collinea/io/text.h"
#include "collinea/math/random.h"
#include "collinea/project/settings.h"

namespace collinea {

/// A block as import leaves it: images of 4000 x 3000 pixels, points A to D in UTM 33 (D is measured on the ground to
/// A, C has correlated coordinates), marks, of which two are of A in one image.
inline Block setup_to_edit(std::uint32_t images = 4) {
  Block block;
  block.georeference = Georeference{"EPSG:32633", 48.2, 15.63, 300};
  block.cameras[{0}] = ideal_camera(3000, 4000, 3000);
  for (std::uint32_t i = 0; i < images; ++i) {
    block.images[{i}].file = "sub/photo " + std::to_string(i) + ".jpg";
    block.images[{i}].camera = {0};
  }
  std::uint32_t id = 0;
  for (const char* name : {"A", "B", "C", "D"}) {
    ControlPoint point{.name = name, .position_in_world = Eigen::Vector3d(10.0 * id, 5, 1)};
    point.position_in_map = Eigen::Vector3d(546800 + 10.0 * id, 5338600, 301);
    point.sigma_m = {0.01, 0.02, 0.03};
    if (id == 2) point.correlation = {0.5, 0, 0.25};
    block.control[{id++}] = point;
  }
  block.control_observations = {{{1}, {2}, {10.5, 20.25}, 0.5},
                                {{0}, {0}, {100, 200}, 0.5, {1.5F, 0.25F}},
                                {{0}, {1}, {1.0 / 3, 200}, 0.25},
                                {{0}, {0}, {101, 201}, 0.5},
                                {{2}, {3}, {4000, 3000}, 0.5}};
  block.geodetic.push_back({.kind = GeodeticKind::kDistance, .from = {0}, .to = {3}, .value = 30, .sigma = 0.01});
  return block;
}

/// A project with that setup.
class EditsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_settings(project(), {}));
    ASSERT_TRUE(store().write_setup(setup_to_edit()));
  }
  [[nodiscard]] std::filesystem::path project() const { return folder_ / ""; }
  [[nodiscard]] std::filesystem::path file() const { return folder_ / "journal.jsonl"; }
  [[nodiscard]] ProjectStore store() const { return ProjectStore::open(project()).value(); }
  [[nodiscard]] std::uint64_t hash() const { return store().setup_hash().value(); }

  static Edit edit(const std::vector<std::string>& words) {
    auto parsed = parse_edit(words);
    EXPECT_TRUE(parsed) << words[0] << ": " << (parsed ? "" : parsed.error().message);
    return parsed.value_or(Undo{});
  }
  /// The message of what goes wrong; empty: it was made, and the database holds it.
  std::string make(const std::vector<std::string>& words) {
    const std::vector<Edit> edits = {edit(words)};
    const auto made = make_edits(project(), journal_, edits);
    if (!made) return made.error().message;
    EXPECT_FALSE(made->waiting) << made->waiting->message;
    EXPECT_EQ(store().last_edit(), made->number);
    return "";
  }
  /// Marks of a point: "image x y sigma" each.
  [[nodiscard]] std::vector<std::string> marks_of(const std::string& point) const {
    const Block block = store().read_setup().value();
    std::vector<std::string> marks;
    for (const ControlObservation& one : block.control_observations)
      if (block.control.at(one.point).name == point)
        marks.push_back(line_of(words_of(MarkPoint{point, std::to_string(one.image.value), one.pixel, one.sigma_px})));
    return marks;
  }
  [[nodiscard]] std::optional<ControlPoint> point(const std::string& name) const {
    const Block block = store().read_setup().value();
    for (const auto& [id, point] : block.control)
      if (point.name == name) return point;
    return std::nullopt;
  }

  TestFolder folder_;
  Journal journal_{folder_ / ""};
};

/// A command of any kind, of which most fit; points X0 to X3 come and go.
inline std::vector<std::string> any_command(Random& random) {
  const auto one_of = [&](const std::vector<std::string>& all) {
    return all[random.below(static_cast<std::uint32_t>(all.size()))];
  };
  const auto number = [&](double low, double high) { return std::to_string(low + (high - low) * random.uniform()); };
  const std::string name = one_of({"A", "B", "C", "D", "X0", "X1", "X2", "X3"});
  const std::string image = one_of({"photo 0.jpg", "photo 1.jpg", "sub/photo 2.jpg", "PHOTO 3.JPG"});
  switch (random.below(6)) {
    case 0:
    case 1:
      return {"mark", name, image, number(0, 4000), number(0, 3000), number(0.1, 2)};
    case 2:
      return {"unmark", name, image};
    case 3:
      return {"role", name, one_of({"control", "check"})};
    case 4:
      return {"point", name, "check", number(546000, 547000), one_of({"-", number(5338000, 5339000)}), number(0, 500)};
    default:
      return {"remove", name};
  }
}

/// A command of any kind that changes what is beside control, of which most fit.
inline std::vector<std::string> any_work(Random& random) {
  const auto one_of = [&](const std::vector<std::string>& all) {
    return all[random.below(static_cast<std::uint32_t>(all.size()))];
  };
  const std::string name = one_of({"a", "b", "c"}),
                    kind = one_of({"mask", "mask", "unmask", "patch", "patch", "unpatch", "draw", "draw", "erase",
                                   "attribute", "layer", "classify", "cut", "crop"});
  const std::string feature = "F" + std::to_string(1 + random.below(12));
  if (kind == "erase") return {kind, feature};
  if (kind == "attribute") return {kind, feature, name, one_of({"x", "y", "-"})};
  if (kind == "layer") return {kind, name, "any", one_of({"#000000", "#ff0000"})};
  if (kind == "draw") {
    std::vector<std::string> words = {kind, one_of({"*", "*", feature}), name, "point"};
    for (const char* attribute : {"a", "code"})
      if (random.below(3) == 0) words.insert(words.end(), {"with", attribute, one_of({"x", "z", "-"})});
    const std::string east = std::to_string(random.uniform()), image = one_of({"photo 0.jpg", "PHOTO 3.JPG"});
    words.insert(words.end(), {"mono", east, "2", "3", "mark", image, "1", "2", "0.5"});
    return words;
  }
  if (kind.starts_with("un")) return {kind, name};
  std::vector<std::string> words = {kind, name, one_of({"photo 0.jpg", "PHOTO 3.JPG"})};
  if (kind == "mask" && random.below(4) == 0) words[2] = "*";
  if (kind == "classify") words = {kind, std::to_string(random.below(256)), "-", "100"};
  if (kind == "cut" || kind == "crop") words = {kind, "-3.5", one_of({"-", "12"})};
  for (int i = 0; i < 8; ++i) words.push_back(std::to_string(1000 * random.uniform()));
  return words;
}

/// A work as lines: equal only of works in which everything is equal. Images by their names in `setup`.
inline std::string text_of(const EditedWork& work, const Block& setup) {
  std::string text;
  const auto ring = [&](const std::vector<Eigen::Vector2d>& points) {
    for (const Eigen::Vector2d& point : points) text += " " + exact(point.x()) + " " + exact(point.y());
    text += "; ";
  };
  for (const ImageMask& one : work.masks) {
    text += "mask " + one.name + " " + (one.image ? setup.images.at(*one.image).file : "*");
    ring(one.ring_px);
  }
  for (const SeamPatch& one : work.patches) {
    text += "patch " + one.name + " " + setup.images.at(one.image).file;
    ring(one.ring_m);
  }
  for (const CloudRegion& one : work.regions) {
    text += std::string(word_of(one.action)) + std::to_string(one.classification);
    for (const auto& height : {one.low_m, one.high_m}) text += " " + (height ? exact(*height) : "-");
    ring(one.ring_m);
  }
  for (const DrawingLayer& one : work.drawing.layers) text += line_of(words_of(SetLayer{one})) + "; ";
  for (const DrawnFeature& one : work.drawing.features) text += line_of(words_of(drawn_again(one))) + "; ";
  for (const std::string& id : work.drawing.erased) text += "erased " + id + "; ";
  return text;
}

}  // namespace collinea
