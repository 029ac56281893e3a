// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/finding_words.h"

#include <fmt/format.h>

#include "collinea/report/internal/finding_sentences.h"

namespace collinea {

std::string reason_of(const Finding& skipped, const Block& block) {
  const FindingWords words{skipped, block};
  switch (skipped.code) {
    case FindingCode::kImageTooSmall:
      return fmt::format("smaller than {} x {} pixels", words.whole(FigureName::kLimit),
                         words.whole(FigureName::kLimit));
    case FindingCode::kImageDuplicate:
      return "the same bytes as " + words.subject(1);
    case FindingCode::kFolderUnreadable:
      return "cannot be read: " + skipped.detail;
    case FindingCode::kScanNotOriented:
      return "no interior orientation: " + skipped.detail;
    case FindingCode::kNoDepthMap:
      return "no depth map: " + skipped.detail;
    default:
      return skipped.detail;
  }
}

std::string what_of(const Finding& finding, const Block& block) {
  const FindingWords words{finding, block};
  for (const auto of : {words_of_given, words_of_measured_control, words_of_marks, words_of_control, words_of_positions,
                        words_of_datum, words_of_weak_images, words_of_weak_unknowns, words_of_weak_cases,
                        words_of_orientation, words_of_products, words_of_pair, words_of_models, words_of_fit,
                        words_of_measured, words_of_poses, words_of_rays, words_of_uncalibrated, words_of_fiducials})
    if (std::string text = of(words); !text.empty()) return text;
  return std::string(word_of(finding.code)) + ".";
}

}  // namespace collinea
