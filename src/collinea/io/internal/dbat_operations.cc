// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/dbat_operations.h"

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "collinea/io/internal/millimetre_camera.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

tl::unexpected<Error> bad(const std::filesystem::path& path, std::size_t line, const std::string& what) {
  return fail(Errc::kBadFormat, path.string() + ": line " + std::to_string(line) + ": " + what);
}

// true and false of groups of parameters, later ones over earlier ones.
Result<> take_estimated(const XmlElement& io, const std::filesystem::path& path, AdjustmentFile& file) {
  using C = Camera;
  static const std::map<std::string, std::vector<int>> kNames = {
      {"all", {C::kF, C::kCx, C::kCy, C::kB1, C::kB2, C::kK1, C::kK2, C::kK3, C::kP1, C::kP2}},
      {"cc", {C::kF}},
      {"px", {C::kCx}},
      {"py", {C::kCy}},
      {"pp", {C::kCx, C::kCy}},
      {"aspect", {C::kB1}},
      {"skew", {C::kB2}},
      {"K", {C::kK1, C::kK2, C::kK3}},
      {"K1", {C::kK1}},
      {"K2", {C::kK2}},
      {"K3", {C::kK3}},
      {"P", {C::kP1, C::kP2}},
      {"P1", {C::kP1}},
      {"P2", {C::kP2}}};
  for (const XmlElement& e : io.children) {
    const auto its = kNames.find(e.name);
    if (its == kNames.end() || (e.text != "true" && e.text != "false"))
      return bad(path, e.line,
                 "io: " + e.name + " = " + e.text + ": true or false of a parameter of the camera is expected");
    for (const int param : its->second) file.camera_sigmas[{0}][std::size_t(param)] = e.text == "true" ? kInfinity : 0;
  }
  return {};
}

// "default" begins anew from the rated focal length; "loaded" is what was read.
Result<> take_initial(const XmlElement& io, double pixel_height_mm, const std::filesystem::path& path,
                      AdjustmentFile& file) {
  Camera& camera = file.block.cameras[{0}];
  for (const XmlElement& e : io.children) {
    if (e.text == "loaded") continue;
    if (e.text == "default" && e.name == "all") {
      const double f = camera.params[Camera::kF];
      camera.params = ideal_camera(f, camera.width_px, camera.height_px).params;
    } else if (e.name == "aspect" && number(e.text)) {
      MillimetreCamera mm = millimetre_camera(camera, pixel_height_mm);
      mm.off_aspect = 1 - *number(e.text);
      camera.params = camera_of(mm).params;
    } else if (!(e.name == "skew" && number(e.text) == 0)) {
      return bad(path, e.line, "io: initial value " + e.name + " = " + e.text + ": this reader does not know it");
    }
  }
  file.given_cameras[{0}] = camera;
  return {};
}

// One image is fixed, and of the one farthest from it along an axis the coordinate there.
Result<> take_dependent_datum(const XmlElement& datum, const std::filesystem::path& path, AdjustmentFile& file) {
  const auto reference = integer(datum.attribute("ref_cam"));
  const ImageId fixed{reference && *reference >= 0 ? std::uint32_t(*reference) : ImageId::kNone};
  const std::optional<Rigid3> pose = find_pose(file.block, fixed);
  if (!pose) return bad(path, datum.line, "ref_cam: there is no image of that number with an orientation");
  file.fixed_images.insert(fixed);
  const Eigen::Vector3d centre = centre_of(*pose);
  double longest = 0;
  ImageId farthest;
  int axis = 0;
  for (const auto& [id, other] : oriented_images(file.block)) {
    Eigen::Index along = 0;
    const double base = (centre_of(other) - centre).cwiseAbs().maxCoeff(&along);
    if (base > longest) longest = base, farthest = id, axis = int(along);
  }
  if (!(longest > 0)) return bad(path, datum.line, "there is no base: no second image has an orientation elsewhere");
  constexpr double kFixedPart = 1e-9;  // of the base: nothing else fixes the scale, so no weight spoils it
  PositionPrior prior{.position_in_world = centre_of(pose_of(file.block, farthest)),
                      .sigma_m = Eigen::Vector3d::Constant(kInfinity)};
  prior.sigma_m[axis] = kFixedPart * longest;
  file.block.images[farthest].position = prior;
  return {};
}

}  // namespace

Result<> apply_dbat_operation(const XmlElement& operation, double pixel_height_mm, const std::filesystem::path& path,
                              AdjustmentFile& file) {
  for (const XmlElement& e : operation.children) {
    if (e.name == "set_bundle_estimate_params") {
      for (const char* whole : {"eo", "op"})
        if (const XmlElement* part = e.child(whole))
          for (const XmlElement& group : part->children)
            if (group.text == "false")
              return bad(path, group.line,
                         std::string(whole) + ": " + group.name + " = " + group.text +
                             ": this reader knows images and points that are all estimated");
      if (!e.child("io")) continue;
      COLLINEA_TRY(take_estimated(*e.child("io"), path, file));
    } else if (e.name == "set_initial_values" && e.child("io")) {
      COLLINEA_TRY(take_initial(*e.child("io"), pixel_height_mm, path, file));
    } else if (e.name == "set_datum") {
      if (e.text != "depend" || (e.attributes.contains("ref_base") && e.attribute("ref_base") != "longest"))
        return bad(path, e.line, "datum " + e.text + ": this reader knows depend with the longest base");
      COLLINEA_TRY(take_dependent_datum(e, path, file));
    }
  }
  return {};
}

}  // namespace collinea
