// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/pdf_page.h"

#include <fmt/format.h>
#include <hpdf.h>

namespace collinea {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;

HPDF_REAL points(double mm) { return HPDF_REAL(mm * kPointsPerMm); }

// UTF-8 as the encoding that the standard fonts have.
std::string latin_of(const std::string& text) {
  std::string latin;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x80) {
      latin += text[i];
    } else if ((byte == 0xC2 || byte == 0xC3) && i + 1 < text.size()) {
      latin += char((byte == 0xC3 ? 0x40 : 0) + static_cast<unsigned char>(text[++i]));
    } else {
      latin += '?';
      while (i + 1 < text.size() && (static_cast<unsigned char>(text[i + 1]) & 0xC0) == 0x80) ++i;
    }
  }
  return latin;
}

}  // namespace

struct PdfPage::State {
  HPDF_Doc file = nullptr;
  HPDF_Page page = nullptr;
  HPDF_Font font = nullptr;
  HPDF_STATUS wrong = 0;  // the first error of the library

  ~State() {
    if (file) HPDF_Free(file);
  }
};

namespace {
void note_error(HPDF_STATUS error, HPDF_STATUS, void* of) {
  auto* state = static_cast<HPDF_STATUS*>(of);
  if (*state == 0) *state = error;
}
}  // namespace

PdfPage::PdfPage() : state_(std::make_unique<State>()) {}
PdfPage::PdfPage(PdfPage&&) noexcept = default;
PdfPage& PdfPage::operator=(PdfPage&&) noexcept = default;
PdfPage::~PdfPage() = default;

Result<PdfPage> PdfPage::create(double width_mm, double height_mm, const std::string& title) {
  PdfPage page;
  State& s = *page.state_;
  s.file = HPDF_New(note_error, &s.wrong);
  if (!s.file) return fail(Errc::kBadInput, "no PDF can be made: memory is full");
  HPDF_SetCompressionMode(s.file, HPDF_COMP_TEXT);
  HPDF_SetInfoAttr(s.file, HPDF_INFO_TITLE, latin_of(title).c_str());
  HPDF_SetInfoAttr(s.file, HPDF_INFO_CREATOR, "collinea");
  s.page = HPDF_AddPage(s.file);
  s.font = HPDF_GetFont(s.file, "Helvetica", "WinAnsiEncoding");
  HPDF_Page_SetWidth(s.page, points(width_mm));
  HPDF_Page_SetHeight(s.page, points(height_mm));
  if (s.wrong)
    return fail(Errc::kBadInput, fmt::format("no sheet of {:.0f} x {:.0f} mm can be made", width_mm, height_mm));
  return page;
}

void PdfPage::line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width_mm, double grey) {
  State& s = *state_;
  HPDF_Page_SetLineWidth(s.page, points(width_mm));
  HPDF_Page_SetGrayStroke(s.page, HPDF_REAL(grey));
  HPDF_Page_MoveTo(s.page, points(a.x()), points(a.y()));
  HPDF_Page_LineTo(s.page, points(b.x()), points(b.y()));
  HPDF_Page_Stroke(s.page);
}

void PdfPage::rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, double line_mm, bool filled) {
  State& s = *state_;
  HPDF_Page_SetLineWidth(s.page, points(line_mm));
  HPDF_Page_SetGrayStroke(s.page, 0);
  HPDF_Page_SetGrayFill(s.page, 0);
  HPDF_Page_Rectangle(s.page, points(corner.x()), points(corner.y()), points(size.x()), points(size.y()));
  if (filled)
    HPDF_Page_FillStroke(s.page);
  else
    HPDF_Page_Stroke(s.page);
}

void PdfPage::text(const Eigen::Vector2d& at, double size_mm, const std::string& text, TextAnchor anchor) {
  State& s = *state_;
  const std::string latin = latin_of(text);
  HPDF_Page_SetGrayFill(s.page, 0);
  HPDF_Page_BeginText(s.page);
  HPDF_Page_SetFontAndSize(s.page, s.font, points(size_mm));
  const double width = HPDF_Page_TextWidth(s.page, latin.c_str());
  const double before = anchor == TextAnchor::kStart ? 0 : anchor == TextAnchor::kMiddle ? width / 2 : width;
  HPDF_Page_MoveTextPos(s.page, HPDF_REAL(points(at.x()) - before), points(at.y()));
  HPDF_Page_ShowText(s.page, latin.c_str());
  HPDF_Page_EndText(s.page);
}

void PdfPage::image(std::string_view jpeg, const Eigen::Vector2d& corner, const Eigen::Vector2d& size) {
  State& s = *state_;
  const HPDF_Image image =
      HPDF_LoadJpegImageFromMem(s.file, reinterpret_cast<const HPDF_BYTE*>(jpeg.data()), HPDF_UINT(jpeg.size()));
  if (image)
    HPDF_Page_DrawImage(s.page, image, points(corner.x()), points(corner.y()), points(size.x()), points(size.y()));
}

Result<std::string> PdfPage::finish() {
  State& s = *state_;
  if (!s.wrong) HPDF_SaveToStream(s.file);
  if (s.wrong) return fail(Errc::kBadInput, fmt::format("the PDF cannot be written (libharu {:#06x})", s.wrong));
  HPDF_ResetStream(s.file);
  std::string bytes(HPDF_GetStreamSize(s.file), '\0');
  auto size = HPDF_UINT32(bytes.size());
  HPDF_ReadFromStream(s.file, reinterpret_cast<HPDF_BYTE*>(bytes.data()), &size);
  bytes.resize(size);
  return bytes;
}

}  // namespace collinea
