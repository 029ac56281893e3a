// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <exiv2/exiv2.hpp>

#include "collinea/raster/codec.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

Exiv2::URational ratio(double value, std::uint32_t per_unit) {
  return {std::uint32_t(std::llround(std::abs(value) * per_unit)), per_unit};
}

void put(Exiv2::ExifData& exif, const char* key, const Exiv2::URational& value) { exif[key] = value; }

void put(Exiv2::ExifData& exif, const char* key, const std::string& text) {
  if (!text.empty()) exif[key] = text;
}

void put(Exiv2::XmpData& xmp, const char* key, const std::optional<double>& value, const char* format) {
  if (!value) return;
  char text[64];
  std::snprintf(text, sizeof text, format, *value);
  xmp[key] = std::string(text);
}

// Degrees, minutes and seconds; seconds in millionths (3e-10 degrees).
void put_angle(Exiv2::ExifData& exif, const char* key, double angle_deg) {
  auto millionths = std::uint64_t(std::llround(std::abs(angle_deg) * 3600e6));
  Exiv2::URationalValue value;
  value.value_ = {{std::uint32_t(millionths / 3600'000'000), 1},
                  {std::uint32_t(millionths / 60'000'000 % 60), 1},
                  {std::uint32_t(millionths % 60'000'000), 1'000'000}};
  exif.add(Exiv2::ExifKey(key), &value);
}

void put_camera(const ImageHeader& header, Exiv2::ExifData& exif) {
  put(exif, "Exif.Image.Make", header.maker);
  put(exif, "Exif.Image.Model", header.model);
  exif["Exif.Image.Orientation"] = std::uint16_t(header.orientation);
  put(exif, "Exif.Photo.LensModel", header.lens);
  put(exif, "Exif.Photo.BodySerialNumber", header.serial);
  if (header.focal_mm) put(exif, "Exif.Photo.FocalLength", ratio(*header.focal_mm, 100'000));
  if (header.focal_35mm_mm)
    exif["Exif.Photo.FocalLengthIn35mmFilm"] = std::uint16_t(std::lround(*header.focal_35mm_mm));
  exif["Exif.Photo.PixelXDimension"] = std::uint32_t(header.width_px);
  exif["Exif.Photo.PixelYDimension"] = std::uint32_t(header.height_px);
  if (header.pixel_pitch_mm) {
    put(exif, "Exif.Photo.FocalPlaneXResolution", ratio(10 / *header.pixel_pitch_mm, 10'000));
    put(exif, "Exif.Photo.FocalPlaneYResolution", ratio(10 / *header.pixel_pitch_mm, 10'000));
    exif["Exif.Photo.FocalPlaneResolutionUnit"] = std::uint16_t(3);  // centimetre
  }
  if (header.taken.size() >= 19) put(exif, "Exif.Photo.DateTimeOriginal", header.taken.substr(0, 19));
  if (header.taken.size() > 20) put(exif, "Exif.Photo.SubSecTimeOriginal", header.taken.substr(20));
}

void put_position(const ImageHeader& header, Exiv2::ExifData& exif) {
  if (!header.latitude_deg || !header.longitude_deg) return;
  exif["Exif.GPSInfo.GPSVersionID"] = "2 3 0 0";
  exif["Exif.GPSInfo.GPSLatitudeRef"] = *header.latitude_deg < 0 ? "S" : "N";
  exif["Exif.GPSInfo.GPSLongitudeRef"] = *header.longitude_deg < 0 ? "W" : "E";
  put_angle(exif, "Exif.GPSInfo.GPSLatitude", *header.latitude_deg);
  put_angle(exif, "Exif.GPSInfo.GPSLongitude", *header.longitude_deg);
  if (!header.height_m) return;
  exif["Exif.GPSInfo.GPSAltitudeRef"] = *header.height_m < 0 ? "1" : "0";
  put(exif, "Exif.GPSInfo.GPSAltitude", ratio(*header.height_m, 10'000));
}

void put_flight(const ImageHeader& header, Exiv2::XmpData& xmp) {
  put(xmp, "Xmp.drone-dji.GimbalYawDegree", header.heading_deg, "%+.4f");
  put(xmp, "Xmp.drone-dji.GimbalPitchDegree", header.pitch_deg, "%+.4f");
  put(xmp, "Xmp.drone-dji.GimbalRollDegree", header.roll_deg, "%+.4f");
  put(xmp, "Xmp.drone-dji.RelativeAltitude", header.relative_height_m, "%+.4f");
  put(xmp, "Xmp.drone-dji.RtkStdLon", header.sigma_east_m, "%.5f");
  put(xmp, "Xmp.drone-dji.RtkStdLat", header.sigma_north_m, "%.5f");
  put(xmp, "Xmp.drone-dji.RtkStdHgt", header.sigma_height_m, "%.5f");
}

}  // namespace

Result<std::string> with_header(const std::string& jpeg, const ImageHeader& header) {
  set_up_exiv2();
  try {
    const auto image = Exiv2::ImageFactory::open(reinterpret_cast<const Exiv2::byte*>(jpeg.data()), long(jpeg.size()));
    Exiv2::ExifData exif;
    Exiv2::XmpData xmp;
    put_camera(header, exif);
    put_position(header, exif);
    put_flight(header, xmp);
    image->setExifData(exif);
    if (!xmp.empty()) image->setXmpData(xmp);
    image->writeMetadata();
    Exiv2::BasicIo& io = image->io();
    io.open();
    std::string bytes(std::size_t(io.size()), '\0');
    const long got = io.read(reinterpret_cast<Exiv2::byte*>(bytes.data()), long(bytes.size()));
    io.close();
    if (got != long(bytes.size())) return fail(Errc::kBadFormat, "EXIF cannot be written into this JPEG");
    return bytes;
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, std::string("EXIF cannot be written: ") + error.what());
  }
}

}  // namespace collinea
