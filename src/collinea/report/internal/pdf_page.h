// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>

#include "collinea/base/result.h"

namespace collinea {

/// Where a text stands to its position.
enum class TextAnchor { kStart, kMiddle, kEnd };

/// One sheet of paper, drawn in millimetres from its lower left corner; written as PDF. The same drawing gives the same
/// bytes: no date, no fonts of the machine. The only user of libharu.
class PdfPage {
 public:
  [[nodiscard]] static Result<PdfPage> create(double width_mm, double height_mm, const std::string& title);

  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width_mm, double grey = 0);
  void rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, double line_mm, bool filled = false);
  /// In Helvetica; letters beyond Latin-1 become "?".
  void text(const Eigen::Vector2d& at, double size_mm, const std::string& text, TextAnchor anchor = TextAnchor::kStart);
  /// A JPEG that fills a rectangle.
  void image(std::string_view jpeg, const Eigen::Vector2d& corner, const Eigen::Vector2d& size);

  /// The bytes of the file. Error: something of what was drawn could not be written.
  [[nodiscard]] Result<std::string> finish();

  PdfPage(PdfPage&&) noexcept;
  PdfPage& operator=(PdfPage&&) noexcept;
  ~PdfPage();

 private:
  PdfPage();
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace collinea
