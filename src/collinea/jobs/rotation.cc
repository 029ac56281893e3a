// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/rotation.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/geometry/rotation_derivatives.h"
#include "collinea/io/number_rows.h"

namespace collinea {
namespace {

using Eigen::MatrixXd;

constexpr double radians_in(AngleUnit unit) {
  return unit == AngleUnit::kDegree ? std::numbers::pi / 180 : unit == AngleUnit::kGon ? std::numbers::pi / 200 : 1;
}

std::size_t count_of(RotationForm form) {
  return form == RotationForm::kMatrix ? 9 : form == RotationForm::kQuaternion ? 4 : 3;
}

bool has_angles(RotationForm form) {
  return form != RotationForm::kMatrix && form != RotationForm::kQuaternion && form != RotationForm::kRodrigues;
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

// The covariance of the numbers, of angles in radians.
Result<MatrixXd> covariance_of_numbers(const ConvertRotationOptions& options) {
  const std::size_t count = count_of(options.from);
  COLLINEA_TRY(const auto sigmas, parse_numbers(*options.sigmas));
  if (sigmas.size() != count || *std::min_element(sigmas.begin(), sigmas.end()) < 0)
    return fail(Errc::kBadInput, fmt::format("{} standard deviations are wanted, none below 0", count),
                {"sigmas"_option});
  std::vector<double> correlations(count * (count - 1) / 2, 0);
  if (options.correlations) {
    COLLINEA_TRY(correlations, parse_numbers(*options.correlations));
    if (correlations.size() != count * (count - 1) / 2)
      return fail(Errc::kBadInput, fmt::format("{} correlations are wanted", count * (count - 1) / 2),
                  {"correlations"_option});
  }
  const auto size = static_cast<Eigen::Index>(count);
  MatrixXd correlation = MatrixXd::Identity(size, size);
  auto next = correlations.begin();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = i + 1; j < size; ++j) correlation(i, j) = correlation(j, i) = *next++;
  constexpr double kRounding = 1e-6;  // correlations of a table have some digits
  if (!(Eigen::SelfAdjointEigenSolver<MatrixXd>(correlation).eigenvalues()[0] > -kRounding))
    return fail(Errc::kBadInput, "the correlations are those of no covariance", {"correlations"_option});
  const double unit = has_angles(options.from) ? radians_in(options.unit) : 1;
  const Eigen::VectorXd scale = unit * Eigen::Map<const Eigen::VectorXd>(sigmas.data(), size);
  return MatrixXd(scale.asDiagonal() * correlation * scale.asDiagonal());
}

// The rotation vector by the numbers.
MatrixXd turn_of(const std::vector<double>& n, RotationForm form, double unit, const Eigen::Matrix3d& rotation) {
  switch (form) {
    case RotationForm::kCardan:
      return turn_by(CardanAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kEuler:
      return turn_by(EulerAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kTopographic:
      return turn_by(TopographicAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kGeodetic:
      return turn_by(GeodeticAngles{unit * n[0], unit * n[1], unit * n[2]});
    case RotationForm::kRodrigues:
      return turn_by(RodriguesParameters{n[0], n[1], n[2]});
    case RotationForm::kQuaternion:
      return turn_by(Eigen::Quaterniond(n[0], n[1], n[2], n[3]));
    case RotationForm::kMatrix:
      break;
  }
  return turn_by(rotation);
}

// All forms but the matrix itself, with the covariance where that of the rotation vector is known.
class Forms {
 public:
  Forms(double unit, const std::optional<Eigen::Matrix3d>& of_turn) : unit_(unit), of_turn_(of_turn) {}

  void add(const char* form, std::vector<const char*> names, const std::vector<double>& values, bool is_angle,
           const MatrixXd& by_rotation, bool is_singular) {
    const double unit = is_angle ? unit_ : 1;
    RotationReport::Form out{form, {}, is_singular};
    for (std::size_t i = 0; i < names.size(); ++i) out.values.emplace_back(names[i], values[i] / unit);
    if (of_turn_ && !is_singular) out.covariance = by_rotation * *of_turn_ * by_rotation.transpose() / (unit * unit);
    forms_.push_back(std::move(out));
  }
  [[nodiscard]] std::vector<RotationReport::Form> take() { return std::move(forms_); }

 private:
  double unit_;
  std::optional<Eigen::Matrix3d> of_turn_;
  std::vector<RotationReport::Form> forms_;
};

std::vector<RotationReport::Form> forms_of(const Eigen::Matrix3d& rotation, double unit,
                                           const std::optional<Eigen::Matrix3d>& of_turn) {
  const CardanAngles c = cardan_angles(rotation);
  const EulerAngles e = euler_angles(rotation);
  const TopographicAngles t = topographic_angles(rotation);
  const GeodeticAngles g = geodetic_angles(rotation);
  const Eigen::Quaterniond q = unit_quaternion(rotation);
  Forms forms(unit, of_turn);
  forms.add("cardan", {"omega", "phi", "kappa"}, {c.omega_rad, c.phi_rad, c.kappa_rad}, true, turn_by(c).inverse(),
            c.is_singular);
  forms.add("euler", {"precession", "nutation", "spin"}, {e.precession_rad, e.nutation_rad, e.spin_rad}, true,
            turn_by(e).inverse(), e.is_singular);
  forms.add("topographic", {"azimuth", "zenith", "roll"}, {t.azimuth_rad, t.zenith_rad, t.roll_rad}, true,
            turn_by(t).inverse(), t.is_singular);
  forms.add("geodetic", {"latitude", "longitude", "azimuth"}, {g.latitude_rad, g.longitude_rad, g.azimuth_rad}, true,
            turn_by(g).inverse(), g.is_singular);
  if (const auto p = rodrigues_parameters(rotation))
    forms.add("rodrigues", {"a", "b", "c"}, {p->a, p->b, p->c}, false, turn_by(*p).inverse(), false);
  else
    forms.add("rodrigues", {}, {}, false, MatrixXd(), true);
  forms.add("quaternion", {"w", "x", "y", "z"}, {q.w(), q.x(), q.y(), q.z()}, false, by_rotation(q), false);
  return forms.take();
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
  if (options.correlations && !options.sigmas)
    return fail(Errc::kBadInput, "correlations are of no use without standard deviations", {"sigmas"_option});
  std::optional<Eigen::Matrix3d> of_turn;
  if (options.sigmas) {
    COLLINEA_TRY(const MatrixXd of_numbers, covariance_of_numbers(options));
    const MatrixXd turn = turn_of(values, options.from, unit, *rotation);
    of_turn = turn * of_numbers * turn.transpose();
    const Eigen::Matrix<double, 9, 3> by = by_rotation(*rotation);
    const Eigen::Matrix<double, 9, 1> sigmas = (by * *of_turn * by.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
    report.sigma_matrix = sigmas.reshaped<Eigen::RowMajor>(3, 3);
  }
  report.forms = forms_of(*rotation, unit, of_turn);
  return report;
}

}  // namespace collinea
