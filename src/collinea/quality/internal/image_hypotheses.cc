// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "collinea/adjust/block_motion.h"
#include "collinea/block/world_frame.h"
#include "collinea/geodesy/refraction.h"
#include "collinea/quality/internal/hypothesis_layout.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kMostCameras = 4;  // those with the most images
constexpr int kLeastImages = 3;          // of a camera

class ImageHypotheses {
 public:
  explicit ImageHypotheses(HypothesisLayout& layout)
      : layout_(layout), block_(layout.block), problem_(layout.problem), options_(layout.options), out_(layout.out) {}

  void choose_cameras() {
    std::vector<std::pair<int, int>> images;  // minus how many, camera
    for (std::size_t c = 0; c < problem_.cameras.size(); ++c) images.emplace_back(0, static_cast<int>(c));
    for (int i = 0; i < problem_.poses; ++i)
      --images[static_cast<std::size_t>(problem_.images[static_cast<std::size_t>(i)].camera)].first;
    std::sort(images.begin(), images.end());
    out_.slot_of_camera.assign(problem_.cameras.size(), -1);
    for (const auto& [count, camera] : images) {
      if (-count < kLeastImages || out_.cameras.size() == kMostCameras) break;
      const Camera& its = block_.cameras.at(problem_.cameras[static_cast<std::size_t>(camera)].id);
      out_.slot_of_camera[static_cast<std::size_t>(camera)] = static_cast<int>(out_.cameras.size());
      out_.cameras.push_back(
          {camera, layout_.next, {static_cast<double>(its.width_px), static_cast<double>(its.height_px)}});
      layout_.next += out_.per_camera();
    }
  }

  void add_of_cameras() {
    for (const CameraColumns& slot : out_.cameras) {
      const ProblemCamera& camera = problem_.cameras[static_cast<std::size_t>(slot.camera)];
      const auto is_free = [&](int param) { return std::ranges::find(camera.free, param) != camera.free.end(); };
      const bool has_additional = std::ranges::any_of(camera.free, [](int k) { return k >= Camera::kParams; });
      if (!has_additional) {
        if (!is_free(Camera::kB1) && !is_free(Camera::kB2)) add_affinity(slot, camera);
        for (const AdditionalSet set :
             {AdditionalSet::kPolynomial, AdditionalSet::kEbner, AdditionalSet::kGruen, AdditionalSet::kFourier})
          add_additional(set, slot, camera);
      }
      const bool moves = std::ranges::any_of(out_.velocity, [](const auto& v) { return !v.isZero(0); });
      if (moves)
        layout_
            .add(SystematicKind::kRollingShutter, layout_.timed ? "s" : "intervals", "px",
                 {slot.first + out_.per_camera() - 1})
            .test.camera = camera.id;
    }
  }

  // b1 and b2 multiply normalised coordinates of the column alone: (column - cx) / f, (row - cy) / f.
  void add_affinity(const CameraColumns& slot, const ProblemCamera& camera) {
    const int count = out_.functions.count();
    const double f = out_.state.cameras[static_cast<std::size_t>(slot.camera)][Camera::kF];
    const double cx = out_.state.cameras[static_cast<std::size_t>(slot.camera)][Camera::kCx];
    const double cy = out_.state.cameras[static_cast<std::size_t>(slot.camera)][Camera::kCy];
    Hypothesis& made = layout_.add(SystematicKind::kAffinity, "px", "px", range(slot.first, count));
    made.test.camera = camera.id;
    made.combination.setZero(count, 2);
    const double w = slot.size.width_px / 2, h = slot.size.height_px / 2;
    made.combination(out_.functions.number_of(1, 0), 0) = w / f;
    made.combination(out_.functions.number_of(0, 0), 0) = (w - cx) / f;
    made.combination(out_.functions.number_of(0, 1), 1) = h / f;
    made.combination(out_.functions.number_of(0, 0), 1) = (h - cy) / f;
  }

  void add_additional(AdditionalSet set, const CameraColumns& slot, const ProblemCamera& camera) {
    auto combination = out_.functions.combination_of(set, slot.size);
    if (!combination) return;
    Hypothesis& made =
        layout_.add(SystematicKind::kAdditional, "px", "px", range(slot.first, 2 * out_.functions.count()));
    made.test.camera = camera.id;
    made.test.additional = set;
    made.combination = std::move(*combination);
  }

  // The bend grows linearly with the height of the camera over the point: known for their mean, it is for all.
  void add_refraction() {
    out_.raise_per_square_m.assign(problem_.images.size(), 0);
    if (options_.refraction_corrected || problem_.point_count() == 0) return;
    const auto frame = world_frame(block_);
    if (!frame || !*frame) return;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t p = 0; p < problem_.point_count(); ++p)
      mean += Eigen::Map<const Eigen::Vector3d>(&out_.state.points[3 * p]) / double(problem_.point_count());
    const double ground_m = (*frame)->geographic_from_local(mean).z();
    bool any = false;
    for (std::size_t i = 0; i < problem_.images.size(); ++i) {
      const double height_m = (*frame)->geographic_from_local(centre_in(out_.state, i)).z();
      if (!(height_m - ground_m > 1)) continue;
      out_.raise_per_square_m[i] = refraction_rad(height_m, ground_m) / (height_m - ground_m);
      any = true;
    }
    if (any) layout_.add(SystematicKind::kRefraction, "1", "px", {out_.refraction()});
  }

 private:
  HypothesisLayout& layout_;
  const Block& block_;
  const Problem& problem_;
  const SystematicOptions& options_;
  HypothesisColumns& out_;
};

}  // namespace

void add_hypotheses_of_images(HypothesisLayout& layout) {
  ImageHypotheses hypotheses(layout);
  hypotheses.choose_cameras();
  hypotheses.add_of_cameras();
  hypotheses.add_refraction();
}

}  // namespace collinea::bundle
