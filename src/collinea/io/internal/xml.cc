// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/xml.h"

#include <algorithm>
#include <utility>

#include "collinea/io/text.h"

namespace collinea {
namespace {

class XmlParser {
 public:
  explicit XmlParser(std::string_view text) : text_(text) {}

  Result<XmlElement> parse() {
    XmlElement root;
    while (true) {
      skip_text(nullptr);
      if (at_ >= text_.size()) return bad("the file has no element, or ends within one");
      if (text_.substr(at_).starts_with("<?")) {
        const auto end = text_.find("?>", at_);
        if (end == std::string_view::npos) return bad("<? does not end");
        at_ = end + 2;
        continue;
      }
      return element(0);
    }
  }

 private:
  tl::unexpected<Error> bad(const std::string& what) {
    return fail(Errc::kBadFormat, "line " + std::to_string(line_here()) + ": " + what);
  }

  // Counted on from where it was last asked for: counting from the start for each element takes hours for a large file.
  std::size_t line_here() {
    const std::size_t here = std::min(at_, text_.size());
    if (here < counted_) line_ = 1, counted_ = 0;
    const auto from = text_.begin() + std::ptrdiff_t(counted_), to = text_.begin() + std::ptrdiff_t(here);
    line_ += std::size_t(std::count(from, to, '\n'));
    counted_ = here;
    return line_;
  }

  void skip_text(std::string* kept) {
    const auto end = std::min(text_.find('<', at_), text_.size());
    if (kept) kept->append(text_.substr(at_, end - at_));
    at_ = end;
  }

  std::string_view word() {
    const auto end = std::min(text_.find_first_of(" \t\r\n=/>", at_), text_.size());
    const std::string_view found = text_.substr(at_, end - at_);
    at_ = end;
    return found;
  }

  void skip_blank() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }

  Result<XmlElement> element(int depth) {
    constexpr int kDeepest = 64;
    if (depth > kDeepest) return bad("elements are nested too deeply");
    XmlElement e;
    e.line = line_here();
    ++at_;  // <
    e.name = word();
    if (e.name.empty()) return bad("an element without a name");
    for (skip_blank(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; skip_blank()) {
      const std::string name(word());
      const auto open = text_.find('"', at_), close = open == std::string_view::npos ? open : text_.find('"', open + 1);
      if (name.empty() || close == std::string_view::npos || trimmed(text_.substr(at_, open - at_)) != "=")
        return bad("in element " + e.name + ": an attribute is expected as name=\"value\"");
      e.attributes[name] = text_.substr(open + 1, close - open - 1);
      at_ = close + 1;
    }
    if (text_.substr(at_).starts_with("/>")) {
      at_ += 2;
      return e;
    }
    if (at_ >= text_.size() || text_[at_] != '>') return bad("element " + e.name + " does not end");
    ++at_;
    while (true) {
      skip_text(&e.text);
      if (at_ >= text_.size()) return bad("the file ends within element " + e.name + "; is it complete?");
      if (text_.substr(at_).starts_with("</")) {
        at_ += 2;
        if (const auto name = word(); name != e.name) return bad("element " + e.name + " ends as " + std::string(name));
        skip_blank();
        if (at_ >= text_.size() || text_[at_] != '>') return bad("the end of element " + e.name + " lacks its >");
        ++at_;
        e.text = trimmed(e.text);
        return e;
      }
      if (e.name == "c" || e.name == "meta") {  // remarks, which may hold anything
        const auto end = text_.find("</" + e.name + ">", at_);
        if (end == std::string_view::npos) return bad("the file ends within element " + e.name);
        at_ = end;
        continue;
      }
      COLLINEA_TRY(XmlElement child, element(depth + 1));
      e.children.push_back(std::move(child));
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t counted_ = 0, line_ = 1;  // the line of position counted_
};

}  // namespace

Result<XmlElement> parse_xml(std::string_view text) { return XmlParser(text).parse(); }

}  // namespace collinea
