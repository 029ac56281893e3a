// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "collinea/cloud/cloud_edits.h"
#include "collinea/edit/edited_point.h"

namespace collinea {

struct EditedWork;

/// What the edits of the cloud have in common: their region; they need nothing of the setup, and only undo takes them
/// back.
struct EditsCloud {
  CloudRegion region;
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext&, const EditedWork&) const {
    return {};
  }
};

/// Gives the points of a region a class: `classify 2 410 - E N E N E N`; LOW and HIGH are heights, `-` without end.
struct ClassifyCloud : EditsCloud {
  static constexpr std::string_view kWord = "classify";
  static constexpr std::string_view kForm = "classify CLASS LOW|- HIGH|- E N E N E N ...";

  static Result<ClassifyCloud> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<ClassifyCloud> completed(const EditContext&, const EditDefaults&) const { return *this; }
};

/// Removes the points of a region: `cut - 405.5 E N E N E N`.
struct CutCloud : EditsCloud {
  static constexpr std::string_view kWord = "cut";
  static constexpr std::string_view kForm = "cut LOW|- HIGH|- E N E N E N ...";

  static Result<CutCloud> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<CutCloud> completed(const EditContext&, const EditDefaults&) const { return *this; }
};

/// Removes all points but those of a region: `crop - - E N E N E N`.
struct CropCloud : EditsCloud {
  static constexpr std::string_view kWord = "crop";
  static constexpr std::string_view kForm = "crop LOW|- HIGH|- E N E N E N ...";

  static Result<CropCloud> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<CropCloud> completed(const EditContext&, const EditDefaults&) const { return *this; }
};

}  // namespace collinea
