// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/subject_words.h"

#include <fmt/format.h>

#include "collinea/block/geodetic_words.h"
#include "collinea/block/subject_label.h"

namespace collinea {
namespace {

constexpr std::size_t kNamed = 6;

const char* axis_in_world(int axis) {
  constexpr const char* kNames[] = {"in east", "in north", "in height", "along the flight"};
  return kNames[axis & 3];
}

const char* axis_in_camera(int axis) {
  constexpr const char* kNames[] = {"to the right", "downwards", "along the axis", "along the flight"};
  return kNames[axis & 3];
}

const char* axis_of_rotation(int axis) {
  constexpr const char* kNames[] = {"about its x axis", "about its y axis", "about its optical axis", "as a whole"};
  return kNames[axis & 3];
}

std::string of_camera(const Subject& subject, const std::string& name) {
  switch (subject.aspect) {
    case Aspect::kParameter:
      return param_name(subject.axis) + " of camera " + name;
    case Aspect::kLeverArm:
      return fmt::format("the lever arm {} of {}", axis_in_camera(subject.axis), name);
    case Aspect::kBoresight:
      return fmt::format("the boresight {} of {}", axis_of_rotation(subject.axis), name);
    case Aspect::kTimeOffset:
      return "the time offset of the positions of " + name;
    case Aspect::kDistance:
      return "the distance between images and object";
    case Aspect::kTiltX:
      return "the tilt of the images about their x axis";
    case Aspect::kTiltY:
      return "the tilt of the images about their y axis";
    case Aspect::kPositionX:
      return "the position of the images along their x axis";
    case Aspect::kPositionY:
      return "the position of the images along their y axis";
    default:
      return name;
  }
}

std::string of_block(Aspect aspect) {
  switch (aspect) {
    case Aspect::kScale:
      return "the scale";
    case Aspect::kAttitude:
      return "the attitude";
    case Aspect::kTilt:
      return "the tilt";
    case Aspect::kRotation:
      return "the rotation about an axis";
    case Aspect::kTwoRotations:
      return "two of three rotations";
    case Aspect::kPosition:
      return "the position";
    case Aspect::kHeight:
      return "the height";
    case Aspect::kPlan:
      return "the position in plan";
    case Aspect::kSomeShift:
      return "a shift";
    default:
      return "the block";
  }
}

std::string of_image(const Subject& subject, const std::string& name) {
  const bool all = subject.id == Subject::kAll && subject.name.empty();
  const std::string whose = all ? "the images" : name;
  switch (subject.aspect) {
    case Aspect::kAttitude:
      return (all ? "the attitudes of " : "the attitude of ") + whose;
    case Aspect::kPosition:
      return (all ? "the positions of " : "the position of ") + whose;
    default:
      return whose;
  }
}

}  // namespace

std::string words_of(const Subject& subject, const Block& block) {
  const std::string name = name_in_block(subject, block);
  switch (subject.kind) {
    case SubjectKind::kBlock:
      return of_block(subject.aspect);
    case SubjectKind::kImage:
      return of_image(subject, name);
    case SubjectKind::kCamera:
      return of_camera(subject, name);
    case SubjectKind::kTiePoint:
      return "tie point " + name;
    case SubjectKind::kControlPoint:
      return subject.aspect == Aspect::kPosition ? "the position of " + name : name;
    case SubjectKind::kGeodetic:
      return subject.id < block.geodetic.size() ? words_of(block.geodetic[subject.id], block) : "observation " + name;
    case SubjectKind::kStrip:
      return fmt::format("the {} of positions {} of strip {}", word_of(subject.aspect), axis_in_world(subject.axis),
                         name);
    case SubjectKind::kSetup:
      return "the orientation of set-up " + name;
    case SubjectKind::kLevel:
      return "the height " + name;
    case SubjectKind::kPlane:
      return (subject.aspect == Aspect::kTilt ? "the tilt of plane " : "the position of plane ") + name;
    case SubjectKind::kLine:
      return (subject.aspect == Aspect::kDirection ? "the direction of line " : "the position of line ") + name;
    case SubjectKind::kProduct:
      return name == "orthophoto" ? name : name.substr(0, name.find('_')) + " model";
    case SubjectKind::kModel:
      return "model " + name;
    case SubjectKind::kPoint:
    case SubjectKind::kMark:
    case SubjectKind::kFile:
    case SubjectKind::kCrs:
      return name;
  }
  return name;
}

std::string words_of(const std::vector<Subject>& subjects, const Block& block) {
  const std::size_t named = std::min(kNamed, subjects.size());
  std::string text;
  for (std::size_t i = 0; i < named; ++i)
    text += (i == 0 ? "" : i + 1 == subjects.size() ? " and " : ", ") + words_of(subjects[i], block);
  if (subjects.size() > named) text += fmt::format(" and {} more", subjects.size() - named);
  return text;
}

std::string words_of(const DatumSources& datum, int rank_defect) {
  std::string text;
  const auto name = [&](bool there, const char* what) {
    if (there) text += (text.empty() ? "" : ", ") + std::string(what);
  };
  name(datum.control, "control points");
  name(datum.positions, "positions of images");
  name(datum.attitudes, "attitudes");
  name(datum.geodetic, "measurements on the ground");
  name(datum.fixed, "images or points that are fixed");
  if (rank_defect == 0) return text.empty() ? "nothing to be fixed" : text;
  text = text.empty() ? "free network" : "partly " + text;
  text += fmt::format(" ({} degrees of freedom kept by inner constraints", rank_defect);
  if (datum.parts > 1) text += fmt::format(", {} unconnected parts", datum.parts);
  return text + ")";
}

std::string words_of(StayReason reason) {
  switch (reason) {
    case StayReason::kTooLittleChecks:
      return "too little checks it";
    case StayReason::kSameDegree:
      return "others are suspect to the same degree";
    case StayReason::kBlockNeedsIt:
      return "without it the block is not determined";
    case StayReason::kWorseOfItsPoint:
      return "what is more suspect of its point stays";
    case StayReason::kImageNeedsIt:
      return "its image would keep too few measurements";
  }
  return "";
}

std::string words_of(LevelSource level) {
  switch (level) {
    case LevelSource::kEdges:
      return "the horizontal edges of the images";
    case LevelSource::kView:
      return "the mean view, taken as down";
    case LevelSource::kLowerEdges:
      return "the mean lower edge of the images";
    case LevelSource::kAttitudes:
      return "the attitudes the camera wrote";
    case LevelSource::kNone:
      return "";
  }
  return "";
}

namespace {

std::string local_gauge(const Gauge& gauge) {
  const std::string given = gauge.given_by.empty() ? "" : "as given by " + gauge.given_by;
  if (gauge.distances > 0)
    return fmt::format("local gauge in metres, {}scale by {} distance{}", given.empty() ? "" : given + " but for its ",
                       gauge.distances, gauge.distances == 1 ? "" : "s");
  if (!given.empty()) return "local gauge, " + given;
  return "local gauge without scale, position or north: the unit is the first base, z is up as the images stand";
}

}  // namespace

std::string words_of(const Gauge& gauge) {
  if (gauge.map.empty()) return local_gauge(gauge);
  if (!gauge.given_by.empty()) return fmt::format("in {}, as given by {}", gauge.map, gauge.given_by);
  std::string by = gauge.by_control ? "control points" : "";
  if (gauge.positions > 0)
    by += fmt::format("{}the position{} of {} image{}", by.empty() ? "" : " and ", gauge.positions == 1 ? "" : "s",
                      gauge.positions, gauge.positions == 1 ? "" : "s");
  if (gauge.position_use == PositionUse::kPlan) by += " in plan";
  if (gauge.position_use == PositionUse::kOnLine) by += " on one line and the attitudes that the camera wrote";
  if (gauge.level != LevelSource::kNone) by += ", levelled by " + words_of(gauge.level);
  return fmt::format("in {}, fixed by {}", gauge.map, by);
}

std::string words_of(const Conditioning& conditioning, const Block& block) {
  std::string text;
  for (const UnknownShare& one : conditioning.mostly)
    text += fmt::format("{}{} ({:.0f} %)", text.empty() ? "" : ", ", words_of(one.unknown, block), 100 * one.share);
  return text;
}

}  // namespace collinea
