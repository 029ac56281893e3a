// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/block/instrument_options.h"
#include "collinea/epipolar/robust_start.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// Whether measurements are corrected for refraction.
enum class RefractionChoice { kAuto, kOn, kOff };
inline constexpr Word<RefractionChoice> kRefractionChoiceWords[] = {
    {RefractionChoice::kAuto, "auto", "where it moves the corner of an image by more than 0.05 px"},
    {RefractionChoice::kOn, "on"},
    {RefractionChoice::kOff, "off"}};
[[nodiscard]] constexpr std::span<const Word<RefractionChoice>> words(RefractionChoice) {
  return kRefractionChoiceWords;
}

/// What an adjustment takes differently of receivers and inertial systems than orientation, or the file, has it.
struct InstrumentChanges {
  std::optional<LeverArmOption> lever_arm;
  std::optional<PositionShift> position_shift;
  std::optional<bool> position_drift, time_offset, use_attitudes;
  std::optional<double> attitude_sigma_deg, heading_sigma_deg;

  template <class Visit>
  static void describe(Visit&& visit) {
    describe_instruments<InstrumentChanges>(visit, Choice{"auto", "as orient, or the file, has it"});
  }
};

/// What was, with what changes.
[[nodiscard]] InstrumentOptions changed(InstrumentOptions instruments, const InstrumentChanges& changes);

/// How an oriented block, or the measurements of a file, are adjusted with the full model.
struct AdjustmentOptions {
  std::optional<Calibration> calibration;
  RobustStart start = RobustStart::kTruncated;
  std::optional<AdditionalSet> additional;
  std::string additional_fixed;
  double additional_level = 0.01;
  RefractionChoice refraction = RefractionChoice::kAuto;
  std::optional<double> deflection_north_arcsec, deflection_east_arcsec;
  std::optional<Loss::Kind> loss, position_loss;
  double loss_scale_sigmas = 2;
  std::optional<bool> weigh_ties;
  bool use_positions = true;
  bool use_control = true;
  bool use_geodetic = true;
  std::optional<bool> check_rays;
  std::string datum_points;
  InstrumentChanges instruments;
  bool given_sigmas = false;
  bool reject_mismatches = false;
  std::optional<bool> snoop;
  bool snoop_given = false;
  int snoop_most = 1000;
  bool variance_components = false;
  bool tie_residuals = false;
  Systematics systematics = Systematics::kAuto;
  double systematics_level = 0.001;
  double residual_level = 0.001;
  TestOptions tests;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = AdjustmentOptions;
    visit(
        Field{"calibration", &O::calibration, "", "free camera parameters"}.or_auto("those of orient, or of the file"));
    visit(
        Field{"start", &O::start, "",
              "by what poses are found that a file of measurements does not state: how much of what an image shows of "
              "known points may be grossly wrong"});
    visit(Field{"additional", &O::additional, "",
                "additional parameters of every camera, on top of its model, also of one that was given"}
              .or_auto("those it has"));
    visit(Field{"additional_fixed", &O::additional_fixed, "",
                "those of them that are fixed at zero, separated by commas: a3,a7"});
    visit(Field{"additional_level", &O::additional_level, "1",
                "chance that one that is zero is called significant; of 44 less than one is then", 1e-12, 0.5});
    visit(Field{"refraction", &O::refraction, "",
                "correct the measurements for the refraction of a standard atmosphere"});
    visit(Field{"deflection_north_arcsec", &O::deflection_north_arcsec, "arcsec",
                "deflection of the vertical in the block, xi: by how much the plumb line points north of the "
                "ellipsoid's normal; of zenith angles, directions, azimuths and height differences",
                -300, 300});
    visit(
        Field{"deflection_east_arcsec", &O::deflection_east_arcsec, "arcsec", "the same to the east, eta", -300, 300});
    visit(Field{"loss", &O::loss, "", "robust loss of tie points and positions"}.or_auto(
        "huber; of the tie points of a project none: their wrong matches are out"));
    visit(Field{"position_loss", &O::position_loss, "", "another one of positions"}.or_auto(
        "that of tie points where it is given, or huber"));
    visit(
        Field{"loss_scale_sigmas", &O::loss_scale_sigmas, "sigma", "residual from which the loss sets in", 0.01, 1e6});
    visit(Field{"weigh_ties", &O::weigh_ties, "",
                "weigh every measurement of a tie point by its own error, as Student's distribution of all of them has "
                "it (yes, and if not given of film), instead of alike (no); without a loss"});
    visit(Field{"use_positions", &O::use_positions, "", "use the positions of images where orient did"});
    visit(Field{"use_control", &O::use_control, "",
                "use control points where orient did; otherwise they are all check points"});
    visit(Field{"use_geodetic", &O::use_geodetic, "",
                "use what was measured between control points where orient did; otherwise it is only compared"});
    visit(Field{"check_rays", &O::check_rays, "",
                "image measurements of check points take part, as those of tie points (yes), or not (no, and if not "
                "given). Given either way the report compares check points with and without"});
    visit(Field{"datum_points", &O::datum_points, "",
                "points that carry the datum of a free network, separated by commas: names of control and check "
                "points, numbers of tie points. Not given: all tie points"});
    visit(
        Field{"given_sigmas", &O::given_sigmas, "",
              "take the sigmas of control and the coordinates of positions as they were given, also where orient found "
              "them contradicted"});
    visit(Field{"reject_mismatches", &O::reject_mismatches, "",
                "reject measurements of tie points that are more probably of another point than as imprecise as the "
                "others, all in one round; orient has done so once"});
    visit(Field{
        "snoop", &O::snoop, "",
        "reject the worst suspect and adjust again, until none is left; measurements of control that orient "
        "rejected are tried again. Of a project what is given (control, positions, ...) is examined so unless this is "
        "no"});
    visit(Field{"snoop_given", &O::snoop_given, "",
                "reject only what is given, no tie points, as of a project without snoop"});
    visit(Field{"snoop_most", &O::snoop_most, "1", "upper bound of what snooping rejects", 1, 1000000});
    visit(Field{"variance_components", &O::variance_components, "",
                "estimate the standard deviations of each group of observations, and use them"});
    visit(Field{"tie_residuals", &O::tie_residuals, "",
                "write tie_residuals.csv: residual, redundancy number and test of every measurement of a tie point"});
    visit(Field{"systematics", &O::systematics, "",
                "errors that many observations have in common: instruments, vertical datum, cameras, atmosphere"});
    visit(Field{"systematics_level", &O::systematics_level, "1", "chance that any of them is named in a block without",
                1e-12, 0.5});
    visit(Field{"residual_level", &O::residual_level, "1",
                "chance that any test of the order and distribution of residuals is significant by accident", 1e-12,
                0.5});
    visit(Part{&O::tests});
    visit(Group{"adjust_instruments", &O::instruments});
  }
};

}  // namespace collinea
