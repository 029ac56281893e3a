// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/enhance.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Bytes = Raster<std::uint8_t>;

void apply(const GreyTable& table, Bytes& image, const GreyImage* known, const Run& run) {
  constexpr std::size_t kAtOnce = 1 << 20;
  const auto channels = static_cast<std::size_t>(image.channels);
  parallel_for(run, (image.data.size() + kAtOnce - 1) / kAtOnce, [&](std::size_t part) {
    const std::size_t end = std::min(image.data.size(), (part + 1) * kAtOnce);
    for (std::size_t i = part * kAtOnce; i < end; ++i)
      if (!known || known->data[i / channels] != 0) image.data[i] = table[image.data[i]];
  });
}

// What is empty as zeros.
void clear_empty(Bytes& image, const GreyImage* known) {
  if (!known) return;
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    if (known->data[i / channels] == 0) image.data[i] = 0;
}

// Red, green, blue and alpha.
Bytes with_alpha(const Bytes& image, const GreyImage& known) {
  Bytes out(image.width, image.height, 4);
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < known.data.size(); ++i) {
    out.data[4 * i + 3] = known.data[i];
    for (std::size_t c = 0; c < 3 && known.data[i] != 0; ++c)
      out.data[4 * i + c] = image.data[channels * i + (channels == 1 ? 0 : c)];
  }
  return out;
}

Bytes in_colours(const Bytes& image, Palette palette) {
  const auto colours = palette_table(palette);
  Bytes out(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    std::copy_n(colours[image.data[i]].data(), 3, out.data.data() + 3 * i);
  return out;
}

// The image on its way through the steps.
class Enhancement {
 public:
  /// `mask`: nothing, where no pixel is empty.
  Enhancement(Bytes image, std::optional<GreyImage> mask, EnhanceReport& report, const Run& run)
      : image_(std::move(image)), known_(std::move(mask)), report_(report), run_(run) {
    clear_empty(image_, known());
    note("image");
  }

  void filter(const EnhanceOptions& o) {
    if (o.gaussian_px > 0) become("gaussian", gaussian_filtered(image_, o.gaussian_px, run_, known()));
    if (o.reduce > 1) reduce(o);
    if (o.contrast == Contrast::kWallis) become("wallis", wallis_filtered(image_, o.wallis, run_, known()));
  }

  // Error: a threshold is to be found where there is one grey value alone.
  Result<> use_tables(const EnhanceOptions& o) {
    if (o.contrast == Contrast::kStretch) {
      report_.black = here().quantile(o.low_percent / 100);
      report_.white = here().quantile(o.high_percent / 100);
      use("stretch", stretch_table(*report_.black, *report_.white));
    } else if (o.contrast == Contrast::kEqualise) {
      use("equalise", equalisation_table(here()));
    }
    if (o.lut == GreyLut::kThreshold) {
      const std::optional<int> threshold = o.threshold ? o.threshold : otsu_threshold(here());
      if (!threshold)
        return fail(Errc::kIllPosed, "the image has one grey value, which no threshold parts: give one",
                    {"threshold"_option});
      report_.is_threshold_found = !o.threshold;
      report_.threshold = threshold;
    }
    if (o.lut != GreyLut::kNone) use(std::string(word_of(o.lut)), table_of(o));
    return {};
  }

  void dither(const EnhanceOptions& o) {
    if (o.dither == Dither::kFloydSteinberg)
      become("floyd-steinberg", dithered_by_diffusion(image_, o.levels, known()));
    else if (o.dither == Dither::kOrdered)
      become("ordered", dithered_by_cells(image_, o.levels, o.cell_px));
  }

  /// As it is to be written: with an alpha channel where pixels are empty.
  [[nodiscard]] Bytes shown(Palette palette) const {
    const Bytes colours = palette == Palette::kGrey ? image_ : in_colours(image_, palette);
    return known_ ? with_alpha(colours, *known_) : colours;
  }

 private:
  [[nodiscard]] const GreyImage* known() const { return known_ ? &*known_ : nullptr; }
  [[nodiscard]] const GreyHistogram& here() const { return report_.steps.back().histogram; }
  void note(std::string name) {
    report_.steps.push_back({std::move(name), image_.width, image_.height, grey_histogram(image_, known())});
  }
  void become(std::string name, Bytes image) {
    image_ = std::move(image);
    clear_empty(image_, known());
    note(std::move(name));
  }
  void reduce(const EnhanceOptions& o) {
    if (!known_) return become(std::string(word_of(o.reduction)), reduced(image_, o.reduce, o.reduction, run_));
    ReducedPart part = reduced(image_, *known_, o.reduce, o.reduction, run_);
    known_ = std::move(part.known);
    become(std::string(word_of(o.reduction)), std::move(part.image));
  }
  void use(std::string name, const GreyTable& table) {
    if (report_.table.empty()) report_.table = {identity_table()};
    report_.table.front() = chained(report_.table.front(), table);
    apply(table, image_, known(), run_);
    note(std::move(name));
  }
  GreyTable table_of(const EnhanceOptions& o) {
    switch (o.lut) {
      case GreyLut::kGamma:
        return gamma_table(o.gamma);
      case GreyLut::kNegative:
        return negative_table();
      case GreyLut::kSlices:
        return slicing_table(o.slices);
      case GreyLut::kThreshold:
        return threshold_table(*report_.threshold);
      case GreyLut::kNone:
        break;
    }
    return identity_table();
  }

  Bytes image_;
  std::optional<GreyImage> known_;
  EnhanceReport& report_;
  const Run& run_;
};

// Options of something that is not done: whoever gives one believes that it is.
Result<> check_read(const EnhanceOptions& o) {
  const EnhanceOptions usual;
  if (o.reduction != usual.reduction && o.reduce <= 1)
    return fail(Errc::kBadInput, "nothing is reduced", {"reduction"_option, "reduce"_option});
  if ((o.low_percent != usual.low_percent || o.high_percent != usual.high_percent) && o.contrast != Contrast::kStretch)
    return fail(Errc::kBadInput, "only a stretch has quantiles",
                {"low_percent"_option, "high_percent"_option, "contrast"_option});
  if (o.wallis != usual.wallis && o.contrast != Contrast::kWallis)
    return fail(Errc::kBadInput, "Wallis' filter is not asked for", {"wallis_window_px"_option, "contrast"_option});
  if (o.gamma != usual.gamma && o.lut != GreyLut::kGamma)
    return fail(Errc::kBadInput, "nothing is raised to a power", {"gamma"_option, "lut"_option});
  if (o.threshold && o.lut != GreyLut::kThreshold)
    return fail(Errc::kBadInput, "nothing has a threshold", {"threshold"_option, "lut"_option});
  if (o.slices != usual.slices && o.lut != GreyLut::kSlices)
    return fail(Errc::kBadInput, "nothing is sliced", {"slices"_option, "lut"_option});
  if (o.levels != usual.levels && o.dither == Dither::kNone)
    return fail(Errc::kBadInput, "nothing is dithered", {"levels"_option, "dither"_option});
  if (o.cell_px != usual.cell_px && o.dither != Dither::kOrdered)
    return fail(Errc::kBadInput, "only ordered dithering has cells", {"cell_px"_option, "dither"_option});
  return {};
}

Result<> check_together(const EnhanceOptions& o) {
  if (o.colour && o.palette != Palette::kGrey)
    return fail(Errc::kBadInput, "a palette shows grey values: leave the colours of the image out, or the palette",
                {"palette"_option, "colour"_option});
  if (o.contrast == Contrast::kStretch && o.low_percent >= o.high_percent)
    return fail(Errc::kBadInput, "the lower quantile must lie below the upper one",
                {"low_percent"_option, "high_percent"_option});
  return {};
}

}  // namespace

Result<EnhanceReport> enhance_image(const fs::path& file, const fs::path& folder, const EnhanceOptions& options,
                                    const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(check_together(options));
  COLLINEA_TRY(check_read(options));
  COLLINEA_TRY(Bytes image, options.colour ? read_colour(file) : read_grey(file));
  COLLINEA_TRY(std::optional<GreyImage> known, read_known_pixels(file));
  EnhanceReport report{.image = file.filename().string(), .channels = image.channels};
  if (known) report.empty_share = double(std::ranges::count(known->data, std::uint8_t{0})) / double(known->data.size());
  if (report.empty_share == 1) return fail(Errc::kIllPosed, file.string() + ": all pixels are empty");
  Enhancement work(std::move(image), std::move(known), report, run);
  work.filter(options);
  COLLINEA_TRY(work.use_tables(options));
  work.dither(options);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  COLLINEA_TRY(make_out_folder(folder));
  COLLINEA_TRY(write_png(folder / "enhanced.png", work.shown(options.palette)));
  COLLINEA_TRY(write_file(folder / "statistics.txt", text_of(grey_statistics_table(report))));
  COLLINEA_TRY(write_file(folder / "histogram.txt", text_of(histogram_table(report))));
  COLLINEA_TRY(write_file(folder / "histogram.svg", histogram_svg(report)));
  return report;
}

}  // namespace collinea
