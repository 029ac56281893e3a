// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/words.h"
#include "collinea/epipolar/given_coplanarity.h"
#include "collinea/epipolar/model_points.h"
#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/pair_shape.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/epipolar/scaled_pair.h"
#include "collinea/io/photo_frame.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// In which form a relative orientation is written.
enum class RelativeForm : std::uint8_t { kDependent, kSymmetric, kExterior };
inline constexpr Word<RelativeForm> kRelativeFormWords[] = {
    {RelativeForm::kDependent, "dependent", "base and attitude of the second image, in the first one"},
    {RelativeForm::kSymmetric, "symmetric", "attitudes of both images, with the base as x axis"},
    {RelativeForm::kExterior, "exterior", "projection centres and attitudes of both images"}};
[[nodiscard]] constexpr std::span<const Word<RelativeForm>> words(RelativeForm) { return kRelativeFormWords; }

/// The relative orientation of a pair, as found from a table.
struct RelativeReport {
  PhotoFrame frame;
  std::optional<double> second_principal_distance;  ///< of the second image; nothing: as of the first
  std::vector<std::string> names;
  std::vector<PairPoint> points;
  RelativeOptions options;
  double sigma = 0;  ///< of a coordinate where the table gives none, in its unit
  bool sigma_is_given = false;
  double base = 1;
  bool base_is_given = false;                   ///< then it is in m
  bool is_given = false;                        ///< the orientation: points are only compared with it
  std::optional<RelativeForm> given_form;       ///< where elements were given as such, and nothing was solved
  std::optional<GivenCoplanarity> coplanarity;  ///< of the points for them
  RelativeOrientation orientation;
  std::optional<PairShape> shape;
  std::optional<RelativeOrientation> second;  ///< the other one of points in or near a plane (second_orientation())
  std::optional<LinearOrientation> linear;    ///< of the points used, where it was the start
  PairModel model;                            ///< x right, y up, z backwards
  std::array<RelativeSolution, 4> solutions;  ///< by the points used; the first one is the orientation
  /// Exterior orientation of the second image in the model: X, Y, Z (in the unit of the base), omega, phi, kappa [deg].
  /// The first image stands at 0. The covariance holds sigma0 where sigmas were not given, and the base's where
  /// distances gave it.
  Eigen::Matrix<double, 6, 1> right_pose = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> right_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  struct Distance {
    std::string from, to;
    double length_m = 0, sigma_m = 0;
  };
  std::vector<Distance> distances;   ///< measured on the object
  std::optional<ScaledPair> scaled;  ///< by them; orientation, base and model are those of it
  std::vector<Finding> findings;
};

/// For a terminal: elements with standard deviations and correlations, residuals, tests, the geometry of the pair.
[[nodiscard]] std::string relative_text(const RelativeReport& report);

/// The same, of the residuals those of at most so many rejected points alone, the largest tests first.
[[nodiscard]] std::string relative_summary_text(const RelativeReport& report, std::size_t most_rejected);

/// element value sigma unit, of the dependent and the symmetric form.
[[nodiscard]] TextTable relative_parameter_table(const RelativeReport& report);
/// element linear sigma rigorous difference unit: the simplified orientation beside the rigorous one.
[[nodiscard]] TextTable relative_linear_table(const RelativeReport& report);
/// point parallax: residual y-parallaxes of the simplified orientation, of the points used.
[[nodiscard]] TextTable relative_linear_parallax_table(const RelativeReport& report);
/// What is known of the geometry of a pair that leaves no orientation: conditioning, null vector, surfaces.
[[nodiscard]] std::string pair_shape_text(const RelativeReport& report);
/// form element other correlation, of the dependent and the symmetric form.
[[nodiscard]] TextTable relative_correlation_table(const RelativeReport& report);
/// solution form element value unit in_front: the four solutions, the chosen one first.
[[nodiscard]] TextTable relative_solutions_table(const RelativeReport& report);
/// point, four residuals, y-parallax, redundancy number, standardised residual, used or rejected.
[[nodiscard]] TextTable relative_residual_table(const RelativeReport& report);
/// point U V W with standard deviations, correlations and the length of the spatial parallax.
[[nodiscard]] TextTable relative_model_table(const RelativeReport& report);
/// image X Y Z omega phi kappa of both images in the model, with standard deviations and correlations.
[[nodiscard]] TextTable relative_exterior_table(const RelativeReport& report);
/// solution form element value unit: counts of the exhaustive search, and the orientations that fit as well as the
/// best.
[[nodiscard]] TextTable relative_search_table(const RelativeReport& report);
/// point dependent symmetric exterior sigma gap w: the coplanarity condition for given elements in its three forms.
[[nodiscard]] TextTable relative_coplanarity_table(const RelativeReport& report);
/// The points seen along the base, with the nearest critical cylinder and the nearest plane through the base, and seen
/// along the plane that fits them best: an SVG.
[[nodiscard]] std::string pair_shape_svg(const RelativeReport& report);

}  // namespace collinea
