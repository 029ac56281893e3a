// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/jpeg_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "collinea/raster/codec.h"
#include "collinea/raster/internal/jpeg_decoder.h"

namespace collinea {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

bool read_header(JpegDecoder& decoder, std::FILE* file) {
  if (setjmp(decoder.errors.back)) return false;
  jpeg_create_decompress(&decoder.info);
  jpeg_stdio_src(&decoder.info, file);
  jpeg_read_header(&decoder.info, TRUE);
  return true;
}

bool start(JpegDecoder& decoder, bool grey, int shrink) {
  if (setjmp(decoder.errors.back)) return false;
  jpeg_decompress_struct& info = decoder.info;
  const bool four_inks = info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK;
  info.out_color_space = four_inks ? JCS_CMYK : grey ? JCS_GRAYSCALE : JCS_RGB;
  info.scale_num = 1;
  info.scale_denom = unsigned(shrink);
  jpeg_start_decompress(&info);
  return true;
}

bool fill(JpegDecoder& decoder, Raster<std::uint8_t>& rows) {
  if (setjmp(decoder.errors.back)) return false;
  for (int y = 0; y < rows.height;) {
    JSAMPROW row = rows.row(y);
    y += int(jpeg_read_scanlines(&decoder.info, &row, 1));
  }
  return true;
}

// Reads on to the end marker: a file cut just before it is noticed, too.
bool finish(JpegDecoder& decoder) {
  if (setjmp(decoder.errors.back)) return false;
  jpeg_finish_decompress(&decoder.info);
  return true;
}

// The decoder cuts at whole blocks of code: the columns that it gives begin at `left`, or before it.
bool go_to(JpegDecoder& decoder, JDIMENSION& left, JDIMENSION& width, int top) {
  if (setjmp(decoder.errors.back)) return false;
  jpeg_crop_scanline(&decoder.info, &left, &width);
  jpeg_skip_scanlines(&decoder.info, JDIMENSION(top));
  return true;
}

using File = std::unique_ptr<std::FILE, CloseFile>;

Result<File> begun(JpegDecoder& decoder, const std::filesystem::path& path) {
  File file(std::fopen(path.c_str(), "rbe"));
  if (!file) return fail(Errc::kNotFound, path.string() + ": cannot be opened: " + std::strerror(errno));
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(path, error);
  if (error) return fail(Errc::kBadFormat, "reading " + path.string() + ": " + error.message());
  if (!read_header(decoder, file.get())) return decoder.error();
  const auto sized = check_size(decoder.info.image_width, decoder.info.image_height, bytes, kJpegPxPerByte);
  if (!sized) return tl::unexpected(sized.error());
  return file;
}

}  // namespace

struct JpegReader::State {
  JpegDecoder decoder;
  File file;
  std::filesystem::path path;

  [[nodiscard]] tl::unexpected<Error> error() const {
    return tl::unexpected(Error(decoder.error().value()).within("reading " + path.string()));
  }
};

JpegReader::JpegReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
JpegReader::JpegReader(JpegReader&&) noexcept = default;
JpegReader::~JpegReader() = default;

Result<JpegReader> JpegReader::open(const std::filesystem::path& path, int shrink) {
  COLLINEA_CHECK(shrink == 1 || shrink == 2 || shrink == 4 || shrink == 8);
  auto state = std::make_unique<State>();
  state->path = path;
  COLLINEA_TRY(state->file, begun(state->decoder, path).map_error([&](Error error) {
    return error.code == Errc::kNotFound ? error : std::move(error).within("reading " + path.string());
  }));
  const bool grey = state->decoder.info.jpeg_color_space == JCS_GRAYSCALE;
  if (!start(state->decoder, grey, shrink)) return state->error();
  return JpegReader(std::move(state));
}

int JpegReader::width() const { return int(state_->decoder.info.output_width); }
int JpegReader::height() const { return int(state_->decoder.info.output_height); }
int JpegReader::channels() const { return state_->decoder.info.output_components == 1 ? 1 : 3; }
int JpegReader::full_width_px() const { return int(state_->decoder.info.image_width); }
int JpegReader::full_height_px() const { return int(state_->decoder.info.image_height); }
bool JpegReader::at_end() const { return state_->decoder.info.output_scanline >= state_->decoder.info.output_height; }

Result<Raster<std::uint8_t>> JpegReader::read(int rows) {
  JpegDecoder& decoder = state_->decoder;
  const int left = int(decoder.info.output_height - decoder.info.output_scanline);
  Raster<std::uint8_t> out(width(), std::min(rows, left), decoder.info.output_components);
  if (!fill(decoder, out)) return state_->error();
  if (out.height > 0 && at_end() && !finish(decoder)) return state_->error();
  return out.channels == 4 ? rgb_from_cmyk(out, decoder.info.saw_Adobe_marker) : std::move(out);
}

Result<GreyImage> read_jpeg_window(const std::filesystem::path& path, const PixelWindow& window) {
  JpegDecoder decoder;
  const auto within = [&](Error error) {
    return error.code == Errc::kNotFound ? error : std::move(error).within("reading " + path.string());
  };
  COLLINEA_TRY(const File file, begun(decoder, path).map_error(within));
  const auto damaged = [&] { return tl::unexpected(within(decoder.error().value())); };
  const bool is_inside = window.left >= 0 && window.top >= 0 && window.width > 0 && window.height > 0 &&
                         window.left + window.width <= int(decoder.info.image_width) &&
                         window.top + window.height <= int(decoder.info.image_height);
  if (!is_inside) return fail(Errc::kBadFormat, path.string() + ": the window is not inside the image");
  if (!start(decoder, true, 1)) return damaged();
  JDIMENSION left = JDIMENSION(window.left), width = JDIMENSION(window.width);
  if (!go_to(decoder, left, width, window.top)) return damaged();
  Raster<std::uint8_t> rows(int(width), window.height, decoder.info.output_components);
  if (!fill(decoder, rows)) return damaged();
  if (rows.channels == 4) rows = with_channels(rgb_from_cmyk(rows, decoder.info.saw_Adobe_marker), 1);
  GreyImage out(window.width, window.height);
  for (int y = 0; y < out.height; ++y) std::copy_n(rows.row(y) + (window.left - int(left)), out.width, out.row(y));
  return out;
}

}  // namespace collinea
