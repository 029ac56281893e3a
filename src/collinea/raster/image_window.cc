// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/image_window.h"

#include <algorithm>

#include "collinea/raster/codec.h"
#include "collinea/raster/gdal_access.h"

namespace collinea {
namespace {

bool is_colour(GDALDatasetH file) {
  return GDALGetRasterCount(file) >= 3 && GDALGetRasterColorInterpretation(GDALGetRasterBand(file, 1)) == GCI_RedBand;
}

Result<FloatImage> read_by_gdal(const std::filesystem::path& path, int width_px, int height_px,
                                const PixelWindow& window) {
  set_up_gdal();
  const GdalErrors errors;
  const char* const drivers[] = {"PNG", "GTiff", nullptr};
  const GdalDataset file(GDALOpenEx(path.c_str(), GDAL_OF_READONLY | GDAL_OF_RASTER, drivers, nullptr, nullptr));
  if (!file) return errors.error(Errc::kBadFormat, "reading " + path.string());
  if (GDALGetRasterXSize(file.get()) != width_px || GDALGetRasterYSize(file.get()) != height_px)
    return fail(Errc::kBadFormat, path.string() + ": it has another size than when it was imported");
  constexpr float kLuma[] = {0.299f, 0.587f, 0.114f};
  const int bands = is_colour(file.get()) ? 3 : 1;
  FloatImage out(window.width, window.height), one(window.width, window.height);
  bool is_deep = false;
  for (int band = 0; band < bands; ++band) {
    const GDALRasterBandH source = GDALGetRasterBand(file.get(), band + 1);
    is_deep |= GDALGetRasterDataType(source) != GDT_Byte;
    if (GDALRasterIO(source, GF_Read, window.left, window.top, window.width, window.height, one.data.data(),
                     window.width, window.height, GDT_Float32, 0, 0) != CE_None)
      return errors.error(Errc::kBadFormat, "reading " + path.string());
    for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] += (bands == 3 ? kLuma[band] : 1) * one.data[i];
  }
  if (is_deep) {
    const auto [low, high] = std::minmax_element(out.data.begin(), out.data.end());
    const float base = *low, scale = *high > *low ? 255 / (*high - *low) : 1;
    for (float& grey : out.data) grey = (grey - base) * scale;
  }
  return out;
}

}  // namespace

Result<FloatImage> read_grey_window(const std::filesystem::path& path, int width_px, int height_px,
                                    const PixelWindow& window) {
  COLLINEA_CHECK(window.left >= 0 && window.top >= 0 && window.width > 0 && window.height > 0 &&
                 window.left + window.width <= width_px && window.top + window.height <= height_px);
  COLLINEA_TRY(const FileKind kind, kind_of_file(path));
  if (kind != FileKind::kJpeg) return read_by_gdal(path, width_px, height_px, window);
  COLLINEA_TRY(const GreyImage grey, read_jpeg_window(path, window));
  FloatImage out(grey.width, grey.height);
  std::copy(grey.data.begin(), grey.data.end(), out.data.begin());
  return out;
}

}  // namespace collinea
