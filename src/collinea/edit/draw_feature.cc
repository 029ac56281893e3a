// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/draw_feature.h"

#include <Eigen/Eigenvalues>
#include <charconv>

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/words_in.h"
#include "collinea/edit/set_attribute.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

/// The words of a command, one after the other.
class Reader {
 public:
  explicit Reader(std::span<const std::string> words) : words_(words) {}
  [[nodiscard]] bool at_end() const { return next_ == words_.size(); }
  [[nodiscard]] bool is_at(std::string_view word) const { return !at_end() && words_[next_] == word; }
  Result<std::string> word() {
    if (at_end()) return wrong_form(DrawFeature::kForm);
    return words_[next_++];
  }
  Result<double> number(std::string_view what) {
    COLLINEA_TRY(const std::string text, word());
    return number_in(text, what);
  }

 private:
  std::span<const std::string> words_;
  std::size_t next_ = 0;
};

Result<Eigen::Matrix3d> covariance_in(Reader& reader) {
  Eigen::Matrix3d c;
  for (const auto& [row, column, what] :
       {std::tuple(0, 0, "EE"), {0, 1, "EN"}, {0, 2, "EH"}, {1, 1, "NN"}, {1, 2, "NH"}, {2, 2, "HH"}}) {
    COLLINEA_TRY(c(row, column), reader.number(what));
    c(column, row) = c(row, column);
  }
  // What rounding makes of an exact coordinate is let pass.
  constexpr double kRounding = 1e-9;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(c, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] >= -kRounding * c.trace()) || !(c.trace() >= 0))
    return fail(Errc::kBadInput, "cov: it is no covariance: it would make the variance of some direction negative");
  return c;
}

Result<VertexMark> mark_in(Reader& reader) {
  VertexMark mark;
  COLLINEA_TRY(mark.image, reader.word());
  COLLINEA_TRY(check_name(mark.image, "IMAGE"));
  COLLINEA_TRY(mark.pixel.x(), reader.number("X"));
  COLLINEA_TRY(mark.pixel.y(), reader.number("Y"));
  COLLINEA_TRY(const std::string sigma, reader.word());
  COLLINEA_TRY(mark.sigma_px, sigma_in(sigma, "SIGMA_PX"));
  return mark;
}

Result<DrawnVertex> vertex_in(Reader& reader) {
  DrawnVertex vertex;
  COLLINEA_TRY(const std::string word, reader.word());
  const auto source = from_word<VertexSource>(word);
  if (!source)
    return fail(Errc::kBadInput,
                "\"" + word.substr(0, 40) + "\" begins no vertex: its SOURCE is stereo, mono, surface, cloud or typed");
  vertex.source = *source;
  for (int axis = 0; axis < 3; ++axis) {
    COLLINEA_TRY(vertex.position[axis], reader.number(std::string_view("ENH").substr(std::size_t(axis), 1)));
  }
  if (reader.is_at("cov")) {
    COLLINEA_TRY([[maybe_unused]] const std::string cov, reader.word());
    COLLINEA_TRY(vertex.covariance_m2, covariance_in(reader));
  }
  while (reader.is_at("mark")) {
    COLLINEA_TRY([[maybe_unused]] const std::string at, reader.word());
    COLLINEA_TRY(VertexMark mark, mark_in(reader));
    if (vertex.marks.size() == DrawFeature::kMostMarks) return fail(Errc::kBadInput, "a vertex has at most 100 marks");
    vertex.marks.push_back(std::move(mark));
  }
  return vertex;
}

// "with NAME VALUE" as often as it stands there.
Result<std::map<std::string, std::string>> attributes_in(Reader& reader) {
  std::map<std::string, std::string> attributes;
  while (reader.is_at("with")) {
    COLLINEA_TRY([[maybe_unused]] const std::string with, reader.word());
    COLLINEA_TRY(const std::string name, reader.word());
    COLLINEA_TRY(const std::string value, reader.word());
    COLLINEA_TRY(check_attribute(name, value));
    if (!attributes.emplace(name, value).second) return fail(Errc::kBadInput, "with " + name + ": it is stated twice");
  }
  return attributes;
}

// Of a feature that is drawn now; journals may have others.
Result<> check_leaves_numbers(const std::string& id) {
  constexpr std::size_t kLongestNumber = 14;
  if (id.size() > 1 + kLongestNumber && id[0] == 'F' && id.find_first_not_of("0123456789", 1) == std::string::npos)
    return fail(Errc::kBadInput, "FEATURE: F and more than 14 digits leave no number for features to come");
  return {};
}

Result<> check_count(VectorKind kind, std::size_t count) {
  const std::size_t least = kind == VectorKind::kPoint ? 1 : kind == VectorKind::kLine ? 2 : 3;
  if (count < least || (kind == VectorKind::kPoint && count > 1))
    return fail(Errc::kBadInput, "a " + std::string(word_of(kind)) + " has " + std::to_string(least) +
                                     (least == 1 ? " vertex" : " vertices or more") + ", not " + std::to_string(count));
  return {};
}

}  // namespace

Result<DrawFeature> DrawFeature::parse(std::span<const std::string> words) {
  if (words.size() < 7) return wrong_form(kForm);
  DrawFeature one{.feature = words[0], .layer = words[1]};
  COLLINEA_TRY(check_new_name(one.feature, "FEATURE"));
  COLLINEA_TRY(check_new_name(one.layer, "LAYER"));
  const auto kind = from_word<VectorKind>(words[2]);
  if (!kind)
    return fail(Errc::kBadInput, "\"" + words[2].substr(0, 40) + "\" is no kind: it is point, line or polygon");
  one.kind = *kind;
  Reader reader(words.subspan(3));
  COLLINEA_TRY(one.attributes, attributes_in(reader));
  while (!reader.at_end()) {
    if (one.vertices.size() == kMostVertices)
      return fail(Errc::kBadInput,
                  "a feature has at most " + std::to_string(kMostVertices) + " vertices: draw several");
    COLLINEA_TRY(DrawnVertex vertex, vertex_in(reader));
    one.vertices.push_back(std::move(vertex));
  }
  COLLINEA_TRY(check_count(one.kind, one.vertices.size()));
  return one;
}

std::vector<std::string> DrawFeature::words() const {
  std::vector<std::string> words = {feature, layer, std::string(word_of(kind))};
  for (const auto& [name, value] : attributes) words.insert(words.end(), {"with", name, value});
  for (const DrawnVertex& vertex : vertices) {
    words.emplace_back(word_of(vertex.source));
    for (int axis = 0; axis < 3; ++axis) words.push_back(exact(vertex.position[axis]));
    if (vertex.covariance_m2) {
      words.emplace_back("cov");
      for (const auto& [row, column] : {std::pair(0, 0), {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}})
        words.push_back(exact((*vertex.covariance_m2)(row, column)));
    }
    for (const VertexMark& mark : vertex.marks)
      for (const std::string& word :
           {std::string("mark"), mark.image, exact(mark.pixel.x()), exact(mark.pixel.y()), exact(mark.sigma_px)})
        words.push_back(word);
  }
  return words;
}

Result<DrawFeature> DrawFeature::completed(const EditContext& context, const EditDefaults&) const {
  DrawFeature one = *this;
  COLLINEA_TRY(check_leaves_numbers(feature));
  for (DrawnVertex& vertex : one.vertices)
    for (VertexMark& mark : vertex.marks) {
      COLLINEA_TRY(const ImageId id, context.image(mark.image));
      mark.image = context.block().images.at(id).file;
    }
  return one;
}

// A photograph that is gone takes no feature with it: the vertices have their coordinates.
Result<> DrawFeature::apply(const EditContext&, EditedWork& work) const {
  Drawing& drawing = work.drawing;
  if (feature == "*") return fail(Errc::kBadInput, "the feature has no id");
  if (drawing.erased.contains(feature))
    return fail(Errc::kBadInput, feature + " was erased, and ids are not given again: draw it as * or by another name");
  for (const DrawingLayer& one : drawing.layers)
    if (one.name == layer && one.kind && *one.kind != kind)
      return fail(Errc::kBadInput, "layer " + layer + " holds each feature as a " + std::string(word_of(*one.kind)));
  DrawnFeature* known = drawing.features.find(feature);
  std::map<std::string, std::string> all = known ? known->attributes : std::map<std::string, std::string>();
  COLLINEA_TRY(set_attributes(attributes, all));
  if (known)
    *known = {feature, layer, kind, std::move(all), vertices};
  else
    drawing.features.add({feature, layer, kind, std::move(all), vertices});
  return {};
}

std::vector<std::vector<std::string>> DrawFeature::restoring(const EditContext&, const EditedWork& before) const {
  const DrawnFeature* known = before.drawing.features.find(feature);
  if (!known) return {command_words(EraseFeature{feature})};
  DrawFeature again = drawn_again(*known);
  for (const auto& [name, value] : attributes) again.attributes.emplace(name, "-");  // those that it had not
  return {command_words(again)};
}

std::uint64_t DrawFeature::number_of(const std::string& id) {
  std::uint64_t number = 0;
  if (id.size() < 2 || id[0] != 'F' || id[1] == '0' || id.size() > 16) return 0;
  const auto [end, error] = std::from_chars(id.data() + 1, id.data() + id.size(), number);
  return error == std::errc() && end == id.data() + id.size() ? number : 0;
}

DrawFeature drawn_again(const DrawnFeature& feature) {
  return {feature.id, feature.layer, feature.kind, feature.vertices, feature.attributes};
}

Result<EraseFeature> EraseFeature::parse(std::span<const std::string> words) {
  if (words.size() != 1) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "FEATURE"));
  return EraseFeature{words[0]};
}

std::vector<std::string> EraseFeature::words() const { return {feature}; }

Result<EraseFeature> EraseFeature::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> EraseFeature::apply(const EditContext&, EditedWork& work) const {
  Drawing& drawing = work.drawing;
  if (!drawing.features.erase(feature)) return fail(Errc::kNotFound, "there is no feature " + feature);
  drawing.erased.insert(feature);
  return {};
}

// The feature comes back under another id.
std::vector<std::vector<std::string>> EraseFeature::restoring(const EditContext&, const EditedWork& before) const {
  const DrawnFeature* known = before.drawing.features.find(feature);
  if (!known) return {};
  DrawFeature again = drawn_again(*known);
  again.feature = "*";
  return {command_words(again)};
}

}  // namespace collinea
