// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"
#include "collinea/report/subject_words.h"

namespace collinea {

/// A finding with what its words are made of.
struct FindingWords {
  const Finding& finding;
  const Block& block;

  [[nodiscard]] double operator[](FigureName name) const {
    return finding.figure(name).value_or(std::numeric_limits<double>::quiet_NaN());
  }
  [[nodiscard]] std::string whole(FigureName name) const { return fmt::format("{:.0f}", (*this)[name]); }
  [[nodiscard]] std::string percent(FigureName name, const char* format = "{:.2g} %") const {
    return fmt::format(fmt::runtime(format), 100 * (*this)[name]);
  }
  [[nodiscard]] std::string all() const { return words_of(finding.subjects, block); }
  [[nodiscard]] std::string subject(std::size_t i) const {
    return i < finding.subjects.size() ? words_of(finding.subjects[i], block) : "";
  }
  /// Subjects from the i-th on.
  [[nodiscard]] std::string from(std::size_t i) const {
    if (i >= finding.subjects.size()) return "";
    return words_of(
        std::vector<Subject>(finding.subjects.begin() + static_cast<std::ptrdiff_t>(i), finding.subjects.end()), block);
  }
  [[nodiscard]] bool one() const { return (*this)[FigureName::kCount] == 1; }
  /// The first of those that are counted, or the only one: ", the first: X" or ": X".
  [[nodiscard]] std::string first(std::size_t i) const { return (one() ? ": " : ", the first: ") + subject(i); }
  /// "1 image", "3 images".
  [[nodiscard]] std::string counted(FigureName name, const char* what) const {
    return whole(name) + " " + what + ((*this)[name] == 1 ? "" : "s");
  }
};

// Sentences of findings by their subject: "" for a code of another one.

[[nodiscard]] std::string words_of_given(const FindingWords& w);             ///< images and files as given
[[nodiscard]] std::string words_of_measured_control(const FindingWords& w);  ///< control as it was measured in images
[[nodiscard]] std::string words_of_marks(const FindingWords& w);             ///< how image measurements were counted
[[nodiscard]] std::string words_of_control(const FindingWords& w);           ///< coordinates of control, distances
[[nodiscard]] std::string words_of_positions(const FindingWords& w);         ///< positions and attitudes of images
[[nodiscard]] std::string words_of_datum(const FindingWords& w);             ///< what fixes the block
[[nodiscard]] std::string words_of_weak_images(const FindingWords& w);       ///< images that hang loosely
[[nodiscard]] std::string words_of_weak_unknowns(const FindingWords& w);     ///< unknowns that are determined badly
[[nodiscard]] std::string words_of_weak_cases(const FindingWords& w);    ///< scenes and motions that determine badly
[[nodiscard]] std::string words_of_orientation(const FindingWords& w);   ///< what orientation and adjustment did
[[nodiscard]] std::string words_of_products(const FindingWords& w);      ///< products and exchange
[[nodiscard]] std::string words_of_pair(const FindingWords& w);          ///< a pair of images
[[nodiscard]] std::string words_of_models(const FindingWords& w);        ///< independent models
[[nodiscard]] std::string words_of_fit(const FindingWords& w);           ///< control and residuals of a single step
[[nodiscard]] std::string words_of_measured(const FindingWords& w);      ///< measurements of a single step
[[nodiscard]] std::string words_of_poses(const FindingWords& w);         ///< orientations by a single step
[[nodiscard]] std::string words_of_rays(const FindingWords& w);          ///< points by intersection
[[nodiscard]] std::string words_of_uncalibrated(const FindingWords& w);  ///< images without a known camera
[[nodiscard]] std::string words_of_fiducials(const FindingWords& w);     ///< marks of films

}  // namespace collinea
