// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/dbat_camera.h"

#include <array>
#include <cmath>

#include "collinea/io/text.h"

namespace collinea {
namespace {

class CameraReader {
 public:
  CameraReader(const XmlElement& camera, const std::filesystem::path& path) : camera_(camera), path_(path) {}

  Result<> read(DbatProject& project) {
    COLLINEA_TRY(check_children(camera_,
                                {"id", "name", "unit", "sensor", "image", "aspect", "focal", "model", "nK", "nP", "cc",
                                 "pp", "skew", "K", "P", "all", "calibrated", "calibration_info"},
                                path_));
    for (const char* needed : {"image", "sensor", "model"})
      if (!camera_.child(needed)) return bad(camera_, std::string("the camera has no element ") + needed);
    if (const XmlElement* all = camera_.child("all"); all && all->text != "default")
      return bad(*all, "all = " + all->text + ": default is expected");
    COLLINEA_TRY(take_image());
    COLLINEA_TRY(take_pixels());
    COLLINEA_TRY(take_focal(project.nominal_focal_mm));
    COLLINEA_TRY(take_principal_point());
    COLLINEA_TRY(take_terms("K", "nK", mm_.k, project.radial_terms));
    COLLINEA_TRY(take_terms("P", "nP", mm_.p, project.tangential_terms));
    COLLINEA_TRY(take_model());
    project.loaded_camera = mm_;
    return {};
  }

 private:
  [[nodiscard]] tl::unexpected<Error> bad(const XmlElement& at, const std::string& what) const {
    return bad_dbat(path_, at.line, what);
  }

  // The number of an element; `otherwise` where it is not there.
  [[nodiscard]] Result<double> number_of(const char* name, double otherwise) const {
    const XmlElement* e = camera_.child(name);
    if (!e) return otherwise;
    COLLINEA_TRY(const auto values, dbat_numbers(*e, 1, 1, path_));
    return values[0];
  }

  Result<> take_image() {
    const XmlElement& e = *camera_.child("image");
    COLLINEA_TRY(const auto size, dbat_numbers(e, 2, 2, path_));
    if (!(size[0] >= 1 && size[1] >= 1 && size[0] < 1e6 && size[1] < 1e6))
      return bad(e, "width and height of an image are numbers of pixels above 0");
    mm_.width_px = static_cast<int>(size[0]);
    mm_.height_px = static_cast<int>(size[1]);
    return {};
  }

  // DBAT's aspect is 1 less what the width of a pixel is more than its height. A sensor says the same once more.
  Result<> take_pixels() {
    XmlElement sensor = *camera_.child("sensor");
    const bool automatic = sensor.text.starts_with("auto,");
    if (automatic) sensor.text = sensor.text.substr(5);
    COLLINEA_TRY(const auto extent, dbat_numbers(sensor, automatic ? 1 : 2, automatic ? 1 : 2, path_));
    mm_.pixel_height_mm = extent.back() / mm_.height_px;
    const double pixel_width_mm = automatic ? mm_.pixel_height_mm : extent.front() / mm_.width_px;
    if (!(mm_.pixel_height_mm > 0) || !(pixel_width_mm > 0)) return bad(sensor, "a sensor has a size above 0 [mm]");
    const double off_by_sensor = pixel_width_mm / mm_.pixel_height_mm - 1;
    const XmlElement* aspect = camera_.child("aspect");
    if (aspect && aspect->text == "auto") {
      if (automatic) return bad(*aspect, "aspect and width of the sensor are both auto: one follows from the other");
      mm_.off_aspect = off_by_sensor;
      return {};
    }
    COLLINEA_TRY(const double stated, number_of("aspect", 1));
    mm_.off_aspect = 1 - stated;
    constexpr double kAgree = 1e-4;
    if (std::abs(off_by_sensor) > kAgree && std::abs(off_by_sensor - mm_.off_aspect) > kAgree)
      return bad(sensor, "by sensor and image a pixel is " + fixed(1 + off_by_sensor, 6) +
                             " times as wide as high, by aspect " + fixed(1 + mm_.off_aspect, 6) +
                             ": write aspect auto");
    return {};
  }

  Result<> take_focal(double& nominal_mm) {
    COLLINEA_TRY(nominal_mm, number_of("focal", 0));
    const XmlElement* cc = camera_.child("cc");
    double constant_mm = nominal_mm;
    if (cc && cc->text != "focal") {
      COLLINEA_TRY(constant_mm, number_of("cc", 0));
    }
    mm_.focal_mm = constant_mm > 0 ? constant_mm : nominal_mm;
    if (!(nominal_mm > 0)) nominal_mm = mm_.focal_mm;
    if (!(mm_.focal_mm > 0)) return bad(camera_, "the camera has no focal length: add an element focal [mm]");
    return {};
  }

  Result<> take_principal_point() {
    mm_.principal_mm = {mm_.pixel_height_mm * mm_.width_px / 2, mm_.pixel_height_mm * mm_.height_px / 2};
    const XmlElement* pp = camera_.child("pp");
    if (!pp || pp->text == "default") return {};
    COLLINEA_TRY(const auto given, dbat_numbers(*pp, 2, 2, path_));
    mm_.principal_mm = {given[0], std::abs(given[1])};
    return {};
  }

  // As many coefficients as the lens has: those that are listed, else as many zeros as their count says, else none.
  template <std::size_t N>
  Result<> take_terms(const char* name, const char* count_name, std::array<double, N>& terms, std::size_t& count) {
    const XmlElement *listed = camera_.child(name), *counted = camera_.child(count_name);
    count = 0;
    if (counted) {
      COLLINEA_TRY(const double stated, number_of(count_name, 0));
      if (!(stated >= 0 && stated <= static_cast<double>(N)) || stated != std::floor(stated))
        return bad(*counted,
                   std::string(count_name) + " = " + counted->text + ": this reader knows 0 to " + std::to_string(N));
      count = static_cast<std::size_t>(stated);
    }
    if (!listed) return {};
    COLLINEA_TRY(const auto values, dbat_numbers(*listed, counted ? count : 0, counted ? count : N, path_));
    count = values.size();
    std::copy(values.begin(), values.end(), terms.begin());
    return {};
  }

  Result<> take_model() {
    COLLINEA_TRY(mm_.skew, number_of("skew", 0));
    COLLINEA_TRY(const double model, number_of("model", 0));
    if (mm_.skew != 0 && model != 3)
      return bad(*camera_.child("skew"), "a skew that is not 0: of these lens models 3 alone has one");
    if (model == 4 || model == 5)
      return bad(*camera_.child("model"),
                 "lens model " + exact(model) +
                     ": its affinity lies behind the correction of the lens, and no camera here has it there; that of "
                     "model 3 lies in front");
    if (model != 1 && model != 3 && model != -1)
      return bad(*camera_.child("model"),
                 "lens model " + exact(model) + ": this reader knows 1 and 3 (corrections) and -1 (distortion)");
    mm_.forward = model < 0;
    return {};
  }

  const XmlElement& camera_;
  const std::filesystem::path& path_;
  MillimetreCamera mm_;
};

Result<> take_only_camera(const XmlElement& cameras, const std::filesystem::path& path, DbatProject& project) {
  const auto found = children_named(cameras, "camera");
  if (found.empty()) return bad_dbat(path, cameras.line, "there is no element camera");
  if (found.size() > 1) return bad_dbat(path, found[1]->line, "several cameras: this reader knows one");
  COLLINEA_TRY(CameraReader(*found[0], path).read(project));
  Camera camera = camera_of(project.loaded_camera);
  camera.name = found[0]->child("name") ? found[0]->child("name")->text : "camera";
  camera.prior.source = Provenance::kGiven;
  AdjustmentFile& file = project.file;
  file.block.cameras[{0}] = file.given_cameras[{0}] = camera;
  file.camera_sigmas[{0}].fill(0);
  if (!project.loaded_camera.forward) file.corrected_cameras.insert({0});
  return {};
}

}  // namespace

Result<> read_dbat_camera(const XmlElement& input, DbatProject& project) {
  const XmlElement* cameras = input.child("cameras");
  if (!cameras) return bad_dbat(project.script, input.line, "there is no element cameras");
  COLLINEA_TRY(check_children(*cameras, {"file", "camera"}, project.script));
  const auto files = children_named(*cameras, "file");
  if (files.empty()) return take_only_camera(*cameras, project.script, project);
  if (files.size() > 1 || cameras->child("camera"))
    return bad_dbat(project.script, files.back()->line, "several cameras: this reader knows one");
  COLLINEA_TRY(const std::filesystem::path path, project.path_of(*files[0], files[0]->text));
  COLLINEA_TRY(const XmlElement document, read_xml(path));
  const XmlElement* inner = document.child("cameras");
  if (!inner) return bad_dbat(path, document.line, "there is no element cameras");
  COLLINEA_TRY(check_children(*inner, {"camera"}, path));
  return take_only_camera(*inner, path, project);
}

}  // namespace collinea
