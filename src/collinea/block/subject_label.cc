// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/subject_label.h"

#include <fmt/format.h>

namespace collinea {
namespace {

std::string number_of(const Subject& subject) { return std::to_string(subject.id + 1); }

// As the observations of it call it.
std::string name_of_shape(const Subject& subject, const Block& block, GeodeticKind kind) {
  for (const GeodeticObservation& one : block.geodetic)
    if (one.kind == kind && one.setup == subject.id && !one.name.empty()) return one.name;
  return number_of(subject);
}

std::string name_of_geodetic(const Subject& subject, const Block& block) {
  if (subject.id >= block.geodetic.size()) return number_of(subject);
  const GeodeticObservation& one = block.geodetic[subject.id];
  const std::string& from = block.control.at(one.from).name;
  return one.is_of_shape() ? from : from + " - " + block.control.at(one.to).name;
}

template <class Table, class Key, class Name>
std::string name_in(const Table& table, Key key, Name&& name, const Subject& subject) {
  const auto found = table.find(key);
  return found == table.end() || name(found->second).empty() ? number_of(subject) : name(found->second);
}

}  // namespace

std::string name_in_block(const Subject& subject, const Block& block) {
  const auto by_name = [](const auto& one) -> const std::string& { return one.name; };
  const auto by_file = [](const auto& one) -> const std::string& { return one.file; };
  if (!subject.name.empty()) return subject.name;
  if (subject.id == Subject::kAll) return "";
  switch (subject.kind) {
    case SubjectKind::kImage:
      return name_in(block.images, ImageId{subject.id}, by_file, subject);
    case SubjectKind::kCamera:
      return name_in(block.cameras, CameraId{subject.id}, by_name, subject);
    case SubjectKind::kControlPoint:
      return name_in(block.control, ControlId{subject.id}, by_name, subject);
    case SubjectKind::kGeodetic:
      return name_of_geodetic(subject, block);
    case SubjectKind::kLevel:
      return name_of_shape(subject, block, GeodeticKind::kAtHeight);
    case SubjectKind::kPlane:
      return name_of_shape(subject, block, GeodeticKind::kOnPlane);
    case SubjectKind::kLine:
      return name_of_shape(subject, block, GeodeticKind::kOnLine);
    case SubjectKind::kProduct:
      return std::string(word_of(static_cast<Product>(subject.id)));
    default:
      return number_of(subject);
  }
}

std::string label_of(const Subject& subject, const Block& block) {
  std::string label;
  if (subject.aspect == Aspect::kParameter)
    label = param_name(subject.axis) + " of ";
  else if (subject.aspect != Aspect::kWhole)
    label = std::string(word_of(subject.aspect)) + " of ";
  label += word_of(subject.kind);
  const std::string name = name_in_block(subject, block);
  return name.empty() ? label : label + " " + name;
}

std::string label_of(const Finding& finding, const Block& block) {
  std::string label(word_of(finding.code));
  for (const Subject& subject : finding.subjects)
    label += (&subject == finding.subjects.data() ? ": " : ", ") + label_of(subject, block);
  for (const Figure& figure : finding.figures) label += fmt::format("; {} {:.4g}", word_of(figure.name), figure.value);
  return label;
}

std::string label_of(const std::optional<Finding>& finding, const Block& block) {
  return finding ? label_of(*finding, block) : "";
}

}  // namespace collinea
