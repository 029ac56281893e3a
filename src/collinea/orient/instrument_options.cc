// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/instrument_options.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "collinea/block/image_axes.h"
#include "collinea/io/text.h"
#include "collinea/orient/flight_strips.h"

namespace collinea {
namespace {

const Eigen::Vector3d kNotKnown = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
constexpr double kRadians = std::numbers::pi / 180;

// A lever arm, of the cameras of that name; of all that no other names where there is none.
struct NamedArm {
  std::string camera;
  std::optional<LeverArm> arm;  // nothing: none
};

// Of one that is given or to be found; false: it is neither, nor none.
bool read_arm(const LeverArmOption& asked, std::optional<LeverArm>& arm) {
  if (asked.word() == LeverArmWord::kEstimate)
    arm = {Eigen::Vector3d::Zero(), kNotKnown};
  else if (const ThreeNumbers* given = asked.get<ThreeNumbers>())
    arm = {Eigen::Map<const Eigen::Vector3d>(given->data()), Eigen::Vector3d::Zero()};
  else
    return asked.word() == LeverArmWord::kNone;
  return true;
}

// Of all cameras, or of each. A name may hold colons; what follows the last one cannot.
Result<std::vector<NamedArm>> lever_arms_of(const LeverArmOption& asked) {
  std::vector<NamedArm> arms;
  for (const std::string_view part : fields_of(asked.text(), ';')) {
    const std::size_t colon = part.rfind(':');
    NamedArm one;
    if (colon != part.npos) one.camera = trimmed(part.substr(0, colon));
    const std::string_view value = trimmed(colon == part.npos ? part : part.substr(colon + 1));
    const bool twice =
        std::any_of(arms.begin(), arms.end(), [&](const NamedArm& other) { return other.camera == one.camera; });
    if (twice || (colon != part.npos && one.camera.empty()) || !read_arm(LeverArmOption(value), one.arm))
      return fail(Errc::kBadInput,
                  "lever_arm = \"" + asked.text() +
                      "\": give x,y,z in metres (right, down, forward in the camera), estimate or none, once for all "
                      "cameras or for each: NAME:x,y,z; NAME:estimate",
                  {"lever_arm"_option});
    arms.push_back(std::move(one));
  }
  return arms;
}

// That of each camera that has one.
Result<std::map<CameraId, LeverArm>> lever_arms_of(const LeverArmOption& asked, const Block& block) {
  COLLINEA_TRY(const std::vector<NamedArm> arms, lever_arms_of(asked));
  std::map<CameraId, std::optional<LeverArm>> found;
  for (const bool named : {false, true})
    for (const NamedArm& one : arms) {
      if (one.camera.empty() == named) continue;
      bool any = false;
      for (const auto& [id, camera] : block.cameras) {
        if (named && camera.name != one.camera) continue;
        found[id] = one.arm;
        any = true;
      }
      if (!any && named)
        return fail(Errc::kBadInput,
                    "lever_arm names the camera \"" + one.camera + "\", and there is none of that name",
                    {"lever_arm"_option});
    }
  std::map<CameraId, LeverArm> of_camera;
  for (const auto& [id, arm] : found)
    if (arm) of_camera[id] = *arm;
  return of_camera;
}

GivenAttitude attitude_of(const AttitudePrior& prior, const InstrumentOptions& asked) {
  Eigen::Vector3d sigma_deg(asked.attitude_sigma_deg, asked.attitude_sigma_deg, asked.heading_sigma_deg);
  sigma_deg = (prior.sigma_deg.array() > 0).select(prior.sigma_deg, sigma_deg);
  return {cam_from_world(prior), sigma_deg * kRadians};
}

}  // namespace

bool has_lever_arm(const InstrumentOptions& asked) {
  return asked.lever_arm && !asked.lever_arm->text().empty() && asked.lever_arm->word() != LeverArmWord::kNone;
}

bool is_of_positions(const InstrumentOptions& asked) {
  return has_lever_arm(asked) || asked.position_shift != PositionShift::kNone || asked.time_offset;
}

Result<> check_instruments(const InstrumentOptions& asked) {
  if (Result<> valid = validate(asked); !valid) return valid;
  if (has_lever_arm(asked)) COLLINEA_TRY(lever_arms_of(*asked.lever_arm));
  if (asked.position_drift && asked.position_shift == PositionShift::kNone)
    return fail(Errc::kBadInput, "a drift of positions needs a shift of the block or of its strips",
                {"position_drift"_option, "position_shift"_option});
  return {};
}

Result<> check_instruments(const InstrumentOptions& asked, const Block& block) {
  if (Result<> valid = check_instruments(asked); !valid) return valid;
  if (has_lever_arm(asked)) COLLINEA_TRY(lever_arms_of(*asked.lever_arm, block));
  const auto& images = block.images;
  const auto any = [&](auto&& has) {
    return std::any_of(images.begin(), images.end(), [&](const auto& one) { return has(one.second); });
  };
  if (is_of_positions(asked) && !any([](const Image& image) { return image.position.has_value(); }))
    return fail(Errc::kBadInput,
                "lever arm, shift and time offset are of positions, and no photograph has one: give a file of them",
                {"positions"_option});
  if (asked.time_offset && any([](const Image& image) { return image.position && image.taken.empty(); }))
    return fail(Errc::kBadInput,
                "a time offset needs the time at which every photograph with a position was taken, and not all say it",
                {"time_offset"_option});
  if (asked.use_attitudes && !any([](const Image& image) { return image.attitude.has_value(); }))
    return fail(Errc::kBadInput, "no photograph says how its camera was turned", {"use_attitudes"_option});
  return {};
}

Result<> add_instruments(const Block& block, const InstrumentOptions& asked, AdjustScope& scope) {
  if (Result<> valid = check_instruments(asked, block); !valid) return valid;
  if (has_lever_arm(asked)) {
    COLLINEA_TRY(scope.lever_arms, lever_arms_of(*asked.lever_arm, block));
  }
  if (asked.position_shift != PositionShift::kNone)
    for (FlightStrip& strip : asked.position_shift == PositionShift::kBlock ? one_strip(block) : flight_strips(block))
      scope.position_tracks.push_back(
          {std::move(strip), kNotKnown, asked.position_drift ? kNotKnown : Eigen::Vector3d(0, 0, 0)});
  if (asked.time_offset) {
    scope.velocity_m_s = flight_velocities(block);
    if (scope.velocity_m_s.empty())
      return fail(Errc::kBadInput,
                  "the times at which the photographs were taken tell no velocity, and so no time offset",
                  {"time_offset"_option});
    for (const auto& [id, camera] : block.cameras)
      scope.time_offset_sigma_s[id] = std::numeric_limits<double>::infinity();
  }
  if (!asked.use_attitudes) return {};
  for (const auto& [id, image] : block.images) {
    if (!image.attitude) continue;
    scope.attitudes[id] = attitude_of(*image.attitude, asked);
    scope.boresight_sigma_rad[image.camera] = kNotKnown;
  }
  return {};
}

void expect_shift(ControlDiagnosis& diagnosis) {
  const auto is_of_crs = [](const Finding& finding) { return finding.code == FindingCode::kPositionCrs; };
  if (std::any_of(diagnosis.findings.begin(), diagnosis.findings.end(), is_of_crs)) return;
  std::erase_if(diagnosis.findings, [](const Finding& finding) {
    return finding.code == FindingCode::kPositionHeights || finding.code == FindingCode::kPositionOffset;
  });
  diagnosis.position_height_shift_m = 0;
  diagnosis.positions_unusable = false;
}

}  // namespace collinea
