// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csetjmp>
#include <cstdio>
#include <string>
// jpeglib.h needs <cstdio> before it.
#include <jerror.h>
#include <jpeglib.h>

#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

// libjpeg leaves by longjmp. Functions that call setjmp therefore hold no C++ object with a destructor, and say by
// their bool whether they got through; the message stays in JpegErrors.

namespace collinea {

/// What libjpeg says, and where it leaves to.
struct JpegErrors {
  jpeg_error_mgr base;  // first: libjpeg hands out a pointer to it
  std::jmp_buf back;
  char message[JMSG_LENGTH_MAX];
};

inline void leave(j_common_ptr info) {
  auto* errors = reinterpret_cast<JpegErrors*>(info->err);
  info->err->format_message(info, errors->message);
  std::longjmp(errors->back, 1);
}

// Stray bytes before a marker and odd headers leave the image whole; every other warning means lost content.
inline void on_message(j_common_ptr info, int level) {
  if (level >= 0) return;
  switch (info->err->msg_code) {
    case JWRN_EXTRANEOUS_DATA:
    case JWRN_ADOBE_XFORM:
    case JWRN_JFIF_MAJOR:
    case JWRN_NOT_SEQUENTIAL:
    case JWRN_TOO_MUCH_DATA:
      break;
    default:
      leave(info);
  }
}

inline void set_up(JpegErrors& errors) {
  jpeg_std_error(&errors.base);
  errors.base.error_exit = leave;
  errors.base.emit_message = on_message;
  errors.base.output_message = [](j_common_ptr) {};
  errors.message[0] = '\0';
}

/// A decoder of libjpeg that is destroyed at its end.
struct JpegDecoder {
  jpeg_decompress_struct info = {};
  JpegErrors errors;

  JpegDecoder() {
    set_up(errors);
    info.err = &errors.base;
  }
  ~JpegDecoder() { jpeg_destroy_decompress(&info); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  tl::unexpected<Error> error() const {
    return fail(Errc::kBadFormat, std::string("damaged or incomplete JPEG: ") + errors.message);
  }
};

/// Colours of four inks, which Adobe writes inverted: 255 is no ink.
[[nodiscard]] Raster<std::uint8_t> rgb_from_cmyk(const Raster<std::uint8_t>& inks, bool inverted);

}  // namespace collinea
