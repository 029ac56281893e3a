// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <exiv2/exiv2.hpp>
#include <mutex>

#include "collinea/raster/codec.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

std::string trimmed(std::string text) {
  text.erase(text.find_last_not_of(" \t\r\n\0", std::string::npos, 5) + 1);
  text.erase(0, std::min(text.size(), text.find_first_not_of(" \t\r\n\0", 0, 5)));
  return text;
}

// "+12.5", "-3", "5/2"; nothing else.
std::optional<double> parsed(std::string text) {
  text = trimmed(std::move(text));
  const char *at = text.data(), *end = at + text.size();
  if (at != end && *at == '+') ++at;
  double value = 0;
  auto [rest, error] = std::from_chars(at, end, value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  if (rest != end && *rest == '/') {
    double divisor = 0;
    const auto [rest2, error2] = std::from_chars(rest + 1, end, divisor);
    if (error2 != std::errc() || divisor == 0) return std::nullopt;
    value /= divisor;
    rest = rest2;
  }
  if (rest != end) return std::nullopt;
  return value;
}

// Exiv2 itself goes through float and signed integers, which loses digits of GPS; 0/0 means "unknown" in EXIF.
std::optional<double> number(const Exiv2::Value& value, std::size_t i = 0) {
  if (i >= std::size_t(value.count())) return std::nullopt;
  if (const auto* ratios = dynamic_cast<const Exiv2::URationalValue*>(&value)) {
    const auto [up, down] = ratios->value_[i];
    return down ? std::optional(double(up) / double(down)) : std::nullopt;
  }
  if (const auto* ratios = dynamic_cast<const Exiv2::RationalValue*>(&value)) {
    const auto [up, down] = ratios->value_[i];
    return down ? std::optional(double(up) / double(down)) : std::nullopt;
  }
  if (const auto* doubles = dynamic_cast<const Exiv2::DoubleValue*>(&value))
    return std::isfinite(doubles->value_[i]) ? std::optional(doubles->value_[i]) : std::nullopt;
  return parsed(value.toString(long(i)));
}

/// The tags of one file; every question is answered by what is there, or by nothing.
struct Tags {
  const Exiv2::ExifData& exif;
  const Exiv2::XmpData& xmp;

  const Exiv2::Value* exif_value(const char* key) const {
    const auto at = exif.findKey(Exiv2::ExifKey(key));
    return at == exif.end() || at->count() == 0 ? nullptr : &at->value();
  }
  std::optional<double> exif_number(const char* key) const {
    const Exiv2::Value* value = exif_value(key);
    return value ? number(*value) : std::nullopt;
  }
  std::string exif_text(const char* key) const {
    const Exiv2::Value* value = exif_value(key);
    return value ? trimmed(value->toString()) : std::string();
  }
  std::string xmp_text(const char* key) const {
    const auto at = xmp.findKey(Exiv2::XmpKey(key));
    return at == xmp.end() || at->count() == 0 ? std::string() : trimmed(at->toString());
  }
  std::optional<double> xmp_number(const char* key) const { return parsed(xmp_text(key)); }
};

std::optional<double> positive(std::optional<double> value) { return value && *value > 0 ? value : std::nullopt; }

std::optional<double> exif_angle_deg(const Tags& tags, const char* key, const char* reference_key, char negative) {
  const Exiv2::Value* value = tags.exif_value(key);
  if (!value) return std::nullopt;
  const std::optional<double> degrees = number(*value, 0);
  if (!degrees) return std::nullopt;
  // Minutes and seconds may be missing, or 0/0, when the degrees hold the fraction.
  const double angle = std::abs(*degrees) + number(*value, 1).value_or(0) / 60 + number(*value, 2).value_or(0) / 3600;
  const std::string reference = tags.exif_text(reference_key);
  const bool below =
      reference.empty() ? *degrees < 0 : std::toupper(static_cast<unsigned char>(reference[0])) == negative;
  return below ? -angle : angle;
}

bool is_location(const std::optional<double>& latitude_deg, const std::optional<double>& longitude_deg) {
  // Devices without a fix write 0, 0.
  return latitude_deg && longitude_deg && std::abs(*latitude_deg) <= 90 && std::abs(*longitude_deg) <= 180 &&
         (*latitude_deg != 0 || *longitude_deg != 0);
}

std::optional<double> exif_height_m(const Tags& tags) {
  std::optional<double> height_m = tags.exif_number("Exif.GPSInfo.GPSAltitude");
  if (height_m && tags.exif_number("Exif.GPSInfo.GPSAltitudeRef").value_or(0) == 1) height_m = -std::abs(*height_m);
  return height_m;
}

void read_position(const Tags& tags, ImageHeader& header) {
  std::optional<double> latitude_deg =
      exif_angle_deg(tags, "Exif.GPSInfo.GPSLatitude", "Exif.GPSInfo.GPSLatitudeRef", 'S');
  std::optional<double> longitude_deg =
      exif_angle_deg(tags, "Exif.GPSInfo.GPSLongitude", "Exif.GPSInfo.GPSLongitudeRef", 'W');
  std::optional<double> height_m = exif_height_m(tags);
  const bool in_exif = is_location(latitude_deg, longitude_deg);

  const std::optional<double> fine_latitude_deg = tags.xmp_number("Xmp.drone-dji.GpsLatitude");
  std::optional<double> fine_longitude_deg = tags.xmp_number("Xmp.drone-dji.GpsLongitude");
  if (!fine_longitude_deg) fine_longitude_deg = tags.xmp_number("Xmp.drone-dji.GpsLongtitude");  // sic: early firmware
  const std::optional<double> fine_height_m = tags.xmp_number("Xmp.drone-dji.AbsoluteAltitude");

  // Where the two agree XMP has more digits; where they do not, EXIF was corrected after the flight.
  constexpr double kSame_deg = 2e-6, kSame_m = 0.2;
  if (is_location(fine_latitude_deg, fine_longitude_deg) &&
      (!in_exif || (std::abs(*fine_latitude_deg - *latitude_deg) < kSame_deg &&
                    std::abs(*fine_longitude_deg - *longitude_deg) < kSame_deg))) {
    latitude_deg = fine_latitude_deg;
    longitude_deg = fine_longitude_deg;
    if (fine_height_m && (!height_m || std::abs(*fine_height_m - *height_m) < kSame_m)) height_m = fine_height_m;
  }
  if (!is_location(latitude_deg, longitude_deg)) return;
  header.latitude_deg = latitude_deg;
  header.longitude_deg = longitude_deg;
  header.height_m = height_m;
}

void read_position_sigmas(const Tags& tags, ImageHeader& header) {
  const std::optional<double> fix = tags.xmp_number("Xmp.drone-dji.RtkFlag");  // 0: no position at all
  if (!fix || *fix != 0) {
    header.sigma_east_m = positive(tags.xmp_number("Xmp.drone-dji.RtkStdLon"));
    header.sigma_north_m = positive(tags.xmp_number("Xmp.drone-dji.RtkStdLat"));
    header.sigma_height_m = positive(tags.xmp_number("Xmp.drone-dji.RtkStdHgt"));
  }
  if (!header.sigma_east_m || !header.sigma_north_m) {
    std::optional<double> plan_m = positive(tags.xmp_number("Xmp.Camera.GPSXYAccuracy"));
    if (!plan_m) plan_m = positive(tags.exif_number("Exif.GPSInfo.0x001f"));  // GPSHPositioningError
    header.sigma_east_m = header.sigma_north_m = plan_m;
  }
  if (!header.sigma_height_m) header.sigma_height_m = positive(tags.xmp_number("Xmp.Camera.GPSZAccuracy"));
}

void read_attitude(const Tags& tags, ImageHeader& header) {
  for (const auto& [yaw, pitch, roll] :
       {std::array{"Xmp.drone-dji.GimbalYawDegree", "Xmp.drone-dji.GimbalPitchDegree",
                   "Xmp.drone-dji.GimbalRollDegree"},
        std::array{"Xmp.drone-parrot.CameraYawDegree", "Xmp.drone-parrot.CameraPitchDegree",
                   "Xmp.drone-parrot.CameraRollDegree"}}) {
    header.heading_deg = tags.xmp_number(yaw);
    header.pitch_deg = tags.xmp_number(pitch);
    header.roll_deg = tags.xmp_number(roll);
    if (header.heading_deg || header.pitch_deg || header.roll_deg) return;
  }
  header.heading_deg = tags.xmp_number("Xmp.Camera.Yaw");
  header.roll_deg = tags.xmp_number("Xmp.Camera.Roll");
  header.pitch_deg = tags.xmp_number("Xmp.Camera.Pitch");
  // Pix4D's namespace counts pitch from straight down. Some makers write -90 for it all the same; a camera that looks
  // backwards to the horizon is not meant.
  if (header.pitch_deg && *header.pitch_deg > -45) *header.pitch_deg -= 90;
}

std::string date_and_time(const Tags& tags) {
  std::string taken = tags.exif_text("Exif.Photo.DateTimeOriginal");
  std::string fraction = tags.exif_text("Exif.Photo.SubSecTimeOriginal");
  if (taken.empty()) {
    taken = tags.exif_text("Exif.Image.DateTime");
    fraction = tags.exif_text("Exif.Photo.SubSecTime");
  }
  const std::string form = "dddd:dd:dd dd:dd:dd";
  if (taken.size() < form.size()) return {};
  taken.resize(form.size());
  for (std::size_t i = 0; i < form.size(); ++i)
    if (form[i] == 'd' ? !std::isdigit(static_cast<unsigned char>(taken[i])) : taken[i] != form[i]) return {};
  if (taken.rfind("0000", 0) == 0) return {};
  if (fraction.empty() || fraction.find_first_not_of("0123456789") != std::string::npos) return taken;
  fraction.resize(std::max<std::size_t>(3, fraction.size()), '0');
  return taken + "." + fraction;
}

// The pixel of the image as it is now: a reduced image keeps the resolution of its original in some programs.
std::optional<double> pixel_pitch_mm(const Tags& tags, const ImageHeader& header) {
  const std::optional<double> per_unit = positive(tags.exif_number("Exif.Photo.FocalPlaneXResolution"));
  if (!per_unit) return std::nullopt;
  const double unit = tags.exif_number("Exif.Photo.FocalPlaneResolutionUnit").value_or(2);
  const double unit_mm = unit == 3 ? 10 : unit == 4 ? 1 : unit == 5 ? 0.001 : 25.4;
  double pitch_mm = unit_mm / *per_unit;
  const double original_px = tags.exif_number("Exif.Photo.PixelXDimension").value_or(header.width_px);
  const double longer_px = std::max(header.width_px, header.height_px);
  if (original_px > 1.02 * longer_px) pitch_mm *= original_px / longer_px;
  const double sensor_mm = pitch_mm * longer_px;
  if (sensor_mm < 2 || sensor_mm > 300 || pitch_mm < 0.0004 || pitch_mm > 0.2) return std::nullopt;
  if (header.focal_mm && header.focal_35mm_mm) {
    const double sensor_by_focal_mm = 36 * *header.focal_mm / *header.focal_35mm_mm;
    if (sensor_mm > 1.4 * sensor_by_focal_mm || sensor_mm < sensor_by_focal_mm / 1.4) return std::nullopt;
  }
  return pitch_mm;
}

void read_camera(const Tags& tags, ImageHeader& header) {
  header.maker = tags.exif_text("Exif.Image.Make");
  header.model = tags.exif_text("Exif.Image.Model");
  header.lens = tags.exif_text("Exif.Photo.LensModel");
  if (header.lens.empty()) header.lens = tags.xmp_text("Xmp.aux.Lens");
  header.serial = tags.exif_text("Exif.Photo.BodySerialNumber");
  for (const char* key : {"Xmp.drone-dji.CameraSerialNumber", "Xmp.drone-dji.SerialNumber", "Xmp.aux.SerialNumber"})
    if (header.serial.empty()) header.serial = tags.xmp_text(key);
  header.focal_mm = positive(tags.exif_number("Exif.Photo.FocalLength"));
  header.focal_35mm_mm = positive(tags.exif_number("Exif.Photo.FocalLengthIn35mmFilm"));
  header.pixel_pitch_mm = pixel_pitch_mm(tags, header);
  header.taken = date_and_time(tags);
  const double orientation = tags.exif_number("Exif.Image.Orientation").value_or(1);
  if (orientation >= 1 && orientation <= 8) header.orientation = int(orientation);
}

// Broken tags are common and no reason to refuse a good image: what can be read is taken.
void read_tags(const std::filesystem::path& path, ImageHeader& header) {
  set_up_exiv2();
  try {
    const auto image = Exiv2::ImageFactory::open(path.string());
    try {
      image->readMetadata();
    } catch (...) {
    }
    const Tags tags{image->exifData(), image->xmpData()};
    for (const auto& read : {read_camera, read_position, read_position_sigmas, read_attitude}) {
      try {
        read(tags, header);
      } catch (...) {
      }
    }
    header.relative_height_m = tags.xmp_number("Xmp.drone-dji.RelativeAltitude");
  } catch (...) {
  }
}

Result<Size> size_of(const std::filesystem::path& path) {
  COLLINEA_TRY(const FileKind kind, kind_of_file(path));
  if (kind == FileKind::kTiff) return tiff_size(path);
  const auto size = kind == FileKind::kJpeg ? jpeg_size : png_size;
  // The size stands at the start, in a JPEG behind EXIF, XMP and a thumbnail.
  constexpr std::size_t kStart_bytes = 1 << 18;
  std::error_code unknown;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, unknown);
  COLLINEA_TRY(const std::string start, read_bytes(path, kStart_bytes));
  if (auto found = size(start, file_bytes); found || start.size() < kStart_bytes) return found;
  COLLINEA_TRY(const std::string bytes, read_bytes(path));
  return size(bytes, file_bytes);
}

}  // namespace

void set_up_exiv2() {
  static std::recursive_mutex toolkit;
  static std::once_flag once;
  std::call_once(once, [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    Exiv2::XmpParser::initialize(
        [](void* mutex, bool lock) {
          auto& held = *static_cast<std::recursive_mutex*>(mutex);
          lock ? held.lock() : held.unlock();
        },
        &toolkit);
    Exiv2::XmpProperties::registerNs("http://www.dji.com/drone-dji/1.0/", "drone-dji");
    Exiv2::XmpProperties::registerNs("http://www.parrot.com/drone-parrot/1.0/", "drone-parrot");
    Exiv2::XmpProperties::registerNs("http://pix4d.com/camera/1.0/", "Camera");
  });
}

Result<ImageHeader> read_image_header(const std::filesystem::path& path) {
  Result<Size> size = size_of(path);
  if (!size) {
    if (size.error().code == Errc::kNotFound) return tl::unexpected(std::move(size).error());
    return tl::unexpected(std::move(size).error().within("reading " + path.string()));
  }
  ImageHeader header;
  header.width_px = (*size)[0];
  header.height_px = (*size)[1];
  read_tags(path, header);
  return header;
}

}  // namespace collinea
