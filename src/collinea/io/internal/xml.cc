// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/xml.h"

#include <algorithm>
#include <optional>
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
      COLLINEA_TRY(skip_text(nullptr));
      COLLINEA_TRY(const bool skipped, skip_markup(nullptr));
      if (skipped) continue;
      if (at_ >= text_.size()) return bad("the file has no element, or ends within one");
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

  Result<> skip_text(std::string* kept) {
    const auto end = std::min(text_.find('<', at_), text_.size());
    if (kept) {
      COLLINEA_TRY(const std::string decoded, without_entities(text_.substr(at_, end - at_)));
      kept->append(decoded);
    }
    at_ = end;
    return {};
  }

  // Comments, CDATA (which is text, into `kept`) and processing instructions; false where none stands.
  Result<bool> skip_markup(std::string* kept) {
    struct Markup {
      std::string_view begin, end;
      bool is_text;
    };
    for (const Markup& one : {Markup{"<!--", "-->", false}, {"<![CDATA[", "]]>", true}, {"<?", "?>", false}}) {
      if (!text_.substr(at_).starts_with(one.begin)) continue;
      const auto from = at_ + one.begin.size(), end = text_.find(one.end, from);
      if (end == std::string_view::npos)
        return bad(std::string(one.begin) + " does not end with " + std::string(one.end));
      if (one.is_text && kept) kept->append(text_.substr(from, end - from));
      at_ = end + one.end.size();
      return true;
    }
    if (text_.substr(at_).starts_with("<!"))
      return bad("<!...> that is no comment: this reader knows no document types");
    return false;
  }

  Result<std::string> without_entities(std::string_view text) {
    std::string decoded;
    for (auto mark = text.find('&'); mark != std::string_view::npos; mark = text.find('&')) {
      decoded.append(text.substr(0, mark));
      text.remove_prefix(mark + 1);
      const auto end = text.find(';');
      const std::string_view name = text.substr(0, std::min(end, std::size_t{12}));
      const auto character = end == std::string_view::npos ? std::nullopt : character_of(name);
      if (!character) return bad("&" + std::string(name) + ": no character of XML has that name; & is written &amp;");
      decoded += *character;
      text.remove_prefix(end + 1);
    }
    return decoded.append(text);
  }

  static std::optional<char> character_of(std::string_view name) {
    constexpr std::pair<std::string_view, char> kNamed[] = {
        {"lt", '<'}, {"gt", '>'}, {"amp", '&'}, {"quot", '"'}, {"apos", '\''}};
    for (const auto& [known, character] : kNamed)
      if (name == known) return character;
    if (!name.starts_with('#')) return std::nullopt;
    const auto code = integer(name.substr(1));
    return code && *code >= 32 && *code < 127 ? std::optional(static_cast<char>(*code)) : std::nullopt;
  }

  // name="value" or name='value'
  Result<> attribute(XmlElement& e) {
    const std::string name(word());
    const auto open = text_.find_first_of("\"'", at_);
    const auto close = open == std::string_view::npos ? open : text_.find(text_[open], open + 1);
    if (name.empty() || close == std::string_view::npos || trimmed(text_.substr(at_, open - at_)) != "=")
      return bad("in element " + e.name + ": an attribute is expected as name=\"value\"");
    COLLINEA_TRY(std::string value, without_entities(text_.substr(open + 1, close - open - 1)));
    if (!e.attributes.emplace(name, std::move(value)).second)
      return bad("in element " + e.name + ": a second attribute " + name);
    at_ = close + 1;
    return {};
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
    for (skip_blank(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; skip_blank())
      COLLINEA_TRY(attribute(e));
    if (text_.substr(at_).starts_with("/>")) {
      at_ += 2;
      return e;
    }
    if (at_ >= text_.size() || text_[at_] != '>') return bad("element " + e.name + " does not end");
    ++at_;
    COLLINEA_TRY(contents(e, depth));
    return e;
  }

  // What stands in an element, and its end.
  Result<> contents(XmlElement& e, int depth) {
    const bool is_remark = e.name == "c" || e.name == "meta";  // which may hold anything
    while (true) {
      COLLINEA_TRY(skip_text(is_remark ? nullptr : &e.text));
      if (at_ >= text_.size()) return bad("the file ends within element " + e.name + "; is it complete?");
      if (text_.substr(at_).starts_with("</")) {
        at_ += 2;
        if (const auto name = word(); name != e.name) return bad("element " + e.name + " ends as " + std::string(name));
        skip_blank();
        if (at_ >= text_.size() || text_[at_] != '>') return bad("the end of element " + e.name + " lacks its >");
        ++at_;
        e.text = trimmed(e.text);
        return {};
      }
      if (is_remark) {
        const auto end = text_.find("</" + e.name + ">", at_);
        if (end == std::string_view::npos) return bad("the file ends within element " + e.name);
        at_ = end;
        continue;
      }
      COLLINEA_TRY(const bool skipped, skip_markup(&e.text));
      if (skipped) continue;
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
