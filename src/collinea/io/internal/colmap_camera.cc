// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/colmap_camera.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "collinea/io/text.h"

namespace collinea::colmap {
namespace {

constexpr int kOpencvFisheye = 5, kThinPrismFisheye = 10;
constexpr int kGrid = 24;  // positions along each side of the image where cameras are compared

template <class Visit>
void visit_grid(const Camera& camera, Visit&& visit) {
  for (int row = 0; row <= kGrid; ++row)
    for (int column = 0; column <= kGrid; ++column)
      visit(Eigen::Vector2d(double(column) * camera.width_px / kGrid, double(row) * camera.height_px / kGrid));
}

// A fisheye of any law as an odd polynomial of the angle with the same f: least squares over the angles of the image.
template <class Law>
Camera fitted_equidistant(const Camera& camera) {
  Camera fitted = camera;
  fitted.model = Equidistant{};
  double widest = 0.1;
  visit_grid(camera, [&](const Eigen::Vector2d& pixel) {
    widest = std::max(widest, std::acos(std::clamp(ray_in_cam(camera, pixel).z(), -1.0, 1.0)));
  });
  constexpr int kAngles = 200;
  Eigen::Matrix<double, kAngles, 4> powers;
  Eigen::Matrix<double, kAngles, 1> rest;
  const auto& p = camera.params;
  for (int i = 0; i < kAngles; ++i) {
    const double t = widest * (i + 1) / kAngles, g = Law::radius(t).g, g2 = g * g;
    rest[i] = g * (1 + g2 * (p[Camera::kK1] + g2 * (p[Camera::kK2] + g2 * p[Camera::kK3]))) - t;
    for (int k = 0; k < 4; ++k) powers(i, k) = std::pow(t, 2 * k + 3);
  }
  const Eigen::Vector4d k = powers.colPivHouseholderQr().solve(rest);
  for (const int i : {0, 1, 2}) fitted.params[std::size_t(Camera::kK1 + i)] = k[i];
  fitted.params[Camera::kK4] = k[3];
  return fitted;
}

double largest_difference_px(const Camera& camera, const Camera& exported) {
  double largest = 0;
  visit_grid(camera, [&](const Eigen::Vector2d& pixel) {
    const auto other = project(exported, ray_in_cam(camera, pixel));
    if (other) largest = std::max(largest, (*other - pixel).norm());
  });
  return largest;
}

double largest_additional_px(const Camera& camera) {
  double largest = 0;
  visit_grid(camera, [&](const Eigen::Vector2d& pixel) {
    largest = std::max(largest, (pixel - without_additional(camera, pixel)).norm());
  });
  return largest;
}

// What COLMAP makes of a camera: one of a model that it has.
struct Counterpart {
  Camera camera;
  bool is_fitted = false;  // nearly the same, not exactly
};

// One overload for each model that COLMAP can express.
Result<Counterpart> counterpart(const Camera& camera, const Brown&) { return Counterpart{camera}; }
Result<Counterpart> counterpart(const Camera& camera, const Equidistant&) { return Counterpart{camera}; }
Result<Counterpart> counterpart(const Camera& camera, const Equisolid&) {
  return Counterpart{fitted_equidistant<Equisolid>(camera), true};
}
Result<Counterpart> counterpart(Camera camera, const KannalaBrandt&) {
  camera.model = Equidistant{};
  return Counterpart{camera};
}
Result<Counterpart> counterpart(const Camera& camera, const BrownOfMeasured&) {
  return fail(Errc::kUnsupported, "camera " + camera.name +
                                      ": COLMAP has no camera that corrects measured coordinates (brown_of_measured)");
}
template <class Model>
Result<Counterpart> counterpart(const Camera& camera, const Model&) {
  return fail(Errc::kUnsupported,
              "camera " + camera.name + ": COLMAP has no camera of the model " + std::string(Model::kName));
}

}  // namespace

Result<ExportedCamera> exported(CameraId id, const Camera& camera) {
  Camera kept = camera;
  kept.params[Camera::kB2] = 0;
  kept.additional = AdditionalSet::kNone;
  std::fill(kept.params.begin() + Camera::kParams, kept.params.end(), 0.0);
  COLLINEA_TRY(const Counterpart theirs,
               std::visit([&](const auto& model_of_ours) { return counterpart(kept, model_of_ours); }, camera.model));
  ExportedCamera result;
  result.as_exported = theirs.camera;
  const bool fisheye = is_fisheye(camera.model);
  if (theirs.is_fitted)
    result.findings.push_back(finding_of(FindingCode::kProjectionFitted, {id},
                                         {{FigureName::kOffsetPx, largest_difference_px(kept, result.as_exported)}}));
  const auto& p = result.as_exported.params;
  const double f = p[Camera::kF], b2 = camera.params[Camera::kB2];
  const bool decentred = p[Camera::kP1] != 0 || p[Camera::kP2] != 0;
  const int model = !fisheye ? kFullOpencv : decentred ? kThinPrismFisheye : kOpencvFisheye;
  result.row = {id.value + std::uint64_t{1},
                model,
                std::uint64_t(camera.width_px),
                std::uint64_t(camera.height_px),
                {f + p[Camera::kB1], f, p[Camera::kCx], p[Camera::kCy], p[Camera::kK1], p[Camera::kK2]}};
  auto& v = result.row.params;
  // OpenCV's tangential terms are named the other way round: its p1 is the one that grows with 2 x y in x
  if (model == kFullOpencv) v.insert(v.end(), {p[Camera::kP2], p[Camera::kP1], p[Camera::kK3], 0, 0, 0});
  if (model == kOpencvFisheye) v.insert(v.end(), {p[Camera::kK3], p[Camera::kK4]});
  if (model == kThinPrismFisheye)
    v.insert(v.end(), {p[Camera::kP2], p[Camera::kP1], p[Camera::kK3], p[Camera::kK4], 0, 0});
  const double worst = std::abs(b2) / f * camera.height_px / 2;
  if (worst > 1e-6)
    result.findings.push_back(
        finding_of(FindingCode::kShearDropped, {id}, {{FigureName::kValue, b2}, {FigureName::kOffsetPx, worst}}));
  if (camera.additional != AdditionalSet::kNone)
    result.findings.push_back(finding_of(FindingCode::kAdditionalDropped, {id},
                                         {{FigureName::kOffsetPx, largest_additional_px(camera)}}, {},
                                         std::string(kAdditionalNames[std::size_t(camera.additional)])));
  return result;
}

Result<Camera> imported(const CameraRow& row) {
  constexpr double kLargest = 1e100;  // so that sums of parameters are finite too
  const auto& v = row.params;
  if (row.width_px == 0 || row.height_px == 0 || row.width_px > 1'000'000 || row.height_px > 1'000'000)
    return fail(Errc::kBadFormat, "a camera without sensible size");
  if (!std::all_of(v.begin(), v.end(), [](double value) { return std::abs(value) < kLargest; }))
    return fail(Errc::kBadFormat, "a camera with a parameter that is no sensible number");
  Camera camera;
  camera.width_px = int(row.width_px);
  camera.height_px = int(row.height_px);
  camera.name = "COLMAP camera " + std::to_string(row.id);
  camera.prior.source = Provenance::kGiven;
  auto& p = camera.params;
  const std::string_view model = kModels[std::size_t(row.model)].name;
  const bool thin_prism = model == "THIN_PRISM_FISHEYE", opencv_fisheye = model == "OPENCV_FISHEYE";
  const bool two_focals =
      model == "PINHOLE" || model == "OPENCV" || model == "FULL_OPENCV" || opencv_fisheye || thin_prism;
  const std::size_t centre = two_focals ? 2 : 1, distortion = centre + 2;
  p[Camera::kF] = v[two_focals ? 1 : 0];
  p[Camera::kB1] = two_focals ? v[0] - v[1] : 0;
  p[Camera::kCx] = v[centre];
  p[Camera::kCy] = v[centre + 1];
  if (model.find("FISHEYE") != std::string_view::npos) camera.model = KannalaBrandt{};
  if (model != "SIMPLE_PINHOLE" && model != "PINHOLE") p[Camera::kK1] = v[distortion];
  if (v.size() > distortion + 1) p[Camera::kK2] = v[distortion + 1];
  if (opencv_fisheye) {
    p[Camera::kK3] = v[distortion + 2];
    p[Camera::kK4] = v[distortion + 3];
  }
  if (model == "OPENCV" || model == "FULL_OPENCV" || thin_prism) {
    p[Camera::kP2] = v[distortion + 2];
    p[Camera::kP1] = v[distortion + 3];
  }
  if (model == "FULL_OPENCV") {
    p[Camera::kK3] = v[8];
    if (v[9] != 0 || v[10] != 0 || v[11] != 0)
      return fail(Errc::kUnsupported, "a FULL_OPENCV camera with k4, k5 or k6 has no counterpart here");
  }
  if (thin_prism) {
    p[Camera::kK3] = v[8];
    p[Camera::kK4] = v[9];
    const bool decentred = p[Camera::kP1] != 0 || p[Camera::kP2] != 0;
    if (v[10] != 0 || v[11] != 0 || (decentred && v[9] != 0))
      return fail(Errc::kUnsupported,
                  "a THIN_PRISM_FISHEYE camera with sx1 or sy1, or with k4 beside p1 and p2, has no counterpart here");
    if (decentred) camera.model = Equidistant{};
  }
  if (model == "FOV") return fail(Errc::kUnsupported, "camera model FOV is not supported");
  if (!(p[Camera::kF] > 0)) return fail(Errc::kBadFormat, "a camera without focal length");
  return camera;
}

}  // namespace collinea::colmap
