// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/counted.h"
#include "collinea/report/internal/page.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

// Over which files a digest goes: "18 photographs and 2 other files".
std::string counts_of(const SignedFiles& all, SignedPart part) {
  const auto count = [&](FileRole role) {
    return std::count_if(all.files.begin(), all.files.end(), [&](const SignedFile& file) { return file.role == role; });
  };
  const auto unread = std::count_if(all.files.begin(), all.files.end(), [&](const SignedFile& file) {
    return file.sha256.empty() && (part == SignedPart::kInputs ? file.is_input() : file.role == FileRole::kProduct);
  });
  std::string text = part == SignedPart::kProducts ? counted(count(FileRole::kProduct), "file")
                                                   : counted(count(FileRole::kImage), "photograph");
  if (const auto given = count(FileRole::kGiven); part == SignedPart::kInputs && given > 0)
    text += " and " + counted(given, "other file");
  return text + (unread > 0 ? fmt::format(", {} of which could not be read", unread) : "");
}

std::string digest_row(const char* name, const SignedFiles& all, SignedPart part) {
  const std::string digest = digest_of(all, part);
  if (digest.empty()) return "";
  return "<tr>" + text_cell(name) + "<td>" + escaped(counts_of(all, part)) +
         fmt::format("<br><span class=\"hash\">SHA-256 {}</span></td></tr>\n", digest);
}

std::string line(const char* name, const std::string& value) {
  return fmt::format("<div>{}<span>{}</span></div>", escaped(value), name);
}

}  // namespace

std::string signature_section(const ReportInput& input) {
  std::string html = "<section class=\"signed\"><h2>Signature</h2>\n";
  if (input.files) {
    html += "<table class=\"pairs\"><tbody>\n<tr>" + text_cell("made by") +
            text_cell(fmt::format("collinea {}, seed {}", input.files->version, input.files->seed)) + "</tr>\n" +
            digest_row("inputs", *input.files, SignedPart::kInputs) +
            digest_row("products", *input.files, SignedPart::kProducts) +
            "</tbody></table>\n<p>The hash of every file is in hashes.json. <code>collinea verify</code> compares "
            "them with the files and prints the two hashes above.</p>\n";
  }
  return html + "<div class=\"signature\">" + line("Surveyor", input.signer.surveyor) +
         line("Licence or register", input.signer.licence) + line("Date", input.signer.signed_on) +
         line("Signature", "") + "</div>\n</section>\n";
}

}  // namespace collinea
