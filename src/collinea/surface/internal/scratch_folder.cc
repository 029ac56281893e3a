// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/scratch_folder.h"

#include <cerrno>
#include <system_error>
#include <utility>

namespace collinea {

ScratchFolder::ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (made_) std::filesystem::remove(path_, ignored);
}

Result<> ScratchFolder::make() {
  std::error_code error;
  made_ |= std::filesystem::create_directories(path_, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + path_.string() + ": " + error.message());
  return {};
}

tl::unexpected<Error> cannot_write(const std::filesystem::path& file) {
  return fail(Errc::kBadInput, "cannot write " + file.string() + ": " + std::generic_category().message(errno));
}

}  // namespace collinea
