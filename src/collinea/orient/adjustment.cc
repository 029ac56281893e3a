// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/adjustment.h"

#include <algorithm>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "collinea/orient/flight_strips.h"
#include "collinea/orient/internal/systematics_taken_up.h"
#include "collinea/quality/divergence.h"

namespace collinea {
namespace {

// "a3, a7" as its names.
std::vector<std::string> names_in(std::string_view list) {
  std::vector<std::string> names;
  std::string name;
  for (const char one : list) {
    if (one == ' ' || one == '\t') continue;
    if (one != ',') {
      name += one;
      continue;
    }
    if (!name.empty()) names.push_back(std::exchange(name, {}));
  }
  if (!name.empty()) names.push_back(std::move(name));
  return names;
}

Error no_such_parameter(const AdjustmentOptions& asked, AdditionalSet set) {
  const std::string last = "a" + std::to_string(count_of(set));
  return {Errc::kBadInput,
          "additional_fixed = \"" + asked.additional_fixed + "\": the " + std::to_string(count_of(set)) +
              " parameters of " + std::string(kAdditionalNames[std::size_t(set)]) + " are a1 to " + last,
          {"additional_fixed"_option}};
}

void change_set(Camera& camera, AdditionalSet set) {
  if (camera.additional != set) std::fill(camera.params.begin() + Camera::kParams, camera.params.end(), 0.0);
  camera.additional = set;
}

bool is_to_be_corrected(RefractionChoice choice, const Block& block) {
  constexpr double kNoticeable_px = 0.05;  // a tenth of what images of tie points are measured to
  if (choice != RefractionChoice::kAuto) return choice == RefractionChoice::kOn;
  return largest_refraction_px(block) > kNoticeable_px;
}

SystematicOptions systematics_of(const AdjustmentOptions& asked, const Adjustment& done) {
  SystematicOptions options;
  options.test = asked.systematics != Systematics::kNone;
  for (const FlightStrip& strip : flight_strips(done.block)) options.strips.push_back(strip);
  if (!options.test) return options;
  options.level = asked.systematics_level;
  options.sigma0_known = asked.tests.sigma0_known;
  options.refraction_corrected = done.refracted.has_value();
  options.velocity_m_s = flight_velocities(done.block);
  return options;
}

std::map<ImageId, Eigen::Vector3d> adjusted_velocities(const Adjustment& done) {
  Block images;
  images.images = done.block.images;
  for (const auto& [id, pose] : oriented_images(done.block)) set_pose(images, id, pose);
  for (const auto& [id, pose] : done.adjusted.cam_from_world) set_pose(images, id, pose);
  return flight_velocities(images);
}

// Whether velocities by poses of the beginning are too rough to test with: from a file these may be decimetres off.
bool are_rough(const std::map<ImageId, Eigen::Vector3d>& velocities,
               const std::map<ImageId, Eigen::Vector3d>& adjusted) {
  constexpr double kRough = 0.02;
  double squares = 0, of_differences = 0;
  for (const auto& [id, velocity] : adjusted) {
    const auto before = velocities.find(id);
    squares += velocity.squaredNorm();
    of_differences += before == velocities.end() ? velocity.squaredNorm() : (velocity - before->second).squaredNorm();
  }
  return of_differences > kRough * kRough * squares;
}

// One adjustment, with gross errors rejected where they are to be.
Result<> adjust_once(const AdjustmentTask& task, const ExamineOptions& options, const AdjustmentOptions& asked,
                     const Run& run, Adjustment& done) {
  if (task.snoop) {
    COLLINEA_TRY(done.snooped, snoop(done.block, done.scope, options, asked.snoop_most, run, *task.snoop));
    done.block = done.snooped->block;
    done.scope.attitudes = done.snooped->attitudes;
    done.adjusted = std::move(done.snooped->adjusted);
    return {};
  }
  COLLINEA_TRY(done.adjusted, examine_strictly(done.block, done.scope, options, run));
  return {};
}

// A second adjustment, from where the first has come: an iteration or two, and no covariances but those of control.
Result<OtherCheckRays> otherwise(const Adjustment& done, ExamineOptions options, const Run& run) {
  AdjustScope scope = done.scope;
  scope.use_check_rays = !scope.use_check_rays;
  options.adjust.settle_points = true;
  Adjuster adjuster;
  COLLINEA_TRY(Adjusted adjusted, adjust_with_control_precision(adjuster, done.block, scope, options.adjust, run));
  return OtherCheckRays{std::move(adjusted.control), adjusted.sigma0, adjusted.redundancy};
}

}  // namespace

Result<std::vector<std::string>> set_additional(const AdjustmentOptions& asked, AdjustmentTask& task) {
  const std::vector<std::string> fixed = names_in(asked.additional_fixed);
  std::set<std::string> instead;
  bool any = false;
  for (auto& [id, camera] : task.block.cameras) {
    if (camera.prior.film && asked.additional.value_or(AdditionalSet::kNone) != AdditionalSet::kNone)
      return fail(Errc::kBadInput,
                  "every scan of film has parameters of its own for its deformation, and none that all have in common",
                  {"additional"_option, {.name = "film_deformation_um", .group = "import", .value = "0"}});
    if (camera.prior.film) {
      if (asked.additional) camera.prior.film.reset();  // none: as if it was not deformed
      continue;
    }
    const auto own = task.scope.camera_sigmas.find(id);
    Camera& first = task.scope.first_cameras.try_emplace(id, camera).first->second;
    if (asked.additional) {
      change_set(camera, *asked.additional);
      change_set(first, *asked.additional);
    } else {
      first.additional = camera.additional;  // found by orient, around zero
    }
    if (camera.additional == AdditionalSet::kNone) continue;
    any = true;
    if (own != task.scope.camera_sigmas.end() && !asked.additional && fixed.empty()) continue;
    CameraSigmas sigmas{};  // a camera that was given stays as it is beneath them
    if (own != task.scope.camera_sigmas.end())
      sigmas = own->second;
    else if (camera.prior.calibrate)
      sigmas = calibration_sigmas(task.options.adjust.calibration, first);
    const auto both = with_additional(sigmas, first, fixed);
    if (!both) return tl::unexpected(no_such_parameter(asked, camera.additional));
    for (int k = 0; k < Camera::kParams; ++k)
      if (sigmas[std::size_t(k)] > 0 && (*both)[std::size_t(k)] == 0) instead.insert(param_name(k));
    task.scope.camera_sigmas[id] = *both;
  }
  if (!fixed.empty() && !any)
    return fail(Errc::kBadInput, "additional parameters are to be fixed, but no camera has any",
                {"additional_fixed"_option, "additional"_option});
  return std::vector<std::string>(instead.begin(), instead.end());
}

Result<> set_deflection(const AdjustmentOptions& asked, Block& block) {
  if (!asked.deflection_north_arcsec && !asked.deflection_east_arcsec) return {};
  if (!block.georeference)
    return fail(Errc::kBadInput,
                "the deflection of the vertical is that from the ellipsoid: it needs a block with a location on Earth",
                {"deflection_north_arcsec"_option, "deflection_east_arcsec"_option});
  constexpr double kArcsecond = std::numbers::pi / 180 / 3600;
  Georeference& frame = *block.georeference;
  if (const auto& north = asked.deflection_north_arcsec) frame.deflection_north_rad = *north * kArcsecond;
  if (const auto& east = asked.deflection_east_arcsec) frame.deflection_east_rad = *east * kArcsecond;
  return {};
}

Result<> choose_datum(const AdjustmentOptions& asked, AdjustmentTask& task) {
  COLLINEA_TRY(task.options.datum, datum_points_named(task.block, asked.datum_points));
  std::set<ControlId> measured;
  for (const GeodeticObservation& one : task.block.geodetic) measured.insert({one.from, one.to});
  std::set<ControlId> seen;
  for (const ControlObservation& one : task.block.control_observations) seen.insert(one.point);
  for (const ControlId id : task.options.datum.control) {
    const ControlPoint& point = task.block.control.at(id);
    if (!seen.contains(id))
      return fail(Errc::kBadInput, "datum points: " + point.name + " is measured in no image", {"datum_points"_option});
    const bool is_control = task.scope.use_control && point.role == ControlRole::kControl;
    if (!is_control && !task.scope.use_check_rays && !measured.contains(id))
      return fail(Errc::kBadInput,
                  "datum points: " + point.name + " is a check point, whose measurements in images take no part",
                  {"datum_points"_option, {.name = "check_rays", .value = "yes"}});
  }
  return {};
}

Result<Adjustment> adjust_block(AdjustmentTask task, const AdjustmentOptions& asked, const Run& run) {
  constexpr int kMostTakenUp = 4;
  Adjustment done;
  if (is_to_be_corrected(asked.refraction, task.block)) {
    COLLINEA_TRY(done.refracted, correct_refraction(task.block));
  }
  add_film(task.block);
  done.scope = with_first_cameras(task.scope, task.block.cameras);
  done.instruments = task.instruments;
  done.block = std::move(task.block);
  done.datum_points = task.options.datum;
  if (asked.tie_residuals) done.measured_ties = done.block.observations;
  if (task.reject_mismatches) {
    COLLINEA_TRY(WithoutMismatches clean, reject_mismatches(std::move(done.block), done.scope, task.options.adjust,
                                                            task.options.test.false_alarm, run));
    done.block = std::move(clean.block);
    done.mismatches = std::move(clean.found);
  }
  ExamineOptions options = task.options;
  const bool has_loss = options.adjust.loss != Loss::kNone;
  if (asked.weigh_ties.value_or(film_takes_part(done.block) && !has_loss)) {
    if (has_loss)
      return fail(Errc::kBadInput, "tie points weigh by their errors, or by a loss: not by both",
                  {"weigh_ties"_option, {.name = "loss", .value = "none"}});
    COLLINEA_TRY(done.tie_weights, weigh_ties(done.block, done.scope, options.adjust, run));
  }
  if (film_takes_part(done.block)) {
    COLLINEA_TRY(done.film, estimate_film(done.block, done.scope, options, run));
  }
  options.systematics = systematics_of(asked, done);
  COLLINEA_TRY(adjust_once(task, options, asked, run, done));
  if (options.systematics.test && !options.systematics.velocity_m_s.empty()) {
    auto velocities = adjusted_velocities(done);
    if (are_rough(options.systematics.velocity_m_s, velocities)) {
      options.systematics.velocity_m_s = std::move(velocities);
      apply(done.adjusted, done.block);
      COLLINEA_TRY(adjust_once(task, options, asked, run, done));
    }
  }
  for (int taken = 0; taken < kMostTakenUp && asked.systematics == Systematics::kAuto; ++taken) {
    COLLINEA_TRY(const bool more,
                 take_up_systematics(asked, options.adjust.calibration,
                                     {done.adjusted, done.block, done.scope, done.instruments, done.taken_up}));
    if (!more) break;
    COLLINEA_TRY(adjust_once(task, options, asked, run, done));
  }
  if (asked.variance_components) {
    COLLINEA_TRY(done.components, estimate_variance_components(done.block, done.scope, options, run));
    done.adjusted = done.components->adjusted;
    COLLINEA_TRY(refuse_diverged(done.adjusted, done.block, done.scope, options, run));
    done.block = with_sigmas(done.block, done.components->factors);
  }
  done.additional_level = asked.additional_level;
  done.additional = test_additional(done.block, done.adjusted, options.test.sigma0_known, asked.additional_level);
  done.residual_level = asked.residual_level;
  done.residual_tests = residual_tests(done.block, done.adjusted, options.systematics.strips, asked.residual_level);
  apply(done.adjusted, done.block);
  if (asked.check_rays) {
    COLLINEA_TRY(done.other_check_rays, otherwise(done, options, run));
  }
  return done;
}

}  // namespace collinea
