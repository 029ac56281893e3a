// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "collinea/base/file.h"
#include "collinea/raster/codec.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/internal/jpeg_decoder.h"
#include "collinea/raster/jpeg_writer.h"

namespace collinea {
namespace {

bool read_header(JpegDecoder& decoder, const std::string& bytes) {
  if (setjmp(decoder.errors.back)) return false;
  jpeg_create_decompress(&decoder.info);
  jpeg_mem_src(&decoder.info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&decoder.info, TRUE);
  return true;
}

bool start(JpegDecoder& decoder, int channels, int shrink) {
  if (setjmp(decoder.errors.back)) return false;
  jpeg_decompress_struct& info = decoder.info;
  const bool four_inks = info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK;
  info.out_color_space = four_inks ? JCS_CMYK : channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  info.scale_num = 1;
  info.scale_denom = unsigned(shrink);
  jpeg_start_decompress(&info);
  return true;
}

bool read_rows(JpegDecoder& decoder, Raster<std::uint8_t>& image) {
  if (setjmp(decoder.errors.back)) return false;
  while (decoder.info.output_scanline < decoder.info.output_height) {
    JSAMPROW rows[4];
    const int first = int(decoder.info.output_scanline);
    const int count = std::min(4, image.height - first);
    for (int i = 0; i < count; ++i) rows[i] = image.row(first + i);
    jpeg_read_scanlines(&decoder.info, rows, JDIMENSION(count));
  }
  jpeg_finish_decompress(&decoder.info);  // reads on to the end marker: a file cut just before it is noticed too
  return true;
}

struct JpegEncoder {
  jpeg_compress_struct info = {};
  JpegErrors errors;
  unsigned char* bytes = nullptr;
  unsigned long size = 0;

  JpegEncoder() {
    set_up(errors);
    info.err = &errors.base;
  }
  ~JpegEncoder() {
    jpeg_destroy_compress(&info);
    std::free(bytes);
  }
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
};

void start(jpeg_compress_struct& info, int width, int height, int channels, int quality) {
  info.image_width = JDIMENSION(width);
  info.image_height = JDIMENSION(height);
  info.input_components = channels;
  info.in_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, std::clamp(quality, 1, 100), TRUE);
  jpeg_start_compress(&info, TRUE);
}

void write_rows(jpeg_compress_struct& info, const Raster<std::uint8_t>& rows) {
  for (int y = 0; y < rows.height; ++y) {
    JSAMPROW row = const_cast<JSAMPROW>(rows.row(y));
    jpeg_write_scanlines(&info, &row, 1);
  }
}

bool encode(JpegEncoder& encoder, const Raster<std::uint8_t>& image, int quality) {
  if (setjmp(encoder.errors.back)) return false;
  jpeg_create_compress(&encoder.info);
  jpeg_mem_dest(&encoder.info, &encoder.bytes, &encoder.size);
  start(encoder.info, image.width, image.height, image.channels, quality);
  write_rows(encoder.info, image);
  jpeg_finish_compress(&encoder.info);
  return true;
}

Result<> check_jpeg_size(int width, int height) {
  if (width < 1 || height < 1 || width > 65500 || height > 65500)
    return fail(Errc::kUnsupported, "a JPEG image has 1 to 65500 columns and rows");
  return {};
}

tl::unexpected<Error> not_written(const JpegEncoder& encoder) {
  return fail(Errc::kBadInput, std::string("JPEG cannot be written: ") + encoder.errors.message);
}

// Where libjpeg writes: a buffer that goes to a file when it is full.
struct FileSink {
  jpeg_destination_mgr base;  // first: libjpeg hands out a pointer to it
  OutputFile* file;
  JOCTET buffer[1 << 16];

  static FileSink& of(j_compress_ptr info) { return *reinterpret_cast<FileSink*>(info->dest); }
  void rewind() {
    base.next_output_byte = buffer;
    base.free_in_buffer = sizeof buffer;
  }
  void drain(std::size_t bytes) { file->write({reinterpret_cast<const char*>(buffer), bytes}); }
};

void use(FileSink& sink, jpeg_compress_struct& info) {
  sink.base.init_destination = [](j_compress_ptr of) { FileSink::of(of).rewind(); };
  sink.base.empty_output_buffer = [](j_compress_ptr of) -> boolean {
    FileSink::of(of).drain(sizeof FileSink::buffer);
    FileSink::of(of).rewind();
    return TRUE;
  };
  sink.base.term_destination = [](j_compress_ptr of) {
    FileSink::of(of).drain(sizeof FileSink::buffer - FileSink::of(of).base.free_in_buffer);
  };
  info.dest = &sink.base;
}

bool begin(JpegEncoder& encoder, FileSink& sink, int width, int height, int channels, int quality) {
  if (setjmp(encoder.errors.back)) return false;
  jpeg_create_compress(&encoder.info);
  use(sink, encoder.info);
  start(encoder.info, width, height, channels, quality);
  return true;
}

bool go_on(JpegEncoder& encoder, const Raster<std::uint8_t>& rows) {
  if (setjmp(encoder.errors.back)) return false;
  write_rows(encoder.info, rows);
  return true;
}

bool end(JpegEncoder& encoder) {
  if (setjmp(encoder.errors.back)) return false;
  jpeg_finish_compress(&encoder.info);
  return true;
}

}  // namespace

Raster<std::uint8_t> rgb_from_cmyk(const Raster<std::uint8_t>& inks, bool inverted) {
  Raster<std::uint8_t> rgb(inks.width, inks.height, 3);
  const std::size_t count = std::size_t(inks.width) * std::size_t(inks.height);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* ink = &inks.data[4 * i];
    const int black = inverted ? ink[3] : 255 - ink[3];
    for (std::size_t c = 0; c < 3; ++c)
      rgb.data[3 * i + c] = std::uint8_t(((inverted ? ink[c] : 255 - ink[c]) * black + 127) / 255);
  }
  return rgb;
}

Result<Raster<std::uint8_t>> decode_jpeg(const std::string& bytes, int channels, int shrink) {
  COLLINEA_CHECK(channels == 1 || channels == 3);
  JpegDecoder decoder;
  if (!read_header(decoder, bytes)) return decoder.error();
  COLLINEA_TRY(check_size(decoder.info.image_width, decoder.info.image_height, bytes.size(), kJpegPxPerByte));
  if (!start(decoder, channels, shrink)) return decoder.error();
  Raster<std::uint8_t> image(int(decoder.info.output_width), int(decoder.info.output_height),
                             decoder.info.output_components);
  if (!read_rows(decoder, image)) return decoder.error();
  if (image.channels == 4) image = rgb_from_cmyk(image, decoder.info.saw_Adobe_marker);
  return with_channels(std::move(image), channels);
}

Result<Size> jpeg_size(const std::string& bytes, std::uint64_t file_bytes) {
  JpegDecoder decoder;
  if (!read_header(decoder, bytes)) return decoder.error();
  COLLINEA_TRY(check_size(decoder.info.image_width, decoder.info.image_height, file_bytes, kJpegPxPerByte));
  return Size{int(decoder.info.image_width), int(decoder.info.image_height)};
}

Result<std::string> encode_jpeg(const Raster<std::uint8_t>& image, int quality) {
  COLLINEA_CHECK(image.channels == 1 || image.channels == 3);
  COLLINEA_TRY(check_jpeg_size(image.width, image.height));
  JpegEncoder encoder;
  if (!encode(encoder, image, quality)) return not_written(encoder);
  return std::string(reinterpret_cast<const char*>(encoder.bytes), encoder.size);
}

struct JpegWriter::State {
  explicit State(OutputFile out) : file(std::move(out)) { sink.file = &file; }
  OutputFile file;
  FileSink sink;
  JpegEncoder encoder;
};

JpegWriter::JpegWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
JpegWriter::JpegWriter(JpegWriter&&) noexcept = default;
JpegWriter::~JpegWriter() = default;

Result<JpegWriter> JpegWriter::create(const std::filesystem::path& path, int width, int height, int channels,
                                      int quality) {
  COLLINEA_CHECK(channels == 1 || channels == 3);
  COLLINEA_TRY(check_jpeg_size(width, height));
  COLLINEA_TRY(OutputFile file, OutputFile::create(path));
  auto state = std::make_unique<State>(std::move(file));
  if (!begin(state->encoder, state->sink, width, height, channels, quality)) return not_written(state->encoder);
  return JpegWriter(std::move(state));
}

Result<> JpegWriter::write(const Raster<std::uint8_t>& rows) {
  const jpeg_compress_struct& info = state_->encoder.info;
  COLLINEA_CHECK(rows.channels == info.input_components && rows.width == int(info.image_width));
  if (!go_on(state_->encoder, rows)) return not_written(state_->encoder);
  return {};
}

Result<> JpegWriter::finish() {
  if (!end(state_->encoder)) return not_written(state_->encoder);
  return state_->file.finish();
}

}  // namespace collinea
