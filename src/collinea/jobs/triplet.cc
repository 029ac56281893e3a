// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/triplet.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "collinea/camera/camera.h"
#include "collinea/epipolar/intersect_rays.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/image_marks.h"
#include "collinea/jobs/internal/orientation_findings.h"
#include "collinea/jobs/internal/pose_estimates.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A pair of images oriented by itself.
struct OrientedPair {
  RelativeOrientation orientation;
  std::vector<std::size_t> points;  // in the table, of its points
  std::vector<PairPoint> used;
  std::set<std::size_t> rejected;
};

Result<OrientedPair> oriented(const ImageMarks& table, std::size_t first, const Camera& camera,
                              const TripletOptions& options) {
  OrientedPair out;
  std::vector<PairPoint> points;
  for (std::size_t p = 0; p < table.points.size(); ++p) {
    const BundleMark *one = table.find(first, p), *two = table.find(first + 1, p);
    if (!one || !two) continue;
    out.points.push_back(p);
    points.push_back({normalized(camera, one->in_image), normalized(camera, two->in_image),
                      one->sigma / camera.focal_px(), two->sigma / camera.focal_px()});
  }
  const auto in_pair = [&](Error e) {
    return std::move(e).within(fmt::format("images {} and {}", table.images[first], table.images[first + 1]));
  };
  RelativeOptions adjustment = options.adjustment;
  adjustment.sigma_known = table.sigmas_are_stated;
  COLLINEA_TRY(out.orientation, relative_orientation(points, adjustment, options.seed).map_error(in_pair));
  for (const int i : out.orientation.rejected) out.rejected.insert(out.points[static_cast<std::size_t>(i)]);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!out.rejected.contains(out.points[i])) out.used.push_back(points[i]);
  return out;
}

TripletReport::Pair summary(const OrientedPair& pair, const ImageMarks& table) {
  TripletReport::Pair out;
  out.points = pair.points.size();
  out.sigma0 = pair.orientation.sigma0;
  for (const std::size_t p : pair.rejected) out.rejected.push_back(table.points[p]);
  const auto four = relative_solutions(pair.orientation.second_from_first, pair.used);
  for (std::size_t k = 0; k < 4; ++k) out.in_front[k] = four[k].in_front;
  return out;
}

// The measurements that take part in the adjustment of all bundles, and their points.
struct Participants {
  std::vector<BundleMark> marks;
  std::vector<std::size_t> rows;    // of the table, of the marks
  std::vector<std::size_t> points;  // of the table, of the points
  ImageBundles start;
};

Participants taking_part(const ImageMarks& table, const std::set<std::size_t>& rejected_rows, const Camera& camera,
                         const ImageBundles& images, std::vector<std::string>& without_position) {
  Participants out;
  out.start = images;
  out.start.points.clear();
  without_position.clear();
  for (std::size_t p = 0; p < table.points.size(); ++p) {
    std::vector<Rigid3> poses;
    std::vector<Vector2d> rays;
    std::vector<std::size_t> rows;
    for (const std::size_t k : table.marks_of[p]) {
      const BundleMark& mark = table.marks[k];
      if (rejected_rows.contains(k)) continue;
      poses.push_back(images.cam_from_model[mark.image]);
      rays.push_back(normalized(camera, mark.in_image));
      rows.push_back(k);
    }
    if (rows.size() < 2) continue;
    const auto position = intersect_rays(poses, rays);
    if (!position) {
      without_position.push_back(table.points[p]);
      continue;
    }
    for (const std::size_t k : rows) {
      out.marks.push_back(table.marks[k]);
      out.marks.back().point = out.points.size();
      out.rows.push_back(k);
    }
    out.points.push_back(p);
    out.start.points.push_back(*position);
  }
  return out;
}

struct Adjusted {
  AdjustedBundles found;
  Participants participants;
};

// The worst measurement of each point whose test is beyond the limit and beyond half of the largest one: errors of
// different points hardly hide each other, but a large one makes others look wrong.
std::vector<std::size_t> contradicting_marks(const AdjustedBundles& found, const std::vector<BundleMark>& marks,
                                             double limit) {
  std::map<std::size_t, std::size_t> worst_of_point;
  const auto test = [&](std::size_t k) { return found.marks[k].w.cwiseAbs().maxCoeff(); };
  double largest = 0;
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const auto [worst, is_new] = worst_of_point.emplace(marks[k].point, k);
    if (test(k) > test(worst->second)) worst->second = k;
    largest = std::max(largest, test(k));
  }
  std::vector<std::size_t> out;
  for (const auto& [point, k] : worst_of_point)
    if (test(k) > limit && test(k) > largest / 2) out.push_back(k);
  return out;
}

// Least squares of all bundles, again without those that contradict as long as there are any.
Result<Adjusted> adjusted(const ImageMarks& table, std::set<std::size_t>& rejected_rows, ImageBundles images,
                          const Camera& camera, const TripletOptions& options, TripletReport& report) {
  while (true) {
    Adjusted out;
    out.participants = taking_part(table, rejected_rows, camera, images, report.without_position);
    COLLINEA_TRY(out.found, adjust_bundles(out.participants.start, out.participants.marks));
    report.variance = {out.found.sigma0, out.found.redundancy, table.sigmas_are_stated, options.adjustment.alpha};
    if (options.adjustment.rejection == PairRejection::kNone || out.found.redundancy <= 1) return out;
    const std::vector<std::size_t> contradicting =
        contradicting_marks(out.found, out.participants.marks, report.variance.limit() * report.variance.of_tests());
    if (contradicting.empty()) return out;
    for (const std::size_t k : contradicting) rejected_rows.insert(out.participants.rows[k]);
    images.cam_from_model = out.found.bundles.cam_from_model;
  }
}

void state_images(const ImageMarks& table, const AdjustedBundles& model, TripletReport& report) {
  const double factor = report.variance.factor();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    std::vector<Estimate>& exterior = report.images[i].exterior;
    exterior = estimates_of_pose(model.bundles.cam_from_model[i]);
    Eigen::Matrix<double, 6, 6>& covariance = report.images[i].covariance;
    covariance = factor * factor *
                 covariance_of_estimates(model.bundles.cam_from_model[i], model.covariance.block<6, 6>(row, row));
    add_sigmas(exterior, covariance);
    if (i == 0) covariance.setZero();
    for (Estimate& e : exterior) {
      if (e.unit == "m" && !report.base_is_given) e.unit = "";
      if (i == 0) e = {e.name, e.unit, 0, {}};  // the datum
    }
    report.images[i].name = table.images[i];
  }
  // |C3 - C2| over |C2 - C1|, whose length has no error.
  const Vector3d base = centre_of(model.bundles.cam_from_model[2]) - centre_of(model.bundles.cam_from_model[1]);
  Eigen::RowVectorXd by = Eigen::RowVectorXd::Zero(model.covariance.cols());
  by.segment<3>(9) = -base.normalized().transpose();
  by.segment<3>(15) = base.normalized().transpose();
  report.base_ratio = {"base_ratio", "", base.norm() / report.base,
                       factor * std::sqrt((by * model.covariance * by.transpose())(0, 0)) / report.base};
}

void state_points(const ImageMarks& table, const Adjusted& adjusted, const AdjustedBundles& model,
                  TripletReport& report) {
  const double factor = report.variance.factor();
  std::vector<int> rays(adjusted.participants.points.size(), 0);
  for (const BundleMark& mark : adjusted.participants.marks) ++rays[mark.point];
  for (std::size_t p = 0; p < adjusted.participants.points.size(); ++p)
    report.points.push_back({table.points[adjusted.participants.points[p]], model.bundles.points[p],
                             factor * factor * model.point_covariances[p], rays[p]});
  const Vector2d axes(1, report.frame.y_up ? -1 : 1);
  std::vector<const BundleMarkTest*> tests(table.marks.size(), nullptr);
  for (std::size_t k = 0; k < adjusted.participants.rows.size(); ++k)
    tests[adjusted.participants.rows[k]] = &adjusted.found.marks[k];
  for (std::size_t k = 0; k < table.marks.size(); ++k) {
    const BundleMark& mark = table.marks[k];
    TripletReport::Mark row{table.images[mark.image], table.points[mark.point], {}, tests[k] == nullptr};
    if (tests[k]) {
      row.test.misfit = tests[k]->misfit.cwiseProduct(axes);
      row.test.w = tests[k]->w.cwiseProduct(axes) / report.variance.of_tests();
      row.test.redundancy = tests[k]->redundancy;
    } else {
      const auto at =
          std::lower_bound(adjusted.participants.points.begin(), adjusted.participants.points.end(), mark.point);
      row.test.misfit.setConstant(NAN);
      if (at != adjusted.participants.points.end() && *at == mark.point) {
        const Vector3d& point = adjusted.found.bundles.points[std::size_t(at - adjusted.participants.points.begin())];
        const auto seen = project(report.frame.camera, adjusted.found.bundles.cam_from_model[mark.image] * point);
        if (seen) row.test.misfit = (mark.in_image - *seen).cwiseProduct(axes);
      }
    }
    report.marks.push_back(std::move(row));
  }
}

Eigen::Matrix3d calibration_of(const Camera& camera) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = k(1, 1) = camera.focal_px();
  k(0, 2) = camera.params[Camera::kCx];
  k(1, 2) = camera.params[Camera::kCy];
  return k;
}

std::vector<TriplePoint> common_points(const ImageMarks& table, const Camera& camera,
                                       const std::set<std::size_t>& rejected_points) {
  std::vector<TriplePoint> out;
  for (std::size_t p = 0; p < table.points.size(); ++p) {
    const BundleMark *one = table.find(0, p), *two = table.find(1, p), *three = table.find(2, p);
    if (one && two && three && !rejected_points.contains(p))
      out.push_back(
          {normalized(camera, one->in_image), normalized(camera, two->in_image), normalized(camera, three->in_image)});
  }
  return out;
}

Result<TripletReport> joined(const ImageMarks& table, const PhotoFrame& frame, const TripletOptions& options) {
  if (table.images.size() != 3)
    return fail(Errc::kBadInput, fmt::format("three images are joined, the table has {}", table.images.size()));
  TripletReport report;
  report.frame = frame;
  report.base_is_given = options.base_m.has_value();
  report.base = options.base_m.value_or(1);
  COLLINEA_TRY(const OrientedPair first, oriented(table, 0, frame.camera, options));
  COLLINEA_TRY(const OrientedPair second, oriented(table, 1, frame.camera, options));
  report.pairs = {summary(first, table), summary(second, table)};
  std::set<std::size_t> rejected = first.rejected;
  rejected.insert(second.rejected.begin(), second.rejected.end());
  const std::vector<TriplePoint> common = common_points(table, frame.camera, rejected);
  report.common = common.size();
  const auto three =
      join_three_images(first.orientation.second_from_first, second.orientation.second_from_first, common);
  if (!three)
    return fail(Errc::kIllPosed,
                fmt::format("{} points common to all three images do not join the pairs: two with depth in both are "
                            "needed, most of them in front of all images",
                            common.size()));
  report.joined = *three;
  // A measurement that a pair rejects may be right in the other image: the point leaves with all of its rays.
  std::set<std::size_t> rejected_rows;
  for (std::size_t k = 0; k < table.marks.size(); ++k)
    if (rejected.contains(table.marks[k].point)) rejected_rows.insert(k);
  const ImageBundles images{
      calibration_of(frame.camera), {Rigid3{}, three->second_from_first, three->third_from_first}, {}};
  COLLINEA_TRY(const Adjusted result, adjusted(table, rejected_rows, images, frame.camera, options, report));
  report.conditioning = result.found.conditioning;
  report.iterations = result.found.iterations;
  const AdjustedBundles model = in_photo_axes(result.found, report.base);
  state_images(table, model, report);
  state_points(table, result, model, report);
  report.findings = triplet_findings(report);
  return report;
}

}  // namespace

Result<TripletReport> orient_triplet(const std::filesystem::path& measurements, const TripletOptions& options) {
  COLLINEA_TRY(validate(options));
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  const std::string stated = table.unit_of("x");
  const std::string unit = stated.empty() || stated == "px" ? "px" : "mm";
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, unit));
  COLLINEA_TRY(const ImageMarks marks, read_image_marks(table, frame, options.sigma).map_error(in_file));
  return joined(marks, frame, options).map_error(in_file);
}

}  // namespace collinea
