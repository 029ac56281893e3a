// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/dbat_operations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A parameter of the camera, and the term of the lens that it is, from 1 (0: none).
struct Parameter {
  int index;
  std::size_t radial = 0, tangential = 0;
};

bool is_of_lens(const Parameter& one, const DbatProject& project) {
  return one.radial <= project.radial_terms && one.tangential <= project.tangential_terms;
}

const std::map<std::string, std::vector<Parameter>>& groups() {
  using C = Camera;
  static const Parameter k1{C::kK1, 1}, k2{C::kK2, 2}, k3{C::kK3, 3}, p1{C::kP1, 0, 1}, p2{C::kP2, 0, 2};
  static const std::map<std::string, std::vector<Parameter>> all = {
      {"all", {{C::kF}, {C::kCx}, {C::kCy}, {C::kB1}, {C::kB2}, k1, k2, k3, p1, p2}},
      {"cc", {{C::kF}}},
      {"px", {{C::kCx}}},
      {"py", {{C::kCy}}},
      {"pp", {{C::kCx}, {C::kCy}}},
      {"aspect", {{C::kB1}}},
      {"skew", {{C::kB2}}},
      {"K", {k1, k2, k3}},
      {"K1", {k1}},
      {"K2", {k2}},
      {"K3", {k3}},
      {"P", {p1, p2}},
      {"P1", {p1}},
      {"P2", {p2}}};
  return all;
}

// <io>true</io> stands for <io><all>true</all></io>, and so for eo and op.
std::vector<XmlElement> parts_of(const XmlElement& e) {
  std::vector<XmlElement> parts;
  if (!e.text.empty())
    parts.push_back({.name = "all", .text = e.text, .attributes = {}, .children = {}, .line = e.line});
  for (const XmlElement& child : e.children)
    if (child.name != "c") parts.push_back(child);
  return parts;
}

// true and false of groups of parameters, later ones over earlier ones. Terms that the lens lacks are no parameters.
Result<> take_estimated(const XmlElement& io, DbatProject& project) {
  for (const XmlElement& e : parts_of(io)) {
    const auto its = groups().find(e.name);
    if (its == groups().end() || (e.text != "true" && e.text != "false"))
      return bad_dbat(project.script, e.line,
                      "io: " + e.name + " = " + e.text + ": true or false of a parameter of the camera is expected");
    const bool names_one = its->second.size() == 1;
    for (const Parameter& one : its->second) {
      if (is_of_lens(one, project))
        project.file.camera_sigmas[{0}][std::size_t(one.index)] = e.text == "true" ? kInfinity : 0;
      else if (names_one && e.text == "true")
        return bad_dbat(project.script, e.line, "io: " + e.name + ": the camera has no such term (nK, nP)");
    }
  }
  return {};
}

// Images and points that are not all estimated cannot be told apart in DBAT's own way.
Result<> check_estimated(const XmlElement& part, DbatProject& project) {
  const bool is_points = part.name == "op";
  const auto& control = project.file.block.control;
  const bool has_fixed = std::any_of(control.begin(), control.end(), [](const auto& one) {
    return one.second.role == ControlRole::kControl && (one.second.sigma_m.array() == 0).any();
  });
  for (const XmlElement& e : parts_of(part)) {
    const std::string said = part.name + ": " + e.name + " = " + e.text;
    if (is_points && e.text == "default") continue;
    if (e.text != "true")
      return bad_dbat(project.script, e.line, said + ": this reader knows images and points that are all estimated");
    if (is_points && has_fixed)
      return bad_dbat(project.script, e.line,
                      said + ", but control has a standard deviation of 0: write default, or give it one above 0");
  }
  return {};
}

Result<> take_estimate_params(const XmlElement& e, DbatProject& project) {
  COLLINEA_TRY(check_children(e, {"io", "eo", "op"}, project.script));
  for (const char* whole : {"eo", "op"})
    if (const XmlElement* part = e.child(whole)) COLLINEA_TRY(check_estimated(*part, project));
  return e.child("io") ? take_estimated(*e.child("io"), project) : Result<>{};
}

/// What a parameter of the camera begins with: as it was loaded, DBAT's default, or numbers.
class InitialCamera {
 public:
  explicit InitialCamera(const DbatProject& project)
      : mm(millimetre_camera(project.file.block.cameras.at({0}), project.loaded_camera.pixel_height_mm)),
        project_(project),
        default_(project.loaded_camera) {
    default_.focal_mm = project.nominal_focal_mm;
    default_.principal_mm = {mm.pixel_height_mm * mm.width_px / 2, mm.pixel_height_mm * mm.height_px / 2};
    default_.off_aspect = 0;
    default_.k = {}, default_.p = {};
  }

  Result<> take(const XmlElement& e) {
    const bool is_loaded = e.text == "loaded";
    const std::optional<MillimetreCamera> from = is_loaded ? std::optional(project_.loaded_camera)
                                                 : e.text == "default" || (e.name == "cc" && e.text == "focal")
                                                     ? std::optional(default_)
                                                     : std::nullopt;
    if (from) return copy(e, *from);
    if (e.name == "cc") return number(e, mm.focal_mm);
    if (e.name == "aspect") {
      double aspect = 1;
      COLLINEA_TRY(number(e, aspect));
      mm.off_aspect = 1 - aspect;
      return {};
    }
    if (e.name == "pp") {
      COLLINEA_TRY(const auto values, dbat_numbers(e, 2, 2, project_.script));
      mm.principal_mm = {values[0], std::abs(values[1])};
      return {};
    }
    if (e.name == "K") return terms(e, project_.radial_terms, mm.k.data());
    if (e.name == "P") return terms(e, project_.tangential_terms, mm.p.data());
    if (e.name == "skew") return number(e, mm.skew);
    return unknown(e);
  }

  MillimetreCamera mm;

 private:
  [[nodiscard]] tl::unexpected<Error> unknown(const XmlElement& e) const {
    return bad_dbat(project_.script, e.line,
                    "io: initial value " + e.name + " = " + e.text + ": this reader does not know it");
  }

  Result<> number(const XmlElement& e, double& value) const {
    COLLINEA_TRY(const auto values, dbat_numbers(e, 1, 1, project_.script));
    value = values[0];
    return {};
  }

  Result<> terms(const XmlElement& e, std::size_t count, double* into) const {
    COLLINEA_TRY(const auto values, dbat_numbers(e, count, count, project_.script));
    std::copy(values.begin(), values.end(), into);
    return {};
  }

  Result<> copy(const XmlElement& e, const MillimetreCamera& from) {
    if (e.name == "all")
      mm = from;
    else if (e.name == "cc")
      mm.focal_mm = from.focal_mm;
    else if (e.name == "pp")
      mm.principal_mm = from.principal_mm;
    else if (e.name == "aspect")
      mm.off_aspect = from.off_aspect;
    else if (e.name == "K")
      mm.k = from.k;
    else if (e.name == "P")
      mm.p = from.p;
    else if (e.name == "skew")
      mm.skew = from.skew;
    else
      return unknown(e);
    return {};
  }

  const DbatProject& project_;
  MillimetreCamera default_;
};

Result<> take_initial_values(const XmlElement& e, DbatProject& project) {
  COLLINEA_TRY(check_children(e, {"io", "eo", "op"}, project.script));
  for (const char* name : {"eo", "op"})
    if (const XmlElement* part = e.child(name))
      for (const XmlElement& one : parts_of(*part))
        if (one.name != "all" || one.text != "loaded")
          return bad_dbat(
              project.script, one.line,
              part->name + ": initial value " + one.name + " = " + one.text + ": this reader knows all = loaded");
  const XmlElement* io = e.child("io");
  if (!io) return {};
  InitialCamera initial(project);
  for (const XmlElement& one : parts_of(*io)) COLLINEA_TRY(initial.take(one));
  if (!(initial.mm.focal_mm > 0)) return bad_dbat(project.script, io->line, "io: a focal length is above 0 [mm]");
  Camera& camera = project.file.block.cameras.at({0});
  camera.params = camera_of(initial.mm).params;
  project.file.given_cameras[{0}] = camera;
  return {};
}

// One image is fixed, and of the one farthest from it along an axis the coordinate there.
Result<> take_datum(const XmlElement& datum, DbatProject& project) {
  COLLINEA_TRY(check_attributes(datum, {"ref_cam", "ref_base"}, project.script));
  const std::string base_word = datum.attribute("ref_base");
  const std::size_t only = std::string("xyz").find(base_word);
  const bool is_longest = base_word.empty() || base_word == "longest";
  if (datum.text != "depend" || (!is_longest && (only == std::string::npos || base_word.size() != 1)))
    return bad_dbat(
        project.script, datum.line,
        "datum " + datum.text + " " + base_word + ": this reader knows depend with the base longest, x, y or z");
  AdjustmentFile& file = project.file;
  const auto reference = integer(datum.attribute("ref_cam"));
  const ImageId fixed{reference && *reference >= 0 ? std::uint32_t(*reference) : ImageId::kNone};
  const std::optional<Rigid3> pose = find_pose(file.block, fixed);
  if (!pose)
    return bad_dbat(project.script, datum.line, "ref_cam: there is no image of that number with an orientation");
  file.fixed_images.insert(fixed);
  double longest = 0;
  ImageId farthest;
  int axis = 0;
  for (const auto& [id, other] : oriented_images(file.block)) {
    const Eigen::Vector3d offset = (centre_of(other) - centre_of(*pose)).cwiseAbs();
    Eigen::Index along = is_longest ? 0 : Eigen::Index(only);
    const double base = is_longest ? offset.maxCoeff(&along) : offset[along];
    if (base > longest) longest = base, farthest = id, axis = int(along);
  }
  if (!(longest > 0))
    return bad_dbat(project.script, datum.line, "there is no base: no second image has an orientation elsewhere");
  constexpr double kFixedPart = 1e-9;  // of the base: nothing else fixes the scale, so no weight spoils it
  PositionPrior prior{.position_in_world = centre_of(pose_of(file.block, farthest)),
                      .sigma_m = Eigen::Vector3d::Constant(kInfinity)};
  prior.sigma_m[axis] = kFixedPart * longest;
  file.block.images[farthest].position = prior;
  return {};
}

// Control is exempt, as in DBAT.
Result<> check_rays(const XmlElement& operation, const DbatProject& project) {
  const std::string& stated = operation.attributes.contains("min_rays") ? operation.attributes.at("min_rays") : "2";
  const auto least = integer(trimmed(stated));
  if (!least) return bad_dbat(project.script, operation.line, "min_rays = " + stated + ": a whole number is expected");
  std::map<PointId, std::int64_t> rays;
  for (const Observation& seen : project.file.block.observations) ++rays[seen.point];
  for (const auto& [point, count] : rays)
    if (count < *least)
      return bad_dbat(project.script, operation.line,
                      "point " + std::to_string(point.value) + " is marked in " + std::to_string(count) +
                          (count == 1 ? " image" : " images") + ", fewer than min_rays = " + stated);
  return {};
}

Result<> apply(const XmlElement& operation, DbatProject& project) {
  using Names = std::initializer_list<std::string_view>;
  const bool counts_rays = operation.text == "check_ray_count";
  bool is_known = counts_rays || operation.text.empty();
  for (const char* done_anyway : {"spatial_resection", "forward_intersection", "bundle_adjustment"})
    is_known |= operation.text == done_anyway;
  if (!is_known)
    return bad_dbat(project.script, operation.line, "operation " + operation.text + ": this reader does not know it");
  COLLINEA_TRY(check_attributes(operation, counts_rays ? Names{"min_rays"} : Names{}, project.script));
  COLLINEA_TRY(
      check_children(operation, {"set_initial_values", "set_bundle_estimate_params", "set_datum"}, project.script));
  if (counts_rays) return check_rays(operation, project);
  for (const XmlElement& e : operation.children) {
    if (e.name == "set_initial_values") COLLINEA_TRY(take_initial_values(e, project));
    if (e.name == "set_bundle_estimate_params") COLLINEA_TRY(take_estimate_params(e, project));
    if (e.name == "set_datum") COLLINEA_TRY(take_datum(e, project));
  }
  return {};
}

}  // namespace

Result<> apply_dbat_operations(const XmlElement& operations, DbatProject& project) {
  COLLINEA_TRY(check_children(operations, {"operation"}, project.script));
  const auto all = children_named(operations, "operation");
  const auto is_bundle = [](const XmlElement* one) { return one->text == "bundle_adjustment"; };
  const auto last_bundle = std::find_if(all.rbegin(), all.rend(), is_bundle).base();
  const bool has_bundle = last_bundle != all.begin();
  for (auto one = all.begin(); one != all.end(); ++one) {
    if (has_bundle && one >= last_bundle && (*one)->text.empty())
      return bad_dbat(project.script, (*one)->line,
                      "an operation behind the last bundle_adjustment, which it would not change");
    COLLINEA_TRY(apply(**one, project));
  }
  return {};
}

}  // namespace collinea
