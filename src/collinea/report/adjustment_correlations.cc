// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "collinea/math/median.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr double kStrong = 0.9;    // each is then known two and more times worse than with the other given
constexpr std::size_t kShown = 6;  // pairs of a pose
constexpr int kOfPose = 6;
using PoseNames = std::array<const char*, kOfPose>;
constexpr PoseNames kPoseNames = {
    "rotation about east", "rotation about north", "rotation about up", "east", "north", "height"};
constexpr PoseNames kAngleNames = {"omega", "phi", "kappa", "east", "north", "height"};
constexpr const char* kSense =
    "Rotations are those of the world before the camera, right-handed about the axes of the world frame; omega, phi "
    "and kappa turn the camera about the same axes, so that for images that look down their correlations have the "
    "opposite sign.";

// What a parameter of a camera goes with: the six of a pose, then its angles.
const char* name_of_pose(int of_pose) {
  return of_pose < kOfPose ? kPoseNames[std::size_t(of_pose)] : kAngleNames[std::size_t(of_pose - kOfPose)];
}

double correlation(const auto& covariance, int a, int b) {
  return covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
}

// Of omega, phi, kappa and the centre of each image, in the world.
std::map<ImageId, Matrix6d> angle_covariances(const AdjustmentReport& report) {
  std::map<ImageId, Matrix6d> covariances;
  for (const auto& [id, covariance] : report.adjusted.pose_covariance)
    if (const auto pose = find_pose(report.block, id))
      covariances[id] = covariance_of_angles(covariance, pose->rotation);
  return covariances;
}

// One pair of a pose, over all images.
struct PosePair {
  int a = 0, b = 0;
  double typical = 0, strongest = 0;  // median of the amounts; with its sign
  ImageId image;                      // that has the strongest
};

std::vector<PosePair> pose_pairs(const std::map<ImageId, Matrix6d>& covariances) {
  std::vector<PosePair> pairs;
  if (covariances.empty()) return pairs;
  for (int a = 1; a < kOfPose; ++a)
    for (int b = 0; b < a; ++b) {
      PosePair pair{a, b};
      std::vector<double> amounts;
      for (const auto& [id, covariance] : covariances) {
        const double value = correlation(covariance, a, b);
        if (!std::isfinite(value)) continue;
        amounts.push_back(std::abs(value));
        if (amounts.size() > 1 && std::abs(value) <= std::abs(pair.strongest)) continue;
        pair.strongest = value;
        pair.image = id;
      }
      if (amounts.empty()) continue;
      pair.typical = median(amounts);
      pairs.push_back(pair);
    }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const PosePair& x, const PosePair& y) { return x.typical > y.typical; });
  return pairs;
}

// The parameters of a camera that were estimated.
std::vector<int> free_of(const MatrixPd& covariance) {
  std::vector<int> free;
  for (int k = 0; k < covariance.rows(); ++k)
    if (covariance(k, k) > 0) free.push_back(k);
  return free;
}

std::string camera_table(const Camera& camera, const MatrixPd& covariance) {
  const std::vector<int> free = free_of(covariance);
  if (free.size() < 2) return "";
  std::pair<int, int> strongest{free[1], free[0]};
  std::string rows;
  for (const int k : free) {
    rows += "<tr>" + text_cell(param_name(k));
    for (const int other : free) {
      if (other >= k) {
        rows += other == k ? "<td>1</td>" : "<td></td>";
        continue;
      }
      const double value = correlation(covariance, k, other);
      if (std::abs(value) > std::abs(correlation(covariance, strongest.first, strongest.second)))
        strongest = {k, other};
      rows += fmt::format("<td{}>{:+.2f}</td>", std::abs(value) > kStrong ? " class=\"bad\"" : "", value);
    }
    rows += "</tr>\n";
  }
  std::string html = fmt::format("<p>{}: strongest between {} and {}, {:+.3f}.</p>\n<table><thead><tr><th></th>",
                                 escaped(camera.name), param_name(strongest.first), param_name(strongest.second),
                                 correlation(covariance, strongest.first, strongest.second));
  for (const int k : free) html += fmt::format("<th>{}</th>", param_name(k));
  return html + "</tr></thead><tbody>\n" + rows + "</tbody></table>\n";
}

std::string in_words(const CameraPoseCorrelation& one, const AdjustmentReport& report) {
  constexpr std::array<const char*, kOfPose + 3> kWords = {"rotation about east",
                                                           "rotation about north",
                                                           "rotation about up",
                                                           "easting",
                                                           "northing",
                                                           "height",
                                                           "omega",
                                                           "phi",
                                                           "kappa"};
  return fmt::format("{} and the {} of {} ({:+.2f})", param_name(one.param), kWords[std::size_t(one.of_pose)],
                     report.block.images.at(one.image).file, one.correlation);
}

// The strongest correlation of each parameter of one camera with the poses of its images, in words.
std::string camera_pose_table(const AdjustmentReport& report, CameraId camera) {
  std::string rows, words;
  std::vector<CameraPoseCorrelation> strongest;
  for (const CameraPoseCorrelation& one : report.adjusted.camera_pose_correlations) {
    if (one.camera != camera) continue;
    if (one.of_pose == 0) {
      rows += (rows.empty() ? "<tr>" : "</tr>\n<tr>") + text_cell(param_name(one.param));
      strongest.push_back(one);
    }
    if (std::abs(one.correlation) > std::abs(strongest.back().correlation)) strongest.back() = one;
    rows +=
        fmt::format("<td{}>{:+.2f}</td>", std::abs(one.correlation) > kStrong ? " class=\"bad\"" : "", one.correlation);
  }
  if (rows.empty()) return "";
  std::stable_sort(strongest.begin(), strongest.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.correlation) > std::abs(b.correlation); });
  for (std::size_t i = 0; i < std::min(kShown, strongest.size()); ++i)
    words += (i > 0 ? "; " : "") + in_words(strongest[i], report);
  std::string html = "<p>" + escaped(report.block.cameras.at(camera).name) +
                     " with the poses of its images, in the image where it is strongest: " + escaped(words) +
                     ".</p>\n<table><thead><tr><th></th>";
  for (int i = 0; i < kOfPose + 3; ++i) html += fmt::format("<th>{}</th>", name_of_pose(i));
  return html + "</tr></thead><tbody>\n" + rows + "</tr>\n</tbody></table>\n";
}

std::string pair_table(const AdjustmentReport& report, const char* what, const PoseNames& names,
                       const std::vector<PosePair>& pairs) {
  if (pairs.empty()) return "";
  std::string html = fmt::format(
      "<p>{}</p>\n<table><thead><tr><th class=\"l\">pair</th><th>median amount</th><th>strongest</th><th "
      "class=\"l\">in</th></tr></thead><tbody>\n",
      what);
  for (std::size_t i = 0; i < std::min(kShown, pairs.size()); ++i) {
    const PosePair& pair = pairs[i];
    html += "<tr>" + text_cell(fmt::format("{}, {}", names[std::size_t(pair.b)], names[std::size_t(pair.a)])) +
            cell(pair.typical, 2) + fmt::format("<td>{:+.3f}</td>", pair.strongest) +
            text_cell(report.block.images.at(pair.image).file) + "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

json pairs_json(const PoseNames& names) {
  json pairs = json::array();
  for (std::size_t a = 1; a < kOfPose; ++a)
    for (std::size_t b = 0; b < a; ++b) pairs.push_back({names[b], names[a]});
  return pairs;
}

json correlations_json(const Matrix6d& covariance) {
  json values = json::array();
  for (int a = 1; a < kOfPose; ++a)
    for (int b = 0; b < a; ++b) values.push_back(number(correlation(covariance, a, b)));
  return values;
}

}  // namespace

std::string correlation_section(const AdjustmentReport& report) {
  std::string html;
  for (const auto& [id, covariance] : report.adjusted.camera_covariance)
    if (!is_deformed_film(report.block.cameras.at(id)))  // that are polynomials, of every scan others
      html += camera_table(report.block.cameras.at(id), covariance) + camera_pose_table(report, id);
  html += pair_table(report, "Of the poses: the strongest pairs, over all images.", kPoseNames,
                     pose_pairs(report.adjusted.pose_covariance)) +
          pair_table(report, "The same with the angles.", kAngleNames, pose_pairs(angle_covariances(report)));
  if (html.empty()) return "";
  return fmt::format(
             "<section><h2>Correlations</h2>\n<p>Between the parameters of each camera (red: beyond {:.1f}; each is "
             "then known more than twice worse than if the other were given), of these with the poses, and within the "
             "poses. {} All are in adjustment.json.</p>\n",
             kStrong, kSense) +
         html + "</section>\n";
}

json pose_correlation_json(const AdjustmentReport& report) {
  json images = json::array();
  const std::map<ImageId, Matrix6d> of_angles = angle_covariances(report);
  for (const auto& [id, covariance] : report.adjusted.pose_covariance) {
    images.push_back({{"image", report.block.images.at(id).file}, {"correlations", correlations_json(covariance)}});
    if (const auto its = of_angles.find(id); its != of_angles.end())
      images.back()["correlations_with_angles"] = correlations_json(its->second);
  }
  return {{"sense", kSense},
          {"pairs", pairs_json(kPoseNames)},
          {"pairs_with_angles", pairs_json(kAngleNames)},
          {"images", images}};
}

json camera_pose_correlation_json(const AdjustmentReport& report) {
  json list = json::array();
  for (const CameraPoseCorrelation& one : report.adjusted.camera_pose_correlations)
    list.push_back({{"camera", report.block.cameras.at(one.camera).name},
                    {"parameter", param_name(one.param)},
                    {"of_pose", name_of_pose(one.of_pose)},
                    {"image", report.block.images.at(one.image).file},
                    {"correlation", number(one.correlation)}});
  return list;
}

}  // namespace collinea
