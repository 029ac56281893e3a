// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/verify_project.h"

#include <algorithm>
#include <utility>

#include "collinea/base/file.h"

namespace collinea {

Result<Verified> verify_project(const std::filesystem::path& folder, const VerifyProjectOptions& options,
                                const Run& run) {
  const std::filesystem::path path = folder / kHashesFile;
  if (!is_there(path)) return fail(Errc::kNotFound, path.string() + " is missing: the step \"report\" writes it");
  COLLINEA_TRY(const std::string text, read_file(path));
  COLLINEA_TRY(SignedFiles record, signed_files_of(text).map_error([&](Error error) {
    return std::move(error).within("reading " + path.string());
  }));
  std::vector<SignedFile> files;
  for (const SignedFile& file : record.files) {
    if (file.is_input() && !options.inputs) continue;
    files.push_back(file);
    if (!options.photos || !file.is_input()) continue;
    if (file.role == FileRole::kImage || !is_there(file.folder / file.name)) files.back().folder = *options.photos;
  }
  return compared(std::move(record), folder, std::move(files), run);
}

}  // namespace collinea
