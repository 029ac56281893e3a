// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <vector>

#include "collinea/raster/codec.h"

// As in jpeg.cc: libpng leaves by longjmp, so functions with setjmp hold no C++ objects of their own.

namespace collinea {
namespace {

// Above, images are packed quickly in place of well: a tenth larger, in a tenth of the time.
constexpr double kLargeImagePx = 20e6;

struct PngState {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::jmp_buf back;
  char message[200] = {};
  const std::string* input = nullptr;
  std::size_t position = 0;
  std::string output;
  bool writes = false;

  PngState() = default;
  ~PngState() { writes ? png_destroy_write_struct(&png, &info) : png_destroy_read_struct(&png, &info, nullptr); }
  PngState(const PngState&) = delete;
  PngState& operator=(const PngState&) = delete;

  tl::unexpected<Error> error() const {
    return fail(Errc::kBadFormat, std::string("damaged or incomplete PNG: ") + message);
  }
};

void on_error(png_structp png, png_const_charp message) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::strncpy(state->message, message, sizeof state->message - 1);
  std::longjmp(state->back, 1);
}

void on_warning(png_structp, png_const_charp) {}

void give(png_structp png, png_bytep to, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (count > state->input->size() - state->position) png_error(png, "the file ends too early");
  std::memcpy(to, state->input->data() + state->position, count);
  state->position += count;
}

void take(png_structp png, png_bytep from, std::size_t count) {
  static_cast<PngState*>(png_get_io_ptr(png))->output.append(reinterpret_cast<const char*>(from), count);
}

bool read_header(PngState& state) {
  if (setjmp(state.back)) return false;
  state.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, on_error, on_warning);
  if (!state.png) return false;
  state.info = png_create_info_struct(state.png);
  if (!state.info) return false;
  png_set_read_fn(state.png, &state, give);
  png_read_info(state.png, state.info);
  return true;
}

Result<> check_header(const PngState& state, std::uint64_t file_bytes) {
  const int bits = std::max(1, png_get_bit_depth(state.png, state.info) * png_get_channels(state.png, state.info));
  return check_size(png_get_image_width(state.png, state.info), png_get_image_height(state.png, state.info), file_bytes,
                    8 * kDeflateBytesPerByte / std::uint64_t(bits) + 1);
}

// To 8 or 16 bits (in this machine's byte order), 1 or 3 channels.
bool simplify(PngState& state) {
  if (setjmp(state.back)) return false;
  png_set_expand(state.png);
  png_set_strip_alpha(state.png);
  if (png_get_bit_depth(state.png, state.info) == 16 && std::endian::native == std::endian::little)
    png_set_swap(state.png);
  png_set_interlace_handling(state.png);
  png_read_update_info(state.png, state.info);
  return true;
}

bool read_rows(PngState& state, png_bytepp rows, int count) {
  if (setjmp(state.back)) return false;
  png_read_rows(state.png, rows, nullptr, png_uint_32(count));
  return true;
}

// Of interlaced ones all rows are read again and again.
bool read_interlaced(PngState& state, png_bytepp rows) {
  if (setjmp(state.back)) return false;
  png_read_image(state.png, rows);
  return true;
}

bool read_end(PngState& state) {
  if (setjmp(state.back)) return false;
  png_read_end(state.png, nullptr);
  return true;
}

bool read_samples(PngState& state, EightBitImage& image) {
  constexpr int kRows = 64;  // at once
  const SampleFormat format{.width = int(png_get_image_width(state.png, state.info)),
                            .height = int(png_get_image_height(state.png, state.info)),
                            .channels = png_get_channels(state.png, state.info),
                            .is_deep = png_get_bit_depth(state.png, state.info) == 16};
  COLLINEA_CHECK(format.channels == 1 || format.channels == 3);
  const bool is_interlaced = png_get_interlace_type(state.png, state.info) != PNG_INTERLACE_NONE;
  const int most = is_interlaced ? format.height : std::min(kRows, format.height);
  const std::size_t stride = std::size_t(format.width) * std::size_t(format.channels) * (format.is_deep ? 2 : 1);
  std::vector<png_byte> samples(stride * std::size_t(most));
  std::vector<png_bytep> rows;
  for (int y = 0; y < most; ++y) rows.push_back(samples.data() + std::size_t(y) * stride);
  image.begin(format);
  for (int top = 0; top < format.height; top += most) {
    const int count = std::min(most, format.height - top);
    if (!(is_interlaced ? read_interlaced(state, rows.data()) : read_rows(state, rows.data(), count))) return false;
    image.take({.top = top,
                .width = format.width,
                .height = count,
                .samples = samples.data(),
                .row_px = format.width,
                .samples_of_px = format.channels});
  }
  return read_end(state);
}

bool write_all(PngState& state, const Raster<std::uint8_t>& image, png_bytepp rows) {
  if (setjmp(state.back)) return false;
  state.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, on_error, on_warning);
  if (!state.png) return false;
  state.info = png_create_info_struct(state.png);
  if (!state.info) return false;
  png_set_write_fn(state.png, &state, take, nullptr);
  const int colour = image.channels == 1   ? PNG_COLOR_TYPE_GRAY
                     : image.channels == 3 ? PNG_COLOR_TYPE_RGB
                                           : PNG_COLOR_TYPE_RGB_ALPHA;
  png_set_IHDR(state.png, state.info, png_uint_32(image.width), png_uint_32(image.height), 8, colour,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (double(image.width) * image.height > kLargeImagePx) {
    png_set_compression_level(state.png, 1);
    png_set_filter(state.png, 0, PNG_FILTER_SUB);
  }
  png_write_info(state.png, state.info);
  png_write_image(state.png, rows);
  png_write_end(state.png, nullptr);
  return true;
}

}  // namespace

Result<> decode_png(const std::string& bytes, EightBitImage& image) {
  PngState state;
  state.input = &bytes;
  if (!read_header(state)) return state.error();
  COLLINEA_TRY(check_header(state, bytes.size()));
  if (!simplify(state) || !read_samples(state, image)) return state.error();
  return {};
}

Result<Size> png_size(const std::string& bytes, std::uint64_t file_bytes) {
  PngState state;
  state.input = &bytes;
  if (!read_header(state)) return state.error();
  COLLINEA_TRY(check_header(state, file_bytes));
  return Size{int(png_get_image_width(state.png, state.info)), int(png_get_image_height(state.png, state.info))};
}

Result<std::string> encode_png(const Raster<std::uint8_t>& image) {
  COLLINEA_CHECK(image.channels == 1 || image.channels == 3 || image.channels == 4);
  if (image.width < 1 || image.height < 1) return fail(Errc::kBadInput, "an image without pixels");
  PngState state;
  state.writes = true;
  std::vector<png_bytep> rows(std::size_t(image.height));
  for (int y = 0; y < image.height; ++y) rows[std::size_t(y)] = const_cast<png_bytep>(image.row(y));
  if (!write_all(state, image, rows.data()))
    return fail(Errc::kBadInput, std::string("PNG cannot be written: ") + state.message);
  return std::move(state.output);
}

}  // namespace collinea
