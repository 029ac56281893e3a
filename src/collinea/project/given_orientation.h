// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/result.h"
#include "collinea/orient/given.h"

namespace collinea {

/// An orientation read from files, and what could not be taken as it is there.
struct ReadOrientation {
  GivenOrientation given;
  std::vector<Finding> findings;
};

/// Reads the orientation of images of `setup` (named by path or file name) from a folder with a COLMAP model, from a
/// folder with Bundler's bundle.out and list.txt or that file itself, or from a table of omega, phi, kappa. Cameras of
/// a model made on images of another size are scaled. Errors: no such file, damaged (with its line), an image that is
/// not among the images, cameras of another shape.
[[nodiscard]] Result<ReadOrientation> read_orientation(const std::filesystem::path& path, const Block& setup);

/// What those files look like from outside: changes when anything in them does.
[[nodiscard]] std::string fingerprint_of_orientation(const std::filesystem::path& path);

}  // namespace collinea
