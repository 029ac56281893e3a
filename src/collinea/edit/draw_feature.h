// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"
#include "collinea/vector/drawing.h"

namespace collinea {

struct EditedWork;

/// Draws a point, a line or a polygon: `draw * roof line with code R typed 1 2 3 mono 4 2 3 cov 1 0 0 1 0 1 mark a.jpg
/// 10 20 0.5`. Each vertex has its source, coordinates in the map, what is known of their covariance (EE EN EH NN NH
/// HH, m^2), and the marks that gave it. A feature of that id is replaced: so vertices are moved; attributes that are
/// not named stay. All of it is one edit, which one undo takes back.
struct DrawFeature {
  static constexpr std::string_view kWord = "draw";
  static constexpr std::string_view kForm =
      "draw FEATURE|* LAYER point|line|polygon [with NAME VALUE|-]... SOURCE E N H [cov EE EN EH NN NH HH] [mark IMAGE "
      "X Y SIGMA_PX]... ...";
  static constexpr std::size_t kMostVertices = 2000, kMostMarks = 100;

  std::string feature;  ///< "*": the next id
  std::string layer;
  VectorKind kind = VectorKind::kLine;
  std::vector<DrawnVertex> vertices;
  std::map<std::string, std::string> attributes = {};  ///< that are set; "-": taken back

  static Result<DrawFeature> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  /// Errors: no such image; an id of F and so many digits that no number is left behind it.
  [[nodiscard]] Result<DrawFeature> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: an id that was erased; another kind than its layer holds; too many attributes.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;

  /// Of ids that the program gave, "F12": 12; 0 of all others.
  static std::uint64_t number_of(const std::string& id);
  static std::string id_of(std::uint64_t number) { return "F" + std::to_string(number); }
};

/// The command that draws a feature as it is, with its attributes.
[[nodiscard]] DrawFeature drawn_again(const DrawnFeature& feature);

/// Removes a feature: `erase F12`. Its id is not given again.
struct EraseFeature {
  static constexpr std::string_view kWord = "erase";
  static constexpr std::string_view kForm = "erase FEATURE";

  std::string feature;

  static Result<EraseFeature> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<EraseFeature> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Error: no such feature.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

}  // namespace collinea
