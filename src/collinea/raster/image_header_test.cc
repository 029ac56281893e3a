// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <exiv2/exiv2.hpp>
#include <functional>

#include "collinea/base/test_folder.h"
#include "collinea/raster/codec.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Tagging = std::function<void(Exiv2::ExifData&, Exiv2::XmpData&)>;

// The header of an image of 4000 x 3 pixels with the given tags.
ImageHeader header_with(const Tagging& tag) {
  const TestFolder folder;
  const std::filesystem::path path = folder / "a.jpg";
  EXPECT_TRUE(write_jpeg(path, Raster<std::uint8_t>(4000, 3, 1), 80));
  set_up_exiv2();
  const auto image = Exiv2::ImageFactory::open(path.string());
  Exiv2::ExifData exif;
  Exiv2::XmpData xmp;
  tag(exif, xmp);
  image->setExifData(exif);
  image->setXmpData(xmp);
  image->writeMetadata();
  return read_image_header(path).value();
}

void put_text(Exiv2::ExifData& exif, const char* key, Exiv2::TypeId type, const std::string& text) {
  const auto value = Exiv2::Value::create(type);
  value->read(text);
  exif.add(Exiv2::ExifKey(key), value.get());
}

void put_location(Exiv2::ExifData& exif, const std::string& latitude, const std::string& longitude) {
  put_text(exif, "Exif.GPSInfo.GPSLatitude", Exiv2::unsignedRational, latitude);
  put_text(exif, "Exif.GPSInfo.GPSLongitude", Exiv2::unsignedRational, longitude);
  put_text(exif, "Exif.GPSInfo.GPSLatitudeRef", Exiv2::asciiString, "N");
  put_text(exif, "Exif.GPSInfo.GPSLongitudeRef", Exiv2::asciiString, "E");
}

TEST(ImageHeader, FinerXmpPositionsWinWhereTheyAgreeWithExif) {
  const ImageHeader header = header_with([](auto& exif, auto& xmp) {
    put_location(exif, "50/1 30/1 0/1", "14/1 15/1 0/1");
    xmp["Xmp.drone-dji.GpsLatitude"] = std::string("50.500000123");
    xmp["Xmp.drone-dji.GpsLongtitude"] = std::string("+14.249999876");  // as early firmware spells it
  });
  EXPECT_EQ(header.latitude_deg, 50.500000123);
  EXPECT_EQ(header.longitude_deg, 14.249999876);
}

TEST(ImageHeader, ExifCorrectedAfterTheFlightWinsOverXmp) {
  const ImageHeader header = header_with([](auto& exif, auto& xmp) {
    put_location(exif, "50/1 30/1 0/1", "14/1 15/1 0/1");
    put_text(exif, "Exif.GPSInfo.GPSAltitude", Exiv2::unsignedRational, "3005/10");
    xmp["Xmp.drone-dji.GpsLatitude"] = std::string("50.50001");
    xmp["Xmp.drone-dji.GpsLongitude"] = std::string("14.25");
    xmp["Xmp.drone-dji.AbsoluteAltitude"] = std::string("+250.00");
  });
  EXPECT_EQ(header.latitude_deg, 50.5);
  EXPECT_EQ(header.height_m, 300.5);
}

TEST(ImageHeader, DivisionsByZeroAreNoPosition) {
  const ImageHeader none = header_with([](auto& exif, auto&) { put_location(exif, "0/0 0/0 0/0", "0/0 0/0 0/0"); });
  EXPECT_FALSE(none.latitude_deg || none.longitude_deg);
  const ImageHeader degrees =
      header_with([](auto& exif, auto&) { put_location(exif, "505/10 0/0 0/0", "1425/100 0/1 0/1"); });
  EXPECT_EQ(degrees.latitude_deg, 50.5);
  EXPECT_EQ(degrees.longitude_deg, 14.25);
}

TEST(ImageHeader, PositionsThatAreNotOnEarthAreLeftOut) {
  const ImageHeader header = header_with([](auto& exif, auto&) { put_location(exif, "95/1 0/1 0/1", "14/1 0/1 0/1"); });
  EXPECT_FALSE(header.latitude_deg);
}

TEST(ImageHeader, SigmasNeedAFix) {
  const auto with_flag = [](const char* flag) {
    return header_with([flag](auto&, auto& xmp) {
      xmp["Xmp.drone-dji.RtkFlag"] = std::string(flag);
      xmp["Xmp.drone-dji.RtkStdLon"] = std::string("0.01");
      xmp["Xmp.drone-dji.RtkStdLat"] = std::string("0.02");
      xmp["Xmp.drone-dji.RtkStdHgt"] = std::string("0.03");
    });
  };
  EXPECT_EQ(with_flag("50").sigma_east_m, 0.01);
  EXPECT_EQ(with_flag("50").sigma_north_m, 0.02);
  EXPECT_EQ(with_flag("50").sigma_height_m, 0.03);
  EXPECT_FALSE(with_flag("0").sigma_east_m);
}

TEST(ImageHeader, PlanAccuracyOfPhonesAndPix4dIsTaken) {
  const ImageHeader phone =
      header_with([](auto& exif, auto&) { put_text(exif, "Exif.GPSInfo.0x001f", Exiv2::unsignedRational, "47/10"); });
  EXPECT_EQ(phone.sigma_east_m, 4.7);
  EXPECT_EQ(phone.sigma_north_m, 4.7);
  EXPECT_FALSE(phone.sigma_height_m);
  const ImageHeader drone = header_with([](auto&, auto& xmp) {
    xmp["Xmp.Camera.GPSXYAccuracy"] = std::string("0.05");
    xmp["Xmp.Camera.GPSZAccuracy"] = std::string("0.1");
  });
  EXPECT_EQ(drone.sigma_north_m, 0.05);
  EXPECT_EQ(drone.sigma_height_m, 0.1);
}

// Pix4D's tags call straight down 0; ours is -90, as in DJI's.
TEST(ImageHeader, PitchIsMinusNinetyDownWhoeverWroteIt) {
  const auto camera_pitch = [](const char* text) {
    return header_with([text](auto&, auto& xmp) {
      xmp["Xmp.Camera.Yaw"] = std::string("90.5");
      xmp["Xmp.Camera.Pitch"] = std::string(text);
      xmp["Xmp.Camera.Roll"] = std::string("-1/2");
    });
  };
  EXPECT_EQ(camera_pitch("2.5").pitch_deg, -87.5);
  EXPECT_EQ(camera_pitch("-90").pitch_deg, -90);
  EXPECT_EQ(camera_pitch("0").heading_deg, 90.5);
  EXPECT_EQ(camera_pitch("0").roll_deg, -0.5);
  EXPECT_FALSE(camera_pitch("nonsense").pitch_deg);
}

TEST(ImageHeader, ThePixelPitchIsThatOfTheImageAsItIs) {
  const auto pitch = [](const char* per_inch, const char* original_width) {
    return header_with([=](auto& exif, auto&) {
             put_text(exif, "Exif.Photo.FocalPlaneXResolution", Exiv2::unsignedRational, per_inch);
             put_text(exif, "Exif.Photo.PixelXDimension", Exiv2::unsignedLong, original_width);
           })
        .pixel_pitch_mm;
  };
  EXPECT_NEAR(pitch("5080/1", "4000").value(), 0.005, 1e-12);  // 25.4 mm / 5080
  EXPECT_NEAR(pitch("5080/1", "8000").value(), 0.010, 1e-12);  // halved since it was taken
  EXPECT_FALSE(pitch("72/1", "4000"));                         // a screen's resolution, not a sensor's
  EXPECT_FALSE(pitch("5080/0", "4000"));
}

TEST(ImageHeader, TheDateSortsAndFallsBack) {
  const auto taken = [](const char* original, const char* fraction) {
    return header_with([=](auto& exif, auto&) {
             put_text(exif, "Exif.Photo.DateTimeOriginal", Exiv2::asciiString, original);
             put_text(exif, "Exif.Photo.SubSecTimeOriginal", Exiv2::asciiString, fraction);
           })
        .taken;
  };
  EXPECT_EQ(taken("2024:01:02 03:04:05", "5"), "2024:01:02 03:04:05.500");
  EXPECT_EQ(taken("2024:01:02 03:04:05", "x"), "2024:01:02 03:04:05");
  EXPECT_EQ(taken("0000:00:00 00:00:00", "12"), "");
  EXPECT_EQ(taken("yesterday", "12"), "");
  EXPECT_EQ(header_with([](auto& exif, auto&) {
              put_text(exif, "Exif.Image.DateTime", Exiv2::asciiString, "2024:01:02 03:04:06");
            }).taken,
            "2024:01:02 03:04:06");
}

}  // namespace
}  // namespace collinea
