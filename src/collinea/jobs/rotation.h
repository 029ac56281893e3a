// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/report/rotation_report.h"

namespace collinea {

enum class RotationForm : std::uint8_t { kCardan, kEuler, kTopographic, kGeodetic, kRodrigues, kQuaternion, kMatrix };
inline constexpr Word<RotationForm> kRotationFormWords[] = {
    {RotationForm::kCardan, "cardan", "omega,phi,kappa"},
    {RotationForm::kEuler, "euler", "precession,nutation,spin"},
    {RotationForm::kTopographic, "topographic", "azimuth,zenith,roll"},
    {RotationForm::kGeodetic, "geodetic", "latitude,longitude,azimuth"},
    {RotationForm::kRodrigues, "rodrigues", "a,b,c"},
    {RotationForm::kQuaternion, "quaternion", "w,x,y,z"},
    {RotationForm::kMatrix, "matrix", "nine elements, row by row"}};
[[nodiscard]] constexpr std::span<const Word<RotationForm>> words(RotationForm) { return kRotationFormWords; }

enum class AngleUnit : std::uint8_t { kDegree, kGon, kRadian };
inline constexpr Word<AngleUnit> kAngleUnitWords[] = {
    {AngleUnit::kDegree, "deg"}, {AngleUnit::kGon, "gon"}, {AngleUnit::kRadian, "rad"}};
[[nodiscard]] constexpr std::span<const Word<AngleUnit>> words(AngleUnit) { return kAngleUnitWords; }

struct ConvertRotationOptions {
  RotationForm from = RotationForm::kCardan;
  AngleUnit unit = AngleUnit::kDegree;
  std::optional<std::string> sigmas, correlations;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ConvertRotationOptions;
    visit(Field{"from", &O::from, "", "what the numbers are"});
    visit(Field{"unit", &O::unit, "", "of the angles, given and shown"});
    visit(Field{"sigmas", &O::sigmas, "",
                "standard deviations of the numbers, with commas between, of angles in their unit; every form then "
                "has its own"});
    visit(Field{"correlations", &O::correlations, "",
                "of the numbers, with commas between: of the first with the second, the third ..., then of the second "
                "with the third ...; nothing: 0"});
  }
};

/// The same rotation in every form, with standard deviations and correlations where those of the numbers are given; a
/// form at a singular attitude has none. Errors: numbers; a matrix that is none of a rotation, even roughly; standard
/// deviations and correlations that are no covariance.
[[nodiscard]] Result<RotationReport> convert_rotation(const std::string& numbers,
                                                      const ConvertRotationOptions& options);

}  // namespace collinea
