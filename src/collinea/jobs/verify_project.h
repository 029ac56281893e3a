// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/report/signed_files.h"

namespace collinea {

struct VerifyProjectOptions {
  std::optional<std::filesystem::path> photos;
  bool inputs = true;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = VerifyProjectOptions;
    visit(Field{
        "photos", &O::photos, "",
        "folder of the photographs now, and of other files that were given and are not where they were; nothing: all "
        "are where they were"}
              .leads_to(PathKind::kFolder));
    visit(Field{"inputs", &O::inputs, "", "also photographs and the other files that were given"});
  }
};

/// Whether the files that a report vouches for are still those: compares each with PROJECT/report/hashes.json. Needs
/// nothing else of the project, so that also a copy of report/, adjustment/ and products/ can be verified. Errors: no
/// hashes.json, or a damaged one; kCancelled.
[[nodiscard]] Result<Verified> verify_project(const std::filesystem::path& folder, const VerifyProjectOptions& options,
                                              const Run& run);

}  // namespace collinea
