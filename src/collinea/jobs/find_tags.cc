// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/find_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "collinea/base/file.h"
#include "collinea/feature/edges.h"
#include "collinea/io/control_file.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Key = std::pair<TagFamily, int>;

Key key_of(const NamedTag& one) { return {one.tag.family, one.tag.id}; }

// The point called by the number of a tag, else the only one whose name ends in it.
std::string named_in(const ControlFile& control, int id) {
  std::vector<std::string> ends;
  for (const ControlFilePoint& point : control.points) {
    if (point.name == std::to_string(id)) return point.name;
    if (is_name_of_tag(point.name, id)) ends.push_back(point.name);
  }
  return ends.size() == 1 ? ends.front() : std::string();
}

using Seen = std::map<Key, std::map<std::size_t, int>>;  // how often an image shows a tag

// Names of tags that images show once; those of one name have none.
std::map<Key, std::string> names_of(const Seen& seen, const std::optional<ControlFile>& control) {
  std::set<TagFamily> families;
  for (const auto& [key, images] : seen) families.insert(key.first);
  std::map<Key, std::string> names;
  std::map<std::string, int> used;
  for (const auto& [key, images] : seen) {
    const auto once = std::ranges::count_if(images, [](const auto& entry) { return entry.second == 1; });
    const std::string number = std::to_string(key.second);
    std::string name = control               ? named_in(*control, key.second)
                       : once < 2            ? std::string()
                       : families.size() > 1 ? std::string(word_of(key.first)) + "-" + number
                                             : number;
    ++used[name];
    names[key] = std::move(name);
  }
  std::erase_if(names, [&](const auto& entry) { return used[entry.second] > 1; });
  return names;
}

void name_all(std::vector<NamedTag>& tags, const std::optional<ControlFile>& control) {
  Seen seen;
  for (const NamedTag& one : tags) ++seen[key_of(one)][one.image];
  const std::map<Key, std::string> names = names_of(seen, control);
  for (NamedTag& one : tags) {
    const auto name = names.find(key_of(one));
    if (name != names.end() && seen[key_of(one)][one.image] == 1) one.point = name->second;
  }
}

// A word of a list of edits: in quotation marks where it has spaces.
std::string quoted(const std::string& word) { return word.find(' ') == std::string::npos ? word : "\"" + word + "\""; }

std::string marks_of(const TagsReport& report, MarksAs as) {
  std::string text;
  if (as == MarksAs::kControl)
    text = "# " + std::string(kControlImageColumns) + "\n# " + std::string(kImageCovarianceColumns) + "\n";
  for (const NamedTag& one : report.tags) {
    if (one.point.empty()) continue;
    const std::string image = report.images[one.image].filename().string();
    const Eigen::Matrix2d& c = one.tag.covariance;
    const double x = one.tag.at.x(), y = one.tag.at.y(), sigma = std::sqrt(c.trace() / 2);
    if (as == MarksAs::kEdits) {
      text += fmt::format("mark {} {} {:.4f} {:.4f} {:.4f}\n", quoted(one.point), quoted(image), x, y, sigma);
      continue;
    }
    text += fmt::format("image, {}, {}, {:.4f}, {:.4f}, {:.4f}\n", one.point, image, x, y, sigma);
    text +=
        fmt::format("image_covariance, {}, {}, {:.4e}, {:.4e}, {:.4e}\n", one.point, image, c(0, 0), c(0, 1), c(1, 1));
  }
  return text;
}

}  // namespace

Result<TagsReport> find_tags_in_files(std::span<const fs::path> images, const fs::path& out,
                                      const FindTagsOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (images.empty()) return fail(Errc::kBadInput, "which images? Name one or more");
  std::optional<ControlFile> control;
  if (options.control) {
    COLLINEA_TRY(control, read_control(*options.control));
  }
  TagsReport report{.images = {images.begin(), images.end()}, .tags = {}, .file = out};
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    COLLINEA_TRY(const GreyImage grey, read_grey(images[i]));
    for (Tag& tag : find_tags(as_float(grey), options.tags)) report.tags.push_back({std::move(tag), i, {}});
    run.report("tags", double(i + 1) / double(images.size()));
  }
  name_all(report.tags, control);
  COLLINEA_TRY(write_file(out, marks_of(report, options.as)));
  return report;
}

}  // namespace collinea
