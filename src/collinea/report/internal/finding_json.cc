// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/finding_json.h"

#include "collinea/block/subject_label.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json subject_json(const Subject& subject, const Block& block) {
  json one = {{"kind", word_of(subject.kind)}};
  if (std::string name = name_in_block(subject, block); !name.empty()) one["name"] = std::move(name);
  if (subject.aspect == Aspect::kWhole) return one;
  one["aspect"] = word_of(subject.aspect);
  if (subject.aspect == Aspect::kParameter)
    one["axis"] = param_name(subject.axis);
  else if (subject.axis > 0)
    one["axis"] = subject.axis;
  return one;
}

json remedy_json(const Remedy& remedy) {
  json one = {{"code", word_of(remedy.code)}};
  if (remedy.code == RemedyCode::kSetOption)
    one["option"] = {{"group", remedy.option.group}, {"field", remedy.option.name}, {"value", remedy.option.value}};
  return one;
}

}  // namespace

json finding_json(const Finding& finding, const Block& block) {
  json one = {{"code", word_of(finding.code)}, {"severity", word_of(finding.severity)},
              {"subjects", json::array()},     {"figures", json::array()},
              {"remedies", json::array()},     {"what", what_of(finding, block)},
              {"remedy", remedy_of(finding)}};
  for (const Subject& subject : finding.subjects) one["subjects"].push_back(subject_json(subject, block));
  for (const Figure& figure : finding.figures)
    one["figures"].push_back(
        {{"name", word_of(figure.name)}, {"value", number(figure.value)}, {"unit", unit_of(figure.name)}});
  for (const Remedy& remedy : finding.remedies) one["remedies"].push_back(remedy_json(remedy));
  return one;
}

json findings_json(const std::vector<Finding>& findings, const Block& block) {
  json list = json::array();
  for (const Finding& finding : findings) list.push_back(finding_json(finding, block));
  return list;
}

}  // namespace collinea
