// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/find_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "collinea/base/file.h"
#include "collinea/base/parallel_in_order.h"
#include "collinea/edit/edit.h"
#include "collinea/feature/edges.h"
#include "collinea/io/control_file.h"
#include "collinea/io/text.h"
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

// A tag that is called by a name, and how many images show it once.
struct Called {
  Key key;
  std::ptrdiff_t images = 0;
};

// The tags that a name may mean: those that images show once, without `control` two of them.
std::map<std::string, std::vector<Called>> called(const Seen& seen, const std::optional<ControlFile>& control) {
  std::map<std::string, std::vector<Called>> by_name;
  for (const auto& [key, images] : seen) {
    const auto once = std::ranges::count_if(images, [](const auto& entry) { return entry.second == 1; });
    if (once < (control ? 1 : 2)) continue;
    const std::string name = control ? named_in(*control, key.second) : std::to_string(key.second);
    if (!name.empty()) by_name[name].push_back({key, once});
  }
  return by_name;
}

// Tags of one name are of several families. One that a single image shows may be misread and gives way to those of
// several images.
std::map<Key, std::string> names_of(const Seen& seen, const std::optional<ControlFile>& control) {
  std::map<Key, std::string> names;
  for (auto& [name, tags] : called(seen, control)) {
    const auto is_single = [](const Called& one) { return one.images < 2; };
    if (!std::ranges::all_of(tags, is_single)) std::erase_if(tags, is_single);
    if (tags.size() == 1)
      names[tags.front().key] = name;
    else if (!control)
      for (const Called& one : tags) names[one.key] = std::string(word_of(one.key.first)) + "-" + name;
  }
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

std::string name_in_marks(const fs::path& image) { return image.filename().string(); }

// As it is written: pixels with four decimals, a standard deviation with four digits.
MarkPoint edit_of(const NamedTag& one, const std::string& image) {
  MarkPoint mark{.point = one.point, .image = image, .sigma_px = std::sqrt(one.tag.covariance.trace() / 2)};
  mark.pixel = (one.tag.at * 1e4).array().round() / 1e4;
  mark.sigma_px = number(fmt::format("{:.4g}", *mark.sigma_px)).value();
  return mark;
}

std::string marks_of(const TagsReport& report, MarksAs as) {
  std::string text;
  if (as == MarksAs::kControl)
    text = "# " + std::string(kControlImageColumns) + "\n# " + std::string(kImageCovarianceColumns) + "\n";
  for (const NamedTag& one : report.tags) {
    if (one.point.empty()) continue;
    const std::string image = name_in_marks(report.images[one.image]);
    const MarkPoint mark = edit_of(one, image);
    if (as == MarksAs::kEdits) {
      text += line_of(words_of(Edit(mark))) + "\n";
      continue;
    }
    const Eigen::Matrix2d& c = one.tag.covariance;
    text += fmt::format("image, {}, {}, {:.4f}, {:.4f}, {:.4g}\n", one.point, image, mark.pixel.x(), mark.pixel.y(),
                        *mark.sigma_px);
    text +=
        fmt::format("image_covariance, {}, {}, {:.4e}, {:.4e}, {:.4e}\n", one.point, image, c(0, 0), c(0, 1), c(1, 1));
  }
  return text;
}

// --- what cannot be written

// Rows of a control file have no quotation marks.
Result<> check_name_in_row(const std::string& name) {
  if (trimmed(name) == name && name.find(',') == std::string::npos) return {};
  return fail(Errc::kBadInput,
              "\"" + name +
                  "\" cannot stand in rows of a control file, because commas separate and spaces at the ends " +
                  "are lost: rename it, or write edits",
              {"as"_option});
}

Result<> check_names(std::span<const fs::path> images, const std::optional<ControlFile>& control, MarksAs as) {
  const auto check = [&](const std::string& point, const std::string& image) -> Result<> {
    COLLINEA_TRY(MarkPoint::parse(std::vector<std::string>{point, image, "1", "1"}));
    if (as == MarksAs::kEdits) return {};
    COLLINEA_TRY(check_name_in_row(point));
    return check_name_in_row(image);
  };
  std::map<std::string, fs::path> known;
  for (const fs::path& image : images) {
    const std::string name = name_in_marks(image);
    COLLINEA_TRY(check("1", name));
    const auto [other, is_new] = known.emplace(name, image);
    if (!is_new)
      return fail(Errc::kBadInput, other->second.string() + " and " + image.string() +
                                       " have the same name, and marks name a photograph by it: rename one of them");
  }
  if (control)
    for (const ControlFilePoint& point : control->points) COLLINEA_TRY(check(point.name, "1"));
  return {};
}

// Where what is read would be lost.
Result<> check_out(const fs::path& out, std::span<const fs::path> images, const FindTagsOptions& options) {
  std::vector<fs::path> read(images.begin(), images.end());
  if (options.control) read.push_back(*options.control);
  for (const fs::path& one : read)
    if (std::error_code ignored; fs::equivalent(one, out, ignored))
      return fail(Errc::kBadInput, out.string() + " would be written over what is read from it");
  return {};
}

}  // namespace

Result<TagsReport> find_tags_in_files(std::span<const fs::path> images, const fs::path& out,
                                      const FindTagsOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (images.empty()) return fail(Errc::kBadInput, "which images? Name one or more");
  COLLINEA_TRY(check_out(out, images, options));
  std::optional<ControlFile> control;
  if (options.control) {
    COLLINEA_TRY(control, read_control(*options.control));
  }
  COLLINEA_TRY(check_names(images, control, options.as));
  TagsReport report{.images = {images.begin(), images.end()}, .tags = {}, .file = out};
  const auto tags_in = [&](std::size_t i) -> Result<std::vector<Tag>> {
    COLLINEA_TRY(const GreyImage grey, read_grey(images[i]));
    return find_tags(as_float(grey), options.tags);
  };
  const auto take = [&](std::size_t i, std::vector<Tag> tags) -> Result<> {
    for (Tag& tag : tags) report.tags.push_back({std::move(tag), i, {}});
    run.report("tags", double(i + 1) / double(images.size()));
    return {};
  };
  COLLINEA_TRY(parallel_in_order(run, images.size(), tags_in, take));
  name_all(report.tags, control);
  COLLINEA_TRY(write_file(out, marks_of(report, options.as)));
  return report;
}

}  // namespace collinea
