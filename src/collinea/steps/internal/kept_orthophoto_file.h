// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/ortho/orthophoto.h"

namespace collinea {

/// PROJECT/ortho/kept.bin: what the orthophoto in `files` leaves for the next one. `inputs` stands for all that it was
/// made from but the patches. Error: not writable.
[[nodiscard]] Result<> write_kept(const std::filesystem::path& project, const std::string& inputs,
                                  const OrthoFiles& files, const KeptOrthophoto& kept);

/// The orthophoto that was made of the same inputs; nothing where there is none, it was of another version of the
/// program, or its files have changed since.
[[nodiscard]] std::optional<EarlierOrthophoto> read_kept(const std::filesystem::path& project,
                                                         const std::string& inputs, const OrthoFiles& files);

}  // namespace collinea
