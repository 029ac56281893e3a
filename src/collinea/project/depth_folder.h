// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/dense/depth_map.h"
#include "collinea/dense/working_images.h"

namespace collinea {

/// A folder with a depth map and its sigmas for each image, as float TIFFs. Maps made from other inputs are removed.
/// Maps may be of any level of the working image's pyramid.
class DepthFolder : public DepthStore {
 public:
  /// Opens the folder for maps made from what `inputs_hash` stands for.
  static Result<DepthFolder> open(const std::filesystem::path& folder, const std::string& inputs_hash,
                                  const Block& block, const WorkingImages& images);

  Result<> write(ImageId image, const DepthMap& map) override;
  Result<DepthMap> read(ImageId image) override;
  [[nodiscard]] bool has(ImageId image) const override;

 private:
  DepthFolder(std::filesystem::path folder, const Block& block, const WorkingImages& images)
      : folder_(std::move(folder)), block_(&block), images_(&images) {}
  [[nodiscard]] std::filesystem::path path(ImageId image, const char* what) const;

  std::filesystem::path folder_;
  const Block* block_;
  const WorkingImages* images_;
};

}  // namespace collinea
