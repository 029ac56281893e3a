// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/assess.h"

#include "collinea/synthetic/write.h"

namespace collinea {

Result<Assessment> assess_project(const Project& project, const std::filesystem::path& truth) {
  COLLINEA_TRY(const TruthFolder known, read_truth(truth));
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  if (oriented_images(block).empty())
    return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + project.folder.string());
  const auto products = project.folder / "products";
  const ProductFiles files{.cloud = project.cloud(),
                           .dsm = products / "dsm.tif",
                           .dsm_state = products / "dsm_state.tif",
                           .dsm_sigma = products / "dsm_sigma.tif",
                           .dsm_sigma_relative = products / "dsm_sigma_relative.tif",
                           .dtm = products / "dtm.tif",
                           .dtm_state = products / "dtm_state.tif",
                           .ortho = products / "ortho.tif",
                           .ortho_source = products / "ortho_source.tif"};
  return assess(block, files, known, project.run);
}

}  // namespace collinea
