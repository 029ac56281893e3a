// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/asked_figures.h"

#include <algorithm>
#include <sstream>

#include "collinea/base/file.h"

namespace collinea {
namespace {

// Lines of a file, or what stands between semicolons.
Result<std::vector<std::string>> figure_lines(const std::string& figures) {
  std::string text = figures;
  const bool is_file = figures.find(' ') == figures.npos && !figures.empty();
  if (is_file) {
    COLLINEA_TRY(text, read_file(figures));
  } else {
    std::ranges::replace(text, ';', '\n');
  }
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.find_first_not_of(" \t\r") != line.npos && line[0] != '#') lines.push_back(line);
  return lines;
}

}  // namespace

Result<std::vector<MeasuredReport::Figure>> read_figures(const std::string& asked) {
  std::vector<MeasuredReport::Figure> out;
  COLLINEA_TRY(const auto lines, figure_lines(asked));
  for (const std::string& line : lines) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    const auto kind = from_word<FigureKind>(word);
    if (!kind) {
      std::string known;
      for (const auto& entry : kFigureKindWords) known += (known.empty() ? "" : ", ") + std::string(entry.word);
      return fail(Errc::kBadInput, "no figure is called \"" + word + "\": choose one of " + known, {"figures"_option});
    }
    MeasuredReport::Figure& figure = out.emplace_back();
    figure.kind = *kind;
    for (std::string name; words >> name;) figure.points.push_back(name);
  }
  return out;
}

}  // namespace collinea
