// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/orient.h"
#include "collinea/report/finding_words.h"

#include "collinea/project/given_orientation.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/internal/orientation_record.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

// By our own means, or from another program's.
Result<Orientation> orientation_of(Project& project, const Block& setup, const std::vector<ImagePair>& pairs) {
  const auto keypoints = [&](ImageId image) { return project.store.read_keypoints(image); };
  const OrientOptions& options = project.settings.orient;
  const auto images = [&](ImageId image) { return read_grey(project.image_file(setup.images.at(image))); };
  if (!options.orientation) return orient(setup, pairs, keypoints, options, project.run, images);
  COLLINEA_TRY(const ReadOrientation read, read_orientation(*options.orientation, setup));
  COLLINEA_TRY(Orientation orientation,
               orient_as_given(setup, pairs, keypoints, read.given, options, project.run, images));
  orientation.findings.insert(orientation.findings.begin(), read.findings.begin(), read.findings.end());
  orientation.findings.insert(
      orientation.findings.begin(),
      finding_of(options.refine_orientation ? FindingCode::kOrientationTaken : FindingCode::kOrientationFixed,
                 {Subject::file(read.given.source)},
                 {{FigureName::kCount, double(read.given.cam_from_world.size())},
                  {FigureName::kOf, double(setup.images.size())},
                  {FigureName::kCameras, double(read.given.cameras.size())}}));
  return orientation;
}

}  // namespace

Result<StepOutput> orient_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  COLLINEA_TRY(const std::vector<ImagePair> pairs, project.store.read_pairs());
  COLLINEA_TRY(Orientation orientation, orientation_of(project, setup, pairs));
  COLLINEA_TRY(project.store.write_orientation(orientation.block));
  for (const Finding& finding : orientation.findings)
    project.run.say("note: " + sentence_of(finding, setup, project.run.spelling));
  return StepOutput{inputs_hash, record_of(orientation)};
}

}  // namespace collinea
