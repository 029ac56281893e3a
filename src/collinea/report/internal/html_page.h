// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace collinea {

/// What a page has beside its body. Plain texts, not HTML.
struct PageHead {
  std::string title;  ///< of the project
  std::string kind;   ///< "adjustment": in the title of the window, and below every printed sheet
  std::string about;  ///< below the title: "Adjustment report"
  std::string date;   ///< as it shall be printed; empty: none
};

/// A page in one file, for screens and for A4 paper: head, looks and body. Each table of the body gets a frame that
/// scrolls where the window is too narrow and takes a smaller type on paper the more columns there are, so that no
/// table runs out of the page.
[[nodiscard]] std::string whole_page(const PageHead& head, std::string_view body);

/// Each table of the body in its frame: part of whole_page().
[[nodiscard]] std::string with_framed_tables(std::string_view body);

/// The looks of all pages.
extern const char* const kStyleSheet;

}  // namespace collinea
