// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/rotation.h"

#include <fmt/format.h>

#include <numbers>
#include <vector>

#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/number_rows.h"

namespace collinea {
namespace {

constexpr double radians_in(AngleUnit unit) {
  return unit == AngleUnit::kDegree ? std::numbers::pi / 180 : unit == AngleUnit::kGon ? std::numbers::pi / 200 : 1;
}

std::size_t count_of(RotationForm form) {
  return form == RotationForm::kMatrix ? 9 : form == RotationForm::kQuaternion ? 4 : 3;
}

Result<Eigen::Matrix3d> matrix_of(const std::vector<double>& n, RotationForm form, double unit) {
  switch (form) {
    case RotationForm::kCardan:
      return rotation_matrix(CardanAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kEuler:
      return rotation_matrix(EulerAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kTopographic:
      return rotation_matrix(TopographicAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kGeodetic:
      return rotation_matrix(GeodeticAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kRodrigues:
      return rotation_matrix(RodriguesParameters{n[0], n[1], n[2]});
    case RotationForm::kQuaternion: {
      const Eigen::Quaterniond q(n[0], n[1], n[2], n[3]);
      if (!(q.norm() > 1e-12)) return fail(Errc::kBadInput, "a quaternion of length 0 is no rotation");
      return rotation_matrix(q);
    }
    case RotationForm::kMatrix:
      break;
  }
  Eigen::Matrix3d matrix;
  matrix << n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8];
  return matrix;
}

}  // namespace

Result<RotationReport> convert_rotation(const std::string& numbers, const ConvertRotationOptions& options) {
  COLLINEA_TRY(const auto values, parse_numbers(numbers));
  if (values.size() != count_of(options.from))
    return fail(Errc::kBadInput,
                fmt::format("{} numbers are given, {} is {}", values.size(), word_of(options.from),
                            words(options.from)[static_cast<std::size_t>(options.from)].meaning),
                {"from"_option});
  const double unit = radians_in(options.unit);
  COLLINEA_TRY(const Eigen::Matrix3d given, matrix_of(values, options.from, unit));
  const auto rotation = rotation_nearest_to(given);
  constexpr double kRough = 0.1;
  if (!rotation || orthonormality_error(given) > kRough)
    return fail(
        Errc::kBadInput,
        "the matrix is not that of a rotation: its rows are not of length 1 and at right angles, or it mirrors");
  RotationReport report;
  report.matrix = *rotation;
  report.given_error = orthonormality_error(given);
  report.unit = word_of(options.unit);
  const CardanAngles c = cardan_angles(*rotation);
  const EulerAngles e = euler_angles(*rotation);
  const TopographicAngles t = topographic_angles(*rotation);
  const GeodeticAngles g = geodetic_angles(*rotation);
  const Eigen::Quaterniond q = unit_quaternion(*rotation);
  const auto add = [&](const char* form, std::vector<const char*> names, const std::vector<double>& angles,
                       double divisor, bool is_singular) {
    RotationReport::Form out{form, {}, is_singular};
    for (std::size_t i = 0; i < names.size(); ++i) out.values.emplace_back(names[i], angles[i] / divisor);
    report.forms.push_back(std::move(out));
  };
  add("cardan", {"omega", "phi", "kappa"}, {c.omega_rad, c.phi_rad, c.kappa_rad}, unit, c.is_singular);
  add("euler", {"precession", "nutation", "spin"}, {e.precession_rad, e.nutation_rad, e.spin_rad}, unit, e.is_singular);
  add("topographic", {"azimuth", "zenith", "roll"}, {t.azimuth_rad, t.zenith_rad, t.roll_rad}, unit, t.is_singular);
  add("geodetic", {"latitude", "longitude", "azimuth"}, {g.latitude_rad, g.longitude_rad, g.azimuth_rad}, unit,
      g.is_singular);
  if (const auto p = rodrigues_parameters(*rotation))
    add("rodrigues", {"a", "b", "c"}, {p->a, p->b, p->c}, 1, false);
  else
    add("rodrigues", {}, {}, 1, true);
  add("quaternion", {"w", "x", "y", "z"}, {q.w(), q.x(), q.y(), q.z()}, 1, false);
  return report;
}

}  // namespace collinea
