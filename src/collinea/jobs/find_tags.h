// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/feature/tags.h"
#include "collinea/report/tags_report.h"

namespace collinea {

/// How marks are written: rows of a control file; or edits, as `edit PROJECT replay` takes them.
enum class MarksAs : std::uint8_t { kControl, kEdits };
inline constexpr Word<MarksAs> kMarksAsWords[] = {
    {MarksAs::kControl, "control", "rows of a control file, to be appended to that of the points"},
    {MarksAs::kEdits, "edits", "commands for `edit PROJECT replay`"}};
[[nodiscard]] constexpr std::span<const Word<MarksAs>> words(MarksAs) { return kMarksAsWords; }

struct FindTagsOptions {
  TagOptions tags;
  std::optional<std::filesystem::path> control;
  MarksAs as = MarksAs::kControl;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FindTagsOptions;
    visit(Part{&O::tags});
    visit(Field{"control", &O::control, "",
                "control file whose points are meant: those whose name is the number of a tag, or ends in it; nothing: "
                "every tag is a point, named by its number"}
              .leads_to(PathKind::kFile));
    visit(Field{"as", &O::as, "", "how marks are written"});
  }
};

/// Finds coded tags in image files, names them and writes their centres as marks, with covariances. A tag has the name
/// of the point that is called by its number, else of the only one whose name ends in it (is_name_of_tag()); without
/// `control` its number, or behind the word of its family where there are several. Tags that are twice in an image,
/// and two tags of one name, are no marks. Without `control` a tag that a single image shows is none either. Errors:
/// the images', the control file's; a file that cannot be written; no images.
[[nodiscard]] Result<TagsReport> find_tags_in_files(std::span<const std::filesystem::path> images,
                                                    const std::filesystem::path& out, const FindTagsOptions& options,
                                                    const Run& run);

}  // namespace collinea
