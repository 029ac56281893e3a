// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/quality/internal/hypothesis_layout.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kMostStrips = 12;    // of their own; more: only the flight as a whole
constexpr std::size_t kLeastForDrift = 3;  // images of a strip

class InstrumentHypotheses {
 public:
  explicit InstrumentHypotheses(HypothesisLayout& layout)
      : layout_(layout), problem_(layout.problem), out_(layout.out), strips_(layout.strips) {}

  template <class Each>
  void for_each_position(Each&& each) {
    for (std::size_t i = 0; i < problem_.positions.size(); ++i) each(problem_.positions[i], out_.positions[i]);
  }

  // A displacement of positions by three columns: `by` times a unit in the world, or the axes of the camera.
  Hypothesis& add_shift(SystematicKind kind, const std::vector<double>& by) {
    const int first = layout_.next;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      if (const double d = by[one.image]; d != 0)
        for (int axis = 0; axis < 3; ++axis) parts[axis].push_back({first + axis, d});
    });
    layout_.next += 3;
    return layout_.add(kind, "m", "m", range(first, 3));
  }

  // Along one vector for each image.
  Hypothesis& add_along(SystematicKind kind, const char* unit, const std::vector<Eigen::Vector3d>& along) {
    const int column = layout_.next++;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      for (int axis = 0; axis < 3; ++axis)
        if (const double d = along[one.image][axis]; d != 0) parts[axis].push_back({column, d});
    });
    return layout_.add(kind, unit, "m", {column});
  }

  void add_of_positions() {
    if (problem_.positions.empty()) return;
    const auto any = [&](auto&& has) { return std::ranges::any_of(problem_.positions, has); };
    for (std::size_t c = 0; c < problem_.cameras.size(); ++c) {
      const auto of_it = [&](const GivenPosition& one) { return layout_.is_of_camera(one.image, c); };
      if (!any(of_it)) continue;
      if (layout_.timed && !any([&](const auto& one) { return of_it(one) && one.time_offset >= 0; }))
        add_time_offset(c);
      if (!any([&](const auto& one) { return of_it(one) && one.lever_arm >= 0; })) add_lever_arm(c);
    }
    const bool is_shifted = any([](const auto& one) { return one.shift >= 0; });
    const bool drifts = any([](const auto& one) { return one.drift >= 0; });
    const std::vector<double> all(problem_.images.size(), 1);
    if (!is_shifted) {
      const Hypothesis& shift = add_shift(SystematicKind::kShift, all);
      const int height = shift.columns[2];  // no column of its own
      layout_.add(SystematicKind::kVerticalDatum, "m", "m", {height});
    }
    if (!drifts) add_drift(all_in_sequence(), std::nullopt);
    if (strips_.size() > 1 && strips_.size() <= kMostStrips)
      for (std::size_t s = 0; s < strips_.size(); ++s) add_of_strip(static_cast<int>(s), is_shifted, drifts);
    add_assignment();
  }

  void add_time_offset(std::size_t camera) {
    std::vector<Eigen::Vector3d> along = out_.velocity;
    for (std::uint32_t i = 0; i < along.size(); ++i)
      if (!layout_.is_of_camera(i, camera)) along[i].setZero();
    add_along(SystematicKind::kTimeOffset, "s", along).test.camera = problem_.cameras[camera].id;
  }

  void add_lever_arm(std::size_t camera) {
    const int first = layout_.next;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      if (!layout_.is_of_camera(one.image, camera)) return;
      const Eigen::Matrix3d world_from_cam = rotation_in(out_.state, one.image).transpose();
      for (int axis = 0; axis < 3; ++axis)
        for (int c = 0; c < 3; ++c) parts[axis].push_back({first + c, world_from_cam(axis, c)});
    });
    layout_.next += 3;
    layout_.add(SystematicKind::kLeverArm, "m", "m", range(first, 3)).test.camera = problem_.cameras[camera].id;
  }

  [[nodiscard]] std::vector<int> all_in_sequence() const {
    std::vector<int> all;
    for (const std::vector<int>& strip : strips_) all.insert(all.end(), strip.begin(), strip.end());
    return all;
  }

  // From -1/2 at the first to 1/2 at the last image, about zero.
  void add_drift(const std::vector<int>& sequence, std::optional<int> strip) {
    if (sequence.size() < kLeastForDrift) return;
    std::vector<double> by(problem_.images.size(), 0);
    for (std::size_t k = 0; k < sequence.size(); ++k)
      by[static_cast<std::size_t>(sequence[k])] =
          static_cast<double>(k) / static_cast<double>(sequence.size() - 1) - 0.5;
    add_shift(SystematicKind::kDrift, by).test.strip = strip;
  }

  void add_of_strip(int strip, bool is_shifted, bool drifts) {
    const std::vector<int>& images = strips_[static_cast<std::size_t>(strip)];
    if (images.empty() || images.size() == all_in_sequence().size()) return;
    std::vector<double> by(problem_.images.size(), 0);
    for (const int image : images) by[static_cast<std::size_t>(image)] = 1;
    if (!is_shifted) add_shift(SystematicKind::kShift, by).test.strip = strip;
    if (!drifts) add_drift(images, strip);
  }

  // By the way to the next image and from the previous one; at the ends of the flight there is none.
  void add_assignment() {
    const std::vector<int> sequence = all_in_sequence();
    if (sequence.size() < 3) return;
    std::vector<Eigen::Vector3d> next(problem_.images.size(), Eigen::Vector3d::Zero()), previous = next;
    for (std::size_t k = 0; k + 1 < sequence.size(); ++k) {
      const auto a = static_cast<std::size_t>(sequence[k]), b = static_cast<std::size_t>(sequence[k + 1]);
      next[a] = previous[b] = centre_in(out_.state, b) - centre_in(out_.state, a);
    }
    add_along(SystematicKind::kAssignment, "1", next);
    add_along(SystematicKind::kAssignment, "1", previous);
  }

  void add_boresights() {
    for (std::size_t c = 0; c < problem_.cameras.size(); ++c) {
      const int first = layout_.next;
      bool found = false;
      for (std::size_t i = 0; i < problem_.attitudes.size(); ++i) {
        const GivenRotation& given = problem_.attitudes[i];
        if (!layout_.is_of_camera(given.image, c) || given.boresight >= 0) continue;
        found = true;
        for (int axis = 0; axis < 3; ++axis) {
          const Row row = row_of(problem_, out_.state, given, axis);  // a boresight turns the other way
          for (int k = 0; k < 3; ++k) out_.attitudes[i][axis].push_back({first + k, -row[k].derivative});
        }
      }
      if (!found) continue;
      layout_.next += 3;
      layout_.add(SystematicKind::kBoresight, "rad", "rad", range(first, 3)).test.camera = problem_.cameras[c].id;
    }
  }

 private:
  HypothesisLayout& layout_;
  const Problem& problem_;
  HypothesisColumns& out_;
  const std::vector<std::vector<int>>& strips_;
};

}  // namespace

void add_hypotheses_of_instruments(HypothesisLayout& layout) {
  InstrumentHypotheses hypotheses(layout);
  hypotheses.add_of_positions();
  hypotheses.add_boresights();
}

}  // namespace collinea::bundle
