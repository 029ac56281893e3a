// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/hypothesis.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/block/world_frame.h"
#include "collinea/geodesy/refraction.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kMostStrips = 12;             // of their own; more: only the flight as a whole
constexpr std::size_t kMostCameras = 4;             // those with the most images
constexpr std::size_t kRaysForGruen = 150000;       // 44 parameters are left out of larger blocks
constexpr int kLeastImages = 3;                     // of a camera
constexpr std::size_t kLeastForDrift = 3;           // images of a strip

std::vector<int> range(int first, int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), first);
  return all;
}

// The images of the problem in the order flown; of each strip from the first to the last.
std::vector<std::vector<int>> sequence_of(const Problem& problem, const SystematicOptions& options) {
  std::map<ImageId, int> number;
  for (int i = 0; i < problem.poses; ++i) number[problem.images[static_cast<std::size_t>(i)].id] = i;
  std::vector<std::vector<int>> strips;
  for (const auto& strip : options.strips) {
    std::vector<std::pair<double, int>> order;
    for (const auto& [id, time] : strip)
      if (const auto its = number.find(id); its != number.end()) order.emplace_back(time, its->second);
    std::sort(order.begin(), order.end());
    std::vector<int>& images = strips.emplace_back();
    for (const auto& [time, image] : order) images.push_back(image);
  }
  return strips;
}

}  // namespace

/// Lays out the hypotheses, family by family.
class HypothesisLayout {
 public:
  HypothesisLayout(const Solved& solved, const SystematicOptions& options, HypothesisColumns& out)
      : block_(solved.block()), problem_(solved.problem()), options_(options), out_(out) {}

  void lay_out() {
    strips_ = sequence_of(problem_, options_);
    out_.positions_.resize(problem_.positions.size());
    out_.attitudes_.resize(problem_.attitudes.size());
    find_velocities();
    add_of_positions();
    add_boresights();
    out_.first_image_column = next_;
    choose_cameras();
    add_of_cameras();
    add_refraction();
    add_bowl();
  }

 private:
  Hypothesis& add(SystematicKind kind, const char* unit, const char* effect_unit, std::vector<int> columns) {
    Hypothesis& made = out_.hypotheses.emplace_back();
    made.test.kind = kind;
    made.test.unit = unit;
    made.test.effect_unit = effect_unit;
    made.columns = std::move(columns);
    return made;
  }

  template <class Each>
  void for_each_position(Each&& each) {
    for (std::size_t i = 0; i < problem_.positions.size(); ++i) each(problem_.positions[i], out_.positions_[i]);
  }

  // A displacement of positions by three columns: `by` times a unit in the world, or the axes of the camera.
  Hypothesis& add_shift(SystematicKind kind, const std::vector<double>& by) {
    const int first = next_;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      if (const double d = by[one.image]; d != 0)
        for (int axis = 0; axis < 3; ++axis) parts[axis].push_back({first + axis, d});
    });
    next_ += 3;
    return add(kind, "m", "m", range(first, 3));
  }

  // Along one vector for each image.
  Hypothesis& add_along(SystematicKind kind, const char* unit, const std::vector<Eigen::Vector3d>& along) {
    const int column = next_++;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      for (int axis = 0; axis < 3; ++axis)
        if (const double d = along[one.image][axis]; d != 0) parts[axis].push_back({column, d});
    });
    return add(kind, unit, "m", {column});
  }

  [[nodiscard]] bool is_camera(std::uint32_t image, std::size_t camera) const {
    return problem_.images[image].camera == static_cast<int>(camera);
  }

  void find_velocities() {
    out_.velocity.assign(problem_.images.size(), Eigen::Vector3d::Zero());
    timed_ = !options_.velocity_m_s.empty();
    for (std::size_t i = 0; timed_ && i < problem_.images.size(); ++i)
      if (const auto its = options_.velocity_m_s.find(problem_.images[i].id); its != options_.velocity_m_s.end())
        out_.velocity[i] = its->second;
    for (const std::vector<int>& strip : strips_)
      for (std::size_t k = 0; !timed_ && strip.size() > 1 && k < strip.size(); ++k) {
        const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, strip.size() - 1);
        out_.velocity[static_cast<std::size_t>(strip[k])] =
            (centre_in(out_.state, static_cast<std::size_t>(strip[after])) -
             centre_in(out_.state, static_cast<std::size_t>(strip[before]))) /
            static_cast<double>(after - before);
      }
  }

  void add_of_positions() {
    if (problem_.positions.empty()) return;
    const auto any = [&](auto&& has) { return std::ranges::any_of(problem_.positions, has); };
    for (std::size_t c = 0; c < problem_.cameras.size(); ++c) {
      const auto of_it = [&](const GivenPosition& one) { return is_camera(one.image, c); };
      if (!any(of_it)) continue;
      if (timed_ && !any([&](const auto& one) { return of_it(one) && one.time_offset >= 0; })) add_time_offset(c);
      if (!any([&](const auto& one) { return of_it(one) && one.lever_arm >= 0; })) add_lever_arm(c);
    }
    const bool is_shifted = any([](const auto& one) { return one.shift >= 0; });
    const bool drifts = any([](const auto& one) { return one.drift >= 0; });
    const std::vector<double> all(problem_.images.size(), 1);
    if (!is_shifted) {
      const Hypothesis& shift = add_shift(SystematicKind::kShift, all);
      const int height = shift.columns[2];  // no column of its own
      add(SystematicKind::kVerticalDatum, "m", "m", {height});
    }
    if (!drifts) add_drift(all_in_sequence(), std::nullopt);
    if (strips_.size() > 1 && strips_.size() <= kMostStrips)
      for (std::size_t s = 0; s < strips_.size(); ++s) add_of_strip(static_cast<int>(s), is_shifted, drifts);
    add_assignment();
  }

  void add_time_offset(std::size_t camera) {
    std::vector<Eigen::Vector3d> along = out_.velocity;
    for (std::uint32_t i = 0; i < along.size(); ++i)
      if (!is_camera(i, camera)) along[i].setZero();
    add_along(SystematicKind::kTimeOffset, "s", along).test.camera = problem_.cameras[camera].id;
  }

  void add_lever_arm(std::size_t camera) {
    const int first = next_;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      if (!is_camera(one.image, camera)) return;
      const Eigen::Matrix3d world_from_cam = rotation_in(out_.state, one.image).transpose();
      for (int axis = 0; axis < 3; ++axis)
        for (int c = 0; c < 3; ++c) parts[axis].push_back({first + c, world_from_cam(axis, c)});
    });
    next_ += 3;
    add(SystematicKind::kLeverArm, "m", "m", range(first, 3)).test.camera = problem_.cameras[camera].id;
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
      const int first = next_;
      bool found = false;
      for (std::size_t i = 0; i < problem_.attitudes.size(); ++i) {
        const GivenRotation& given = problem_.attitudes[i];
        if (!is_camera(given.image, c) || given.boresight >= 0) continue;
        found = true;
        for (int axis = 0; axis < 3; ++axis) {
          const Row row = row_of(problem_, out_.state, given, axis);  // a boresight turns the other way
          for (int k = 0; k < 3; ++k) out_.attitudes_[i][axis].push_back({first + k, -row[k].derivative});
        }
      }
      if (!found) continue;
      next_ += 3;
      add(SystematicKind::kBoresight, "rad", "rad", range(first, 3)).test.camera = problem_.cameras[c].id;
    }
  }

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
          {camera, next_, {static_cast<double>(its.width_px), static_cast<double>(its.height_px)}});
      next_ += out_.per_camera();
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
        add(SystematicKind::kRollingShutter, timed_ ? "s" : "intervals", "px", {slot.first + out_.per_camera() - 1})
            .test.camera = camera.id;
    }
  }

  // b1 and b2 multiply normalised coordinates of the column alone: (column - cx) / f, (row - cy) / f.
  void add_affinity(const CameraColumns& slot, const ProblemCamera& camera) {
    const int count = out_.functions.count();
    const double f = out_.state.cameras[static_cast<std::size_t>(slot.camera)][Camera::kF];
    const double cx = out_.state.cameras[static_cast<std::size_t>(slot.camera)][Camera::kCx];
    const double cy = out_.state.cameras[static_cast<std::size_t>(slot.camera)][Camera::kCy];
    Hypothesis& made = add(SystematicKind::kAffinity, "px", "px", range(slot.first, count));
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
    Hypothesis& made = add(SystematicKind::kAdditional, "px", "px", range(slot.first, 2 * out_.functions.count()));
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
    if (any) add(SystematicKind::kRefraction, "1", "px", {out_.refraction()});
  }

  void add_bowl() {
    std::vector<Eigen::Vector2d> given;
    for (const GivenPosition& one : problem_.positions)
      if (one.inverse_sigma.z() > 0) given.push_back(centre_in(out_.state, one.image).head<2>());
    ControlCoordinate::for_each(problem_, [&](std::size_t p) {
      if (ControlCoordinate::inverse_sigma(problem_, p).z() > 0)
        given.push_back(Eigen::Map<const Eigen::Vector2d>(&out_.state.points[3 * p]));
    });
    if (given.size() < 4) return;
    for (const Eigen::Vector2d& one : given) out_.middle_ += one / static_cast<double>(given.size());
    out_.radius_m_ = 0;
    for (const Eigen::Vector2d& one : given) out_.radius_m_ = std::max(out_.radius_m_, (one - out_.middle_).norm());
    if (!(out_.radius_m_ > 0)) return;
    out_.has_bowl = true;
    for_each_position([&](const GivenPosition& one, auto& parts) {
      parts[2].push_back({out_.bowl(), out_.bowl_at(centre_in(out_.state, one.image))});
    });
    add(SystematicKind::kBowl, "m", "m", {out_.bowl()});
  }

  const Block& block_;
  const Problem& problem_;
  const SystematicOptions& options_;
  HypothesisColumns& out_;
  std::vector<std::vector<int>> strips_;
  bool timed_ = false;
  int next_ = 0;
};

HypothesisColumns::HypothesisColumns(const Solved& solved, const SystematicOptions& options)
    : problem(solved.problem()), state(solved.state()), functions(problem.rays.size() <= kRaysForGruen) {
  HypothesisLayout(solved, options, *this).lay_out();
}

double HypothesisColumns::bowl_at(const Eigen::Vector3d& position) const {
  return (position.head<2>() - middle_).squaredNorm() / (radius_m_ * radius_m_);
}

}  // namespace collinea::bundle
